/*!
  \file resolution.hpp
  \brief Parts of `conservative` that change the number of particles: halving
  where gas expands, merging where it is compressed (docs/conservative.md,
  section 9).
*/
#ifndef MACHPOINT_CONSERVATIVE_RESOLUTION_HPP
#define MACHPOINT_CONSERVATIVE_RESOLUTION_HPP

#include <core/basis.hpp>
#include <core/conservative/parts.hpp>
#include <core/soundness.hpp>

#include <algorithm>

namespace Machpoint
{

//! What halving and merging remember of a particle: accumulated stretch along
//! each axis, volume change apart, and the mass it started with, which is zero
//! until a particle was to be halved or might have merged.
template <int Dim>
using HistoryMembers = Cabana::MemberTypes<Real[Dim], Real>;

//! Names of the members of a history.
enum HistoryMember : std::size_t
{
    Stretch,     //!< integral of C_aa - tr C / Dim [Dim]
    OriginalMass //!< mass
};

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
    Real mass_floor; //!< part of what it started with that it must have

    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION auto
    operator()( const Number& V, const Number& m, const Number& original ) const
    {
        return Number( volume ) < V && mass_floor * original < m;
    }
};

//! Advances the stretch that particles remember, by a rectangle of
//! parts.track_every steps. In 1D volume is all that changes.
template <int Dim>
void trackStretch( const State<Dim>& state,
                   Sidecar<HistoryMembers<Dim>>& history,
                   const ConservativeParts& parts )
{
    if ( Dim == 1 || state.step % parts.track_every != 0 )
        return;
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto stretch = Cabana::slice<Stretch>( history.data() );
    const Real elapsed = parts.track_every * state.dt;
    forEachPack(
        "Machpoint::trackStretch", state.particles.size(),
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            Lanes mean( 0.0 );
            for ( int a = 0; a < Dim; ++a )
                mean += load( C, p, a, a ) * ( 1.0_rt / Dim );
            for ( int a = 0; a < Dim; ++a )
                store( stretch,
                       load( stretch, p, a ) +
                           elapsed * ( load( C, p, a, a ) - mean ),
                       p, a );
        } );
}

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
  largest stretch S: offsets +- V^(1/Dim) e^S / 4, at most most_split_offset of
  a cell and to the sides of the domain. The halves keep v, C and e; mass,
  momentum, energy and volume stay (on hats, what the affine energy loses
  becomes heat). Looks for them where a kernel has told of one. \param new_ids
  scratch
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
            Real offset = 0.25_rt / Kokkos::sqrt( static_cast<Real>( axes ) ) *
                          Kokkos::pow( volume( p ), 1.0_rt / Dim ) *
                          Kokkos::exp( Kokkos::min( longest, 0.7_rt ) );
            for ( int a = 0; a < Dim; ++a )
                if ( u[a] != 0 )
                    offset = Kokkos::min(
                        Kokkos::min( offset,
                                     most_split_offset * grid.spacing[a] ),
                        0.999_rt * Kokkos::min( x( p, a ) - grid.lower[a],
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
                    const Real moment = moment_of( grid, x( half, b ), b );
                    x( half, b ) += ( half == p ? -offset : offset ) * u[b];
                    const Real moment_new = moment_of( grid, x( half, b ), b );
                    const Real factor =
                        moment_of.slopeFactor( moment, moment_new );
                    for ( int a = 0; a < Dim; ++a )
                    {
                        const Real slope = affine( half, a, b );
                        const Real kept = asDeviation( slope * factor );
                        store( affine, kept, half, a, b );
                        e( half ) += 0.5_rt * ( slope * slope * moment -
                                                kept * kept * moment_new );
                    }
                }
            }
        },
        few_particles );
}

//! A mark on every half-cell of a rank's box.
using HalfCellMarks = Kokkos::View<unsigned char*, MemorySpace>;

//! Half-cell of a position within a rank's box, x fastest.
template <int Dim>
KOKKOS_INLINE_FUNCTION int
halfCell( const Grid<Dim>& grid, const CellBox<Dim>& box, const Vector<Dim>& x )
{
    int flat = 0;
    for ( int d = Dim - 1; d >= 0; --d )
    {
        const int last = 2 * box.cells( d ) - 1;
        const int c =
            static_cast<int>( 2 * ( x[d] - grid.lower[d] ) / grid.spacing[d] ) -
            2 * box.begin[d];
        flat = flat * ( last + 1 ) + ( c < 0 ? 0 : ( c > last ? last : c ) );
    }
    return flat;
}

