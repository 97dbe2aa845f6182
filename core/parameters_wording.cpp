/*!
  \file parameters_wording.cpp
  \brief How messages, help and schemas speak of keys and values.
*/
#include <core/parameters_wording.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

namespace Machpoint
{

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

std::string suggestion( const std::string& word,
                        const std::vector<std::string>& candidates )
{
    const auto near = nearest( word, candidates );
    return near.empty() ? "" : fmt::format( "; did you mean \"{}\"?", near );
}

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

std::string vectorPhrase( int dimension, bool whole )
{
    const std::string one = whole ? "whole number" : "number";
    if ( dimension == 0 )
        return fmt::format( "a list of 1 to 3 {}s", one );
    return "a list of " + counted( dimension, one, one + "s" );
}

std::string phrase( const Parameter& key, int dimension )
{
    using Kind = Parameter::Kind;
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

bool mayBeAbsent( const Parameter& key )
{
    return key.default_value || key.is_optional ||
           ( key.kind == Parameter::Kind::Object &&
             std::all_of( key.nested->keys().begin(), key.nested->keys().end(),
                          mayBeAbsent ) );
}

} // namespace Machpoint
