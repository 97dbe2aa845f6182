/*!
  \file parameters_schema.cpp
  \brief JSON Schema of declared parameters.
*/
#include <core/parameters.hpp>
#include <core/parameters_wording.hpp>

#include <fmt/format.h>

#include <utility>

namespace Machpoint
{

namespace
{

using Kind = Parameter::Kind;

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

} // namespace Machpoint
