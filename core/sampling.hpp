/*!
  \file sampling.hpp
  \brief Layer 5: what a run reports of its particles: totals, host copies, and
  fields on the nodes.
*/
#ifndef MACHPOINT_SAMPLING_HPP
#define MACHPOINT_SAMPLING_HPP

#include <core/reproducible_sum.hpp>
#include <core/simulation.hpp>
#include <core/transfer.hpp>

#include <vector>

namespace Machpoint
{

//! Totals as a reduction over particles. Equal small terms on top of a large
//! sum would all be rounded the same way: a Sedov blast's cold gas alone would
//! show an energy drift of 1e-12.
struct TotalsSum
{
    //! \name As in Totals
    //! @{
    ReproducibleSum mass, momentum[3], internal, kinetic, affine;
    //! @}

    KOKKOS_INLINE_FUNCTION TotalsSum& operator+=( const TotalsSum& other )
    {
        mass += other.mass;
        for ( int d = 0; d < 3; ++d )
            momentum[d] += other.momentum[d];
        internal += other.internal;
        kinetic += other.kinetic;
        affine += other.affine;
        return *this;
    }
};

//! Mass, momentum and energies of all particles on all ranks. Collective.
template <int Dim>
Totals sumParticles( const State<Dim>& state )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto grid = state.grid;
    const auto moment = state.affine_moment;
    TotalsSum sums;
    reduceEach(
        "Machpoint::sumParticles", state.particles.size(), few_particles,
        MACHPOINT_LAMBDA( const int p, TotalsSum& sum ) {
            const Real mass = m( p );
            sum.mass += mass;
            sum.internal += mass * e( p );
            for ( int b = 0; b < Dim; ++b )
            {
                sum.momentum[b] += mass * v( p, b );
                sum.kinetic += 0.5_rt * mass * v( p, b ) * v( p, b );
                const Real half = 0.5_rt * moment( grid, x( p, b ), b );
                for ( int a = 0; a < Dim; ++a )
                    sum.affine += mass * half * C( p, a, b ) * C( p, a, b );
            }
        },
        sums );
    const auto& comm = state.decomposition.comm();
    TotalsSum all;
    for ( const auto& rank : comm.gatherAll( std::vector{ sums } ) )
        all += rank;
    sums = all;
    Totals totals;
    totals.mass = sums.mass.value();
    for ( int d = 0; d < 3; ++d )
        totals.momentum[d] = sums.momentum[d].value();
    totals.internal = sums.internal.value();
    totals.kinetic = sums.kinetic.value();
    totals.affine = sums.affine.value();
    return totals;
}

//! Copies this rank's particles to the host. Needs pressures (particleState).
template <int Dim>
ParticleData copyParticles( const State<Dim>& state )
{
    const std::size_t n = state.particles.size();
    ParticleData data;
    data.position = state.particles.template copyMember<Position>();
    data.velocity = state.particles.template copyMember<Velocity>();
    data.mass = state.particles.template copyMember<Mass>();
    data.volume = state.particles.template copyMember<Volume>();
    data.pressure = state.particles.template copyMember<Pressure>();
    data.specific_internal_energy =
        state.particles.template copyMember<SpecificInternalEnergy>();
    data.id = state.particles.template copyMember<Id>();
    data.density.resize( n );
    for ( std::size_t p = 0; p < n; ++p )
        data.density[p] = data.mass[p] / data.volume[p];
    return data;
}

//! Adds m, V, V p, m e and m v of all particles.
//! \param sums the scatter of a field [nodes][4 + Dim]
template <class Basis, int Dim, class Sums>
void sampleParticles( const State<Dim>& state, const Sums& sums )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    forEach(
        "Machpoint::sampleGrid", state.particles.size(),
        MACHPOINT_LAMBDA( const int p ) {
            const Stencil<Basis, Dim> s( grid, layout,
                                         loadVector<Dim>( x, p ) );
            const auto nodes = accessTo( sums.thread(), p, s, layout );
            forEachNode( s, layout,
                         [&]( const auto& i )
                         {
                             const Real mw = m( p ) * i.weight;
                             const Real Vw = V( p ) * i.weight;
                             nodes( i.row, 0 ) += mw;
                             nodes( i.row, 1 ) += Vw;
                             nodes( i.row, 2 ) += Vw * pressure( p );
                             nodes( i.row, 3 ) += mw * e( p );
                             for ( int d = 0; d < Dim; ++d )
                                 nodes( i.row, 4 + d ) += mw * v( p, d );
                         } );
        },
        few_particles );
}

/*!
  \brief Fields on this rank's nodes: density (sum m w) / (sum V w), velocity
  and energy weighted by mass, pressure by volume. All 0 where there is no gas.
  Needs pressures (particleState). Collective.
*/
template <class Basis, int Dim>
GridData sampleGrid( const State<Dim>& state )
{
    constexpr int columns = 4 + Dim; // as in sampleParticles
    const auto& layout = state.layout;
    auto sample = makeNodeSum( "Machpoint::sample", state, columns );
    sample.deposit( [&]( const auto& sums )
                    { sampleParticles<Basis>( state, sums ); } );
    NodeComponents<columns> components{};
    for ( int d = 0; d < Dim; ++d )
        components[4 + d] = { Parity::velocity, d };
    sample.foldAndFill( state.halo, components );

    const auto host = Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(),
                                                           sample.field() );
    GridData data;
    std::size_t total = 1;
    for ( int d = 0; d < Dim; ++d )
    {
        data.shape.insert( data.shape.begin(), layout.owned[d] );
        data.global_shape.insert( data.global_shape.begin(),
                                  layout.cells[d] +
                                      ( layout.centred ? 0 : 1 ) );
        data.start.insert( data.start.begin(), layout.box.begin[d] );
        const double lower = state.grid.lower[d];
        const double spacing =
            ( state.grid.upper[d] - lower ) / state.grid.cells[d];
        data.lower.push_back( lower + ( layout.centred ? 0.5 * spacing : 0 ) );
        data.spacing.push_back( spacing );
        total *= layout.owned[d];
    }
    for ( auto* list :
          { &data.density, &data.pressure, &data.specific_internal_energy } )
        list->assign( total, 0 );
    data.velocity.assign( total * Dim, 0 );
    const Real least = 1e-12_rt * state.grid.cellVolume();
    for ( std::size_t n = 0; n < total; ++n )
    {
        Indices<Dim> i{};
        std::size_t rest = n;
        for ( int d = 0; d < Dim; ++d )
        {
            i[d] = layout.box.begin[d] +
                   static_cast<int>( rest % layout.owned[d] );
            rest /= layout.owned[d];
        }
        const int row = layout( i );
        if ( host( row, 1 ) <= least )
            continue;
        data.density[n] = host( row, 0 ) / host( row, 1 );
        data.pressure[n] = host( row, 2 ) / host( row, 1 );
        if ( !( host( row, 0 ) > 0 ) ) // it rounds to none
            continue;
        data.specific_internal_energy[n] = host( row, 3 ) / host( row, 0 );
        for ( int d = 0; d < Dim; ++d )
            data.velocity[n * Dim + d] = host( row, 4 + d ) / host( row, 0 );
    }
    return data;
}

} // namespace Machpoint

#endif
