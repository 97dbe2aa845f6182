/*!
  \file hdf5_handle.hpp
  \brief Layer 6: what writing and reading share of HDF5's C API: identifiers,
  types and dataspaces; for the sources of core/hdf5_file alone. Empty in a
  build without HDF5.
*/
#ifndef MACHPOINT_HDF5_HANDLE_HPP
#define MACHPOINT_HDF5_HANDLE_HPP

#include <core/hdf5_file.hpp>

#include <cstddef>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#ifdef MACHPOINT_ENABLE_HDF5
#include <hdf5.h>

namespace Machpoint
{

//! Elements of an array of this shape.
inline std::size_t count( const std::vector<std::size_t>& shape )
{
    return std::accumulate( shape.begin(), shape.end(), std::size_t{ 1 },
                            std::multiplies<>{} );
}

//! A shape, as HDF5 takes it.
inline std::vector<hsize_t> extents( const std::vector<std::size_t>& shape )
{
    return { shape.begin(), shape.end() };
}

//! While it lives, HDF5 prints no error stack: here errors become exceptions.
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

//! Owns an HDF5 identifier.
class Handle
{
  public:
    Handle( hid_t id, herr_t ( *close )( hid_t ) ) : _id( id ), _close( close )
    {
    }
    Handle( const Handle& ) = delete;
    Handle& operator=( const Handle& ) = delete;
    ~Handle() { close(); }
    herr_t close() { return _id < 0 ? 0 : _close( std::exchange( _id, -1 ) ); }
    operator hid_t() const { return _id; }

  private:
    hid_t _id;
    herr_t ( *_close )( hid_t );
};

//! What HDF5 calls a type in memory.
inline hid_t nativeType( const Dataset::Type type )
{
    switch ( type )
    {
    case Dataset::Type::real:
        return H5T_NATIVE_DOUBLE;
    case Dataset::Type::single:
        return H5T_NATIVE_FLOAT;
    case Dataset::Type::integer:
        return H5T_NATIVE_INT64;
    default:
        return H5T_NATIVE_UINT8;
    }
}

//! A dataspace of this shape; negative where HDF5 can make none.
inline hid_t makeSpace( const std::vector<std::size_t>& shape )
{
    return shape.empty() ? H5Screate( H5S_SCALAR )
                         : H5Screate_simple( static_cast<int>( shape.size() ),
                                             extents( shape ).data(), nullptr );
}

//! Selects a block of a dataspace, which may be an empty one.
inline herr_t select( const hid_t space, const std::vector<std::size_t>& start,
                      const std::vector<std::size_t>& shape )
{
    if ( count( shape ) == 0 )
        return H5Sselect_none( space );
    if ( shape.empty() )
        return H5Sselect_all( space );
    return H5Sselect_hyperslab( space, H5S_SELECT_SET, extents( start ).data(),
                                nullptr, extents( shape ).data(), nullptr );
}

} // namespace Machpoint

#endif

#endif
