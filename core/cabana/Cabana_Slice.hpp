/*!
  \file Cabana_Slice.hpp
  \brief Access to one member of all particles of an AoSoA.
*/
#ifndef CABANA_SLICE_HPP
#define CABANA_SLICE_HPP

#include <Cabana_Types.hpp>
#include <impl/Cabana_ArrayStride.hpp>
#include <impl/Cabana_AtomicReference.hpp>
#include <impl/Cabana_Index.hpp>
#include <impl/Cabana_Label.hpp>

#include <Kokkos_Core.hpp>

#include <cassert>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>

namespace Cabana
{
namespace Impl
{

//! Reference and pointer that a memory access tag hands out.
template <class T, class MemoryAccess>
struct SliceAccess
{
    using pointer = T*;
    using reference = T&;
};

template <class T>
struct SliceAccess<T, RandomAccessMemory>
{
    using pointer = const T*;
    using reference = const T&;
};

template <class T>
struct SliceAccess<T, AtomicAccessMemory>
{
    using pointer = T*;
    using reference = AtomicReference<T>;
};

} // namespace Impl

/*!
  \brief One member of all particles. Does not own the memory: it is valid
  until its AoSoA reallocates or dies.

  \tparam DataType Type of the member, e.g. `double[3][3]`.
  \tparam MemorySpace Where the particles live.
  \tparam MemoryAccessType DefaultAccessMemory, RandomAccessMemory (read only)
  or AtomicAccessMemory. A default slice converts to the other two.
  \tparam VectorLength Length of the arrays inside a struct.
  \tparam Stride Distance of two structs, counted in values of the member.
*/
template <typename DataType, typename MemorySpace, typename MemoryAccessType,
          int VectorLength, int Stride>
class Slice
{
    static_assert( Kokkos::is_memory_space<MemorySpace>::value,
                   "A slice lives in a memory space" );
    static_assert( is_memory_access_tag<MemoryAccessType>::value,
                   "Unknown memory access tag" );

  public:
    //! This type.
    using slice_type =
        Slice<DataType, MemorySpace, MemoryAccessType, VectorLength, Stride>;
    //! Where the particles live.
    using memory_space = MemorySpace;
    //! Where loops over them run by default.
    using execution_space = typename memory_space::execution_space;
    //! Type of sizes and indices.
    using size_type = typename memory_space::size_type;
    //! How the memory is read and written.
    using memory_access_type = MemoryAccessType;
    //! Conversion between particle numbers and (s, a).
    using index_type = Impl::Index<VectorLength>;
    //! Number type of the member.
    using value_type = std::remove_all_extents_t<DataType>;
    //! What access returns.
    using reference_type =
        typename Impl::SliceAccess<value_type, MemoryAccessType>::reference;
    //! What data() returns.
    using pointer_type =
        typename Impl::SliceAccess<value_type, MemoryAccessType>::pointer;

    //! The same slice with plain access.
    using default_access_slice =
        Slice<DataType, MemorySpace, DefaultAccessMemory, VectorLength, Stride>;
    //! The same slice with atomic access.
    using atomic_access_slice =
        Slice<DataType, MemorySpace, AtomicAccessMemory, VectorLength, Stride>;
    //! The same slice, read only.
    using random_access_slice =
        Slice<DataType, MemorySpace, RandomAccessMemory, VectorLength, Stride>;

    //! Length of the arrays inside a struct.
    static constexpr int vector_length = VectorLength;
    //! Distance of two structs, counted in values of the member.
    static constexpr int soa_stride = Stride;
    //! Distance of two components, counted in values of the member.
    static constexpr int array_stride =
        Impl::array_stride<value_type, VectorLength>;
    //! Most dimensions a member may have.
    static constexpr std::size_t max_supported_rank = 3;
    //! Indices that operator() takes: the particle's and the member's.
    static constexpr int rank = std::rank_v<DataType> + 1;

    //! A slice of nothing.
    Slice() = default;

    /*!
      \brief Slice of given memory.
      \param data First value of the member.
      \param size Number of particles.
      \param num_soa Number of structs.
      \param label Name for messages.
    */
    Slice( const pointer_type data, const size_type size,
           const size_type num_soa, const std::string& label = "" )
        : _data( data ), _size( size ), _num_soa( num_soa ),
          _label( Impl::internLabel( label ) )
    {
    }

