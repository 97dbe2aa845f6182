/*!
  \file splitting.hpp
  \brief Part of `conservative`: large particles are halved where gas expands
  (docs/conservative.md, section 9).
*/
#ifndef MACHPOINT_CONSERVATIVE_SPLITTING_HPP
#define MACHPOINT_CONSERVATIVE_SPLITTING_HPP

#include <core/basis.hpp>
#include <core/conservative/history.hpp>
#include <core/soundness.hpp>

#include <algorithm>
#include <vector>

namespace Machpoint
{

namespace Impl
{

//! How far a half stands from where its particle was at most, cells. What lies
//! that far beyond its rank's box, and drifts for half a step (at CFL numbers
//! up to 1.08), is still within the cell beyond the box whose nodes the rank
//! has (Conservative::reach).
inline constexpr Real most_split_offset = 0.46_rt;

/*!
  \brief New ids for the children of the given particles, in the order of their
  parents' ids over all ranks, so that they depend neither on the number of
  ranks nor on the order in memory. Advances state.next_id. Collective.
  \param parents rows [n] \param memory of the ids \return ids [n]
*/
template <int Dim>
Reused<std::int64_t>::list_type numberByParent( State<Dim>& state,
                                                const IndexList& parents,
                                                Reused<std::int64_t>& memory )
{
    const int n = parents.extent_int( 0 );
    const auto ids = memory.take( n );
    const auto id = state.particles.template slice<Id>();
    forEach(
        "Machpoint::parentIds", n,
        MACHPOINT_LAMBDA( const int k ) { ids( k ) = id( parents( k ) ); } );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), ids );
    auto all = state.decomposition.comm().gatherAll(
        std::vector<std::int64_t>( host.data(), host.data() + n ) );
    std::sort( all.begin(), all.end() );
    for ( int k = 0; k < n; ++k )
        host( k ) = state.next_id +
                    ( std::lower_bound( all.begin(), all.end(), host( k ) ) -
                      all.begin() );
    Kokkos::deep_copy( ids, host );
    state.next_id += static_cast<std::int64_t>( all.size() );
    return ids;
}

//! Is a particle, or each of a pack, to be halved?
struct LargeParticle
{
    Real volume;     //!< that it may have
    Real mass_floor; //!< part of what it started with that a half must have

    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION auto
    operator()( const Number& V, const Number& m, const Number& original ) const
    {
        return Number( volume ) < V && 2 * mass_floor * original <= m;
    }
};

//! Volume above which particles are halved; one as large as those of the start
//! is not.
template <int Dim>
Real largeVolume( const State<Dim>& state, const ConservativeParts& parts )
{
    return Kokkos::max( parts.split_volume, 1.5_rt / state.per_cell ) *
           state.grid.cellVolume();
}

