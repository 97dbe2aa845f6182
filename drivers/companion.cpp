#include <drivers/companion.hpp>

#include <drivers/output_times.hpp>

#include <core/price.hpp>

#include <fmt/format.h>

#include <Kokkos_Timer.hpp>

#include <algorithm>

namespace Machpoint
{

std::vector<StepCost> stepTo( Simulation& simulation, const Json& input,
                              const double end, const IsStopped& stop )
{
    std::vector<StepCost> costs;
    OutputTimes outputs( input, simulation.time() );
    while ( simulation.time() < end )
    {
        const double next = std::min( outputs.next(), end );
        Kokkos::Timer timer;
        simulation.step( next );
        // An empty domain's step has its price, too.
        costs.push_back(
            { timer.seconds(),
              std::max( std::int64_t( 1 ), simulation.particles() ),
              simulation.time() } );
        if ( simulation.time() >= next )
            outputs.pass();
        if ( stop( simulation ) )
            break;
    }
    return costs;
}

std::int64_t resolution( const Json& input )
{
    const std::vector<std::int64_t> cells = input.at( "grid" ).at( "cells" );
    return *std::max_element( cells.begin(), cells.end() );
}

Json coarsened( const Json& input, const std::int64_t factor )
{
    constexpr std::int64_t fewest = 4;
    Json coarse = input;
    for ( auto& n : coarse.at( "grid" ).at( "cells" ) )
    {
        const auto cells = n.get<std::int64_t>();
        n = std::max( std::min( cells, fewest ),
                      ( cells + factor / 2 ) / factor );
    }
    return coarse;
}

std::unique_ptr<Simulation> makeCompanion( const Json& input,
                                           const char* option )
{
    try
    {
        return makeSimulation( input );
    }
    catch ( const InputError& error )
    {
        auto messages = error.messages();
        for ( auto& message : messages )
            message = fmt::format(
                "{} runs the scene with {} cells, too, and then {}", option,
                formatCells( input.at( "grid" ).at( "cells" ) ), message );
        throw InputError( messages );
    }
}

} // namespace Machpoint
