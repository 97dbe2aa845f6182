#include <drivers/study_error.hpp>

#include <core/file.hpp>
#include <core/hdf5_file.hpp>
#include <core/types.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

namespace fs = std::filesystem;

namespace Machpoint
{

Json exactErrors( const Json& summary )
{
    Json errors = Json::object();
    for ( const auto& field : summary.at( "errors" ).items() )
        for ( const auto& norm : field.value().items() )
            errors[fmt::format( "{}.{}", field.key(), norm.key() )] =
                norm.value();
    return errors;
}

namespace
{

//! The files of a folder, in order; none without the folder.
std::vector<fs::path> filesOf( const fs::path& folder, const char* extension )
{
    std::vector<fs::path> files;
    std::error_code error;
    for ( const auto& entry : fs::directory_iterator( folder, error ) )
        if ( entry.path().extension() == extension )
            files.push_back( entry.path() );
    std::sort( files.begin(), files.end() );
    return files;
}

std::vector<std::string> split( const std::string& line )
{
    std::vector<std::string> words;
    std::istringstream stream( line );
    for ( std::string word; std::getline( stream, word, ',' ); )
        words.push_back( word );
    return words;
}

} // namespace

Json seriesMeans( const fs::path& folder )
{
    Json means = Json::object();
    for ( const auto& file : filesOf( folder / "series", ".csv" ) )
    {
        std::ifstream stream( file );
        std::string line;
        std::getline( stream, line );
        const auto columns = split( line );
        std::vector<std::vector<Real>> rows;
        while ( std::getline( stream, line ) )
        {
            std::vector<Real> row;
            for ( const auto& word : split( line ) )
                row.push_back( std::strtod( word.c_str(), nullptr ) );
            if ( row.size() != columns.size() )
                throw IoError( file.string() + ": a row lacks columns; run "
                                               "the study anew" );
            rows.push_back( std::move( row ) );
        }
        for ( std::size_t c = 1; c < columns.size(); ++c )
        {
            Real sum = 0, time = 0;
            for ( std::size_t r = 1; r < rows.size(); ++r )
                if ( rows[r][0] > 0.5 * rows.back()[0] )
                {
                    // A row tells of the step that ends at its time.
                    const Real dt = rows[r][0] - rows[r - 1][0];
                    sum += dt * rows[r][c];
                    time += dt;
                }
            if ( time > 0 )
                means[fmt::format( "{}.{}", file.stem().string(),
                                   columns[c] )] = sum / time;
        }
    }
    return means;
}

namespace
{

//! The last grid output of a run, to be asked at any place.
class GridFields
{
  public:
    explicit GridFields( const fs::path& folder )
    {
        const auto files = filesOf( folder / "grid", ".h5" );
        if ( files.empty() )
            throw IoError( ( folder / "grid" ).string() +
                           ": holds no output; run the study anew" );
        const Hdf5Reader reader( files.back() );
        _lower = reader.attribute<Real>( "lower" );
        _spacing = reader.attribute<Real>( "spacing" );
        _shape = reader.shape( "density" );
        std::reverse( _shape.begin(), _shape.end() ); // x first
        for ( const auto* name :
              { "density", "pressure", "specific_internal_energy" } )
            _fields.push_back( reader.read<Real>( name ) );
        const auto velocity = reader.read<Real>( "velocity" );
        const std::size_t dim = _shape.size();
        const std::size_t nodes = velocity.size() / dim;
        for ( std::size_t d = 0; d < dim; ++d )
        {
            auto& component = _fields.emplace_back( nodes );
            for ( std::size_t i = 0; i < nodes; ++i )
                component[i] = velocity[i * dim + d];
        }
    }