/*!
  \brief Halves particles larger than state.large_volume along the axis of the
  largest stretch S, or along m axes that share it: offsets
  +- h (V/h^d)^(1/d) e^min(S, .7) / (4 sqrt m), at most most_split_offset of a
  cell and to the sides of the domain. S gains ln 2 / d on every axis and loses
  ln 2 / m on those m. The halves keep v, C and e; mass, momentum, energy and
  volume stay (on hats, what the affine energy loses becomes heat). Looks for
  them where a kernel has told of one.
  \param new_ids scratch
*/
template <int Dim>
void splitParticles( State<Dim>& state, Sidecar<HistoryMembers<Dim>>& history,
                     Reused<std::int64_t>& new_ids,
                     const ConservativeParts& parts )
{
    const auto& comm = state.decomposition.comm();
    if ( comm.sum( std::int64_t( isSuspected( state, Large ) ) ) == 0 )
        return;
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto original = Cabana::slice<OriginalMass>( history.data() );
    const LargeParticle is_large{ state.large_volume, parts.mass_floor };
    const int n = state.particles.size();
    const RowList& found = state.noted;
    state.noted.clear( n );
    forEachPack(
        "Machpoint::noteLarge", n,
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            const Lanes volume = load( V, p );
            const LaneMask big = Lanes( is_large.volume ) < volume;
            if ( !any( big ) )
                return;
            const Lanes mass = load( m, p );
            const Lanes first = load( original, p );
            const LaneMask known = Lanes( 0.0 ) < first;
            const Lanes start = choose( known, first, mass );
            if ( any( !known ) ) // of large ones alone, whoever is beside them
                store( original, choose( big, start, first ), p );
            found.note( p, active( p ) && is_large( volume, mass, start ) );
        } );
    if ( comm.sum( static_cast<std::int64_t>( found.count() ) ) == 0 )
        return;

    const auto large = found.rows(
        n, MACHPOINT_LAMBDA( const int p ) {
            return is_large( V( p ), m( p ), original( p ) );
        } );
    const int count = large.extent_int( 0 );
    state.particles.keepIdentities( large );
    const auto number = numberByParent( state, large, new_ids );
    state.particles.duplicate( large );
    const auto x = state.particles.template slice<Position>();
    const auto id = state.particles.template slice<Id>();
    const auto affine = state.particles.template slice<VelocityGradient>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto mass = state.particles.template slice<Mass>();
    const auto volume = state.particles.template slice<Volume>();
    const auto lengths = Cabana::slice<Stretch>( history.data() );
    const auto grid = state.grid;
    const Real cell_volume = grid.cellVolume();
    const auto moment_of = state.affine_moment;
    forEach(
        "Machpoint::splitParticles", count,
        MACHPOINT_LAMBDA( const int k ) {
            const int p = large( k );
            const int q = n + k;
            Real longest = lengths( p, 0 );
            for ( int a = 1; a < Dim; ++a )
                longest = Kokkos::max( longest, lengths( p, a ) );
            // Axes that are alike share the direction, with the signs along
            // which the gas is stretched; neither is left to round-off.
            Vector<Dim> u{};
            int axes = 0;
            int first = 0;
            for ( int a = 0; a < Dim; ++a )
                if ( lengths( p, a ) >= longest - round_off )
                {
                    if ( axes++ == 0 )
                        first = a;
                    const Real shear =
                        affine( p, first, a ) + affine( p, a, first );
                    const Real strain =
                        Kokkos::abs( affine( p, a, a ) ) +
                        Kokkos::abs( affine( p, first, first ) );
                    u[a] = a != first && shear < -round_off * strain ? -1 : 1;
                }
            // In cells, whose proportions particles have.
            Real offset = Kokkos::min(
                Real( most_split_offset ),
                0.25_rt / Kokkos::sqrt( static_cast<Real>( axes ) ) *
                    Kokkos::pow( volume( p ) / cell_volume, 1.0_rt / Dim ) *
                    Kokkos::exp( Kokkos::min( longest, 0.7_rt ) ) );
            for ( int a = 0; a < Dim; ++a )
                if ( u[a] != 0 )
                    offset = Kokkos::min(
                        offset, 0.999_rt / grid.spacing[a] *
                                    Kokkos::min( x( p, a ) - grid.lower[a],
                                                 grid.upper[a] - x( p, a ) ) );
            offset = Kokkos::max( offset, 0.0_rt );
            // Half the length along the direction, the same across.
            const Real halved = Kokkos::log( 2.0_rt );
            id( q ) = number( k );
            for ( const int half : { p, q } )
            {
                mass( half ) *= 0.5_rt;
                volume( half ) *= 0.5_rt;
                for ( int b = 0; b < Dim; ++b )
                {
                    lengths( half, b ) += halved / Dim;
                    if ( u[b] == 0 )
                        continue;
                    lengths( half, b ) -= halved / axes;
                    const Real from = x( half, b );
                    x( half, b ) += ( half == p ? -offset : offset ) *
                                    grid.spacing[b] * u[b];
                    moment_of.carry( grid, affine, e, half, b, from,
                                     x( half, b ) );
                }
            }
        },
        few_particles );
}

} // namespace Impl
} // namespace Machpoint

#endif
