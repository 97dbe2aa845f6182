/*!
  \file output.cpp
  \brief The output directory and its XDMF files.
*/
#include <core/output.hpp>

#include <core/parameters.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <system_error>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{
// Refuses a directory that holds one of the names. \param what they belong to
void requireNone( const fs::path& directory, const char* what,
                  const std::initializer_list<const char*> names,
                  const char* remedy )
{
    for ( const auto* name : names )
    {
        std::error_code error; // of a place that nobody may look at
        if ( fs::exists( directory / name, error ) )
            throw IoError( fmt::format(
                "{}: holds {} ({} exists); {} another directory with "
                "--output DIR",
                directory.string(), what, name, remedy ) );
    }
}

//---------------------------------------------------------------------------//
// What a former run wrote.
//---------------------------------------------------------------------------//

// Root files of a run and of tools/plot.py.
constexpr const char* root_files[] = { "summary.json",
                                       "particles.xdmf",
                                       "grid.xdmf",
                                       "profiles.png",
                                       "schlieren.png",
                                       "slices.png",
                                       "contact_sheet.png",
                                       "movie.mp4",
                                       "movie.gif",
                                       "report.html",
                                       "stop" };

constexpr const char* step_folders[] = { "particles", "grid", "exact",
                                         "checkpoints" };
constexpr const char* series_folder = "series";

bool isSeriesFile( const fs::path& file )
{
    return file.extension() == ".csv";
}

// The folder itself goes only when nothing else is left in it.
void clearFolder( const fs::path& folder,
                  const std::function<bool( const fs::path& )>& is_ours )
{
    std::error_code error;
    if ( !fs::is_directory( folder, error ) )
        return;
    std::vector<fs::path> ours;
    for ( fs::directory_iterator entry( folder, error ), end;
          !error && entry != end; entry.increment( error ) )
    {
        auto file = entry->path();
        if ( file.extension() == ".tmp" )
            file.replace_extension();
        if ( is_ours( file ) )
            ours.push_back( file );
    }
    if ( error )
        throw IoError( folder, "cannot list the directory", error.value() );
    for ( const auto& file : ours )
        removeFile( file );
    if ( !fs::is_symlink( folder, error ) ) // which is the user's own
        fs::remove( folder, error );
}

void removeFormerRun( const fs::path& directory )
{
    for ( const auto* folder : step_folders )
        clearFolder( directory / folder, isStepFile );
    clearFolder( directory / series_folder, isSeriesFile );
    for ( const auto* file : root_files )
        removeFile( directory / file );
}

//! Makes the directory or takes an existing one, on the root.
//! \param lock of it, or of none
DirectoryLock takeDirectory( const fs::path& directory, const FormerRun former,
                             DirectoryLock lock )
{
    makeDirectory( directory );
    if ( !lock.isHeld() )
        lock = DirectoryLock( directory );
    // (Its study.json may as well be somebody's input.)
    requireNone( directory, "a study", { "study.csv" }, "choose" );
    if ( former == FormerRun::refuse )
        requireNoRun( directory, "pass --overwrite to replace it, or choose" );
    const auto probe = directory / "machpoint_probe";
    writeFile( probe, "probe", 5 );
    removeFile( probe );
    if ( former == FormerRun::replace )
        removeFormerRun( directory );
    return lock;
}

//---------------------------------------------------------------------------//
// XDMF, restricted to what both of ParaView's readers (XDMF 2 and 3) load:
// no functions, no hyperslabs, every grid a 3DCoRectMesh.
// Of a 2D vector version 2 makes three components, version 3 leaves two.
//---------------------------------------------------------------------------//

std::string join( const std::vector<std::size_t>& extents )
{
    return fmt::format( "{}", fmt::join( extents, " " ) );
}

bool isReal( const Dataset& dataset )
{
    return dataset.type == Dataset::Type::real ||
           dataset.type == Dataset::Type::single;
}

