/*!
  \file input_parameters.cpp
  \brief The keys of an input, declared.
*/
#include <drivers/input.hpp>

#include <core/basis.hpp>
#include <core/exact.hpp>
#include <core/method_apic.hpp>
#include <core/method_conservative.hpp>
#include <core/method_paper.hpp>
#include <core/registry.hpp>

#include <fmt/format.h>

namespace Machpoint
{

namespace
{
//! Numbers of steps are counted as int.
constexpr double most_steps = 1e9;
} // namespace

Parameters methodParameters( const std::string& name, const int dimension )
{
    const bool is_any = name.empty();
    const bool has_parts = is_any || name == Conservative::name;
    using Names = std::vector<std::string>;
    Parameters method( "method", "numerical method", dimension );
    auto& names = method.choice(
        "name",
        is_any ? Names{ Paper::name, Apic::name, Conservative::name }
               : Names{ name },
        "time stepping method" );
    auto& basis = method.choice(
        "basis", { Linear::name, Quadratic::name, Cubic::name }, "B-splines" );
    auto& time = method.choice( "time",
                                has_parts ? Names{ "symplectic", "midpoint" }
                                          : Names{ "symplectic" },
                                "time integrator" );
    if ( is_any )
    {
        basis.optional( "linear of paper, else quadratic" );
        time.optional( "midpoint of conservative, else symplectic" );
        time.description += "; midpoint is of conservative alone";
    }
    else
    {
        basis.defaultsTo( name == Paper::name  ? Paper::default_basis
                          : name == Apic::name ? Apic::default_basis
                                               : Conservative::default_basis );
        time.defaultsTo( has_parts ? ConservativeParts::default_time
                                   : "symplectic" );
    }
    if ( !has_parts )
        return method;
    names.defaultsTo( Conservative::name );
    time.switches( "midpoint", "symplectic" );
    const auto parts = ConservativeParts::declare( dimension );
    const auto in_1d = ConservativeParts::declare( 1 );
    for ( std::size_t k = 0; k < parts.keys().size(); ++k )
    {
        const auto& part = parts.keys()[k];
        auto& key = part.kind == Parameter::Kind::Boolean
                        ? method.boolean( part.name, part.description )
                        : method.number( part.name, part.description );
        key = part;
        const auto& value = *part.default_value;
        const auto& line = *in_1d.keys()[k].default_value;
        const bool differs = dimension == 0 && line != value;
        // No default applies before method and dimension are known.
        if ( is_any || differs )
        {
            key.optional( differs ? fmt::format( "{} in 1D, else {}",
                                                 line.get<double>(),
                                                 value.get<double>() )
                                  : value.dump() );
            key.default_value.reset();
        }
        if ( is_any )
            key.description += " (of conservative alone)";
    }
    return method;
}

Parameters inputParameters( const int dimension )
{
    Parameters grid( "grid", "uniform Cartesian grid", dimension );
    grid.vector( "lower", "lower corner of the domain" ).unit( "length" );
    grid.vector( "upper", "upper corner of the domain" ).unit( "length" );
    grid.integerVector( "cells", "number of cells" ).atLeast( 1 ).atMost( 1e8 );

    Parameters particles( "particles", "the gas's particles", dimension );
    particles.integer( "per_cell", "particles per cell" )
        .atLeast( 1 )
        .atMost( 10000 );
    particles
        .choice( "placement", { "lattice", "jittered", "random" },
                 "where they start within a cell" )
        .defaultsTo( "lattice" );
    particles.integer( "seed", "of all random numbers" )
        .atLeast( 0 )
        .defaultsTo( 1 );
    particles
        .integer(
            "sort_every",
            "steps between sorts by cell, of particles that are out of order" )
        .atLeast( 1 )
        .atMost( most_steps )
        .defaultsTo( 20 );

    Parameters time( "time", "length of the run and of its steps", dimension );
    time.number( "end", "final time" ).unit( "time" ).above( 0 );
    time.number( "cfl", "Courant number: part of a cell that the fastest wave "
                        "crosses in a step" )
        .above( 0 )
        .atMost( 100 )
        .source( "stable up to the limits in docs/stability.md" )
        .optional( "0.8 of midpoint, 0.5 on the linear basis; else 0.4" );
    time.integer( "retries", "how often a step that breaks the gas is repeated "
                             "with half its length before the run ends" )
        .atLeast( 0 )
        .atMost( 50 )
        .switches( "retries", 0 )
        .defaultsTo( 10 );

    Parameters decomposition(
        "decomposition", "boxes of cells, one for each MPI rank", dimension );
    decomposition
        .integerVector( "ranks", "ranks along each axis; by default the boxes "
                                 "with the least area of cuts" )
        .atLeast( 1 )
        .atMost( 1e6 )
        .optional();
    Parameters balance( "balance", "boxes that follow the gas", dimension );
    balance
        .integer( "every", "steps between looks at the ranks' loads; 0: boxes "
                           "stay as they begin, of equal numbers of cells or, "
                           "in a restart, as its checkpoint has them" )
        .atLeast( 0 )
        .atMost( most_steps )
        .defaultsTo( 20 );
    balance
        .number( "threshold", "largest over mean load of the ranks above which "
                              "the cuts move" )
        .atLeast( 1 )
        .defaultsTo( 1.1 );
    balance.number( "cell_cost", "load of a cell; that of a particle is 1" )
        .unit( "particles" )
        .atLeast( 0 )
        .defaultsTo( 0.1 )
        .source( "measured: docs/ranks.md" );
    decomposition.object( "balance", balance,
                          "when the cuts between boxes move" );

    Parameters output( "output", "what is written, and when", dimension );
    output.number( "every", "time between outputs; by default start and end" )
        .unit( "time" )
        .above( 0 )
        .optional();
    output.boolean( "particles", "write particles" ).defaultsTo( true );
    output.boolean( "grid", "write node fields" ).defaultsTo( true );
    output
        .integer( "compression", "effort of compressing what is written "
                                 "(shuffle and deflate); 0: none" )
        .atLeast( 0 )
        .atMost( 9 )
        .defaultsTo( 0 );

    Parameters checkpoint( "checkpoint",
                           "when the state is kept to restart from; never, "
                           "unless one of the first three says so",
                           dimension );
    checkpoint.integer( "every_steps", "steps between checkpoints" )
        .atLeast( 1 )
        .optional();
    checkpoint
        .number( "every_time", "time between checkpoints; steps are not cut "
                               "for it" )
        .unit( "time" )
        .above( 0 )
        .optional();
    checkpoint
        .number( "every_wall_seconds", "seconds of the clock between "
                                       "checkpoints" )
        .unit( "s" )
        .above( 0 )
        .optional();
    checkpoint.integer( "keep", "how many checkpoints are kept, the last ones" )
        .atLeast( 1 )
        .atMost( most_steps )
        .defaultsTo( 2 );

    Parameters all( "input", "a run of machpoint", dimension );
    all.text( "scene", "name of the scene and of its output directory" )
        .nonEmpty();
    all.integer( "dimension", "number of axes" ).atLeast( 1 ).atMost( 3 );
    all.object( "grid", grid, "the domain and its cells" );
    all.object( "method", methodParameters( "", dimension ),
                "how the equations are solved" );
    all.object( "particles", particles, "how many particles, and where" );
    all.listOf( "physics", physicsFamily(),
                "the gas and the effects that act on it, in order" )
        .nonEmpty();
    all.listOf( "initial", initialFamily(),
                "what fills the domain; later entries overwrite earlier ones" )
        .nonEmpty();
    all.listOf( "boundary", boundaryFamily(), "sides and obstacles" )
        .nonEmpty();
    all.object( "time", time, "length of the run" );
    all.oneOf( "exact", exactFamily(), "exact solution to measure errors by" )
        .optional();
    all.object( "decomposition", decomposition,
                "which rank computes which part of the domain" );
    all.boolean( "reproducible", "the same bits on any number of ranks and "
                                 "threads, at a price (docs/ranks.md)" )
        .switches( "reproducible sums", false )
        .defaultsTo( false );
    all.object( "output", output, "what is written" );
    all.object( "checkpoint", checkpoint, "what to restart from, and when" );
    return all;
}

Json inputSchema()
{
    auto schema = jsonSchema( inputParameters( 0 ) );
    auto& method = schema["properties"]["method"];
    for ( const auto* name : { Paper::name, Apic::name } )
    {
        Json is_it, own;
        is_it["properties"]["name"]["const"] = name;
        is_it["required"] = Json::array( { "name" } );
        own["properties"] =
            jsonSchema( methodParameters( name, 0 ) )["properties"];
        own["additionalProperties"] = false;
        method["allOf"].push_back( { { "if", is_it }, { "then", own } } );
    }
    return schema;
}

} // namespace Machpoint
