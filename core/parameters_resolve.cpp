/*!
  \file parameters_resolve.cpp
  \brief Checking an input against its declaration, with defaults filled in.
*/
#include <core/parameters.hpp>
#include <core/parameters_wording.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>

namespace Machpoint
{

namespace
{

using Kind = Parameter::Kind;

const Parameters* findMember( const std::vector<Parameters>& members,
                              const std::string& name )
{
    for ( const auto& member : members )
        if ( member.name() == name )
            return &member;
    return nullptr;
}

//! Checks values against declarations, and collects what is wrong.
class Resolver
{
  public:
    Resolver( const std::string& file, std::vector<std::string>& errors )
        : _file( file ), _errors( errors )
    {
    }

    //! An object with the declared keys; a member of a family if \c typed.
    Json object( const Json& input, const Parameters& parameters,
                 const std::string& path, bool typed )
    {
        Json resolved = Json::object();
        if ( !input.is_object() )
        {
            fail( path, "expected an object, got " + found( input ) );
            return resolved;
        }
        const auto misspelt = unknownKeys( input, parameters, path, typed );
        if ( typed )
            resolved["type"] = parameters.name();
        for ( const auto& key : parameters.keys() )
        {
            const int dimension = parameters.dimension();
            const auto place = path + pointerStep( key.name );
            const auto given = input.find( key.name );
            if ( given != input.end() )
                resolved[key.name] = value( *given, key, dimension, place );
            else if ( key.default_value )
                resolved[key.name] =
                    value( *key.default_value, key, dimension, place );
            else if ( key.is_optional )
                continue;
            else if ( mayBeAbsent( key ) )
                resolved[key.name] =
                    object( Json::object(), *key.nested, place, false );
            // A key that was meant is not missing as well.
            else if ( !misspelt.count( key.name ) )
                fail( place,
                      fmt::format( "missing; {} ({})", phrase( key, dimension ),
                                   key.description ) );
        }
        return resolved;
    }

    //! The defaults of keys, and of those of objects in them. A family may
    //! hold the type whose keys these are: it is not asked for.
    void defaults( const Parameters& parameters, const std::string& path )
    {
        for ( const auto& key : parameters.keys() )
        {
            const auto place = path + pointerStep( key.name );
            if ( key.kind == Kind::Object )
                defaults( *key.nested, place );
            else if ( key.default_value && key.kind != Kind::OneOf &&
                      key.kind != Kind::ListOf )
                value( *key.default_value, key, parameters.dimension(), place );
        }
    }

  private:
    void fail( const std::string& path, const std::string& message )
    {
        _errors.push_back( fmt::format( "{}{}{}: {}", _file,
                                        _file.empty() ? "" : ": ",
                                        path.empty() ? "/" : path, message ) );
    }

    //! Reports keys that are not declared; returns those that were meant.
    std::set<std::string> unknownKeys( const Json& input,
                                       const Parameters& parameters,
                                       const std::string& path, bool typed )
    {
        std::vector<std::string> known;
        if ( typed )
            known.push_back( "type" );
        for ( const auto& key : parameters.keys() )
            known.push_back( key.name );

        std::set<std::string> meant;
        for ( const auto& item : input.items() )
        {
            const auto& key = item.key();
            if ( std::find( known.begin(), known.end(), key ) != known.end() )
                continue;
            const auto near = nearest( key, known );
            meant.insert( near );
            fail( path + pointerStep( key ),
                  "unknown key" +
                      ( !near.empty()
                            ? fmt::format( "; did you mean \"{}\"?", near )
                        : known.empty() ? "; none is expected here"
                                        : "; expected " + quoted( known ) ) );
        }
        return meant;
    }

    Json value( const Json& input, const Parameter& key, int dimension,
                const std::string& path )
    {
        switch ( key.kind )
        {
        case Kind::Number:
        case Kind::Integer:
            checkNumber( input, key, key.kind == Kind::Integer, path );
            return input;
        case Kind::Boolean:
            expect( input.is_boolean(), input, key, dimension, path );
            return input;
        case Kind::Text:
            if ( expect( input.is_string(), input, key, dimension, path ) &&
                 key.is_non_empty && input.get<std::string>().empty() )
                fail( path, "must not be empty" );
            return input;
        case Kind::Choice:
            checkChoice( input, key.options, path );
            return input;
        case Kind::Vector:
        case Kind::IntegerVector:
            checkVector( input, key, dimension, path );
            return input;
        case Kind::Points:
            if ( expectList( input, key, dimension, path ) )
                for ( std::size_t i = 0; i < input.size(); ++i )
                    checkVector( input[i], key, dimension,
                                 fmt::format( "{}/{}", path, i ) );
            return input;
        case Kind::Object:
            return object( input, *key.nested, path, false );
        case Kind::OneOf:
            return member( input, key.family, key.family.members( dimension ),
                           dimension, path );
        case Kind::ListOf:
            return list( input, key, dimension, path );
        case Kind::Anything:
            return input;
        }
        throw std::logic_error( "a kind of parameter without a check" );
    }

    bool expect( bool fulfilled, const Json& input, const Parameter& key,
                 int dimension, const std::string& path )
    {
        if ( !fulfilled )
            fail( path,
                  fmt::format( "expected {}, got {}", phrase( key, dimension ),
                               found( input ) ) );
        return fulfilled;
    }

    bool expectList( const Json& input, const Parameter& key, int dimension,
                     const std::string& path )
    {
        if ( !expect( input.is_array(), input, key, dimension, path ) )
            return false;
        if ( key.is_non_empty && input.empty() )
            fail( path, "must have at least one entry" );
        return true;
    }

