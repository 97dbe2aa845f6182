/*!
  \file parameters.cpp
  \brief Declared input parameters: strict parsing, checking, defaults, help.
*/
#include <core/parameters.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace Machpoint
{

void setKeys( Json& object, const Json& keys )
{
    for ( const auto& item : keys.items() )
        object[item.key()] = item.value();
}

//---------------------------------------------------------------------------//
// Declaring.

InputError::InputError( std::vector<std::string> messages )
    : std::runtime_error( fmt::format( "{}", fmt::join( messages, "\n" ) ) ),
      _messages( std::move( messages ) )
{
}

Parameter& Parameter::unit( std::string text )
{
    unit_text = std::move( text );
    return *this;
}

Parameter& Parameter::source( std::string text )
{
    source_text = std::move( text );
    return *this;
}

Parameter& Parameter::defaultsTo( Json value )
{
    default_value = std::move( value );
    return *this;
}

Parameter& Parameter::optional( std::string text )
{
    is_optional = true;
    otherwise = std::move( text );
    return *this;
}

Parameter& Parameter::above( double bound )
{
    greater_than = bound;
    return *this;
}

Parameter& Parameter::atLeast( double bound )
{
    minimum = bound;
    return *this;
}

Parameter& Parameter::below( double bound )
{
    less_than = bound;
    return *this;
}

Parameter& Parameter::atMost( double bound )
{
    maximum = bound;
    return *this;
}

Parameter& Parameter::nonEmpty()
{
    is_non_empty = true;
    return *this;
}

Parameter& Parameter::switches( std::string name_of_effect, Json value )
{
    effect = std::move( name_of_effect );
    off = std::move( value );
    return *this;
}

Parameters::Parameters( std::string name, std::string summary, int dimension )
    : _name( std::move( name ) ), _summary( std::move( summary ) ),
      _dimension( dimension )
{
    if ( dimension < 0 || dimension > 3 )
        throw std::logic_error(
            fmt::format( "{}: no such dimension: {}", _name, dimension ) );
}

Parameter& Parameters::add( Parameter::Kind kind, std::string name,
                            std::string description )
{
    for ( const auto& key : _keys )
        if ( key.name == name )
            throw std::logic_error(
                fmt::format( "{}: {} is declared twice", _name, name ) );
    auto& key = _keys.emplace_back();
    key.kind = kind;
    key.name = std::move( name );
    key.description = std::move( description );
    return key;
}

Parameter& Parameters::number( std::string name, std::string description )
{
    return add( Parameter::Kind::Number, std::move( name ),
                std::move( description ) );
}

Parameter& Parameters::integer( std::string name, std::string description )
{
    return add( Parameter::Kind::Integer, std::move( name ),
                std::move( description ) );
}

Parameter& Parameters::boolean( std::string name, std::string description )
{
    return add( Parameter::Kind::Boolean, std::move( name ),
                std::move( description ) );
}

Parameter& Parameters::text( std::string name, std::string description )
{
    return add( Parameter::Kind::Text, std::move( name ),
                std::move( description ) );
}

Parameter& Parameters::choice( std::string name,
                               std::vector<std::string> options,
                               std::string description )
{
    auto& key = add( Parameter::Kind::Choice, std::move( name ),
                     std::move( description ) );
    key.options = std::move( options );
    return key;
}

Parameter& Parameters::vector( std::string name, std::string description )
{
    return add( Parameter::Kind::Vector, std::move( name ),
                std::move( description ) );
}

Parameter& Parameters::integerVector( std::string name,
                                      std::string description )
{
    return add( Parameter::Kind::IntegerVector, std::move( name ),
                std::move( description ) );
}

Parameter& Parameters::points( std::string name, std::string description )
{
    return add( Parameter::Kind::Points, std::move( name ),
                std::move( description ) );
}

Parameter& Parameters::object( std::string name, Parameters nested,
                               std::string description )
{
    auto& key = add( Parameter::Kind::Object, std::move( name ),
                     std::move( description ) );
    key.nested = std::make_shared<const Parameters>( std::move( nested ) );
    return key;
}

Parameter& Parameters::oneOf( std::string name, Family family,
                              std::string description )
{
    auto& key = add( Parameter::Kind::OneOf, std::move( name ),
                     std::move( description ) );
    key.family = std::move( family );
    return key;
}

Parameter& Parameters::listOf( std::string name, Family family,
                               std::string description )
{
    auto& key = add( Parameter::Kind::ListOf, std::move( name ),
                     std::move( description ) );
    key.family = std::move( family );
    return key;
}

Parameter& Parameters::anything( std::string name, std::string description )
{
    return add( Parameter::Kind::Anything, std::move( name ),
                std::move( description ) );
}

namespace
{

using Kind = Parameter::Kind;

//---------------------------------------------------------------------------//
// Wording.

//! Text from an input, made fit for one line of a terminal.
std::string printable( std::string text )
{
    constexpr std::size_t limit = 80;
    if ( text.size() > limit )
    {
        // Cut before a character, not inside of it: bytes 10xxxxxx continue.
        std::size_t end = limit;
        while ( end > 0 && ( text[end] & 0xC0 ) == 0x80 )
            --end;
        text = text.substr( 0, end ) + "...";
    }
    // Writing replaces what is not UTF-8; reading undoes the escapes.
    text = Json::parse( Json( text ).dump( -1, ' ', false,
                                           Json::error_handler_t::replace ) )
               .get<std::string>();
    std::replace_if(
        text.begin(), text.end(),
        []( unsigned char c ) { return c < 0x20 || c == 0x7F; }, '?' );
    return text;
}

//! A key as a step of a JSON pointer (RFC 6901: ~ is ~0 and / is ~1).
std::string pointerStep( const std::string& key )
{
    std::string step = "/";
    for ( const char c : printable( key ) )
        step += c == '~' ? "~0" : c == '/' ? "~1" : std::string( 1, c );
    return step;
}

std::string quoted( const std::vector<std::string>& words )
{
    return words.empty()
               ? ""
               : fmt::format( "\"{}\"", fmt::join( words, "\", \"" ) );
}

std::string counted( std::size_t count, const std::string& one,
                     const std::string& many )
{
    return fmt::format( "{} {}", count, count == 1 ? one : many );
}

//! "; did you mean ...?", or nothing.
std::string suggestion( const std::string& word,
                        const std::vector<std::string>& candidates )
{
    const auto near = nearest( word, candidates );
    return near.empty() ? "" : fmt::format( "; did you mean \"{}\"?", near );
}

//! What was found in the place of something else.
std::string found( const Json& value )
{
    if ( value.is_array() )
        return "a list of " + counted( value.size(), "entry", "entries" );
    if ( value.is_object() )
        return "an object";
    if ( value.is_string() )
        return fmt::format( "\"{}\"", printable( value.get<std::string>() ) );
    return value.dump();
}

//! What a vector holds, as in "a list of 2 whole numbers".
std::string vectorPhrase( int dimension, bool whole )
{
    const std::string one = whole ? "whole number" : "number";
    if ( dimension == 0 )
        return fmt::format( "a list of 1 to 3 {}s", one );
    return "a list of " + counted( dimension, one, one + "s" );
}

//! What a key takes, as in "a whole number".
std::string phrase( const Parameter& key, int dimension )
{
    switch ( key.kind )
    {
    case Kind::Number:
        return "a number";
    case Kind::Integer:
        return "a whole number";
    case Kind::Boolean:
        return "true or false";
    case Kind::Text:
        return "a text";
    case Kind::Choice:
        return "one of " + quoted( key.options );
    case Kind::Vector:
        return vectorPhrase( dimension, false );
    case Kind::IntegerVector:
        return vectorPhrase( dimension, true );
    case Kind::Points:
        return "a list of points, each " + vectorPhrase( dimension, false );
    case Kind::Object:
        return "an object";
    case Kind::OneOf:
        return "an object with a \"type\"";
    case Kind::ListOf:
        return "a list of objects with a \"type\"";
    case Kind::Anything:
        return "any JSON";
    }
    throw std::logic_error( "a kind of parameter without a phrase" );
}

//! The range of a key's numbers, as in "> 0 and <= 1"; "" if there is none.
std::string range( const Parameter& key )
{
    std::vector<std::string> bounds;
    const auto add = [&bounds]( const char* relation, const auto& bound )
    {
        if ( bound )
            bounds.push_back( fmt::format( "{} {}", relation, *bound ) );
    };
    add( ">", key.greater_than );
    add( ">=", key.minimum );
    add( "<", key.less_than );
    add( "<=", key.maximum );
    return fmt::format( "{}", fmt::join( bounds, " and " ) );
}

std::vector<std::string> namesOf( const std::vector<Parameters>& members )
{
    std::vector<std::string> names;
    for ( const auto& member : members )
        names.push_back( member.name() );
    return names;
}

const Parameters* findMember( const std::vector<Parameters>& members,
                              const std::string& name )
{
    for ( const auto& member : members )
        if ( member.name() == name )
            return &member;
    return nullptr;
}

//! Whether an input may leave the key out.
bool mayBeAbsent( const Parameter& key )
{
    return key.default_value || key.is_optional ||
           ( key.kind == Kind::Object &&
             std::all_of( key.nested->keys().begin(), key.nested->keys().end(),
                          mayBeAbsent ) );
}

//---------------------------------------------------------------------------//
// Parsing.

// Recursive functions walk the document later: it must not exhaust the stack.
constexpr std::size_t max_depth = 64;

/*!
  Builds the document from the parser's events. The parser's own builder keeps
  the last of two equal keys and does not limit the depth.
*/
class DocumentBuilder : public nlohmann::json_sax<Json>
{
  public:
    bool null() override { return add( nullptr ); }
    bool boolean( bool value ) override { return add( value ); }
    bool number_integer( std::int64_t value ) override { return add( value ); }
    bool number_unsigned( std::uint64_t value ) override
    {
        return add( value );
    }
    bool number_float( double value, const std::string& ) override
    {
        return add( value );
    }
    bool string( std::string& value ) override
    {
        return add( std::move( value ) );
    }
    bool binary( Json::binary_t& ) override
    {
        throw std::logic_error( "JSON text has no binary values" );
    }

    bool start_object( std::size_t ) override { return open( true ); }
    bool start_array( std::size_t ) override { return open( false ); }

    bool key( std::string& name ) override
    {
        auto& container = _open.back();
        container.key = std::move( name );
        const auto count = ++container.times_given[container.key];
        if ( count == 2 )
            duplicates.push_back( path() );
        return true;
    }

    bool end_object() override
    {
        Json object( std::move( _open.back().members ) );
        _open.pop_back();
        return add( std::move( object ) );
    }
    bool end_array() override
    {
        Json array( std::move( _open.back().entries ) );
        _open.pop_back();
        return add( std::move( array ) );
    }

    bool parse_error( std::size_t position, const std::string&,
                      const nlohmann::detail::exception& error ) override
    {
        error_position = position;
        // "[json.exception.parse_error.101] parse error at line 1, column 2:
        // syntax error while parsing value - REASON"
        reason = error.what();
        for ( const std::string before : { "] ", " - " } )
            if ( const auto at = reason.find( before );
                 at != std::string::npos )
                reason.erase( 0, at + before.size() );
        return false;
    }

    Json document;
    std::vector<std::string> duplicates; //!< paths of keys given twice
    std::string too_deep;                //!< path of what is nested too deeply
    std::string reason;                  //!< of a syntax error
    std::size_t error_position = 0;      //!< bytes read up to that error

  private:
    // Containers are filled as such and become JSON when complete: adding to
    // an ordered JSON object searches it, which makes long ones slow.
    struct Container
    {
        bool is_object = false;
        std::string key;
        Json::object_t members;
        Json::array_t entries;
        std::map<std::string, int> times_given;
    };

    bool open( bool is_object )
    {
        if ( _open.size() == max_depth )
        {
            too_deep = path();
            return false;
        }
        _open.emplace_back().is_object = is_object;
        return true;
    }

    bool add( Json value )
    {
        if ( _open.empty() )
            document = std::move( value );
        else if ( auto& container = _open.back(); !container.is_object )
            container.entries.push_back( std::move( value ) );
        // Of equal keys the first stays, so that all else can be checked.
        else if ( container.times_given[container.key] == 1 )
            container.members.emplace_back( container.key, std::move( value ) );
        return true;
    }

    std::string path() const
    {
        std::string result;
        for ( const auto& container : _open )
            result += container.is_object
                          ? pointerStep( container.key )
                          : fmt::format( "/{}", container.entries.size() );
        return result;
    }

    std::vector<Container> _open;
};

//! "file:line:column" of a byte; a column counts characters, not bytes.
std::string lineAndColumn( const std::string& file, const std::string& text,
                           std::size_t byte )
{
    std::size_t line = 1;
    std::size_t column = 1;
    for ( std::size_t i = 0; i < std::min( byte, text.size() ); ++i )
    {
        if ( text[i] == '\n' )
        {
            ++line;
            column = 1;
        }
        else if ( ( text[i] & 0xC0 ) != 0x80 )
            ++column;
    }
    return fmt::format( "{}:{}:{}", file, line, column );
}

} // namespace

Json parseJson( const std::string& text, const std::string& file )
{
    std::vector<std::string> errors;
    auto document = parseJson( text, file, errors );
    if ( !errors.empty() )
        throw InputError( std::move( errors ) );
    return document;
}

Json parseJson( const std::string& text, const std::string& file,
                std::vector<std::string>& errors )
{
    if ( text.find_first_not_of( " \t\r\n" ) == std::string::npos )
        throw InputError( { file + ": empty; expected JSON" } );
    // The parser would take a zero byte for the end and ignore what follows.
    if ( const auto zero = text.find( '\0' ); zero != std::string::npos )
        throw InputError( { lineAndColumn( file, text, zero ) +
                            ": a zero byte; this is not a text file" } );

    DocumentBuilder builder;
    Json::sax_parse( text, &builder );

    for ( const auto& path : builder.duplicates )
        errors.push_back( fmt::format( "{}: {}: given twice", file, path ) );
    if ( !builder.too_deep.empty() )
        errors.push_back( fmt::format( "{}: {}: nested deeper than {} levels",
                                       file, printable( builder.too_deep ),
                                       max_depth ) );
    if ( !builder.reason.empty() )
    {
        // The position counts the byte that did not fit as read already.
        const auto byte = std::max<std::size_t>( builder.error_position, 1 );
        errors.push_back( fmt::format( "{}: {}",
                                       lineAndColumn( file, text, byte - 1 ),
                                       printable( builder.reason ) ) );
    }
    if ( !builder.too_deep.empty() || !builder.reason.empty() )
        throw InputError( errors );
    return std::move( builder.document );
}

//---------------------------------------------------------------------------//
// Checking.

namespace
{

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

  private:
    void fail( const std::string& path, const std::string& message )
    {
        _errors.push_back( fmt::format( "{}: {}: {}", _file,
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

//---------------------------------------------------------------------------//
// Overriding.

namespace
{

bool isIndex( const std::string& step )
{
    return !step.empty() &&
           step.find_first_not_of( "0123456789" ) == std::string::npos;
}

//! The steps of "physics.1.linear" or "physics[1].linear", namely physics, 1,
//! linear; none if the path is malformed.
std::vector<std::string> splitPath( const std::string& path )
{
    std::vector<std::string> steps( 1 );
    for ( std::size_t i = 0; i < path.size(); ++i )
    {
        if ( path[i] == '.' )
            steps.emplace_back();
        else if ( path[i] == '[' )
        {
            const auto close = std::min( path.find( ']', i ), path.size() );
            steps.push_back( path.substr( i + 1, close - i - 1 ) );
            // Only another step can follow the bracket.
            const bool ends = close + 1 >= path.size() ||
                              path[close + 1] == '.' || path[close + 1] == '[';
            if ( close == path.size() || !ends || !isIndex( steps.back() ) )
                return {};
            i = close;
        }
        else if ( path[i] == ']' )
            return {};
        else
            steps.back() += path[i];
    }
    const bool has_gap =
        std::any_of( steps.begin(), steps.end(),
                     []( const std::string& step ) { return step.empty(); } );
    return has_gap ? std::vector<std::string>() : steps;
}

bool isUtf8( const std::string& text )
{
    try
    {
        return !Json( text ).dump().empty();
    }
    catch ( const Json::type_error& )
    {
        return false;
    }
}

//! JSON, or else text. What starts like JSON was meant to be JSON.
Json overrideValue( const std::string& text, const std::string& name )
{
    try
    {
        return parseJson( text, name + ": value" );
    }
    catch ( const InputError& )
    {
        if ( text.empty() ||
             std::string( "{[\"" ).find( text[0] ) != std::string::npos )
            throw;
    }
    return Json( text );
}

} // namespace

void applyOverride( Json& input, const std::string& assignment )
{
    const auto name = "--set " + printable( assignment );
    const auto fail = [&name]( const std::string& message ) -> void
    { throw InputError( { name + ": " + message } ); };

    // A shell passes on any bytes, and what is not UTF-8 could not be written.
    if ( !isUtf8( assignment ) )
        fail( "not UTF-8" );
    const auto equals = assignment.find( '=' );
    const auto steps = equals == std::string::npos
                           ? std::vector<std::string>()
                           : splitPath( assignment.substr( 0, equals ) );
    if ( steps.empty() )
        fail( "expected path=value, as in method.basis=cubic or "
              "physics.1.linear=0.3" );
    // No deeper than what can be parsed, even if overrides build on each other.
    if ( steps.size() > max_depth )
        fail( fmt::format( "more than {} levels", max_depth ) );
    const auto value = overrideValue( assignment.substr( equals + 1 ), name );

    Json* place = &input;
    std::string parent = "the input";
    for ( std::size_t i = 0; i < steps.size(); ++i )
    {
        const auto& step = steps[i];
        const bool last = i + 1 == steps.size();
        const auto path = i == 0 ? step : parent + "." + step;
        if ( place->is_array() )
        {
            std::size_t index = 0;
            const auto [end, error] = std::from_chars(
                step.data(), step.data() + step.size(), index );
            if ( !isIndex( step ) || error != std::errc() ||
                 index >= place->size() )
                fail( fmt::format(
                    "{} is a list of {}, counted from 0; choose one of them or "
                    "give the whole list, --set '{}=[...]'",
                    printable( parent ),
                    counted( place->size(), "entry", "entries" ),
                    printable( parent ) ) );
            place = &place->at( index );
        }
        else if ( !place->is_object() )
            fail( fmt::format( "{} is {}, no {}, and has nothing inside; to "
                               "replace it, --set {}=VALUE",
                               printable( parent ), found( *place ),
                               isIndex( step ) ? "list" : "object",
                               printable( parent ) ) );
        else if ( const auto child = place->find( step );
                  child != place->end() )
            place = &*child;
        else if ( last )
            place = &( *place )[step];
        else
        {
            std::vector<std::string> keys;
            for ( const auto& item : place->items() )
                keys.push_back( item.key() );
            fail( fmt::format(
                "the input has no {}{}; to add it, give it as a whole, "
                "--set '{}={}'",
                printable( path ), suggestion( step, keys ), printable( path ),
                isIndex( steps[i + 1] ) ? "[...]" : "{...}" ) );
        }
        parent = path;
    }
    *place = value;
}

//---------------------------------------------------------------------------//
// Help.

namespace
{

//! The columns of one key in the help text, and the text below them.
struct HelpRow
{
    std::vector<std::string> columns;
    std::string text;
};

//! What may be given for a key: a range, options, or names of a family.
std::string allowed( const Parameter& key, int dimension )
{
    switch ( key.kind )
    {
    case Kind::Choice:
        return fmt::format( "{}", fmt::join( key.options, ", " ) );
    case Kind::OneOf:
    case Kind::ListOf:
        return fmt::format(
            "{}: {}", key.family.name,
            fmt::join( namesOf( key.family.members( dimension ) ), ", " ) );
    default:
        return range( key );
    }
}

std::string defaultOf( const Parameter& key )
{
    if ( key.default_value )
        return key.default_value->dump();
    if ( key.is_optional )
        return key.otherwise;
    return mayBeAbsent( key ) ? "as below" : "required";
}

std::string typeOf( const Parameter& key, int dimension )
{
    if ( key.kind == Kind::Choice )
        return "text";
    // In a table, articles are noise.
    auto words = phrase( key, dimension );
    for ( const std::string article : { "a ", "an " } )
        if ( words.compare( 0, article.size(), article ) == 0 )
            return words.substr( article.size() );
    return words;
}

void addRows( const Parameters& parameters, const std::string& prefix,
              std::vector<HelpRow>& rows )
{
    for ( const auto& key : parameters.keys() )
    {
        const int dimension = parameters.dimension();
        HelpRow row;
        row.columns = { prefix + key.name, typeOf( key, dimension ),
                        key.unit_text.empty() ? "-" : key.unit_text,
                        defaultOf( key ), allowed( key, dimension ) };
        row.text = key.description;
        if ( key.is_non_empty )
            row.text += " (not empty)";
        if ( !key.effect.empty() )
            row.text += fmt::format( " ({}: off)", key.off.dump() );
        if ( !key.source_text.empty() )
            row.text += fmt::format( " [{}]", key.source_text );
        rows.push_back( std::move( row ) );
        if ( key.kind == Kind::Object )
            addRows( *key.nested, prefix + key.name + ".", rows );
    }
}

} // namespace

std::string describe( const Parameters& parameters, const std::string& name )
{
    if ( name.empty() && parameters.keys().empty() )
        return "  no parameters\n";

    std::vector<HelpRow> rows;
    addRows( parameters, "", rows );
    if ( !name.empty() )
        std::erase_if( rows,
                       [&]( const HelpRow& row )
                       {
                           const auto& key = row.columns[0];
                           return key != name && !key.ends_with( "." + name );
                       } );
    if ( rows.empty() )
        return "";
    rows.insert( rows.begin(),
                 { { "key", "type", "unit", "default", "allowed" }, "" } );
    std::vector<std::size_t> widths( rows[0].columns.size() );
    for ( const auto& row : rows )
        for ( std::size_t i = 0; i < widths.size(); ++i )
            widths[i] = std::max( widths[i], row.columns[i].size() );

    std::string result;
    for ( const auto& row : rows )
    {
        std::string line;
        for ( std::size_t i = 0; i < widths.size(); ++i )
            line += fmt::format( "  {:<{}}", row.columns[i], widths[i] );
        line.erase( line.find_last_not_of( ' ' ) + 1 );
        result += line + "\n";
        if ( !row.text.empty() )
            result += "      " + row.text + "\n";
    }
    return result;
}

//---------------------------------------------------------------------------//
// JSON Schema.

namespace
{

Json objectSchema( const Parameters& parameters, bool typed,
                   Json& definitions );

//! A reference to the family's definition, which is added if it is not there.
Json familySchema( const Family& family, int dimension, Json& definitions )
{
    if ( !definitions.contains( family.name ) )
    {
        // Its presence ends the recursion of a family that contains itself.
        definitions[family.name] = nullptr;
        Json members = Json::array();
        for ( const auto& member : family.members( dimension ) )
            members.push_back( objectSchema( member, true, definitions ) );
        definitions[family.name] = { { "oneOf", std::move( members ) } };
    }
    return { { "$ref", "#/definitions/" + family.name } };
}

Json numberSchema( const Parameter& key, bool whole )
{
    Json schema = { { "type", whole ? "integer" : "number" } };
    if ( key.greater_than )
        schema["exclusiveMinimum"] = *key.greater_than;
    if ( key.minimum )
        schema["minimum"] = *key.minimum;
    if ( key.less_than )
        schema["exclusiveMaximum"] = *key.less_than;
    if ( key.maximum )
        schema["maximum"] = *key.maximum;
    return schema;
}

Json vectorSchema( const Parameter& key, int dimension )
{
    return { { "type", "array" },
             { "items", numberSchema( key, key.kind == Kind::IntegerVector ) },
             { "minItems", dimension == 0 ? 1 : dimension },
             { "maxItems", dimension == 0 ? 3 : dimension } };
}

Json listSchema( Json items, bool non_empty )
{
    Json schema = { { "type", "array" }, { "items", std::move( items ) } };
    if ( non_empty )
        schema["minItems"] = 1;
    return schema;
}

Json valueSchema( const Parameter& key, int dimension, Json& definitions )
{
    switch ( key.kind )
    {
    case Kind::Number:
    case Kind::Integer:
        return numberSchema( key, key.kind == Kind::Integer );
    case Kind::Boolean:
        return { { "type", "boolean" } };
    case Kind::Text:
        return { { "type", "string" },
                 { "minLength", key.is_non_empty ? 1 : 0 } };
    case Kind::Choice:
        return { { "enum", key.options } };
    case Kind::Vector:
    case Kind::IntegerVector:
        return vectorSchema( key, dimension );
    case Kind::Points:
        return listSchema( vectorSchema( key, dimension ), key.is_non_empty );
    case Kind::Object:
        return objectSchema( *key.nested, false, definitions );
    case Kind::OneOf:
        // Draft 7 ignores what stands beside $ref, and a description will.
        return { { "allOf", Json::array( { familySchema( key.family, dimension,
                                                         definitions ) } ) } };
    case Kind::ListOf:
        return listSchema( familySchema( key.family, dimension, definitions ),
                           key.is_non_empty );
    case Kind::Anything:
        return Json::object();
    }
    throw std::logic_error( "a kind of parameter without a schema" );
}

Json objectSchema( const Parameters& parameters, bool typed, Json& definitions )
{
    Json properties = Json::object();
    Json required = Json::array();
    if ( typed )
    {
        properties["type"] = { { "const", parameters.name() } };
        required.push_back( "type" );
    }
    for ( const auto& key : parameters.keys() )
    {
        auto schema = valueSchema( key, parameters.dimension(), definitions );
        auto text = key.description;
        if ( !key.unit_text.empty() )
            text += fmt::format( " ({})", key.unit_text );
        if ( !key.source_text.empty() )
            text += fmt::format( " [{}]", key.source_text );
        if ( key.is_optional && key.otherwise != "absent" )
            text += fmt::format( "; default: {}", key.otherwise );
        schema["description"] = text;
        if ( key.default_value )
            schema["default"] = *key.default_value;
        if ( !mayBeAbsent( key ) )
            required.push_back( key.name );
        properties[key.name] = std::move( schema );
    }
    return { { "description", parameters.summary() },
             { "type", "object" },
             { "properties", std::move( properties ) },
             { "required", std::move( required ) },
             { "additionalProperties", false } };
}

} // namespace

Json jsonSchema( const Parameters& parameters )
{
    Json definitions = Json::object();
    const auto root = objectSchema( parameters, false, definitions );
    Json schema = { { "$schema", "http://json-schema.org/draft-07/schema#" },
                    { "title", parameters.name() } };
    setKeys( schema, root );
    schema["definitions"] = std::move( definitions );
    return schema;
}

//---------------------------------------------------------------------------//
// Suggesting.

namespace
{

//! Number of edits between two words; a swap of neighbours is one.
std::size_t editDistance( const std::string& a, const std::string& b )
{
    std::vector<std::vector<std::size_t>> edits(
        a.size() + 1, std::vector<std::size_t>( b.size() + 1 ) );
    for ( std::size_t i = 0; i <= a.size(); ++i )
        for ( std::size_t j = 0; j <= b.size(); ++j )
        {
            if ( i == 0 || j == 0 )
            {
                edits[i][j] = i + j;
                continue;
            }
            const std::size_t replaced = a[i - 1] == b[j - 1] ? 0 : 1;
            edits[i][j] = std::min( { edits[i - 1][j] + 1, edits[i][j - 1] + 1,
                                      edits[i - 1][j - 1] + replaced } );
            if ( i > 1 && j > 1 && a[i - 1] == b[j - 2] &&
                 a[i - 2] == b[j - 1] )
                edits[i][j] = std::min( edits[i][j], edits[i - 2][j - 2] + 1 );
        }
    return edits[a.size()][b.size()];
}

std::string lowerCase( std::string text )
{
    for ( char& c : text )
        if ( c >= 'A' && c <= 'Z' )
            c += 'a' - 'A';
    return text;
}

} // namespace

std::string nearest( const std::string& word,
                     const std::vector<std::string>& candidates )
{
    std::string best;
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for ( const auto& candidate : candidates )
    {
        const auto [shorter, longer] =
            std::minmax( { word.size(), candidate.size() } );
        // A third: one edit in "type", two in "gamma", none in "x".
        const std::size_t limit = ( longer + 1 ) / 3;
        // Every surplus character is an edit, so long junk costs nothing.
        if ( longer - shorter > limit )
            continue;
        const auto edits =
            editDistance( lowerCase( word ), lowerCase( candidate ) );
        if ( edits <= limit && edits < least )
        {
            best = candidate;
            least = edits;
        }
    }
    return best;
}

} // namespace Machpoint
