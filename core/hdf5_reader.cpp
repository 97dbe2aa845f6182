/*!
  \file hdf5_reader.cpp
  \brief HDF5 files, read by one rank for itself.
*/
#include <core/hdf5_file.hpp>
#include <core/hdf5_handle.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <system_error>

namespace fs = std::filesystem;

namespace Machpoint
{

#ifdef MACHPOINT_ENABLE_HDF5

namespace
{

[[noreturn]] void refuseHdf5( const fs::path& file, const std::string& reason )
{
    throw IoError( fmt::format( "{}: {}; is it a file of this program, and "
                                "whole?",
                                file.string(), reason ) );
}

//! Is what is stored of this type, or a real of another precision?
bool fits( const hid_t stored, const Dataset::Type type )
{
    const auto native = nativeType( type );
    return H5Tget_class( stored ) == H5Tget_class( native ) &&
           ( H5Tget_class( native ) == H5T_FLOAT ||
             H5Tget_size( stored ) == H5Tget_size( native ) );
}

} // namespace

Hdf5Reader::Hdf5Reader( const fs::path& file ) : _path( file )
{
    const QuietHdf5 quiet;
    _file = H5Fopen( file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT );
    if ( _file >= 0 )
        return;
    std::error_code error;
    const auto kind = fs::status( file, error ).type();
    if ( kind == fs::file_type::directory )
        throw IoError(
            fmt::format( "{}: cannot be read: it is a directory; name a file",
                         file.string() ) );
    if ( kind == fs::file_type::not_found )
        throw IoError( fmt::format(
            "{}: cannot be read: there is no such file; check its name",
            file.string() ) );
    refuseHdf5( file, "cannot be read as an HDF5 file" );
}

Hdf5Reader::~Hdf5Reader()
{
    H5Fclose( _file );
}

bool Hdf5Reader::has( const std::string& dataset ) const
{
    const QuietHdf5 quiet;
    return Handle( H5Dopen2( _file, dataset.c_str(), H5P_DEFAULT ),
                   H5Dclose ) >= 0;
}

std::vector<std::size_t> Hdf5Reader::shape( const std::string& name ) const
{
    const QuietHdf5 quiet;
    const Handle dataset( H5Dopen2( _file, name.c_str(), H5P_DEFAULT ),
                          H5Dclose );
    if ( dataset < 0 )
        refuseHdf5( _path, "there is no dataset " + name );
    const Handle space( H5Dget_space( dataset ), H5Sclose );
    std::vector<hsize_t> extents(
        static_cast<std::size_t>( H5Sget_simple_extent_ndims( space ) ) );
    H5Sget_simple_extent_dims( space, extents.data(), nullptr );
    return { extents.begin(), extents.end() };
}

void Hdf5Reader::readBlock( const std::string& name, const Dataset::Type type,
                            const std::vector<std::size_t>& start,
                            const std::vector<std::size_t>& shape,
                            void* values ) const
{
    const QuietHdf5 quiet;
    const auto whole = this->shape( name );
    bool inside = start.size() == whole.size() && shape.size() == whole.size();
    for ( std::size_t axis = 0; inside && axis < whole.size(); ++axis )
        inside = start[axis] <= whole[axis] &&
                 shape[axis] <= whole[axis] - start[axis];
    if ( !inside )
        refuseHdf5( _path,
                    fmt::format( "the dataset {} is [{}], and lacks a block "
                                 "[{}] from [{}]",
                                 name, fmt::join( whole, "][" ),
                                 fmt::join( shape, "][" ),
                                 fmt::join( start, "][" ) ) );
    const Handle dataset( H5Dopen2( _file, name.c_str(), H5P_DEFAULT ),
                          H5Dclose );
    const Handle stored( H5Dget_type( dataset ), H5Tclose );
    if ( !fits( stored, type ) )
        refuseHdf5( _path, "the dataset " + name + " has another type" );
    if ( count( shape ) == 0 )
        return;
    const Handle space( H5Dget_space( dataset ), H5Sclose );
    const Handle memory( makeSpace( shape ), H5Sclose );
    if ( select( space, start, shape ) < 0 ||
         H5Dread( dataset, nativeType( type ), memory, space, H5P_DEFAULT,
                  values ) < 0 )
        refuseHdf5( _path, "cannot read the dataset " + name );
}

std::size_t Hdf5Reader::attributeSize( const std::string& name ) const
{
    const QuietHdf5 quiet;
    const Handle attribute( H5Aopen( _file, name.c_str(), H5P_DEFAULT ),
                            H5Aclose );
    if ( attribute < 0 )
        refuseHdf5( _path, "there is no attribute " + name );
    const Handle space( H5Aget_space( attribute ), H5Sclose );
    return static_cast<std::size_t>( H5Sget_simple_extent_npoints( space ) );
}

void Hdf5Reader::readAttribute( const std::string& name,
                                const Dataset::Type type, void* values ) const
{
    const QuietHdf5 quiet;
    const Handle attribute( H5Aopen( _file, name.c_str(), H5P_DEFAULT ),
                            H5Aclose );
    const Handle stored( H5Aget_type( attribute ), H5Tclose );
    if ( !fits( stored, type ) )
        refuseHdf5( _path, "the attribute " + name + " has another type" );
    if ( H5Aread( attribute, nativeType( type ), values ) < 0 )
        refuseHdf5( _path, "cannot read the attribute " + name );
}

#else

Hdf5Reader::Hdf5Reader( const fs::path& file ) : _path( file ), _file( -1 )
{
    throw IoError( file.string() +
                   ": cannot be read: this build lacks HDF5; configure with "
                   "-DMachpoint_ENABLE_HDF5=ON" );
}

// Never reached: there is no reader.
Hdf5Reader::~Hdf5Reader() = default;
bool Hdf5Reader::has( const std::string& ) const
{
    return false;
}
std::vector<std::size_t> Hdf5Reader::shape( const std::string& ) const
{
    return {};
}
void Hdf5Reader::readBlock( const std::string&, Dataset::Type,
                            const std::vector<std::size_t>&,
                            const std::vector<std::size_t>&, void* ) const
{
}
std::size_t Hdf5Reader::attributeSize( const std::string& ) const
{
    return 0;
}
void Hdf5Reader::readAttribute( const std::string&, Dataset::Type, void* ) const
{
}

#endif

} // namespace Machpoint