/*!
  \brief Merges the nearest pairs of similar small particles of a half-cell.

  Mass-weighted x, v, C and e; volumes add. The relative velocity goes into C
  where that does not raise the kinetic energy, and what is lost of
  |v|^2/2 + moment |C|^2/2 into e, so mass, momentum, volume and energy stay.
  Similar: |e1 - e2| < .1 (e1 + e2), |dv| < .2 c; no result is heavier than
  four times what its parts started with.
  \param marks all zero, on entry and on return
*/
template <int Dim>
void mergeParticles( State<Dim>& state, Sidecar<HistoryMembers<Dim>>& history,
                     const HalfCellMarks& marks,
                     const ConservativeParts& parts )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto id = state.particles.template slice<Id>();
    const auto stretch = Cabana::slice<Stretch>( history.data() );
    const auto original = Cabana::slice<OriginalMass>( history.data() );
    const auto grid = state.grid;
    const auto moment_of = state.affine_moment;
    // Pairs that the gas's own particles would be at the start do not merge.
    const Real largest =
        Kokkos::min( parts.merge_volume, 0.5_rt / state.per_cell ) *
        grid.cellVolume();
    const int n = state.particles.size();
    const auto box = state.layout.box;
    // Of a pair one has less than half of the volume that the two may have, so
    // half-cells without such a one are left alone: nearly all where the gas is
    // only compressed.
    RowList& noted = state.noted;
    noted.clear( n );
    forEachPack(
        "Machpoint::noteTiny", n,
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            noted.note( p, active( p ) &&
                               load( V, p ) < Lanes( 0.5_rt * largest ) );
        } );
    if ( noted.count() == 0 )
        return;
    const auto tiny = noted.rows(
        n,
        MACHPOINT_LAMBDA( const int p ) { return V( p ) < 0.5_rt * largest; } );
    forEach(
        "Machpoint::markHalfCells", tiny.extent_int( 0 ),
        MACHPOINT_LAMBDA( const int k ) {
            marks( halfCell<Dim>( grid, box,
                                  loadVector<Dim>( x, tiny( k ) ) ) ) = 1;
        } );
    auto isCandidate = MACHPOINT_LAMBDA( const int p )
    {
        return V( p ) < largest &&
               marks( halfCell<Dim>( grid, box, loadVector<Dim>( x, p ) ) ) !=
                   0;
    };
    noted.clear( n );
    forEachPack(
        "Machpoint::noteSmall", n,
        MACHPOINT_LAMBDA( const Pack pack ) MACHPOINT_INLINE {
            if ( any( load( V, pack ) < Lanes( largest ) ) )
                forEachOf( pack,
                           [&]( const int p )
                           {
                               if ( isCandidate( p ) )
                                   noted.note( p );
                           } );
        } );
    const auto rows = noted.rows( n, isCandidate );
    const int small = rows.extent_int( 0 );
    IndexList keys( "Machpoint::halfCells", small );
    forEach(
        "Machpoint::halfCellOfParticle", small,
        MACHPOINT_LAMBDA( const int k ) {
            const int p = rows( k );
            keys( k ) = halfCell<Dim>( grid, box, loadVector<Dim>( x, p ) );
            marks( keys( k ) ) = 0;
            if ( original( p ) == 0 )
                original( p ) = m( p );
        } );
    state.particles.keepIdentities( rows );
    const auto order = Cabana::sortByKey( keys );
    IndexList ordered( "Machpoint::orderedParticles", small );
    RowList& merged = state.noted;
    merged.clear( n );
    forEach(
        "Machpoint::mergeParticles", small,
        MACHPOINT_LAMBDA( const int begin ) {
            auto keyOf = [&]( const int i )
            { return keys( static_cast<int>( order.permutation( i ) ) ); };
            const int key = keyOf( begin );
            if ( begin > 0 && keyOf( begin - 1 ) == key )
                return; // another one's half-cell
            int end = begin + 1;
            while ( end < small && keyOf( end ) == key )
                ++end;
            // Pairs must not depend on the order in memory, so ids order them.
            for ( int i = begin; i < end; ++i )
            {
                const int p =
                    rows( static_cast<int>( order.permutation( i ) ) );
                int j = i;
                for ( ; j > begin && id( ordered( j - 1 ) ) > id( p ); --j )
                    ordered( j ) = ordered( j - 1 );
                ordered( j ) = p;
            }
            auto particle = [&]( const int k ) { return ordered( k ); };
            for ( int i = begin; i < end; ++i )
            {
                const int p = particle( i );
                if ( id( p ) < 0 )
                    continue;
                int partner = -1;
                Real nearest = Kokkos::Experimental::infinity_v<Real>;
                for ( int j = i + 1; j < end; ++j )
                {
                    const int q = particle( j );
                    if ( id( q ) < 0 || V( p ) + V( q ) >= largest ||
                         m( p ) + m( q ) >
                             2 * ( original( p ) + original( q ) ) ||
                         Kokkos::abs( e( p ) - e( q ) ) >=
                             0.1_rt * ( e( p ) + e( q ) ) )
                        continue;
                    Real distance = 0;
                    Real slip = 0;
                    for ( int d = 0; d < Dim; ++d )
                    {
                        const Real dx = x( p, d ) - x( q, d );
                        const Real dv = v( p, d ) - v( q, d );
                        distance += dx * dx;
                        slip += dv * dv;
                    }
                    if ( slip < 0.04_rt * c( p ) * c( p ) &&
                         distance < nearest * ( 1 - round_off ) )
                    {
                        nearest = distance;
                        partner = q;
                    }
                }
                if ( partner < 0 )
                    continue;
                const int q = partner;
                const Real mass = m( p ) + m( q );
                const Real fp = m( p ) / mass;
                const Real fq = m( q ) / mass;
                Real before = 0;      // twice the kinetic energy of the pair
                Real after = 0;       // with the mean C
                Real with_spread = 0; // with the relative velocity in C
                auto spreadOf = [&]( const int a, const int b )
                {
                    return fp * fq * ( v( p, a ) - v( q, a ) ) *
                           ( x( p, b ) - x( q, b ) ) /
                           ( moment_of.varies
                                 ? grid.spacing[b] * grid.spacing[b]
                                 : moment_of( grid, x( p, b ), b ) );
                };
                for ( int b = 0; b < Dim; ++b )
                {
                    const Real moment_p = moment_of( grid, x( p, b ), b );
                    const Real moment_q = moment_of( grid, x( q, b ), b );
                    const Real moment =
                        moment_of( grid, fp * x( p, b ) + fq * x( q, b ), b );
                    const Real dv = v( p, b ) - v( q, b );
                    before += fp * fq * dv * dv;
                    for ( int a = 0; a < Dim; ++a )
                    {
                        const Real Cp = C( p, a, b );
                        const Real Cq = C( q, a, b );
                        const Real mean = fp * Cp + fq * Cq;
                        const Real spread = mean + spreadOf( a, b );
                        before +=
                            fp * moment_p * Cp * Cp + fq * moment_q * Cq * Cq;
                        after += moment * mean * mean;
                        with_spread += moment * spread * spread;
                    }
                }
                const bool spreads = with_spread <= before;
                const Real kinetic = spreads ? with_spread : after;
                // Without spread it cannot grow, but for hats.
                const Real factor = kinetic > before
                                        ? Kokkos::sqrt( before / kinetic )
                                        : 1.0_rt;
                Real lost = before; // twice
                for ( int b = 0; b < Dim; ++b )
                {
                    const Real moment =
                        moment_of( grid, fp * x( p, b ) + fq * x( q, b ), b );
                    for ( int a = 0; a < Dim; ++a )
                    {
                        const Real kept = asDeviation(
                            factor *
                            ( fp * C( p, a, b ) + fq * C( q, a, b ) +
                              ( spreads ? spreadOf( a, b ) : 0.0_rt ) ) );
                        store( C, kept, p, a, b );
                        lost -= moment * kept * kept;
                    }
                }
                e( p ) = fp * e( p ) + fq * e( q ) + 0.5_rt * lost;
                for ( int a = 0; a < Dim; ++a )
                {
                    x( p, a ) = fp * x( p, a ) + fq * x( q, a );
                    v( p, a ) = fp * v( p, a ) + fq * v( q, a );
                    stretch( p, a ) =
                        fp * stretch( p, a ) + fq * stretch( q, a );
                }
                original( p ) = fp * original( p ) + fq * original( q );
                m( p ) = mass;
                V( p ) += V( q );
                id( q ) = -1;
                merged.note( q );
            }
        },
        few_particles );
    state.particles.remove( merged.rows(
        n, MACHPOINT_LAMBDA( const int p ) { return id( p ) < 0; } ) );
}

} // namespace Impl
} // namespace Machpoint

#endif
