/*!
  \file input.cpp
  \brief An input file, from text to a resolved and checked document.
*/
#include <drivers/input.hpp>

#include <drivers/input_conflicts.hpp>
#include <drivers/sound_keys.hpp>

#include <core/method_conservative.hpp>
#include <core/registry.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

namespace Machpoint
{

std::string readFile( const std::string& file )
{
    std::ifstream stream( file, std::ios::binary );
    std::ostringstream text;
    if ( stream )
        text << stream.rdbuf();
    if ( !stream || stream.bad() || std::filesystem::is_directory( file ) )
        throw InputError( { file + ": cannot be read; check that the path is "
                                   "a readable file" } );
    return text.str();
}

namespace
{

//! Defaults that depend on the method, of what is sound: a method that is has
//! all of its keys then but those whose default the dimension has a part in,
//! where that is not known.
void fillMethodDefaults( Json& input, const SoundKeys& sound )
{
    if ( !sound.have( { "method" } ) )
        return;
    const int dimension =
        sound.have( { "dimension" } ) ? input.at( "dimension" ).get<int>() : 0;
    auto& method = input.at( "method" );
    auto fill = []( Json& object, const std::string& key, const Json& value )
    {
        if ( !object.contains( key ) )
            object[key] = value;
    };
    for ( const auto own = methodParameters( method.at( "name" ), dimension );
          const auto& key : own.keys() )
        if ( key.default_value )
            fill( method, key.name, *key.default_value );
    if ( sound.have( { "time" } ) )
        fill( input.at( "time" ), "cfl",
              ConservativeParts::defaultCfl( method.at( "time" ),
                                             method.at( "basis" ) ) );
    if ( dimension == 0 )
        return; // nothing is asked of modules
    auto complete = [&]( const char* key, const auto& hooksOfEntry )
    {
        if ( !sound.have( { key } ) )
            return;
        for ( auto& entry : input.at( key ) )
            if ( const auto& hooks = hooksOfEntry( entry, dimension );
                 hooks.complete )
                hooks.complete( entry, methodFacts( input ) );
    };
    complete( "boundary", boundaryHooks );
    complete( "physics", physicsHooks );
}

//! The key with one value that an override reaches into, if it does: what the
//! file leaves out, applyOverride does not know. Empty: none.
std::string valueReachedInto( const std::string& assignment )
{
    auto text = assignment.substr( 0, assignment.find( '=' ) );
    std::replace( text.begin(), text.end(), '[', '.' );
    std::istringstream path( text );
    const auto all = inputParameters( 0 );
    const Parameters* place = &all;
    std::string name, step;
    while ( place && std::getline( path, step, '.' ) && !path.eof() )
    {
        name += ( name.empty() ? "" : "." ) + step;
        const auto& keys = place->keys();
        const auto key =
            std::find_if( keys.begin(), keys.end(),
                          [&]( const auto& k ) { return k.name == step; } );
        if ( key == keys.end() )
            return "";
        using Kind = Parameter::Kind;
        for ( const auto kind : { Kind::Number, Kind::Integer, Kind::Boolean,
                                  Kind::Text, Kind::Choice } )
            if ( key->kind == kind )
                return name;
        place = key->nested.get();
    }
    return "";
}

} // namespace

Json resolveInput( const Json& input, const std::string& file,
                   std::vector<std::string> errors )
{
    if ( input.is_object() && input.contains( "study" ) &&
         !input.contains( "scene" ) )
        throw InputError( { file + ": a study, not an input of one run; give "
                                   "it to machpoint study" } );
    int dimension = 0;
    if ( input.is_object() && input.contains( "dimension" ) )
    {
        const auto& value = input.at( "dimension" );
        if ( value.is_number_integer() && value >= 1 && value <= 3 )
            dimension = value;
    }
    Json resolved =
        resolve( input, inputParameters( dimension ), file, errors );
    const SoundKeys sound( resolved, input, file, errors );
    fillMethodDefaults( resolved, sound );
    for ( const auto& conflict : findConflicts( resolved, sound, dimension ) )
        errors.push_back( file + ": " + conflict );
    if ( !errors.empty() )
        throw InputError( errors );
    return resolved;
}

Json loadInput( const std::string& file,
                const std::vector<std::string>& overrides )
{
    std::vector<std::string> errors;
    Json input = parseJson( readFile( file ), file, errors );
    for ( const auto& assignment : overrides )
        try
        {
            if ( const auto key = valueReachedInto( assignment ); !key.empty() )
                throw InputError( { fmt::format(
                    "--set {}: {} is no object; set it itself, --set {}=VALUE",
                    assignment, key, key ) } );
            applyOverride( input, assignment );
        }
        catch ( const InputError& error )
        {
            errors.insert( errors.end(), error.messages().begin(),
                           error.messages().end() );
        }
    return resolveInput( input, file, std::move( errors ) );
}

} // namespace Machpoint
