#include <drivers/study_probe.hpp>

#include <drivers/study_error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace Machpoint
{

namespace
{

// In the order in which GridFields tells them.
const std::vector<std::string> fields = { "density", "pressure",
                                          "specific_internal_energy" };

//! Places on a line that are looked at.
constexpr int samples = 1024;

using Place = std::array<double, 3>;

Place place( const Json& coordinates )
{
    Place x{};
    for ( std::size_t d = 0; d < coordinates.size(); ++d )
        x[d] = coordinates[d];
    return x;
}

//! The field of a probe on one output.
class ProbedField
{
  public:
    ProbedField( const GridFields& grid, const Json& probe )
        : _grid( grid ),
          _field( std::find( fields.begin(), fields.end(),
                             probe.at( "field" ).get<std::string>() ) -
                  fields.begin() )
    {
    }

    //! None without gas.
    std::optional<double> at( const Place& x ) const
    {
        const auto values = _grid.at( x );
        if ( values.empty() )
            return std::nullopt;
        return values[static_cast<std::size_t>( _field )];
    }

    //! Calls visit( part of the way, value ) along a line, where there is gas,
    //! until it returns true.
    template <class Visitor>
    void alongLine( const Json& probe, const Visitor& visit ) const
    {
        const auto from = place( probe.at( "from" ) );
        const auto to = place( probe.at( "to" ) );
        for ( int k = 0; k <= samples; ++k )
        {
            const double part = static_cast<double>( k ) / samples;
            Place x{};
            for ( std::size_t d = 0; d < x.size(); ++d )
                x[d] = from[d] + part * ( to[d] - from[d] );
            const auto value = at( x );
            if ( value && visit( part, *value ) )
                return;
        }
    }

  private:
    const GridFields& _grid;
    std::ptrdiff_t _field;
};

std::optional<double> largest( const ProbedField& field, const Json& probe )
{
    std::optional<double> most;
    field.alongLine( probe,
                     [&]( double, const double value )
                     {
                         most = std::max( most.value_or( value ), value );
                         return false;
                     } );
    return most;
}

std::optional<double> distance( const ProbedField& field, const Json& probe )
{
    const double sought = probe.at( "value" );
    const auto from = place( probe.at( "from" ) );
    const auto to = place( probe.at( "to" ) );
    const double length =
        std::hypot( to[0] - from[0], to[1] - from[1], to[2] - from[2] );
    std::optional<double> found;
    std::optional<std::array<double, 2>>
        last; // part of the way, value - sought
    field.alongLine( probe,
                     [&]( const double part, const double value )
                     {
                         const double above = value - sought;
                         if ( last && ( ( *last )[1] < 0 ) != ( above < 0 ) )
                         {
                             const auto [part0, above0] = *last;
                             found =
                                 length * ( part0 + ( part - part0 ) * above0 /
                                                        ( above0 - above ) );
                         }
                         last = { part, above };
                         return found.has_value();
                     } );
    return found;
}

std::optional<double> measure( const GridFields& grid, const Json& probe )
{
    const ProbedField field( grid, probe );
    const auto type = probe.at( "type" ).get<std::string>();
    return type == "point"     ? field.at( place( probe.at( "at" ) ) )
           : type == "maximum" ? largest( field, probe )
                               : distance( field, probe );
}

} // namespace

Family probeFamily()
{
    auto named = []( const char* type, const char* summary )
    {
        Parameters p( type, summary, 0 );
        p.text( "name", "what its errors are called" ).nonEmpty();
        p.choice( "field", fields, "what is looked at" )
            .defaultsTo( "density" );
        return p;
    };
    auto onLine = [named]( const char* type, const char* summary )
    {
        auto p = named( type, summary );
        p.vector( "from", "where the line begins" ).unit( "length" );
        p.vector( "to", "where it ends" ).unit( "length" );
        return p;
    };
    return { "probe", [named, onLine]( int )
             {
                 auto point = named( "point", "a field at a place" );
                 point.vector( "at", "the place" ).unit( "length" );
                 auto crossing =
                     onLine( "crossing", "how far along a line a field first "
                                         "passes a value" );
                 crossing.number( "value", "of the field" );
                 return std::vector<Parameters>{
                     point, onLine( "maximum", "largest value on a line" ),
                     crossing };
             } };
}

std::string probeColumn( const Json& probe )
{
    const auto column = probe.at( "type" ) == "crossing"
                            ? std::string( "distance" )
                            : probe.at( "field" ).get<std::string>();
    return fmt::format( "{}.{}", probe.at( "name" ).get<std::string>(),
                        column );
}

std::vector<std::string> misfitPlaces( const Json& probe, const int dimension )
{
    std::vector<std::string> keys;
    for ( const auto* key : { "at", "from", "to" } )
        if ( probe.contains( key ) &&
             static_cast<int>( probe.at( key ).size() ) != dimension )
            keys.push_back( key );
    return keys;
}

Json probeMeans( const std::filesystem::path& folder, const Json& probes )
{
    std::vector<std::vector<double>> values( probes.size() );
    const auto outputs = gridOutputs( folder );
    for ( const auto& output : outputs )
    {
        if ( output.time <= 0.5 * outputs.back().time )
            continue;
        const auto grid = readGrid( output.file );
        for ( std::size_t k = 0; k < probes.size(); ++k )
            if ( const auto value = measure( grid, probes[k] ) )
                values[k].push_back( *value );
    }
    auto means = Json::object();
    for ( std::size_t k = 0; k < probes.size(); ++k )
    {
        const auto& own = values[k];
        means[probeColumn( probes[k] )] =
            own.empty() ? Json()
                        : Json( std::accumulate( own.begin(), own.end(), 0.0 ) /
                                static_cast<double>( own.size() ) );
    }
    return means;
}

} // namespace Machpoint
