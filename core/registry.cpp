#include <core/registry.hpp>
#include <core/shape_input.hpp>

#include <fmt/format.h>

#include <stdexcept>

namespace Machpoint
{

namespace
{

//! What is wrong with a key whose name means the same in all module types;
//! empty: nothing.
std::string faultOfKey( const Parameter& key )
{
    using Kind = Parameter::Kind;
    if ( key.name == "type" )
        return "the key \"type\" is the module's name, which every entry has: "
               "call it something else";
    auto unless = [&]( const bool is_right, const char* meaning )
    {
        return is_right ? ""
                        : fmt::format( "the key \"{}\" is {}: declare it as "
                                       "that, or call it something else",
                                       key.name, meaning );
    };
    if ( key.name == "name" )
        return unless( key.kind == Kind::Text, "the text that names a series" );
    if ( key.name == "side" )
        return unless( key.kind == Kind::Choice, "a choice" );
    if ( key.name == "region" )
        return unless( key.kind == Kind::OneOf &&
                           key.family.name == shapeFamily().name,
                       "the shape within which a module acts" );
    return "";
}

} // namespace

Parameters checkedDeclaration( const std::string& type, Parameters declared )
{
    if ( declared.name() != type )
        throw std::logic_error(
            fmt::format( "the type is called \"{}\" and declares \"{}\": give "
                         "both one name",
                         type, declared.name() ) );
    for ( const auto& key : declared.keys() )
        if ( const auto fault = faultOfKey( key ); !fault.empty() )
            throw std::logic_error( fault );
    // Told here, lest an input that leaves the key out be blamed.
    for ( const auto& fault : wrongDefaults( declared ) )
        throw std::logic_error( "a default is wrong: " + fault );
    return declared;
}

std::string reportName( const Json& entry )
{
    auto name = entry.at( "type" ).get<std::string>();
    for ( const auto* key : { "side", "name" } )
        if ( entry.contains( key ) )
            name += " " + entry.at( key ).get<std::string>();
    return name;
}

} // namespace Machpoint
