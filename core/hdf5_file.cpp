/*!
  \file hdf5_file.cpp
  \brief Writing HDF5 files: small ones in memory, large ones by MPI-IO.
*/
#include <core/hdf5_file.hpp>
#include <core/hdf5_handle.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <utility>

namespace fs = std::filesystem;

namespace Machpoint
{

std::vector<Dataset> stackRows( const Communicator& ranks,
                                std::vector<Dataset> blocks )
{
    std::vector<std::size_t> rows;
    for ( const auto& block : blocks )
        rows.push_back( block.shape.at( 0 ) );
    const auto all = ranks.gatherAll( rows ); // [ranks][blocks]
    const auto own = static_cast<std::size_t>( ranks.rank() ) * blocks.size();
    for ( std::size_t k = 0; k < blocks.size(); ++k )
    {
        auto& block = blocks[k];
        block.start.assign( block.shape.size(), 0 );
        block.global_shape = block.shape;
        block.global_shape[0] = 0;
        for ( auto other = k; other < all.size(); other += blocks.size() )
        {
            block.start[0] += other < own ? all[other] : 0;
            block.global_shape[0] += all[other];
        }
    }
    return blocks;
}

#ifdef MACHPOINT_ENABLE_HDF5

namespace
{

#ifdef H5_HAVE_PARALLEL
constexpr bool is_parallel = true;
#else
constexpr bool is_parallel = false;
#endif

//! Fills one new file; every member is called by all ranks alike.
class Writer
{
  public:
    //! \param ranks that call it, all of them
    Writer( const int ranks, const bool is_root, const fs::path& target,
            const hid_t access, const fs::path& name, const int compression )
        : _target( target ), _is_root( is_root ), _compression( compression ),
          _links( H5Pcreate( H5P_LINK_CREATE ), H5Pclose ),
          _transfer( H5Pcreate( H5P_DATASET_XFER ), H5Pclose ),
          _file( create( name, access ), H5Fclose )
    {
        check<hid_t>( _file, "create it" );
        check( H5Pset_create_intermediate_group( _links, 1 ), "create it" );
#ifdef H5_HAVE_PARALLEL
        if ( ranks > 1 )
            check( H5Pset_dxpl_mpio( _transfer, H5FD_MPIO_COLLECTIVE ),
                   "create it" );
#else
        static_cast<void>( ranks );
#endif
    }

    void attribute( const Dataset& item )
    {
        const auto operation = "write the attribute " + item.name;
        const auto type = nativeType( item.type );
        const Handle space( check( makeSpace( item.shape ), operation ),
                            H5Sclose );
        const Handle attribute(
            check( H5Acreate2( _file, item.name.c_str(), type, space,
                               H5P_DEFAULT, H5P_DEFAULT ),
                   operation ),
            H5Aclose );
        check( H5Awrite( attribute, type, item.data ), operation );
    }

    void dataset( const Dataset& item )
    {
        const auto operation = "write the dataset " + item.name;
        const auto type = nativeType( item.type );
        const auto& whole = item.extents();
        const Handle layout( chunks( item ), H5Pclose );
        const Handle space( check( makeSpace( whole ), operation ), H5Sclose );
        const Handle dataset(
            check( H5Dcreate2( _file, item.name.c_str(), type, space, _links,
                               layout, H5P_DEFAULT ),
                   operation ),
            H5Dclose );
        if ( count( whole ) == 0 )
            return;
        if ( item.fetch )
            writeBlocks( item, dataset, space );
        else
            writeAtOnce( item, dataset, space );
    }

    void flush()
    {
        check( H5Fflush( _file, H5F_SCOPE_GLOBAL ), "flush it" );
    }
    void close()
    {
        check( _file.close(), "close it" );
    }

    //! The bytes of a file that is built in memory.
    std::pair<const void*, std::size_t> image()
    {
        void** bytes = nullptr;
        check( H5Fget_vfd_handle( _file, H5P_DEFAULT,
                                  reinterpret_cast<void**>( &bytes ) ),
               "hand it out" );
        // The memory behind the end is spare room.
        const auto size =
            check( H5Fget_file_image( _file, nullptr, 0 ), "hand it out" );
        return { *bytes, static_cast<std::size_t>( size ) };
    }

