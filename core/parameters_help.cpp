/*!
  \file parameters_help.cpp
  \brief Help text of declared parameters.
*/
#include <core/parameters.hpp>
#include <core/parameters_wording.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace Machpoint
{

namespace
{

using Kind = Parameter::Kind;

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

} // namespace Machpoint