    void checkNumber( const Json& input, const Parameter& key, bool whole,
                      const std::string& path )
    {
        if ( !input.is_number() )
            return fail( path,
                         fmt::format( "expected a {}number, got {}",
                                      whole ? "whole " : "", found( input ) ) );
        const double number = input.get<double>();
        // Text cannot say so, but a program that builds its input can.
        if ( !std::isfinite( number ) )
            return fail( path, "must be finite" );
        if ( whole && !checkWhole( input, number, path ) )
            return;
        const bool inside =
            ( !key.greater_than || number > *key.greater_than ) &&
            ( !key.minimum || number >= *key.minimum ) &&
            ( !key.less_than || number < *key.less_than ) &&
            ( !key.maximum || number <= *key.maximum );
        if ( !inside )
            fail( path, fmt::format( "must be {}, got {}", range( key ),
                                     input.dump() ) );
    }

    bool checkWhole( const Json& input, double number, const std::string& path )
    {
        using Limits = std::numeric_limits<std::int64_t>;
        // The parser makes a whole number beyond 64 bits a floating one, and
        // 2^63 is the least power of two that a signed one cannot hold.
        const bool fits =
            input.is_number_unsigned()
                ? input.get<std::uint64_t>() <=
                      static_cast<std::uint64_t>( Limits::max() )
                : std::abs( number ) < 0x1p63 || input.is_number_integer();
        if ( !fits )
            fail( path,
                  fmt::format( "must be a whole number from {} to {}, "
                               "got {}",
                               Limits::min(), Limits::max(), input.dump() ) );
        else if ( !input.is_number_integer() )
            fail( path, fmt::format( "expected a whole number{}, got {}",
                                     number == std::trunc( number )
                                         ? " without point or exponent"
                                         : "",
                                     input.dump() ) );
        return fits && input.is_number_integer();
    }

    void checkChoice( const Json& input,
                      const std::vector<std::string>& options,
                      const std::string& path )
    {
        const auto word = input.is_string() ? input.get<std::string>() : "";
        if ( !input.is_string() || std::find( options.begin(), options.end(),
                                              word ) == options.end() )
            fail( path, fmt::format( "expected one of {}, got {}{}",
                                     quoted( options ), found( input ),
                                     suggestion( word, options ) ) );
    }

    void checkVector( const Json& input, const Parameter& key, int dimension,
                      const std::string& path )
    {
        const bool whole = key.kind == Kind::IntegerVector;
        const std::size_t size = input.size();
        const bool right_size =
            dimension == 0 ? size >= 1 && size <= 3
                           : size == static_cast<std::size_t>( dimension );
        if ( !input.is_array() || !right_size )
            return fail( path, fmt::format( "expected {}, got {}",
                                            vectorPhrase( dimension, whole ),
                                            found( input ) ) );
        for ( std::size_t i = 0; i < size; ++i )
            checkNumber( input[i], key, whole,
                         fmt::format( "{}/{}", path, i ) );
    }

    Json list( const Json& input, const Parameter& key, int dimension,
               const std::string& path )
    {
        Json::array_t resolved;
        if ( expectList( input, key, dimension, path ) )
        {
            const auto members = key.family.members( dimension );
            for ( std::size_t i = 0; i < input.size(); ++i )
                resolved.push_back( member( input[i], key.family, members,
                                            dimension,
                                            fmt::format( "{}/{}", path, i ) ) );
        }
        return Json( std::move( resolved ) );
    }

    //! An object whose "type" says which of the family's members it is. As
    //! long as that is unknown, nothing is said about its other keys.
    Json member( const Json& input, const Family& family,
                 const std::vector<Parameters>& members, int dimension,
                 const std::string& path )
    {
        if ( !input.is_object() )
        {
            fail( path,
                  "expected an object with a \"type\", got " + found( input ) );
            return Json::object();
        }
        const auto names = namesOf( members );
        const auto type = input.find( "type" );
        if ( type == input.end() )
        {
            missingType( input, names, path );
            return Json::object();
        }
        const auto name = type->is_string() ? type->get<std::string>() : "";
        if ( const auto* chosen = findMember( members, name ) )
            return object( input, *chosen, path, true );

        if ( findMember( family.members( 0 ), name ) )
            fail( path + "/type",
                  fmt::format( "{} is not available in {}; expected one of {}",
                               name,
                               counted( dimension, "dimension", "dimensions" ),
                               quoted( names ) ) );
        else
            checkChoice( *type, names, path + "/type" );
        return Json::object();
    }

    void missingType( const Json& input, const std::vector<std::string>& names,
                      const std::string& path )
    {
        for ( const auto& item : input.items() )
            if ( !nearest( item.key(), { "type" } ).empty() )
                return fail( path + pointerStep( item.key() ),
                             "unknown key; did you mean \"type\"?" );
        fail( path + "/type", "missing; one of " + quoted( names ) );
    }

    const std::string& _file;
    std::vector<std::string>& _errors;
};

} // namespace

Json resolve( const Json& input, const Parameters& parameters,
              const std::string& file, std::vector<std::string>& errors )
{
    return Resolver( file, errors ).object( input, parameters, "", false );
}

std::vector<std::string> wrongDefaults( const Parameters& parameters )
{
    std::vector<std::string> errors;
    const std::string no_file;
    Resolver( no_file, errors ).defaults( parameters, "" );
    return errors;
}

} // namespace Machpoint
