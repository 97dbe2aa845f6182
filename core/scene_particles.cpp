/*!
  \file scene_particles.cpp
  \brief The particles of a scene, laid into the cells.
*/
#include <core/scene_parts.hpp>

#include <core/initial_gas.hpp>
#include <core/shape_input.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace Machpoint
{

namespace
{

//! Calls visit( id, x, gas, gradient of its velocity ) for each particle that
//! is to be laid into this rank's cells, cell by cell.
template <int Dim, class Visitor>
void forEachNewParticle( const InitialGas<Dim>& initial,
                         const Scene<Dim>& scene, const Visitor& visit )
{
    const auto& state = scene.state;
    const auto& grid = state.grid;
    const auto& box = state.layout.box;
    const int q = latticeSize( state.per_cell, Dim );
    std::vector<Shape<Dim, Kokkos::HostSpace>> solids;
    for ( const auto& active : scene.modules )
        if ( !active.solid.is_null() )
            solids.push_back(
                makeShape<Dim, Kokkos::HostSpace>( active.solid ) );
    for ( int own_cell = 0; own_cell < box.totalCells(); ++own_cell )
    {
        Indices<Dim> i{};
        int rest = own_cell;
        for ( int d = 0; d < Dim; ++d )
        {
            i[d] = box.begin[d] + rest % box.cells( d );
            rest /= box.cells( d );
        }
        // Ids and random places count the cells of the whole domain.
        std::int64_t cell = 0;
        for ( int d = Dim - 1; d >= 0; --d )
            cell = cell * grid.cells[d] + i[d];
        for ( int k = 0; k < state.per_cell; ++k )
        {
            const auto f =
                placeInCell<Dim>( state.placement, q, state.seed, cell, k );
            Vector<Dim> x{};
            for ( int d = 0; d < Dim; ++d )
                x[d] = grid.lower[d] + ( i[d] + f[d] ) * grid.spacing[d];
            bool is_solid = false;
            for ( const auto& shape : solids )
                is_solid = is_solid || shape.distance( x ) < 0;
            for ( const auto& active : scene.modules )
                is_solid = is_solid || active.module->isSolid( x );
            if ( is_solid )
                continue;
            Gradient gradient;
            const auto gas = initial.at( x, gradient );
            if ( gas.density != 0 ) // else a place without gas
                visit( cell * state.per_cell + k, x, gas, gradient );
        }
    }
}

//! Writes a row of host memory for a new particle.
template <int Dim>
void setParticle( const HostParticles<Dim>& host, const std::size_t p,
                  const std::int64_t id, const Vector<Dim>& x,
                  const GasState& gas, const Gradient& gradient,
                  const Real volume, const Real specific_internal_energy )
{
    for ( int a = 0; a < Dim; ++a )
    {
        host.template slice<Position>()( p, a ) = x[a];
        host.template slice<Velocity>()( p, a ) = gas.velocity[a];
        for ( int b = 0; b < Dim; ++b )
            host.template slice<VelocityGradient>()( p, a, b ) = gradient[a][b];
    }
    host.template slice<Volume>()( p ) = volume;
    host.template slice<SpecificInternalEnergy>()( p ) =
        specific_internal_energy;
    host.template slice<Mass>()( p ) = gas.density * volume;
    host.template slice<Pressure>()( p ) = 0;
    host.template slice<SoundSpeed>()( p ) = 0;
    host.template slice<Id>()( p ) = id;
}

} // namespace

//! Lays the particles into this rank's cells: counted first, then in blocks by
//! way of the host, so that memory holds them once.
template <int Dim>
void placeParticles( const Json& input, Scene<Dim>& scene )
{
    const InitialGas<Dim> initial( input );
    auto& state = scene.state;
    std::size_t count = 0;
    std::string fault;
    forEachNewParticle(
        initial, scene,
        [&]( const auto, const auto& x, const auto& gas, const auto& )
        {
            ++count;
            if ( fault.empty() )
                fault = initial.fault( x, gas );
        } );
    const auto& comm = state.decomposition.comm();
    const double first_fault =
        comm.min( fault.empty() ? comm.size() : comm.rank() );
    if ( first_fault < comm.size() )
        throw InputError(
            { comm.from( static_cast<int>( first_fault ), fault ) } );
    if ( comm.sum( static_cast<std::int64_t>( count ) ) == 0 )
        throw InputError(
            { "/initial: no particle finds room: obstacles and regions leave "
              "no gas in the domain; shrink the obstacle or widen a region" } );
    state.particles.resize( count );
    HostParticles<Dim> block;
    block.resize( std::min<std::size_t>( count, 1 << 14 ) );
    const Real volume = state.grid.cellVolume() / state.per_cell;
    std::size_t first = 0, p = 0;
    forEachNewParticle(
        initial, scene,
        [&]( const std::int64_t id, const Vector<Dim>& x, const GasState& gas,
             const Gradient& gradient )
        {
            setParticle<Dim>( block, p, id, x, gas, gradient, volume,
                              scene.gas->specificInternalEnergy(
                                  gas.density, gas.pressure ) );
            if ( ++p < block.size() )
                return;
            state.particles.put( first, block );
            first += p;
            p = 0;
            block.resize( std::min( count - first, block.size() ) );
        } );
}

template void placeParticles( const Json&, Scene<1>& );
template void placeParticles( const Json&, Scene<2>& );
template void placeParticles( const Json&, Scene<3>& );

} // namespace Machpoint