  private:
    //! Without the time of day, here and in datasets: runs that are alike leave
    //! the same bytes.
    static hid_t create( const fs::path& name, const hid_t access )
    {
        const Handle properties( H5Pcreate( H5P_FILE_CREATE ), H5Pclose );
        H5Pset_obj_track_times( properties, false );
        return H5Fcreate( name.c_str(), H5F_ACC_TRUNC, properties, access );
    }

    //! What a rank has in memory; all ranks call it.
    void writeAtOnce( const Dataset& item, const hid_t dataset,
                      const hid_t space ) const
    {
        const auto operation = "write the dataset " + item.name;
        const Handle memory( check( makeSpace( item.shape ), operation ),
                             H5Sclose );
        if ( !item.global_shape.empty() )
            check( select( space, item.start, item.shape ), operation );
        else if ( !_is_root )
            check( H5Sselect_none( space ), operation );
        if ( H5Sget_select_npoints( space ) == 0 )
            check( H5Sselect_none( memory ), operation );
        check( H5Dwrite( dataset, nativeType( item.type ), memory, space,
                         _transfer, item.data ),
               operation );
    }

    //! What a rank fetches, a few MiB at a time. Ranks do not wait for each
    //! other, and may have more blocks than others.
    void writeBlocks( const Dataset& item, const hid_t dataset,
                      const hid_t space ) const
    {
        constexpr std::size_t block_bytes = std::size_t{ 4 } << 20;
        const auto operation = "write the dataset " + item.name;
        auto start = item.start, block = item.shape;
        block[0] = 1;
        const auto row_bytes = count( block ) * elementSize( item.type );
        const auto most = std::max<std::size_t>( 1, block_bytes / row_bytes );
        const auto rows = item.shape[0];
        std::vector<char> values( std::min( rows, most ) * row_bytes );
        for ( std::size_t first = 0; first < rows; first += most )
        {
            start[0] = item.start[0] + first;
            block[0] = std::min( most, rows - first );
            item.fetch( first, block[0], values.data() );
            const Handle memory( check( makeSpace( block ), operation ),
                                 H5Sclose );
            check( select( space, start, block ), operation );
            check( H5Dwrite( dataset, nativeType( item.type ), memory, space,
                             H5P_DEFAULT, values.data() ),
                   operation );
        }
    }

    template <class Result>
    Result check( const Result result, const std::string& operation ) const
    {
        if ( result < 0 )
            throw IoError( fmt::format(
                "{}: HDF5 cannot {}; is there room for it in memory and on the "
                "disk?",
                _target.string(), operation ) );
        return result;
    }

    //! Creation properties: contiguous, or compressed chunks of about 1 MiB,
    //! whole in all but the slowest axis.
    hid_t chunks( const Dataset& item ) const
    {
        const auto& whole = item.extents();
        const auto properties = H5Pcreate( H5P_DATASET_CREATE );
        H5Pset_obj_track_times( properties, false );
        if ( _compression == 0 || item.fetch || whole.empty() ||
             count( whole ) == 0 )
            return properties;
        auto chunk = extents( whole );
        const auto row = count( whole ) / whole[0] * elementSize( item.type );
        chunk[0] = std::clamp<hsize_t>( ( 1 << 20 ) / row, 1, whole[0] );
        H5Pset_chunk( properties, static_cast<int>( chunk.size() ),
                      chunk.data() );
        H5Pset_shuffle( properties );
        H5Pset_deflate( properties, static_cast<unsigned>( _compression ) );
        return properties;
    }

