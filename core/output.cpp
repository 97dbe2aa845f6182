/*!
  \file output.cpp
  \brief Output directory, atomic files, HDF5 through its C API, XDMF.
*/
#include <core/output.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <numeric>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#ifdef MACHPOINT_ENABLE_HDF5
#include <hdf5.h>
#endif

namespace fs = std::filesystem;

namespace Machpoint
{
namespace
{

std::string remedy( int error )
{
    switch ( error )
    {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
        return "free some space or choose another disk with --output DIR";
    case EACCES:
    case EPERM:
    case EROFS:
        return "choose a directory that you may write to with --output DIR";
    default:
        return "check the path that --output names, or choose another one";
    }
}

//---------------------------------------------------------------------------//
// Atomic files.
//---------------------------------------------------------------------------//

// Writes a whole file or none: beside the target, forced to the disk, renamed.
// A disk may refuse as late as fsync or close: delayed allocation and network
// file systems report a full disk only there.
void writeFile( const fs::path& target, const void* data, std::size_t size )
{
    const auto temporary = target.string() + ".tmp";
    const int file = ::open( temporary.c_str(),
                             O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666 );
    if ( file < 0 )
        throw IoError( target, "cannot create the file", errno );

    const auto* bytes = static_cast<const char*>( data );
    int error = 0;
    for ( std::size_t done = 0; done < size && !error; )
    {
        const auto count = ::write( file, bytes + done, size - done );
        if ( count >= 0 )
            done += static_cast<std::size_t>( count );
        else if ( errno != EINTR )
            error = errno;
    }
    if ( !error && ::fsync( file ) != 0 )
        error = errno;
    if ( ::close( file ) != 0 && !error )
        error = errno;
    if ( !error && ::rename( temporary.c_str(), target.c_str() ) != 0 )
        error = errno;
    if ( error )
    {
        ::unlink( temporary.c_str() );
        throw IoError( target, "cannot write the file", error );
    }
}

void makeDirectory( const fs::path& directory )
{
    std::error_code error;
    fs::create_directories( directory, error );
    if ( error )
        throw IoError( directory, "cannot create the directory",
                       error.value() );
}

void writeText( const fs::path& target, const std::string& text )
{
    makeDirectory( target.parent_path() );
    writeFile( target, text.data(), text.size() );
}

//---------------------------------------------------------------------------//
// What a former run wrote.
//---------------------------------------------------------------------------//

// Root files of a run and of tools/plot.py.
constexpr const char* root_files[] = {
    "summary.json",      "particles.xdmf", "grid.xdmf",
    "profiles.png",      "schlieren.png",  "slices.png",
    "contact_sheet.png", "movie.mp4",      "movie.gif" };

constexpr const char* step_folders[] = { "particles", "grid", "exact" };
constexpr const char* series_folder = "series";

// Also what a killed run left under a temporary name.
void removeFile( const fs::path& file )
{
    for ( const fs::path& name : { file, fs::path( file.string() + ".tmp" ) } )
    {
        std::error_code error;
        fs::remove( name, error );
        if ( error )
            throw IoError( name, "cannot remove the file", error.value() );
    }
}

bool isStepFile( const fs::path& file )
{
    const auto stem = file.stem().string();
    return file.extension() == ".h5" && stem.size() >= 8 &&
           std::all_of( stem.begin(), stem.end(),
                        []( char c ) { return c >= '0' && c <= '9'; } );
}

bool isSeriesFile( const fs::path& file )
{
    return file.extension() == ".csv";
}

// The folder itself goes only when nothing else is left in it.
void clearFolder( const fs::path& folder, bool ( *is_ours )( const fs::path& ) )
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

//---------------------------------------------------------------------------//
// HDF5.
//---------------------------------------------------------------------------//

#ifdef MACHPOINT_ENABLE_HDF5

constexpr bool has_hdf5 = true;

std::size_t count( const std::vector<std::size_t>& shape )
{
    return std::accumulate( shape.begin(), shape.end(), std::size_t{ 1 },
                            std::multiplies<>{} );
}

// HDF5 prints its error stack by default; here errors become exceptions.
class QuietHdf5
{
  public:
    QuietHdf5()
    {
        H5Eget_auto2( H5E_DEFAULT, &_function, &_data );
        H5Eset_auto2( H5E_DEFAULT, nullptr, nullptr );
    }
    QuietHdf5( const QuietHdf5& ) = delete;
    QuietHdf5& operator=( const QuietHdf5& ) = delete;
    ~QuietHdf5() { H5Eset_auto2( H5E_DEFAULT, _function, _data ); }

  private:
    H5E_auto2_t _function = nullptr;
    void* _data = nullptr;
};

// The image is built in memory, so that memory is all that can be lacking.
template <class Result>
Result check( Result result, const std::string& operation )
{
    if ( result < 0 )
        throw IoError( "HDF5 cannot " + operation +
                       " in memory; is there room for one output?" );
    return result;
}

// Owns an HDF5 identifier.
class Handle
{
  public:
    Handle( hid_t id, herr_t ( *close )( hid_t ) ) : _id( id ), _close( close )
    {
    }
    Handle( const Handle& ) = delete;
    Handle& operator=( const Handle& ) = delete;
    ~Handle() { _close( _id ); }
    operator hid_t() const { return _id; }