std::string xdmfItem( const std::string& file, const Dataset& dataset,
                      const std::vector<std::size_t>& extents )
{
    return fmt::format( R"(<DataItem Format="HDF" NumberType="{}" )"
                        R"(Precision="{}" Dimensions="{}">{}:/{}</DataItem>)",
                        isReal( dataset ) ? "Float" : "Int",
                        elementSize( dataset.type ), join( extents ), file,
                        dataset.name );
}

std::string xdmfAttribute( const std::string& file, const Dataset& dataset,
                           const std::vector<std::size_t>& extents,
                           bool is_vector )
{
    return fmt::format(
        "        <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">"
        "{}</Attribute>\n",
        dataset.name, is_vector ? "Vector" : "Scalar",
        xdmfItem( file, dataset, extents ) );
}

std::string xdmfCollection( const std::string& name,
                            const std::map<std::int64_t, std::string>& entries )
{
    std::string text;
    for ( const auto& [step, entry] : entries )
        text += entry;
    return fmt::format( R"(<?xml version="1.0"?>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="{}" GridType="Collection" CollectionType="Temporal">
{}    </Grid>
  </Domain>
</Xdmf>
)",
                        name, text );
}

std::string xdmfEntry( const std::string& name, double time,
                       const std::string& body )
{
    return fmt::format( R"(      <Grid Name="{}" GridType="Uniform">
        <Time Value="{}"/>
{}      </Grid>
)",
                        name, time, body );
}

// `[Dim]` with x first, as the three numbers with z first that XDMF wants.
std::string xdmfTriple( const std::vector<double>& values, double missing )
{
    std::vector<double> triple( 3 - values.size(), missing );
    triple.insert( triple.end(), values.rbegin(), values.rend() );
    return fmt::format( R"(<DataItem Format="XML" NumberType="Float" )"
                        R"(Precision="8" Dimensions="3">{}</DataItem>)",
                        fmt::join( triple, " " ) );
}

std::string stepFile( const std::string& kind, std::int64_t step )
{
    return fmt::format( "{}/{:08}.h5", kind, step );
}

void require( bool condition, const std::string& what )
{
    if ( !condition )
        throw std::invalid_argument( "OutputDirectory: " + what );
}

} // end anonymous namespace

void requireNoRun( const fs::path& directory, const char* remedy )
{
    requireNone( directory, "another run",
                 { "summary.json", "particles", "grid", "checkpoints" },
                 remedy );
}

//---------------------------------------------------------------------------//

OutputDirectory::OutputDirectory( const fs::path& directory,
                                  const FormerRun former, int dimension,
                                  const bool needs_fields,
                                  const int compression, DirectoryLock lock )
    : _directory( directory ), _dimension( dimension ),
      _compression( compression )
{
    if ( needs_fields )
        requireHdf5( _ranks );
    require( dimension >= 1 && dimension <= 3, "the dimension is 1, 2 or 3" );
    onRoot( _ranks,
            [&] {
                _lock = takeDirectory( directory, former, std::move( lock ) );
            } );
}

void OutputDirectory::writeText( const fs::path& name,
                                 const std::string& text ) const
{
    onRoot( _ranks,
            [&]
            {
                const auto target = _directory / name;
                makeDirectory( target.parent_path() );
                writeFile( target, text.data(), text.size() );
            } );
}

void OutputDirectory::writeStep( const std::string& kind, std::int64_t step,
                                 double time, std::vector<Dataset> attributes,
                                 const std::vector<Dataset>& datasets ) const
{
    attributes.insert( attributes.begin(),
                       { { "time", {}, &time, Dataset::Type::real },
                         { "step", {}, &step, Dataset::Type::integer } } );
    onRoot( _ranks, [&] { makeDirectory( _directory / kind ); } );
    writeHdf5( _ranks, _directory / stepFile( kind, step ), attributes,
               datasets, _compression );
}

