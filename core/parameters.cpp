/*!
  \file parameters.cpp
  \brief Declaring input parameters.
*/
#include <core/parameters.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

namespace Machpoint
{

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

} // namespace Machpoint
