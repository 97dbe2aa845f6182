#include <drivers/dry_run.hpp>

#include <drivers/output_times.hpp>
#include <drivers/run.hpp>
#include <drivers/study_fit.hpp>

#include <core/communicator.hpp>
#include <core/exact.hpp>
#include <core/price.hpp>
#include <core/report.hpp>
#include <core/scene.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace Machpoint
{

namespace
{

constexpr const char* option = "--estimate";
//! \name What the next finer rung may be expected to take
//! Anything up to the first, more where the run is long, the second at most.
//! @{
constexpr double affordable = 5, most_affordable = 30; // seconds
constexpr double affordable_share = 0.02;              // of the run
//! @}
//! Seconds after which a calibration has seen enough, and those that it may
//! take for fewer steps than it should.
constexpr double enough = 0.3, longest_calibration = 3;
//! Steps that a calibration should take: all that there is between two sorts,
//! after a first one that meets cold memory.
constexpr std::size_t calibration_steps = 21;
//! A coarsest rung with fewer cells along its longest axis shows no flow.
constexpr std::int64_t fewest_cells = 12;
//! What a prediction is believed to, where the rungs fare no worse.
constexpr double least_doubt = 0.15;

double sumOfParticles( const std::vector<StepCost>& costs )
{
    double sum = 0;
    for ( const auto& cost : costs )
        sum += static_cast<double>( cost.particles );
    return sum;
}

double sumOfSeconds( const std::vector<StepCost>& costs )
{
    double sum = 0;
    for ( const auto& cost : costs )
        sum += cost.seconds;
    return sum;
}

//! Seconds per particle and step; the first step aside.
double rate( const Calibration& calibration )
{
    auto costs = calibration.costs;
    if ( costs.size() > 1 )
        costs.erase( costs.begin() );
    return sumOfSeconds( costs ) / sumOfParticles( costs );
}

//! The middle of the first steps' seconds per particle: on a busy machine one
//! step may take many times as long as another.
double medianRate( const std::vector<StepCost>& costs, const std::size_t steps )
{
    std::vector<double> rates;
    for ( std::size_t k = 0; k < steps; ++k )
        rates.push_back( costs[k].seconds /
                         static_cast<double>( costs[k].particles ) );
    const auto middle = rates.begin() + static_cast<int>( steps / 2 );
    std::nth_element( rates.begin(), middle, rates.end() );
    return *middle;
}

double fineness( const Json& input )
{
    const auto& grid = input.at( "grid" );
    double largest = 0;
    for ( std::size_t d = 0; d < grid.at( "cells" ).size(); ++d )
    {
        const double lower = grid.at( "lower" ).at( d );
        const double upper = grid.at( "upper" ).at( d );
        const double cells = grid.at( "cells" ).at( d );
        largest = std::max( largest, cells / ( upper - lower ) );
    }
    return largest;
}

//! How often a run writes.
std::int64_t outputCount( const Json& input )
{
    const double end = input.at( "time" ).at( "end" );
    std::int64_t count = 2; // start and end
    for ( OutputTimes times( input, 0 ); times.next() < end; times.pass() )
        ++count;
    return count;
}

//! Takes the memory that an output takes.
void sample( Simulation& simulation, const Json& input )
{
    if ( input.at( "output" ).at( "particles" ) )
        simulation.particleData();
    if ( input.at( "output" ).at( "grid" ) )
        simulation.gridData();
}

Rung climb( const Communicator& ranks, const Json& input )
{
    Kokkos::Timer timer;
    Rung rung;
    rung.cells = input.at( "grid" ).at( "cells" ).get<decltype( rung.cells )>();
    rung.fineness = fineness( input );
    rung.fixed = start_up_steps * ( 1 - start_up_factor ) +
                 static_cast<double>( outputCount( input ) );
    const auto simulation = makeCompanion( input, option );
    rung.first = simulation->particles();
    rung.costs = stepTo( *simulation, input, input.at( "time" ).at( "end" ),
                         []( const Simulation& ) { return false; } );
    rung.last = simulation->particles();
    rung.most = rung.first;
    for ( const auto& cost : rung.costs )
        rung.most = std::max( rung.most, cost.particles );
    rung.bytes_per_particle = simulation->bytesPerParticle();
    sample( *simulation, input );
    rung.seconds = ranks.max( timer.seconds() );
    return rung;
}

/*!
  \brief Runs on ever finer grids, up to half the cells along each axis, as long
  as that is cheap.
  \throws what kept all of them from running
*/
std::vector<Rung> ladder( const Communicator& ranks, const Json& input )
{
    const int dim = input.at( "dimension" );
    std::int64_t factor = 2;
    while ( resolution( input ) >= 2 * factor * fewest_cells )
        factor *= 2;
    std::vector<Rung> rungs;
    for ( ; factor > 1; factor /= 2 )
    {
        if ( !rungs.empty() )
        {
            const double next = std::pow( 2, dim + 1 ) * rungs.back().seconds;
            const double run = next * std::pow( factor, dim + 1 );
            if ( next > std::clamp( affordable_share * run, affordable,
                                    most_affordable ) )
                break;
        }
        try
        {
            rungs.push_back( climb( ranks, coarsened( input, factor ) ) );
        }
        // Too coarse for this scene, or for so many ranks.
        catch ( const InputError& )
        {
            if ( factor == 2 && rungs.empty() )
                throw;
        }
        catch ( const NumericalFailure& )
        {
            if ( factor == 2 && rungs.empty() )
                throw;
        }
    }
    return rungs;
}

Calibration calibrate( const Communicator& ranks, const Json& input )
{
    Calibration result;
    result.cells =
        input.at( "grid" ).at( "cells" ).get<decltype( result.cells )>();
    result.fineness = fineness( input );
    const auto simulation = makeCompanion( input, option );
    result.first = simulation->particles();
    Kokkos::Timer timer;
    result.bytes_per_particle = simulation->bytesPerParticle();
    result.costs = stepTo(
        *simulation, input, input.at( "time" ).at( "end" ),
        [&]( const Simulation& s )
        {
            const double seconds = ranks.max( timer.seconds() );
            return s.steps() < static_cast<std::int64_t>( calibration_steps )
                       ? s.steps() > 3 && seconds > longest_calibration
                       : seconds > enough;
        } );
    sample( *simulation, input );
    return result;
}

//! Free memory of this machine, bytes; infinite where the system does not say.
double availableMemory()
{
    std::ifstream stream( "/proc/meminfo" );
    std::string line;
    while ( std::getline( stream, line ) )
        if ( line.starts_with( "MemAvailable:" ) )
            return 1024 * std::strtod( line.c_str() + 13, nullptr );
    return std::numeric_limits<double>::infinity();
}

std::string formatBytes( const double bytes )
{
    constexpr double mega = 1 << 20;
    return bytes < 1000 * mega
               ? fmt::format( "{:.3g} MiB", bytes / mega )
               : fmt::format( "{:.3g} GiB", bytes / mega / 1024 );
}

//! Bytes of an output, uncompressed.
double outputBytes( const Json& input, const double particles )
{
    const int dim = input.at( "dimension" );
    const auto& output = input.at( "output" );
    double bytes = 0;
    if ( output.at( "particles" ) )
    {
        // In 1D positions in a plane, too, for ParaView.
        const int numbers = 2 * dim + 4 + ( dim == 1 ? 2 : 0 );
        bytes += static_cast<double>( numbers * sizeof( Real ) +
                                      sizeof( std::int64_t ) ) *
                 particles;
        if ( dim == 1 && makeExact( input ) )
            bytes += 5 * profile_points * sizeof( double );
    }
    if ( output.at( "grid" ) )
        bytes += static_cast<double>( ( 3 + dim ) * sizeof( Real ) ) *
                 cellCount( input.at( "grid" ).at( "cells" ) );
    return bytes;
}

} // namespace

Forecast forecast( const std::vector<Rung>& rungs, const double fineness,
                   const double first, const Calibration& calibration )
{
    const auto& finest = rungs.back();
    const auto& costs = finest.costs;
    const auto steps = static_cast<double>( costs.size() );
    double slope = std::max( 0.0, steps - finest.fixed ) / finest.fineness;
    if ( rungs.size() > 1 )
    {
        const auto& coarser = rungs[rungs.size() - 2];
        const double finer = finest.fineness - coarser.fineness;
        const double more = steps - static_cast<double>( coarser.costs.size() );
        if ( finer > 0 )
            slope = std::clamp( more / finer, slope, steps / finest.fineness );
    }
    // The part of the finest rung that the calibration is of the run.
    const double time = calibration.costs.back().time;
    const auto seen = std::count_if( costs.begin(), costs.end(),
                                     [&]( const StepCost& cost )
                                     { return cost.time <= time; } );
    const auto part =
        std::min( costs.size(), std::max( calibration_steps,
                                          static_cast<std::size_t>( seen ) ) );
    const double slowdown =
        medianRate( costs, costs.size() ) / medianRate( costs, part );
    const double scale = first / static_cast<double>( finest.first );
    Forecast result;
    result.steps = std::round( steps + slope * ( fineness - finest.fineness ) );
    if ( calibration.fineness == fineness )
    {
        // So many steps of the finest rung has the run behind it.
        double behind = static_cast<double>( seen );
        if ( behind < steps )
        {
            const double before = seen > 0 ? costs[seen - 1].time : 0;
            behind += ( time - before ) / ( costs[seen].time - before );
        }
        const auto own = static_cast<double>( calibration.costs.size() );
        result.steps = std::max(
            result.steps, std::round( own + std::max( 1.0, own / behind ) *
                                                ( steps - behind ) ) );
    }
    result.last = scale * static_cast<double>( finest.last );
    result.most = scale * static_cast<double>( finest.most );
    result.seconds = result.steps * scale * sumOfParticles( costs ) / steps *
                     rate( calibration ) * slowdown;
    return result;
}

namespace
{

//! As if the finest rung were the run: by which factor would its time have been
//! foretold wrongly, less 1?
double doubtOf( const std::vector<Rung>& rungs )
{
    if ( rungs.size() < 2 )
        return least_doubt;
    const auto& finest = rungs.back();
    Calibration calibration = finest;
    calibration.costs.resize(
        std::min( finest.costs.size(), calibration_steps ) );
    const auto told =
        forecast( { rungs.begin(), rungs.end() - 1 }, finest.fineness,
                  static_cast<double>( finest.first ), calibration );
    const double real = sumOfSeconds( finest.costs );
    return std::max(
        { least_doubt, told.seconds / real - 1, real / told.seconds - 1 } );
}

/*!
  \brief The first steps of the run itself, of one on a coarser grid where that
  would take too long or too much memory, or else those of the finest rung.
  \param bytes that the finest rung took
*/
Calibration calibration( const Communicator& ranks, const Json& input,
                         const Rung& finest, const double bytes )
{
    const double free = ranks.min( availableMemory() );
    const double step =
        finest.seconds / static_cast<double>( finest.costs.size() );
    for ( std::int64_t factor = 1;; factor *= 2 )
    {
        const auto coarse = factor > 1 ? coarsened( input, factor ) : input;
        const double larger = cellCount( coarse.at( "grid" ).at( "cells" ) ) /
                              cellCount( finest.cells );
        if ( larger <= 1 )
            return finest;
        if ( 3 * step * larger < longest_calibration &&
             bytes * larger < 0.8 * free )
            return calibrate( ranks, coarse );
    }
}

//! Of a short run, which its first steps have made.
Forecast whatItTook( const Calibration& run )
{
    Forecast result;
    result.steps = static_cast<double>( run.costs.size() );
    result.last = static_cast<double>( run.costs.back().particles );
    result.most = static_cast<double>( run.first );
    for ( const auto& cost : run.costs )
        result.most =
            std::max( result.most, static_cast<double>( cost.particles ) );
    result.seconds = sumOfSeconds( run.costs );
    return result;
}

} // namespace

ExitCode dryRun( const Json& input )
{
    const Communicator ranks;
    Kokkos::Timer timer;
    auto memory = [&]
    { return ranks.sum( static_cast<double>( peakMemory() ) ); };
    const double base = memory();
    const auto rungs = ladder( ranks, input );
    const auto first_steps =
        calibration( ranks, input, rungs.back(), memory() - base );
    const double larger = cellCount( input.at( "grid" ).at( "cells" ) ) /
                          cellCount( first_steps.cells );
    const double first = larger * static_cast<double>( first_steps.first );
    const bool is_whole =
        larger == 1 && first_steps.costs.back().time >=
                           input.at( "time" ).at( "end" ).get<double>();
    const auto told =
        is_whole ? whatItTook( first_steps )
                 : forecast( rungs, fineness( input ), first, first_steps );
    const double doubt = 1 + doubtOf( rungs );
    const double most =
        std::max_element( first_steps.costs.begin(), first_steps.costs.end(),
                          []( const StepCost& a, const StepCost& b )
                          { return a.particles < b.particles; } )
            ->particles;
    const double bytes =
        base + ( memory() - base ) * std::max( 1.0, told.most / most );
    const auto written = outputCount( input );
    if ( !ranks.isRoot() )
        return finished;

    std::vector<std::string> grids;
    for ( const auto& rung : rungs )
        grids.push_back( formatCells( rung.cells ) );
    fmt::print(
        "{}: what a run would take, told by runs with {} cells and {} {} "
        "steps with {}\n",
        input.at( "scene" ).get<std::string>(), fmt::join( grids, ", " ),
        is_whole ? "all" : "the first", first_steps.costs.size(),
        formatCells( first_steps.cells ) );
    auto print = []( const char* name, const std::string& text )
    { fmt::print( "  {:<12}{}\n", name, text ); };
    print( "time", fmt::format( "{} ({} to {}), without outputs",
                                formatSeconds( told.seconds ),
                                formatSeconds( told.seconds / doubt ),
                                formatSeconds( told.seconds * doubt ) ) );
    print( "steps", fmt::format( "{:.0f}", told.steps ) );
    print( "particles", fmt::format( "{:.0f} at the start, {:.0f} at the end",
                                     first, told.last ) );
    print( "memory",
           fmt::format(
               "{} of the host; the particles take {}", formatBytes( bytes ),
               formatBytes( told.most * first_steps.bytes_per_particle ) ) );
    print( "output",
           fmt::format( "{} times, {}", written,
                        formatBytes( static_cast<double>( written ) *
                                     outputBytes( input, told.most ) ) ) );
    print( "this took", formatSeconds( timer.seconds() ) );
    return finished;
}

} // namespace Machpoint
