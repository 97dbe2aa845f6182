#include "recording.hpp"

#include <core/communicator.hpp>
#include <core/module.hpp>
#include <core/particles.hpp>
#include <core/profile.hpp>
#include <core/simulation.hpp>
#include <core/traffic.hpp>
#include <drivers/input.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace Machpoint
{

namespace
{

//! Name of a part, and of the phase of the profile that it is.
const std::vector<std::pair<std::string, std::string>> phases = {
    { "prepare", "prepare" }, { "P2G", "P2G" },   { "G2P", "G2P" },
    { "grid", "grid" },       { "sort", "sort" }, { "EOS", "particle state" } };

Json makeInput( const Case& c, const int particles )
{
    // The boxes of all ranks have to be wider than their halos.
    const int least =
        6 * static_cast<int>(
                std::ceil( std::pow( Communicator().size(), 1.0 / c.dim ) ) );
    const int cells = std::max(
        least,
        static_cast<int>( std::lround( std::pow(
            static_cast<Real>( particles ) / c.per_cell, 1.0 / c.dim ) ) ) );
    Json input;
    input["scene"] = "kernels";
    input["dimension"] = c.dim;
    // Sides and cuts between ranks lie where the vortices cross them.
    input["grid"] = { { "lower", std::vector( c.dim, 0.125 ) },
                      { "upper", std::vector( c.dim, 1.125 ) },
                      { "cells", std::vector<int>( c.dim, cells ) } };
    const auto bar = c.method.find( '_' );
    input["method"] = { { "name", c.method.substr( 0, bar ) },
                        { "basis", c.basis } };
    if ( bar != std::string::npos )
        input["method"]["time"] = c.method.substr( bar + 1 );
    input["particles"] = {
        { "per_cell", c.per_cell },
        { "placement", c.order == "ordered" ? "lattice" : "random" } };
    if ( c.order == "unsorted" )
        input["particles"]["sort_every"] = 1000000000;
    input["physics"] = Json::array( { { { "type", "ideal_gas" } } } );
    // Mach 0.3: particles cross a cell in some ten steps.
    input["initial"] = Json::array(
        { c.dim == 1
              ? Json{ { "type", "acoustic_wave" }, { "velocity", { 0.3 } } }
              : Json{ { "type", "taylor_green" }, { "pressure", 8 } } } );
    input["boundary"] = Json::array();
    for ( const auto& side : sideNames( c.dim ) )
        input["boundary"].push_back(
            { { "type", "periodic" }, { "side", side } } );
    input["time"] = { { "end", 100 } };
    return input;
}

//! The same rows in another order. \param order [rows]
template <class T>
Rows<T> inOrder( const Rows<T>& rows, const std::vector<std::size_t>& order )
{
    const auto columns = rows.columns;
    std::vector<T> old( rows.count * columns );
    rows.fetch( 0, rows.count, old.data() );
    std::vector<T> values( old.size() );
    for ( std::size_t k = 0; k < values.size(); ++k )
        values[k] = old[order[k / columns] * columns + k % columns];
    return { rows.count, columns,
             [columns, values]( const std::size_t first,
                                const std::size_t count, T* block ) {
                 std::copy_n( values.data() + first * columns, count * columns,
                              block );
             } };
}

//! Shuffles each rank's particles in memory: what a run becomes whose particles
//! have mixed and were never sorted.
void shuffle( Simulation& simulation )
{
    Archive written;
    simulation.checkpoint( written );
    auto entries = written.entries();
    std::vector<std::size_t> order;
    auto permute = [&]( auto& entry, const auto& rows )
    {
        if ( order.empty() ) // all have the same number of rows
        {
            order.resize( rows.count );
            std::iota( order.begin(), order.end(), 0 );
            std::shuffle( order.begin(), order.end(), std::mt19937_64( 1 ) );
        }
        entry.values = inOrder( rows, order );
    };
    for ( auto& [name, entry] : entries )
    {
        if ( name.rfind( "particles/", 0 ) != 0 )
            continue;
        std::visit(
            [&]<class Values>( const Values& values )
            {
                if constexpr ( requires { values.fetch; } )
                    permute( entry, values );
            },
            decltype( entry.values )( entry.values ) );
    }
    Archive shuffled( std::move( entries ) );
    simulation.checkpoint( shuffled );
}

Real phaseSeconds( const std::string& phase )
{
    for ( const auto& entry : Profile::phases() )
        if ( entry.name == phase )
            return entry.seconds;
    return 0;
}

Real activitySeconds( const Traffic& traffic, const Activity activity )
{
    return traffic.seconds[static_cast<std::size_t>( activity )];
}

//! Some steps, the slowest rank's seconds. `other` is what its parts, each of
//! the rank that was slowest there, leave of the step.
Sample advance( Simulation& simulation, const Case& setting, const int steps,
                Traffic& traffic )
{
    const Communicator ranks;
    Profile::start();
    Traffic::start();
    const Kokkos::Timer timer;
    for ( int k = 0; k < steps; ++k )
        simulation.step( 100 );
    ExecutionSpace().fence();
    std::vector<Real> seconds = { timer.seconds() };
    traffic = Traffic::upToNow();
    for ( const auto& entry : phases )
        seconds.push_back( phaseSeconds( entry.second ) );
    seconds.push_back( 0 ); // other
    seconds.push_back( activitySeconds( traffic, Activity::halo ) +
                       activitySeconds( traffic, Activity::halo_wait ) );
    seconds.push_back( activitySeconds( traffic, Activity::migration ) );
    seconds = ranks.max( seconds );
    Sample sample;
    sample.seconds = seconds[0] / steps;
    for ( std::size_t k = 0; k < partNames().size(); ++k )
        sample.parts[partNames()[k]] = seconds[k + 1] / steps;
    Real other = sample.seconds;
    for ( const auto& entry : phases )
        if ( setting.has( entry.first ) )
            other -= sample.parts[entry.first];
    // Where different ranks are slowest nothing may be left; a row has a rate.
    sample.parts["other"] = std::max( other, Real( 1e-9 ) );
    return sample;
}

int particleBytes( const int dim )
{
    return static_cast<int>( dim == 1   ? particle_bytes<1>
                             : dim == 2 ? particle_bytes<2>
                                        : particle_bytes<3> );
}

} // namespace

std::string Case::name() const
{
    return fmt::format( "{}/{}/{}D/{}/{}", method, basis, dim, per_cell,
                        order );
}

bool Case::has( const std::string& part ) const
{
    if ( part == "halo" || part == "migrate" )
        return Communicator().size() > 1;
    if ( part == "prepare" )
        return method.rfind( "conservative", 0 ) == 0;
    return part != "sort" || order != "unsorted";
}

const std::vector<std::string>& partNames()
{
    static const auto names = []
    {
        std::vector<std::string> list;
        for ( const auto& [part, phase] : phases )
            list.push_back( part );
        list.insert( list.end(), { "other", "halo", "migrate" } );
        return list;
    }();
    return names;
}

Recording record( const Case& setting, const Sizes& sizes )
{
    const Json input =
        resolveInput( makeInput( setting, sizes.particles ), setting.name() );
    Recording result;
    result.sort_every = 20;
    if ( setting.order != "unsorted" )
        result.sort_every = input.at( "particles" ).at( "sort_every" );
    const int steps = sizes.cycles * result.sort_every;
    const auto simulation = makeSimulation( input );
    // The first step sorts whatever `sort_every` says.
    if ( setting.order == "unsorted" )
        simulation->step( 100 );
    if ( setting.order != "ordered" )
        shuffle( *simulation );
    Traffic traffic;
    advance( *simulation, setting, steps, traffic ); // warms up
    for ( int k = 0; k < sizes.samples; ++k )
        result.samples.push_back(
            advance( *simulation, setting, steps, traffic ) );
    result.particles = static_cast<Real>( simulation->particles() );
    result.particle_bytes = particleBytes( setting.dim );
    result.bytes_held = simulation->bytesPerParticle();
    result.halo_bytes = static_cast<Real>( traffic.halo_bytes ) / steps;
    result.migrated_bytes = static_cast<Real>( traffic.migrated_bytes ) / steps;
    return result;
}

} // namespace Machpoint