void OutputDirectory::writeParticles( std::int64_t step, double time,
                                      const std::vector<Dataset>& datasets )
{
    const auto dim = static_cast<std::size_t>( _dimension );
    const auto position =
        std::find_if( datasets.begin(), datasets.end(),
                      []( const auto& d ) { return d.name == "position"; } );
    require( position != datasets.end() && position->shape.size() == 2 &&
                 position->shape[1] == dim && isReal( *position ),
             "particles need a real dataset position [n][Dim]" );
    const auto own = position->shape[0];
    for ( const auto& dataset : datasets )
        require( dataset.shape == std::vector{ own } ||
                     dataset.shape == std::vector{ own, dim },
                 "the particles' " + dataset.name +
                     " is neither [n] nor [n][Dim]" );

    const auto whole = stackRows( _ranks, datasets );
    auto written = whole;
    auto points = whole[position - datasets.begin()];
    std::vector<char> padded; // with a second component, 0
    if ( dim == 1 )
    {
        const auto size = elementSize( position->type );
        padded.resize( 2 * own * size, 0 );
        const auto* x = static_cast<const char*>( position->data );
        for ( std::size_t p = 0; p < own; ++p )
            std::copy_n( x + p * size, size, &padded[2 * p * size] );
        points = stackRows( _ranks, { { "xdmf/position",
                                        { own, 2 },
                                        padded.data(),
                                        position->type } } )[0];
        written.push_back( points );
    }
    writeStep( "particles", step, time, {}, written );

    const auto file = stepFile( "particles", step );
    const auto particles = points.extents()[0];
    auto body = fmt::format(
        R"(        <Topology TopologyType="Polyvertex" NodesPerElement="1"
                  NumberOfElements="{}"/>
        <Geometry GeometryType="{}">{}</Geometry>
)",
        particles, dim == 3 ? "XYZ" : "XY",
        xdmfItem( file, points, points.extents() ) );
    for ( const auto& dataset : whole )
    {
        // In 1D a vector has one component, and ParaView shows it as a scalar.
        const bool is_vector = dim > 1 && dataset.shape.size() == 2;
        if ( dataset.name != "position" )
            body += xdmfAttribute( file, dataset,
                                   is_vector ? dataset.extents()
                                             : std::vector{ particles },
                                   is_vector );
    }
    _particles.entries[step] = xdmfEntry( "particles", time, body );
    renew( "particles", _particles );
}

void OutputDirectory::writeGrid( std::int64_t step, double time,
                                 const std::vector<double>& lower,
                                 const std::vector<double>& spacing,
                                 const std::vector<Dataset>& datasets )
{
    const auto dim = static_cast<std::size_t>( _dimension );
    require( lower.size() == dim && spacing.size() == dim,
             "the grid's lower and spacing have one number for each axis" );
    require( !datasets.empty() && datasets[0].shape.size() >= dim,
             "a grid needs datasets [nz][ny][nx]" );
    auto nodes = datasets[0].extents();
    nodes.resize( dim );
    auto vector_shape = nodes;
    vector_shape.push_back( dim );
    for ( const auto& dataset : datasets )
        require( dataset.extents() == nodes ||
                     dataset.extents() == vector_shape,
                 "the grid's " + dataset.name +
                     " is neither [nz][ny][nx] nor [nz][ny][nx][Dim]" );

    writeStep( "grid", step, time,
               { { "lower", { dim }, lower.data() },
                 { "spacing", { dim }, spacing.data() } },
               datasets );

    // Flat axes stand first, so that a 2D grid lies in ParaView's xy plane.
    std::vector<std::size_t> extents( 3 - dim, 1 );
    extents.insert( extents.end(), nodes.begin(), nodes.end() );
    auto vector_extents = extents;
    vector_extents.push_back( dim );

    const auto file = stepFile( "grid", step );
    auto body = fmt::format(
        R"(        <Topology TopologyType="3DCoRectMesh" Dimensions="{}"/>
        <Geometry GeometryType="ORIGIN_DXDYDZ">{}{}</Geometry>
)",
        join( extents ), xdmfTriple( lower, 0.0 ), xdmfTriple( spacing, 1.0 ) );
    for ( const auto& dataset : datasets )
    {
        const bool is_vector = dim > 1 && dataset.shape.size() > dim;
        body += xdmfAttribute(
            file, dataset, is_vector ? vector_extents : extents, is_vector );
    }
    _grid.entries[step] = xdmfEntry( "grid", time, body );
    renew( "grid", _grid );
}

