/*!
  \file parameters_json.cpp
  \brief JSON before it is checked: parsed strictly, and changed by path.
*/
#include <core/parameters.hpp>
#include <core/parameters_wording.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <utility>

namespace Machpoint
{

void setKeys( Json& object, const Json& keys )
{
    for ( const auto& item : keys.items() )
        object[item.key()] = item.value();
}

//---------------------------------------------------------------------------//
// Parsing.

namespace
{

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

} // namespace Machpoint
