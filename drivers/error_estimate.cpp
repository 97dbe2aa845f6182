#include <drivers/error_estimate.hpp>

#include <core/communicator.hpp>
#include <core/price.hpp>

#include <fmt/format.h>

#include <Kokkos_Timer.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace Machpoint
{

namespace
{

//! The order p of errors C h^p, by bisection of (b^p - 1) / (1 - a^-p), which
//! grows with p. \param quotient far / near \param ratio a \param far_ratio b
double observedOrder( const double quotient, const double ratio,
                      const double far_ratio )
{
    const double a = std::log( ratio ), b = std::log( far_ratio );
    double low = -20, high = 20; // no scheme's
    for ( int k = 0; k < 80; ++k )
    {
        const double p = 0.5 * ( low + high );
        const double expected =
            p == 0 ? b / a : std::expm1( p * b ) / -std::expm1( -p * a );
        ( expected < quotient ? low : high ) = p;
    }
    return high;
}

} // namespace

Extrapolation extrapolate( const double near, const std::optional<double> far,
                           const double ratio, const double far_ratio )
{
    Extrapolation result;
    if ( far && *far > 0 && near > 0 )
    {
        result.observed = observedOrder( *far / near, ratio, far_ratio );
        result.order =
            std::clamp( *result.observed, lowest_order, highest_order );
    }
    result.error = near / ( std::pow( ratio, result.order ) - 1 );
    return result;
}

namespace
{

constexpr const char* estimate_error = "--estimate-error";
constexpr std::int64_t factors[] = { 2, 4 };
constexpr std::int64_t fewest_companion_cells = 8;

//! What one companion left; no fields unless it came to its end.
struct Companion
{
    Json input;
    std::optional<GridFields> fields;
    std::string message; //!< why there are none
};

Companion runCompanion( const Json& input, const double time,
                        const IsStopped& stop, Json& list )
{
    const Communicator ranks;
    Companion companion{ input, {}, {} };
    Kokkos::Timer timer;
    try
    {
        const auto simulation = makeCompanion( input, estimate_error );
        stepTo( *simulation, input, time, stop );
        if ( simulation->time() < time )
        {
            companion.message = "its companion runs were stopped";
            return companion;
        }
        companion.fields.emplace( wholeGrid( ranks, simulation->gridData() ) );
        list.push_back( { { "cells", input.at( "grid" ).at( "cells" ) },
                          { "steps", simulation->steps() },
                          { "seconds", timer.seconds() } } );
    }
    catch ( const NumericalFailure& failure )
    {
        companion.message = fmt::format(
            "the companion with {} cells failed: {}",
            formatCells( input.at( "grid" ).at( "cells" ) ), failure.what() );
    }
    catch ( const InputError& error )
    {
        companion.message = error.what();
    }
    return companion;
}

//! A velocity, integrated over the domain, that is round-off beside the speed
//! of sound. \param fields as fieldDifferences has them
double restVelocity( const std::vector<FieldDifference>& fields,
                     const Json& input )
{
    const auto& grid = input.at( "grid" );
    double volume = 1;
    for ( std::size_t d = 0; d < grid.at( "lower" ).size(); ++d )
        volume *= grid.at( "upper" ).at( d ).get<double>() -
                  grid.at( "lower" ).at( d ).get<double>();
    return least_error * volume * std::sqrt( fields[2].size / fields[0].size );
}

} // namespace

void requireCompanions( const Json& input )
{
    const auto coarse = coarsened( input, factors[0] );
    if ( 2 * resolution( coarse ) > resolution( input ) + 1 )
        throw InputError( { "/grid/cells: --estimate-error runs the scene on "
                            "half the cells, too, and these are too few for "
                            "that; take 7 or more along an axis" } );
    // The velocities of all nodes are gathered on the root.
    double bytes = sizeof( Real ) * input.at( "grid" ).at( "cells" ).size();
    for ( const double cells : input.at( "grid" ).at( "cells" ) )
        bytes *= cells + 1;
    if ( Communicator().size() > 1 && bytes > std::numeric_limits<int>::max() )
        throw InputError( { fmt::format(
            "/grid/cells: --estimate-error gathers {:.3g} GiB of velocities "
            "on one rank, and 2 are the most; run it on one rank, or take "
            "fewer cells",
            bytes / ( 1 << 30 ) ) } );
    makeCompanion( coarse, estimate_error );
}

Json estimateError( const Json& input, const GridData& fine, const double time,
                    const IsStopped& stop )
{
    const Communicator ranks;
    Json result = { { "companions", Json::array() } };
    auto& list = result.at( "companions" );
    Kokkos::Timer timer;
    const auto half =
        runCompanion( coarsened( input, factors[0] ), time, stop, list );
    if ( !half.fields )
    {
        result["message"] = half.message;
        return result;
    }
    const auto coarse = coarsened( input, factors[1] );
    const Companion quarter =
        resolution( coarse ) < fewest_companion_cells
            ? Companion{ coarse, {}, "a grid of a quarter has too few cells" }
            : runCompanion( coarse, time, stop, list );
    if ( !quarter.fields )
        result["order_message"] = quarter.message;
    result["seconds"] = timer.seconds();
    const GridFields whole( wholeGrid( ranks, fine ) );
    if ( !ranks.isRoot() )
        return result;
    const auto near = fieldDifferences( *half.fields, whole, half.input );
    if ( !( near[0].size > 0 ) )
    {
        result["message"] = "no cell has gas on both grids";
        return result;
    }
    std::vector<FieldDifference> far;
    if ( quarter.fields )
        far = fieldDifferences( *quarter.fields, *half.fields, quarter.input );
    auto ratioOf = []( const Json& finer, const Json& coarser )
    {
        return static_cast<double>( resolution( finer ) ) /
               static_cast<double>( resolution( coarser ) );
    };
    const double ratio = ratioOf( input, half.input );
    const double far_ratio = ratioOf( half.input, quarter.input );
    const double rest = restVelocity( near, input );
    for ( std::size_t f = 0; f < near.size(); ++f )
    {
        const auto& [error, size] = near[f];
        auto& field = result["fields"][error.field];
        const bool is_rest = error.field == "velocity" && size < rest;
        if ( is_rest || error.L1 < least_error * size )
        {
            field = {
                { "L1", error.L1 },
                { "relative", is_rest ? Json() : Json( error.L1 / size ) },
                { "order", nullptr },
                { "observed_order", nullptr } };
            continue;
        }
        std::optional<double> farther;
        if ( !far.empty() )
            farther = far[f].error.L1;
        const auto e = extrapolate( error.L1, farther, ratio, far_ratio );
        field["L1"] = e.error;
        field["relative"] = e.error / size;
        field["order"] = e.order;
        field["observed_order"] = e.observed ? Json( *e.observed ) : Json();
    }
    return result;
}

} // namespace Machpoint