    fs::path _target;
    bool _is_root;
    int _compression;
    Handle _links;
    Handle _transfer;
    Handle _file;
};

std::size_t sizeOnDisk( const std::vector<Dataset>& datasets )
{
    std::size_t size = 1 << 16; // for all that is not raw data
    for ( const auto& item : datasets )
        size += count( item.extents() ) * elementSize( item.type );
    return size;
}

//! How files are made: in the format of HDF5 1.8, which has checksums of HDF5's
//! own books. Of older ones it believes whatever a damaged byte says.
Handle fileAccess()
{
    const auto access = H5Pcreate( H5P_FILE_ACCESS );
    H5Pset_libver_bounds( access, H5F_LIBVER_V18, H5F_LIBVER_V18 );
    return { access, H5Pclose };
}

// HDF5 builds a small file in memory, and writeFile puts that on the disk.
void writeImage( const fs::path& target, const std::vector<Dataset>& attributes,
                 const std::vector<Dataset>& datasets, const int compression )
{
    const auto access = fileAccess();
    H5Pset_fapl_core( access, sizeOnDisk( datasets ), false );
    Writer writer( 1, true, target, access, target, compression );
    for ( const auto& item : attributes )
        writer.attribute( item );
    for ( const auto& item : datasets )
        writer.dataset( item );
    writer.flush();
    const auto [bytes, size] = writer.image();
    writeFile( target, bytes, size );
}

//! Copies a block to its place in the whole array, row by row.
//! \return the block's end
const char* place( const char* block, const std::size_t* shape,
                   const std::size_t* start, const Dataset& item, char* whole )
{
    const auto& extents = item.extents();
    const std::size_t axes = extents.size();
    const std::size_t size = elementSize( item.type );
    std::size_t rows = 1;
    for ( std::size_t d = 0; d + 1 < axes; ++d )
        rows *= shape[d];
    const std::size_t length = shape[axes - 1] * size;
    for ( std::size_t row = 0; row < rows; ++row )
    {
        std::size_t rest = row, offset = start[axes - 1], stride = 1;
        for ( std::size_t d = axes - 1; d-- > 0; rest /= shape[d] )
        {
            stride *= extents[d + 1];
            offset += ( start[d] + rest % shape[d] ) * stride;
        }
        std::copy_n( block, length, whole + offset * size );
        block += length;
    }
    return block;
}

// Ranks that open, extend and close a file together agree dozens of times: on
// a small one that takes longer than all its data.
void writeSmall( const Communicator& ranks, const fs::path& target,
                 const std::vector<Dataset>& attributes,
                 std::vector<Dataset> datasets, const int compression,
                 const std::function<void()>& then )
{
    std::vector<std::size_t> places; // shape and start of every block
    std::vector<char> bytes;
    for ( const auto& item : datasets )
        if ( !item.global_shape.empty() )
        {
            places.insert( places.end(), item.shape.begin(), item.shape.end() );
            places.insert( places.end(), item.start.begin(), item.start.end() );
            // Memory of its own, so that numbers are aligned.
            std::vector<char> block( count( item.shape ) *
                                     elementSize( item.type ) );
            if ( item.fetch )
                item.fetch( 0, item.shape[0], block.data() );
            else if ( !block.empty() )
                std::memcpy( block.data(), item.data, block.size() );
            bytes.insert( bytes.end(), block.begin(), block.end() );
        }
    then();
    places = ranks.gather( places );
    bytes = ranks.gather( bytes );
    onRoot( ranks,
            [&]
            {
                std::vector<std::vector<char>> arrays;
                for ( const auto& item : datasets )
                    arrays.emplace_back( count( item.extents() ) *
                                         elementSize( item.type ) );
                const char* block = bytes.data();
                const std::size_t* axes = places.data();
                while ( axes != places.data() + places.size() )
                    for ( std::size_t k = 0; k < datasets.size(); ++k )
                        if ( const auto n = datasets[k].global_shape.size() )
                        {
                            block = place( block, axes, axes + n, datasets[k],
                                           arrays[k].data() );
                            axes += 2 * n;
                        }
                for ( std::size_t k = 0; k < datasets.size(); ++k )
                    if ( !datasets[k].global_shape.empty() )
                        datasets[k] = { datasets[k].name,
                                        datasets[k].global_shape,
                                        arrays[k].data(), datasets[k].type };
                writeImage( target, attributes, datasets, compression );
            } );
}

// When its last write to a full disk fails, HDF5 cannot close the file any more
// and crashes at exit (1.10.8). So room is taken before it writes: once to
// learn of a full disk before HDF5 has a file to lose, and again because HDF5
// gives it back when it creates the file. Where the file system cannot do so, a
// file that failed is emptied, and what HDF5 still has for it fits. Ranks agree
// after every call that may fail on one of them alone.
void writeLarge( const Communicator& ranks, const fs::path& target,
                 const std::vector<Dataset>& attributes,
                 const std::vector<Dataset>& datasets, const int compression,
                 const std::function<void()>& then )
{
    const auto temporary = temporaryName( target );
    const auto size = sizeOnDisk( datasets );
    onRoot( ranks, [&] { requireRoom( target, size ); } );
    std::unique_ptr<Writer> writer;
    try
    {
        together( ranks, [&] { requireReachable( target ); } );
        const auto access = fileAccess();
#ifdef H5_HAVE_PARALLEL
        if ( ranks.size() > 1 )
            H5Pset_fapl_mpio( access, ranks.handle(), MPI_INFO_NULL );
#endif
        together( ranks,
                  [&]
                  {
                      writer = std::make_unique<Writer>(
                          ranks.size(), ranks.isRoot(), target, access,
                          temporary, compression );
                  } );
        onRoot( ranks, [&] { reserveFile( target, size ); } );
        for ( const auto& item : datasets )
            together( ranks, [&] { writer->dataset( item ); } );
        then();
        together( ranks,
                  [&]
                  {
                      for ( const auto& item : attributes )
                          writer->attribute( item );
                  } );
        together( ranks, [&] { writer->flush(); } );
        together( ranks, [&] { writer->close(); } );
        onRoot( ranks, [&] { finishFile( target ); } );
    }
    catch ( const IoError& )
    {
        if ( ranks.isRoot() )
            emptyTemporary( target );
        ranks.any( false ); // it is empty before the others close it
        writer.reset();
        if ( ranks.isRoot() )
            dropTemporary( target );
        throw;
    }
    catch ( ... )
    {
        // One rank alone, out of memory say, and so all ranks are ended. It
        // would wait for them here: a file is closed by all ranks together.
        if ( ranks.size() > 1 )
            static_cast<void>( writer.release() );
        throw;
    }
}

} // namespace

void requireHdf5( const Communicator& ranks )
{
    if ( ranks.size() > 1 && !is_parallel )
        throw IoError::onAll(
            "cannot write output: the HDF5 of this build is a serial one; run "
            "on one rank, or build with a parallel HDF5 (Debian: "
            "libhdf5-openmpi-dev), or set output.particles and output.grid to "
            "false" );
}

void writeHdf5( const Communicator& ranks, const fs::path& target,
                const std::vector<Dataset>& attributes,
                const std::vector<Dataset>& datasets, const int compression,
                const std::size_t small, const std::function<void()>& then )
{
    const QuietHdf5 quiet;
    if ( sizeOnDisk( datasets ) <= small )
        writeSmall( ranks, target, attributes, datasets, compression, then );
    else
        writeLarge( ranks, target, attributes, datasets, compression, then );
}

#else

void requireHdf5( const Communicator& )
{
    throw IoError::onAll(
        "cannot write output: this build lacks HDF5; install it (Debian: "
        "libhdf5-openmpi-dev or libhdf5-dev) and configure with "
        "-DMachpoint_ENABLE_HDF5=ON, or set output.particles and output.grid "
        "to false" );
}

void writeHdf5( const Communicator& ranks, const fs::path&,
                const std::vector<Dataset>&, const std::vector<Dataset>&, int,
                std::size_t, const std::function<void()>& )
{
    requireHdf5( ranks );
}

#endif

} // namespace Machpoint