    //! Density, pressure, energy, velocity; empty where a node has no gas.
    std::vector<Real> at( const std::array<Real, 3>& x ) const
    {
        const std::size_t dim = _shape.size();
        std::array<std::size_t, 3> first{};
        std::array<Real, 3> part{};
        for ( std::size_t d = 0; d < dim; ++d )
        {
            // Beyond the outermost nodes their value holds.
            const Real last = static_cast<Real>( _shape[d] - 1 );
            const Real place =
                std::clamp( ( x[d] - _lower[d] ) / _spacing[d], 0.0, last );
            first[d] = std::min( static_cast<std::size_t>( place ),
                                 _shape[d] - ( _shape[d] > 1 ? 2 : 1 ) );
            part[d] = place - static_cast<Real>( first[d] );
        }
        std::vector<Real> values( _fields.size(), 0.0 );
        for ( std::size_t corner = 0; corner < ( 1u << dim ); ++corner )
        {
            Real weight = 1;
            std::size_t node = 0;
            for ( std::size_t d = dim; d-- > 0; )
            {
                const std::size_t upper = ( corner >> d ) & 1;
                weight *= upper ? part[d] : 1 - part[d];
                node = node * _shape[d] + first[d] + upper;
            }
            if ( weight == 0 )
                continue;
            if ( _fields[0][node] <= 0 )
                return {};
            for ( std::size_t f = 0; f < values.size(); ++f )
                values[f] += weight * _fields[f][node];
        }
        return values;
    }

  private:
    std::vector<Real> _lower, _spacing;
    std::vector<std::size_t> _shape;
    std::vector<std::vector<Real>> _fields; // [fields][nodes]
};

//! Norms of the difference of two runs' field, and the L1 of the second's.
struct Difference
{
    std::string field;
    Real L1 = 0, L2 = 0, Linf = 0, size = 0;
};

std::vector<Difference> differences( const fs::path& folder,
                                     const fs::path& finer, const Json& input )
{
    const GridFields coarse( folder ), fine( finer );
    const auto& grid = input.at( "grid" );
    const std::vector<std::int64_t> cells = grid.at( "cells" );
    const std::vector<Real> lower = grid.at( "lower" );
    const std::vector<Real> upper = grid.at( "upper" );
    std::int64_t count = 1;
    Real volume = 1; // of a cell
    for ( std::size_t d = 0; d < cells.size(); ++d )
    {
        count *= cells[d];
        volume *= ( upper[d] - lower[d] ) / static_cast<Real>( cells[d] );
    }

    constexpr std::array names = { "density", "pressure",
                                   "specific_internal_energy", "velocity" };
    std::array<Real, 4> sum{}, square{}, largest{}, size{};
    for ( std::int64_t cell = 0; cell < count; ++cell )
    {
        std::array<Real, 3> x{};
        auto rest = cell;
        for ( std::size_t d = 0; d < cells.size(); ++d )
        {
            x[d] =
                lower[d] + ( upper[d] - lower[d] ) *
                               ( static_cast<Real>( rest % cells[d] ) + .5 ) /
                               static_cast<Real>( cells[d] );
            rest /= cells[d];
        }
        const auto a = coarse.at( x ), b = fine.at( x );
        if ( a.empty() || b.empty() )
            continue;
        std::array<Real, 4> difference{}, value{};
        for ( std::size_t f = 0; f < 3; ++f )
        {
            difference[f] = std::abs( a[f] - b[f] );
            value[f] = std::abs( b[f] );
        }
        for ( std::size_t f = 3; f < a.size(); ++f )
        {
            difference[3] = std::hypot( difference[3], a[f] - b[f] );
            value[3] = std::hypot( value[3], b[f] );
        }
        for ( std::size_t f = 0; f < 4; ++f )
        {
            sum[f] += volume * difference[f];
            square[f] += volume * difference[f] * difference[f];
            largest[f] = std::max( largest[f], difference[f] );
            size[f] += volume * value[f];
        }
    }
    std::vector<Difference> all;
    for ( std::size_t f = 0; f < 4; ++f )
        all.push_back(
            { names[f], sum[f], std::sqrt( square[f] ), largest[f], size[f] } );
    return all;
}

} // namespace

Json gridErrors( const fs::path& folder, const fs::path& finer,
                 const Json& input )
{
    Json errors = Json::object();
    for ( const auto& d : differences( folder, finer, input ) )
    {
        errors[fmt::format( "{}.L1", d.field )] = d.L1;
        errors[fmt::format( "{}.L2", d.field )] = d.L2;
        errors[fmt::format( "{}.Linf", d.field )] = d.Linf;
    }
    return errors;
}

Json gridChanges( const fs::path& folder, const fs::path& whole,
                  const Json& input )
{
    Json changes = Json::object();
    for ( const auto& d : differences( folder, whole, input ) )
        if ( d.field != "specific_internal_energy" )
            changes[fmt::format( "{}.change", d.field )] =
                d.size > 0 ? Json( d.L1 / d.size ) : Json();
    return changes;
}

} // namespace Machpoint
