/*!
  \file catalogue.cpp
  \brief Everything that an input can name, listed and described.
*/
#include <drivers/catalogue.hpp>

#include <drivers/input.hpp>
#include <drivers/study_input.hpp>

#include <core/basis.hpp>
#include <core/exact.hpp>
#include <core/method_apic.hpp>
#include <core/method_conservative.hpp>
#include <core/method_paper.hpp>
#include <core/registry.hpp>
#include <core/shape_input.hpp>

#include <fmt/format.h>

#include <stdexcept>
#include <vector>

namespace Machpoint
{

namespace
{

//! A heading of `list` and what stands below it.
struct Section
{
    std::string title;
    std::vector<Parameters> entries;
};

//! Everything that an input can name.
std::vector<Section> catalogue()
{
    auto find = []( const std::string& key )
    {
        const auto all = inputParameters( 0 );
        for ( const auto& parameter : all.keys() )
            if ( parameter.name == key )
                return *parameter.nested;
        throw std::logic_error( "no input object " + key );
    };
    auto method = [&]( const std::string& name, const std::string& summary )
    {
        Parameters p( name, summary, 0 );
        p.object( "method", methodParameters( name, 0 ),
                  "the input's method object" );
        return p;
    };
    auto basis = []( const char* name, const int degree, const char* nodes )
    {
        return Parameters(
            name,
            fmt::format( "B-splines of degree {}, nodes at {}", degree, nodes ),
            0 );
    };
    return { { "input",
               { inputParameters( 0 ), find( "grid" ), find( "particles" ),
                 find( "time" ), find( "output" ), find( "checkpoint" ),
                 find( "decomposition" ), studyParameters() } },
             { "method",
               { method( Paper::name, Paper::summary ),
                 method( Apic::name, Apic::summary ),
                 method( Conservative::name, Conservative::summary ) } },
             { "basis",
               { basis( Linear::name, 1, "cell vertices" ),
                 basis( Quadratic::name, 2, "cell centres" ),
                 basis( Cubic::name, 3, "cell vertices" ) } },
             { "physics", physicsFamily().members( 0 ) },
             { "boundary", boundaryFamily().members( 0 ) },
             { "shape", shapeFamily().members( 0 ) },
             { "initial state", initialFamily().members( 0 ) },
             { "exact solution", exactFamily().members( 0 ) } };
}

//! The rows of a key, for each object that has it.
//! \return is there any?
bool describeKey( const std::string& key )
{
    std::string text, of_input;
    for ( const auto& section : catalogue() )
        for ( const auto& entry : section.entries )
        {
            const auto rows = describe( entry, key );
            if ( rows.empty() )
                continue;
            // The objects of an input are entries, too.
            auto& place = entry.name() == "input" ? of_input : text;
            place += fmt::format( "{}{} ({}): {}\n{}",
                                  place.empty() ? "" : "\n", entry.name(),
                                  section.title, entry.summary(), rows );
        }
    fmt::print( "{}", text.empty() ? of_input : text );
    return !text.empty() || !of_input.empty();
}

void addKeyNames( const Parameters& parameters,
                  std::vector<std::string>& names )
{
    for ( const auto& key : parameters.keys() )
    {
        names.push_back( key.name );
        if ( key.nested )
            addKeyNames( *key.nested, names );
    }
}

} // namespace

bool listEntries( const std::string& key )
{
    bool found = false;
    for ( const auto& section : catalogue() )
        for ( const auto& entry : section.entries )
            if ( key.empty() ||
                 key == section.title.substr( 0, section.title.find( ' ' ) ) )
            {
                fmt::print( "{:<16} {:<22} {}\n", section.title, entry.name(),
                            entry.summary() );
                found = true;
            }
    return found;
}

void describeByName( const std::string& name )
{
    std::vector<std::string> names, keys;
    bool found = false;
    for ( const auto& section : catalogue() )
        for ( const auto& entry : section.entries )
        {
            names.push_back( entry.name() );
            addKeyNames( entry, keys );
            if ( entry.name() != name )
                continue;
            fmt::print( "{}{} ({}): {}\n", found ? "\n" : "", entry.name(),
                        section.title, entry.summary() );
            fmt::print( "{}", describe( entry ) );
            found = true;
        }
    if ( found || listEntries( name ) || describeKey( name ) )
        return;
    names.insert( names.end(), keys.begin(), keys.end() );
    const auto near = nearest( name, names );
    throw InputError( { fmt::format(
        "describe: nothing is called \"{}\"{}; see machpoint list", name,
        near.empty() ? "" : "; did you mean \"" + near + "\"?" ) } );
}

} // namespace Machpoint
