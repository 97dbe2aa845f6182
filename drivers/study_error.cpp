#include <drivers/study_error.hpp>

#include <drivers/grid_fields.hpp>

#include <core/file.hpp>
#include <core/hdf5_file.hpp>
#include <core/types.hpp>

#include <fmt/format.h>

#include <algorithm>
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
        std::vector<std::vector<double>> rows;
        while ( std::getline( stream, line ) )
        {
            std::vector<double> row;
            for ( const auto& word : split( line ) )
                row.push_back( std::strtod( word.c_str(), nullptr ) );
            if ( row.size() != columns.size() )
                throw IoError( file.string() + ": a row lacks columns; run "
                                               "the study anew" );
            rows.push_back( std::move( row ) );
        }
        for ( std::size_t c = 1; c < columns.size(); ++c )
        {
            double sum = 0, time = 0;
            for ( std::size_t r = 1; r < rows.size(); ++r )
                if ( rows[r][0] > 0.5 * rows.back()[0] )
                {
                    // A row tells of the step that ends at its time.
                    const double dt = rows[r][0] - rows[r - 1][0];
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

std::vector<GridOutput> gridOutputs( const fs::path& folder )
{
    std::vector<GridOutput> outputs;
    for ( const auto& file : filesOf( folder / "grid", ".h5" ) )
        outputs.push_back(
            { Hdf5Reader( file ).attribute<double>( "time" ).at( 0 ), file } );
    if ( outputs.empty() )
        throw IoError( ( folder / "grid" ).string() +
                       ": holds no output; run the study anew" );
    return outputs;
}

GridFields readGrid( const fs::path& file )
{
    const Hdf5Reader reader( file );
    GridData data;
    data.lower = reader.attribute<double>( "lower" );
    data.spacing = reader.attribute<double>( "spacing" );
    data.shape = reader.shape( "density" );
    data.density = reader.read<Real>( "density" );
    data.pressure = reader.read<Real>( "pressure" );
    data.specific_internal_energy =
        reader.read<Real>( "specific_internal_energy" );
    data.velocity = reader.read<Real>( "velocity" );
    return GridFields( data );
}

namespace
{

//! Of the last outputs of two runs.
std::vector<FieldDifference> lastDifferences( const fs::path& folder,
                                              const fs::path& finer,
                                              const Json& input )
{
    return fieldDifferences( readGrid( gridOutputs( folder ).back().file ),
                             readGrid( gridOutputs( finer ).back().file ),
                             input );
}

} // namespace

Json gridErrors( const fs::path& folder, const fs::path& finer,
                 const Json& input )
{
    Json errors = Json::object();
    for ( const auto& [error, size] : lastDifferences( folder, finer, input ) )
    {
        errors[fmt::format( "{}.L1", error.field )] = error.L1;
        errors[fmt::format( "{}.L2", error.field )] = error.L2;
        errors[fmt::format( "{}.Linf", error.field )] = error.Linf;
    }
    return errors;
}

Json gridChanges( const fs::path& folder, const fs::path& whole,
                  const Json& input )
{
    Json changes = Json::object();
    for ( const auto& [error, size] : lastDifferences( folder, whole, input ) )
        if ( error.field != "specific_internal_energy" )
            changes[fmt::format( "{}.change", error.field )] =
                size > 0 ? Json( error.L1 / size ) : Json();
    return changes;
}

} // namespace Machpoint