    //! The same memory, accessed in another way.
    template <class OtherAccess>
    Slice( const Slice<DataType, MemorySpace, OtherAccess, VectorLength,
                       Stride>& other )
        : _data( other._data ), _size( other._size ),
          _num_soa( other._num_soa ), _label( other._label )
    {
    }

    //! Name for messages.
    std::string label() const { return _label; }

    //! Number of particles.
    KOKKOS_FORCEINLINE_FUNCTION size_type size() const { return _size; }

    //! Number of structs.
    KOKKOS_FORCEINLINE_FUNCTION size_type numSoA() const { return _num_soa; }

    //! Number of particles in struct s: the last one may be partly filled.
    KOKKOS_FORCEINLINE_FUNCTION size_type arraySize( const size_type s ) const
    {
        const size_type before = s * vector_length;
        return _size - before < size_type( vector_length ) ? _size - before
                                                           : vector_length;
    }

    /*!
      \brief Component (d...) of the particle at place a of struct s.
      \param d One index per dimension of the member.
    */
    template <class... D>
    KOKKOS_FORCEINLINE_FUNCTION reference_type access( const size_type s,
                                                       const size_type a,
                                                       const D... d ) const
    {
        static_assert( sizeof...( D ) == std::rank_v<DataType>,
                       "One index per dimension of the member" );
        assert( s < _num_soa && a < size_type( vector_length ) );
        return reference_type(
            _data[std::size_t( Stride ) * s + a +
                  array_stride *
                      component( std::index_sequence_for<D...>{}, d... )] );
    }

    //! Component (d...) of particle i.
    template <class... D>
    KOKKOS_FORCEINLINE_FUNCTION reference_type operator()( const size_type i,
                                                           const D... d ) const
    {
        return access( index_type::s( i ), index_type::a( i ), d... );
    }

    //! First value of the member.
    KOKKOS_FORCEINLINE_FUNCTION pointer_type data() const { return _data; }

    //! Dimensions of the raw data: struct, array, and the member's own.
    KOKKOS_FORCEINLINE_FUNCTION constexpr size_type viewRank() const
    {
        return rank + 1;
    }

    //! Extent of dimension d of the raw data; 1 beyond the last.
    KOKKOS_FORCEINLINE_FUNCTION size_type extent( const size_type d ) const
    {
        return d == 0   ? _num_soa
               : d == 1 ? size_type( vector_length )
                        : memberExtent( d - 2 );
    }

    //! Distance in values of two neighbours in dimension d of the raw data.
    KOKKOS_FORCEINLINE_FUNCTION size_type stride( const size_type d ) const
    {
        if ( d == 0 )
            return Stride;
        if ( d == 1 )
            return 1;
        size_type result = array_stride;
        for ( size_type later = d - 1; later < max_supported_rank; ++later )
            result *= memberExtent( later );
        return result;
    }

  private:
    template <typename, typename, typename, int, int>
    friend class Slice;

    // Extent of dimension d of the member; 1 beyond the last.
    KOKKOS_FORCEINLINE_FUNCTION static constexpr size_type
    memberExtent( const size_type d )
    {
        return d >= size_type( std::rank_v<DataType> ) ? 1
               : d == 0 ? std::extent_v<DataType, 0>
               : d == 1 ? std::extent_v<DataType, 1>
                        : std::extent_v<DataType, 2>;
    }

    // Row-major number of component (d...). All extents are constants, so it
    // costs nothing for constant indices.
    template <std::size_t... N, class... D>
    KOKKOS_FORCEINLINE_FUNCTION static constexpr std::size_t
    component( std::index_sequence<N...>, const D... d )
    {
        std::size_t number = 0;
        ( ( number = number * std::extent_v<DataType, N> + std::size_t( d ) ),
          ... );
        return number;
    }

    pointer_type _data = nullptr;
    size_type _size = 0;
    size_type _num_soa = 0;
    const char* _label = "";
};

//! True for any Slice.
template <class T>
struct is_slice : std::false_type
{
};

template <typename DataType, typename MemorySpace, typename MemoryAccessType,
          int VectorLength, int Stride>
struct is_slice<
    Slice<DataType, MemorySpace, MemoryAccessType, VectorLength, Stride>>
    : std::true_type
{
};

template <class T>
struct is_slice<const T> : is_slice<T>
{
};

namespace Impl
{

//! Any Slice.
template <class T>
concept AnySlice = is_slice<T>::value;

} // namespace Impl
} // namespace Cabana

#endif