  private:
    hid_t _id;
    herr_t ( *_close )( hid_t );
};

hid_t nativeType( const Dataset& dataset )
{
    return dataset.type == Dataset::Type::real ? H5T_NATIVE_DOUBLE
                                               : H5T_NATIVE_INT64;
}

hid_t makeSpace( const Dataset& dataset )
{
    if ( dataset.shape.empty() )
        return H5Screate( H5S_SCALAR );
    const std::vector<hsize_t> extents( dataset.shape.begin(),
                                        dataset.shape.end() );
    return H5Screate_simple( static_cast<int>( extents.size() ), extents.data(),
                             nullptr );
}

void writeAttribute( hid_t file, const Dataset& item )
{
    const auto operation = "write the attribute " + item.name;
    const auto type = nativeType( item );
    const Handle space( check( makeSpace( item ), operation ), H5Sclose );
    const Handle attribute(
        check( H5Acreate2( file, item.name.c_str(), type, space, H5P_DEFAULT,
                           H5P_DEFAULT ),
               operation ),
        H5Aclose );
    check( H5Awrite( attribute, type, item.data ), operation );
}

void writeDataset( hid_t file, hid_t link_properties, const Dataset& item )
{
    const auto operation = "write the dataset " + item.name;
    const auto type = nativeType( item );
    const Handle space( check( makeSpace( item ), operation ), H5Sclose );
    const Handle dataset(
        check( H5Dcreate2( file, item.name.c_str(), type, space,
                           link_properties, H5P_DEFAULT, H5P_DEFAULT ),
               operation ),
        H5Dclose );
    if ( count( item.shape ) > 0 )
        check(
            H5Dwrite( dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, item.data ),
            operation );
}

// HDF5 never touches the disk: when its last write to a full one fails, the
// file cannot be closed any more and the library crashes at exit (1.10.8). It
// builds the image in memory, and writeFile puts that on the disk.
void writeHdf5( const fs::path& target, const std::vector<Dataset>& attributes,
                const std::vector<Dataset>& datasets )
{
    const QuietHdf5 quiet;
    std::size_t size = 1 << 16; // for all that is not raw data
    for ( const auto& item : datasets )
        size += count( item.shape ) * sizeof( double );

    const Handle access(
        check( H5Pcreate( H5P_FILE_ACCESS ), "prepare a file" ), H5Pclose );
    check( H5Pset_fapl_core( access, size, false ), "prepare a file" );
    const Handle links( check( H5Pcreate( H5P_LINK_CREATE ), "prepare a file" ),
                        H5Pclose );
    check( H5Pset_create_intermediate_group( links, 1 ), "prepare a file" );

    const Handle file(
        check( H5Fcreate( target.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access ),
               "create a file" ),
        H5Fclose );
    for ( const auto& item : attributes )
        writeAttribute( file, item );
    for ( const auto& item : datasets )
        writeDataset( file, links, item );
    check( H5Fflush( file, H5F_SCOPE_LOCAL ), "complete a file" );

    void** image = nullptr;
    hsize_t image_size = 0;
    check( H5Fget_vfd_handle( file, H5P_DEFAULT,
                              reinterpret_cast<void**>( &image ) ),
           "hand out a file" );
    check( H5Fget_filesize( file, &image_size ), "hand out a file" );
    writeFile( target, *image, image_size );
}

#else

constexpr bool has_hdf5 = false;

// Never reached: without HDF5 there is no OutputDirectory to call it.
void writeHdf5( const fs::path&, const std::vector<Dataset>&,
                const std::vector<Dataset>& )
{
}

#endif

//---------------------------------------------------------------------------//
// XDMF, restricted to what both of ParaView's readers (XDMF 2 and 3) load:
// no functions, no hyperslabs, every grid a 3DCoRectMesh.
// Of a 2D vector version 2 makes three components, version 3 leaves two.
//---------------------------------------------------------------------------//

std::string join( const std::vector<std::size_t>& extents )
{
    return fmt::format( "{}", fmt::join( extents, " " ) );
}

std::string xdmfItem( const std::string& file, const Dataset& dataset,
                      const std::vector<std::size_t>& extents )
{
    return fmt::format( R"(<DataItem Format="HDF" NumberType="{}" )"
                        R"(Precision="8" Dimensions="{}">{}:/{}</DataItem>)",
                        dataset.type == Dataset::Type::real ? "Float" : "Int",
                        join( extents ), file, dataset.name );
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
                            const std::string& entries )
{
    return fmt::format( R"(<?xml version="1.0"?>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="{}" GridType="Collection" CollectionType="Temporal">
{}    </Grid>
  </Domain>
</Xdmf>
)",
                        name, entries );
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

//---------------------------------------------------------------------------//

IoError::IoError( const fs::path& file, const std::string& operation,
                  int error )
    : std::runtime_error( fmt::format(
          "{}: {}: {}; {}", file.string(), operation,
          error ? std::strerror( error ) : "no reason given by the system",
          remedy( error ) ) )
{
}

OutputDirectory::OutputDirectory( const fs::path& directory, bool overwrite,
                                  int dimension, const bool needs_fields )
    : _directory( directory ), _dimension( dimension )
{
    if ( needs_fields && !has_hdf5 )
        throw IoError( directory.string() +
                       ": cannot write output: this build lacks HDF5; install "
                       "it (Debian: libhdf5-openmpi-dev or libhdf5-dev) and "
                       "configure with -DMachpoint_ENABLE_HDF5=ON, or set "
                       "output.particles and output.grid to false" );
    require( dimension >= 1 && dimension <= 3, "the dimension is 1, 2 or 3" );

    if ( !overwrite )
        for ( const auto* name : { "summary.json", "particles", "grid" } )
        {
            std::error_code error; // of a path that is none: reported below
            if ( fs::exists( directory / name, error ) )
                throw IoError( fmt::format(
                    "{}: holds another run ({} exists); pass --overwrite to "
                    "replace it, or choose another directory with --output DIR",
                    directory.string(), name ) );
        }

    makeDirectory( directory );
    const auto probe = directory / "machpoint_probe";
    writeText( probe, "probe\n" );
    removeFile( probe );
    if ( overwrite )
        removeFormerRun( directory );
}

void OutputDirectory::writeStep( const std::string& kind, std::int64_t step,
                                 double time, std::vector<Dataset> attributes,
                                 const std::vector<Dataset>& datasets ) const
{
    attributes.insert( attributes.begin(),
                       { { "time", {}, &time, Dataset::Type::real },
                         { "step", {}, &step, Dataset::Type::integer } } );
    makeDirectory( _directory / kind );
    writeHdf5( _directory / stepFile( kind, step ), attributes, datasets );
}

void OutputDirectory::writeParticles( std::int64_t step, double time,
                                      const std::vector<Dataset>& datasets )
{
    const auto dim = static_cast<std::size_t>( _dimension );
    const auto position =
        std::find_if( datasets.begin(), datasets.end(),
                      []( const auto& d ) { return d.name == "position"; } );
    require( position != datasets.end() && position->shape.size() == 2 &&
                 position->shape[1] == dim &&
                 position->type == Dataset::Type::real,
             "particles need a real dataset position [n][Dim]" );
    const auto particles = position->shape[0];
    for ( const auto& dataset : datasets )
        require( dataset.shape == std::vector{ particles } ||
                     dataset.shape == std::vector{ particles, dim },
                 "the particles' " + dataset.name +
                     " is neither [n] nor [n][Dim]" );

    auto written = datasets;
    auto points = *position;
    std::vector<double> padded;
    if ( dim == 1 )
    {
        padded.resize( 2 * particles, 0.0 );
        const auto* x = static_cast<const double*>( position->data );
        for ( std::size_t p = 0; p < particles; ++p )
            padded[2 * p] = x[p];
        points = { "xdmf/position", { particles, 2 }, padded.data() };
        written.push_back( points );
    }
    writeStep( "particles", step, time, {}, written );

    const auto file = stepFile( "particles", step );
    auto body = fmt::format(
        R"(        <Topology TopologyType="Polyvertex" NodesPerElement="1"
                  NumberOfElements="{}"/>
        <Geometry GeometryType="{}">{}</Geometry>
)",
        particles, dim == 3 ? "XYZ" : "XY",
        xdmfItem( file, points, points.shape ) );
    for ( const auto& dataset : datasets )
    {
        // In 1D a vector has one component, and ParaView shows it as a scalar.
        const bool is_vector = dim > 1 && dataset.shape.size() == 2;
        if ( dataset.name != "position" )
            body += xdmfAttribute( file, dataset,
                                   is_vector ? dataset.shape
                                             : std::vector{ particles },
                                   is_vector );
    }
    _particle_entries += xdmfEntry( "particles", time, body );
    writeText( _directory / "particles.xdmf",
               xdmfCollection( "particles", _particle_entries ) );
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
    const std::vector<std::size_t> nodes(
        datasets[0].shape.begin(), datasets[0].shape.begin() + _dimension );
    auto vector_shape = nodes;
    vector_shape.push_back( dim );
    for ( const auto& dataset : datasets )
        require( dataset.shape == nodes || dataset.shape == vector_shape,
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
    _grid_entries += xdmfEntry( "grid", time, body );
    writeText( _directory / "grid.xdmf",
               xdmfCollection( "grid", _grid_entries ) );
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
    writeText( _directory / file, text );
}

void OutputDirectory::writeSummary( const std::string& json_text )
{
    writeText( _directory / "summary.json", json_text );
}

} // end namespace Machpoint
