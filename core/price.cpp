#include <core/price.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace Machpoint
{

namespace
{

std::string percent( const Json& relative )
{
    return relative.is_null()
               ? "-"
               : fmt::format( "{:.3g} %", 100 * relative.get<double>() );
}

std::string formatEstimate( const Json& estimate )
{
    if ( estimate.contains( "message" ) )
        return fmt::format( "  no estimate of the error: {}\n",
                            estimate.at( "message" ).get<std::string>() );
    std::vector<std::string> grids;
    for ( const auto& run : estimate.at( "companions" ) )
        grids.push_back( formatCells( run.at( "cells" ) ) );
    auto text = fmt::format(
        "  estimated error {:>22} {:>12} {:>12}   (from {} cells, in {})\n",
        "L1", "of the field", "order", fmt::join( grids, " and " ),
        formatSeconds( estimate.at( "seconds" ) ) );
    for ( const auto& [field, e] : estimate.at( "fields" ).items() )
        text += fmt::format(
            "    {:<24} {:>12.4e} {:>12} {:>12}\n", field,
            e.at( "L1" ).get<double>(), percent( e.at( "relative" ) ),
            e.at( "order" ).is_null() ? "-"
            : e.at( "observed_order" ).is_null()
                ? fmt::format( "{:g} assumed", e.at( "order" ).get<double>() )
                : fmt::format( "{:.2f}",
                               e.at( "observed_order" ).get<double>() ) );
    if ( estimate.contains( "order_message" ) )
        text +=
            fmt::format( "    no observed order: {}\n",
                         estimate.at( "order_message" ).get<std::string>() );
    return text;
}

} // namespace

Json makePrice( const Json& summary, const double process_seconds )
{
    const Json* estimate = nullptr;
    if ( const auto& e = summary.at( "error_estimate" );
         e.is_object() && e.contains( "fields" ) )
        estimate = &e.at( "fields" ).at( "density" );
    const bool is_exact = !summary.at( "errors" ).empty();
    const double wall = summary.at( "wall_seconds" );
    Json price = { { "seconds", wall },
                   { "error", nullptr },
                   { "relative_error", nullptr },
                   { "error_source", nullptr },
                   { "order", nullptr },
                   { "order_source", nullptr },
                   { "half_error_seconds", nullptr } };
    if ( is_exact )
    {
        const double error = summary.at( "errors" ).at( "density" ).at( "L1" );
        price["error"] = error;
        const double mass = summary.at( "conservation" ).at( "final_mass" );
        if ( mass > 0 )
            price["relative_error"] = error / mass;
        price["error_source"] = "exact";
    }
    else if ( estimate )
    {
        price["error"] = estimate->at( "L1" );
        price["relative_error"] = estimate->at( "relative" );
        price["error_source"] = "estimated";
    }
    const auto& relative = price.at( "relative_error" );
    if ( !relative.is_number() || relative.get<double>() < least_error )
        return price;
    const bool is_observed =
        estimate && !estimate->at( "observed_order" ).is_null();
    const double order =
        is_observed ? std::min( highest_order,
                                estimate->at( "observed_order" ).get<double>() )
                    : 1;
    price["order"] = order;
    price["order_source"] = is_observed ? "observed" : "assumed";
    const double dim = summary.at( "dimension" );
    // Outputs are as many, however fine the grid.
    const double output_now = summary.at( "communication" )
                                  .at( "seconds" )
                                  .at( "output" )
                                  .at( "largest" );
    // The first output comes before the clock, and a restart may make no step.
    const double output = output_now < process_seconds
                              ? wall * output_now / process_seconds
                              : wall;
    if ( order >= lowest_order )
        price["half_error_seconds"] =
            output + ( wall - output ) * std::pow( 2, ( dim + 1 ) / order );
    return price;
}

std::string formatPrice( const Json& summary )
{
    std::string text;
    if ( const auto& e = summary.at( "error_estimate" ); !e.is_null() )
        text += formatEstimate( e );
    const auto& price = summary.at( "price" );
    text +=
        fmt::format( "  price: {}", formatSeconds( price.at( "seconds" ) ) );
    if ( price.at( "error" ).is_null() )
    {
        const bool is_whole = summary.at( "final_time" ) >=
                              summary.at( "input" ).at( "time" ).at( "end" );
        return fmt::format(
            "{}{}\n", text,
            is_whole && summary.at( "error_estimate" ).is_null()
                ? "; its error is not known: --estimate-error estimates it"
                : "" );
    }
    text += fmt::format( " for a density error of {} (L1, {})",
                         percent( price.at( "relative_error" ) ),
                         price.at( "error_source" ) == "exact" ? "against exact"
                                                               : "estimated" );
    const bool is_observed = price.at( "order_source" ) == "observed";
    if ( const auto& half = price.at( "half_error_seconds" ); !half.is_null() )
        text += fmt::format( "; half of it takes some {} ({} order {:.2g})",
                             formatSeconds( half ),
                             is_observed ? "observed" : "assumed",
                             price.at( "order" ).get<double>() );
    else if ( is_observed )
        text += fmt::format( "; order {:.2g} tells nothing of finer grids",
                             price.at( "order" ).get<double>() );
    return fmt::format( "{}\n", text );
}

std::string formatSeconds( const double seconds )
{
    constexpr double minute = 60, hour = 3600, day = 86400;
    return seconds < 2 * minute ? fmt::format( "{:.3g} s", seconds )
           : seconds < 2 * hour ? fmt::format( "{:.3g} min", seconds / minute )
           : seconds < 2 * day  ? fmt::format( "{:.3g} h", seconds / hour )
                                : fmt::format( "{:.4g} days", seconds / day );
}

std::string formatCells( const std::vector<std::int64_t>& cells )
{
    return fmt::format( "{}", fmt::join( cells, " x " ) );
}

} // namespace Machpoint