void OutputDirectory::writeExact( std::int64_t step, double time,
                                  const std::vector<Dataset>& datasets )
{
    for ( const auto& dataset : datasets )
        require( dataset.shape.size() == 1 &&
                     dataset.shape == datasets[0].shape,
                 "the exact " + dataset.name + " is not [n]" );
    writeStep( "exact", step, time, {}, datasets );
}

void OutputDirectory::writeSeries(
    const std::string& name, const std::vector<std::string>& columns,
    const std::vector<std::vector<double>>& rows )
{
    // Only there does a later --overwrite look for it.
    const fs::path file( name );
    require( file.parent_path() == series_folder && isSeriesFile( file ),
             "a series is called series/<name>.csv, not " + name );

    auto text = fmt::format( "{}\n", fmt::join( columns, "," ) );
    for ( const auto& row : rows )
    {
        require( row.size() == columns.size(),
                 name + " has a row that does not fit its columns" );
        text += fmt::format( "{}\n", fmt::join( row, "," ) );
    }
    writeText( file, text );
}

void OutputDirectory::writeSummary( const std::string& json_text )
{
    for ( const auto& [kind, collection] : collections() )
        complete( kind, *collection );
    writeText( "summary.json", json_text );
}

void OutputDirectory::checkpoint( Archive& archive )
{
    for ( const auto& [kind, collection] : collections() )
    {
        auto& entries = collection->entries;
        std::string text = Json( entries ).dump();
        archive( "outputs/" + kind, text );
        if ( archive.isReading() )
            entries = Json::parse( text ).get<Entries>();
        else
            complete( kind, *collection );
    }
    if ( !archive.isReading() )
        return;
    for ( const auto& [kind, collection] : collections() )
        takeUp( kind, *collection );
    onRoot( _ranks, [&] { removeFile( _directory / "summary.json" ); } );
}

std::map<std::string, OutputDirectory::Collection*>
OutputDirectory::collections()
{
    return { { "particles", &_particles }, { "grid", &_grid } };
}

void OutputDirectory::takeUp( const std::string& kind, Collection& collection )
{
    auto& entries = collection.entries;
    onRoot( _ranks, [&] { removeLater( kind, entries ); } );
    entries =
        Json::parse( _ranks.fromRoot( Json( entries ).dump() ) ).get<Entries>();
    collection.listed = 0;
    complete( kind, collection );
}

void OutputDirectory::removeLater( const std::string& kind,
                                   Entries& entries ) const
{
    // A restart may write into another directory.
    std::erase_if( entries,
                   [&]( const auto& entry )
                   {
                       std::error_code error;
                       return !fs::exists(
                           _directory / stepFile( kind, entry.first ), error );
                   } );
    const auto is_later = [&]( const fs::path& file )
    {
        return isStepFile( file ) &&
               !entries.contains( std::stoll( file.stem().string() ) );
    };
    clearFolder( _directory / kind, is_later );
    if ( kind == "particles" )
        clearFolder( _directory / "exact", is_later );
    if ( entries.empty() )
        removeFile( _directory / ( kind + ".xdmf" ) );
}

void OutputDirectory::renew( const std::string& kind, Collection& collection )
{
    const auto listed = collection.listed;
    if ( collection.entries.size() > listed + listed / 100 )
        complete( kind, collection );
}

void OutputDirectory::complete( const std::string& kind,
                                Collection& collection )
{
    const auto count = collection.entries.size();
    if ( count == collection.listed )
        return;
    writeText( kind + ".xdmf", xdmfCollection( kind, collection.entries ) );
    collection.listed = count;
}

} // end namespace Machpoint
