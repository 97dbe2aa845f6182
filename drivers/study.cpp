/*!
  \file study.cpp
  \brief A study from its file to what it tells.
*/
#include <drivers/study.hpp>

#include <drivers/study_advice.hpp>
#include <drivers/study_effects.hpp>
#include <drivers/study_laboratory.hpp>
#include <drivers/study_report.hpp>
#include <drivers/tell.hpp>

#include <core/price.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

//! The decimal number that a text begins with, 0 if with none, and what
//! follows.
std::pair<double, std::string> leadingNumber( const std::string& text )
{
    double number = 0;
    const char* end = text.data() + text.size();
    const auto rest = std::from_chars( text.data(), end, number ).ptr;
    return { number, std::string( rest, end ) };
}

//! An error that is to be reached.
struct Target
{
    std::string name;
    double value = 0;
};

Target parseTarget( const std::string& text, const Study& study )
{
    const auto equals = text.find( '=' );
    const auto names = errorNames( study );
    Target target{ text.substr( 0, equals ) };
    const auto [number, rest] = leadingNumber(
        equals == std::string::npos ? "" : text.substr( equals + 1 ) );
    target.value = number;
    if ( !rest.empty() || !( number > 0 ) || !std::isfinite( number ) )
        throw InputError( { fmt::format(
            "--target {}: expected NAME=VALUE with a value > 0, as in {}=1e-3",
            text, study.error ) } );
    if ( std::find( names.begin(), names.end(), target.name ) == names.end() )
    {
        const auto near = nearest( target.name, names );
        throw InputError( { fmt::format(
            "--target {}: this study tells {}{}", text,
            fmt::join( names, ", " ),
            near.empty() ? ""
                         : fmt::format( "; did you mean \"{}\"?", near ) ) } );
    }
    return target;
}

//! \return seconds
double parseBudget( const std::string& text )
{
    const auto [number, rest] = leadingNumber( text );
    const std::map<std::string, double> units = {
        { "", 1 }, { "s", 1 }, { "min", 60 }, { "h", 3600 } };
    const auto unit = units.find( rest );
    if ( unit == units.end() || !( number > 0 ) || !std::isfinite( number ) )
        throw InputError( { fmt::format(
            "--budget {}: expected a time > 0, as in 20s, 3min or 1h",
            text ) } );
    return number * unit->second;
}

} // namespace

ExitCode runStudy( const std::string& file, const StudyOptions& options )
{
    auto study = loadStudy( file );
    if ( options.clock == "processor" )
        study.clock = Clock::processor;
    const bool of_effects = study.kind == StudyKind::effects;
    if ( of_effects && !( options.target.empty() && options.budget.empty() ) )
        throw InputError( { fmt::format(
            "{}: --target and --budget choose among the runs of a study of "
            "kind accuracy; this one is of effects",
            file ) } );
    std::optional<Target> target;
    if ( !options.target.empty() )
        target = parseTarget( options.target, study );
    std::optional<double> budget;
    if ( !options.budget.empty() )
        budget = parseBudget( options.budget );
    if ( options.dry_run )
    {
        for ( const auto& run : study.runs )
            fmt::print( "{:>13} cells  {}\n", formatCells( run.cells() ),
                        run.line );
        fmt::print( "{}: {} runs, {} time(s) each\n", file, study.runs.size(),
                    study.repeats );
        return finished;
    }

    const fs::path folder = options.output.empty()
                                ? fs::path( "out/studies" ) / study.name
                                : fs::path( options.output );
    Laboratory laboratory( study, folder );
    if ( const auto foreign = laboratory.foreignRows() )
        tell( "machpoint: {} runs in {} are of another build and "
              "kept; to make them anew, remove the directory\n",
              foreign, folder.string() );
    if ( !laboratory.runAll() )
    {
        tell( "machpoint: stopped; to go on, repeat the "
              "command\n" );
        return stopped_early;
    }
    const auto& rows = laboratory.rows();
    fmt::print( "{}", of_effects ? formatEffects( study, rows )
                                 : formatStudy( study, rows ) );
    auto code = ( of_effects && rows.front().isFailed() ) ||
                        std::all_of( rows.begin(), rows.end(),
                                     []( const StudyRow& row )
                                     { return row.isFailed(); } )
                    ? numerical_failure
                    : finished;
    if ( target && code == finished )
        code = reachTarget( laboratory, target->name, target->value );
    if ( budget && code == finished )
        code = spendBudget( laboratory, study.error, *budget );
    fmt::print( "output: {}\n", folder.string() );
    return code;
}

} // namespace Machpoint
