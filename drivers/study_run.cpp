/*!
  \file study_run.cpp
  \brief A run of a study: its settings, its line, and the errors that it may be
  judged by.
*/
#include <drivers/study_run.hpp>

#include <drivers/input.hpp>
#include <drivers/study_probe.hpp>

#include <core/registry.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <map>

namespace Machpoint
{

const std::vector<std::string> solver_names = { "machpoint", "finite_volume" };

namespace
{

constexpr auto cells_key = "grid.cells"; // what makes a line

std::string shown( const Json& value )
{
    return value.is_string() ? value.get<std::string>() : value.dump();
}

//! "conservative cubic per_cell=4": what tells a line from the others.
//! \param whole_paths or "method.name=conservative ... particles.per_cell=4"
std::string lineName( const Json& settings, const bool whole_paths )
{
    std::vector<std::string> words;
    for ( const auto& item : settings.items() )
    {
        if ( item.key() == cells_key )
            continue;
        const auto& path = item.key();
        const auto value = shown( item.value() );
        if ( whole_paths )
            words.push_back( fmt::format( "{}={}", path, value ) );
        else if ( item.value().is_string() )
            words.push_back( value );
        else
            words.push_back( fmt::format(
                "{}={}", path.substr( path.rfind( '.' ) + 1 ), value ) );
    }
    return fmt::format( "{}", fmt::join( words, " " ) );
}

//! \throws InputError where a probe is outside the domain of a run
//! \param name of the run
void requireInside( const Json& probes, const Json& input,
                    const std::string& name )
{
    const auto& grid = input.at( "grid" );
    std::vector<std::string> errors;
    for ( std::size_t k = 0; k < probes.size(); ++k )
        for ( const auto* key : { "at", "from", "to" } )
            for ( std::size_t d = 0;
                  probes[k].contains( key ) && d < probes[k].at( key ).size();
                  ++d )
            {
                const double x = probes[k].at( key ).at( d );
                const double lower = grid.at( "lower" ).at( d );
                const double upper = grid.at( "upper" ).at( d );
                if ( x < lower || x > upper )
                    errors.push_back( fmt::format(
                        "{}: /probes/{}/{}/{}: {:g} is outside the domain, "
                        "which reaches from {:g} to {:g}",
                        name, k, key, d, x, lower, upper ) );
            }
    if ( !errors.empty() )
        throw InputError( errors );
}

} // namespace

std::string lineOf( const Json& settings, const Study& study )
{
    const auto name = lineName( settings, study.whole_paths );
    return name.empty() ? study.name : name;
}

bool areLinesTold( const std::vector<StudyRun>& runs )
{
    std::map<std::string, Json> lines;
    for ( const auto& run : runs )
    {
        auto settings = run.settings;
        settings.erase( cells_key );
        const auto line = lines.emplace( run.line, settings ).first;
        if ( line->second != settings )
            return false;
    }
    return true;
}

void setValue( Json& input, const std::string& path, const Json& value )
{
    applyOverride( input, fmt::format( "{}={}", path, value.dump() ) );
}

StudyRun makeStudyRun( const Study& study, const Json& settings,
                       const std::string& file )
{
    StudyRun run{ lineOf( settings, study ), settings, study.scene };
    std::vector<std::string> words;
    for ( const auto& item : settings.items() )
    {
        if ( item.key() == solver_key )
            run.solver = item.value() == solver_names[0]
                             ? Solver::machpoint
                             : Solver::finite_volume;
        else
            setValue( run.input, item.key(), item.value() );
        words.push_back(
            fmt::format( "{}={}", item.key(), shown( item.value() ) ) );
    }
    if ( !run.input.at( "output" ).contains( "every" ) )
        run.input["output"]["every"] = run.input.at( "time" ).at( "end" );
    const auto name =
        words.empty() ? file
                      : fmt::format( "{}: {}", file, fmt::join( words, " " ) );
    run.input = resolveInput( run.input, name );
    if ( study.scene.at( "output" ).value( "grid", false ) &&
         !run.input.at( "output" ).at( "grid" ) )
        throw InputError( { name + ": /output/grid: the study compares what is "
                                   "on the grid; leave it out" } );
    requireInside( study.probes, run.input, name );
    return run;
}

bool isFieldError( const std::string& error )
{
    return error.ends_with( ".L1" ) || error.ends_with( ".L2" ) ||
           error.ends_with( ".Linf" );
}

std::vector<std::string> fieldErrors()
{
    std::vector<std::string> names;
    for ( const auto* field :
          { "density", "velocity", "pressure", "specific_internal_energy" } )
        for ( const auto* norm : { "L1", "L2", "Linf" } )
            names.push_back( fmt::format( "{}.{}", field, norm ) );
    return names;
}

std::vector<std::string> columnErrors( const Json& input, const Json& probes )
{
    std::vector<std::string> names;
    for ( const auto& probe : probes )
        names.push_back( probeColumn( probe ) );
    const int dimension = input.at( "dimension" );
    auto addColumns = [&]( const char* list, const auto& hooksOfEntry )
    {
        for ( const auto& entry : input.at( list ) )
        {
            const auto& columns = hooksOfEntry( entry, dimension ).columns;
            if ( !columns || !entry.contains( "name" ) )
                continue;
            const auto name = entry.at( "name" ).get<std::string>();
            for ( const auto& column : columns() )
                names.push_back( fmt::format( "{}.{}", name, column ) );
        }
    };
    addColumns( "boundary", boundaryHooks );
    addColumns( "physics", physicsHooks );
    return names;
}

std::vector<std::string> errorNames( const Study& study )
{
    if ( study.reference == Reference::known )
    {
        std::vector<std::string> names;
        for ( const auto& item : study.known.items() )
            names.push_back( item.key() );
        return names;
    }
    if ( study.kind == StudyKind::effects )
    {
        auto names = study.reference == Reference::exact
                         ? fieldErrors()
                         : std::vector<std::string>();
        std::vector<std::string> changing = { "density", "velocity",
                                              "pressure" };
        if ( !study.error.empty() && !isFieldError( study.error ) )
            for ( const auto& column :
                  columnErrors( study.runs.front().input, study.probes ) )
                changing.push_back( column );
        for ( const auto& name : changing )
            names.push_back( fmt::format( "{}.change", name ) );
        return names;
    }
    // Grids are kept only where they are compared.
    return isFieldError( study.error )
               ? fieldErrors()
               : columnErrors( study.runs.front().input, study.probes );
}

} // namespace Machpoint
