/*!
  \file Cabana_AoSoA.hpp
  \brief The particles: an array of structs of arrays.
*/
#ifndef CABANA_AOSOA_HPP
#define CABANA_AOSOA_HPP

#include <Cabana_MemberTypes.hpp>
#include <Cabana_Slice.hpp>
#include <Cabana_SoA.hpp>
#include <Cabana_Tuple.hpp>
#include <Cabana_Types.hpp>
#include <impl/Cabana_Bytes.hpp>
#include <impl/Cabana_Index.hpp>
#include <impl/Cabana_PerformanceTraits.hpp>

#include <Kokkos_Core.hpp>

#include <cassert>
#include <cstddef>
#include <string>
#include <type_traits>

namespace Cabana
{

/*!
  \brief A resizable container of particles, shared by its copies until one of
  them reallocates.

  Particle i is at place a(i) of struct s(i) (see Impl::Index). Copying an
  AoSoA copies the handle, not the particles, as for a Kokkos::View.

  \tparam DataTypes MemberTypes: what a particle carries. Large types first
  and equal types together keep padding small.
  \tparam MemorySpace Kokkos memory space of the particles.
  \tparam VectorLength Length of the arrays inside a struct; a power of two.
  \tparam MemoryTraits Kokkos memory traits, e.g. Kokkos::MemoryUnmanaged.
*/
template <class DataTypes, class MemorySpace,
          int VectorLength = Impl::PerformanceTraits<
              typename MemorySpace::execution_space>::vector_length,
          class MemoryTraits = Kokkos::MemoryTraits<0>>
class AoSoA
{
    static_assert( is_member_types<DataTypes>::value,
                   "AoSoA members must be given as MemberTypes" );
    static_assert( CheckMemberTypes<DataTypes>::value,
                   "AoSoA members must be numbers or arrays of numbers" );
    static_assert( Kokkos::is_memory_space<MemorySpace>::value,
                   "An AoSoA lives in a memory space" );

  public:
    //! This type.
    using aosoa_type =
        AoSoA<DataTypes, MemorySpace, VectorLength, MemoryTraits>;
    //! The same container in host memory.
    using host_mirror_type = AoSoA<DataTypes, Kokkos::HostSpace, VectorLength>;
    //! What a particle carries.
    using member_types = DataTypes;
    //! Where the particles live.
    using memory_space = MemorySpace;
    //! Where loops over them run by default.
    using execution_space = typename memory_space::execution_space;
    //! Kokkos memory traits of the allocation.
    using memory_traits = MemoryTraits;
    //! Type of sizes and indices.
    using size_type = typename memory_space::size_type;
    //! The struct of arrays.
    using soa_type = SoA<member_types, VectorLength>;
    //! The allocation.
    using soa_view = Kokkos::View<soa_type*, memory_space, memory_traits>;
    //! Conversion between particle numbers and (s, a).
    using index_type = Impl::Index<VectorLength>;
    //! One particle by value.
    using tuple_type = Tuple<member_types>;

    //! Length of the arrays inside a struct.
    static constexpr int vector_length = VectorLength;
    //! Number of members of a particle.
    static constexpr std::size_t number_of_members = member_types::size;
    //! Most dimensions a member may have.
    static constexpr std::size_t max_supported_rank = 3;

    //! Type of member M as the user wrote it.
    template <std::size_t M>
    using member_data_type = typename MemberTypeAtIndex<M, member_types>::type;
    //! Number type of member M.
    template <std::size_t M>
    using member_value_type = std::remove_all_extents_t<member_data_type<M>>;
    //! Pointer to components of member M.
    template <std::size_t M>
    using member_pointer_type = std::add_pointer_t<member_value_type<M>>;
    //! Slice of member M.
    template <std::size_t M>
    using member_slice_type =
        Slice<member_data_type<M>, memory_space, DefaultAccessMemory,
              vector_length,
              sizeof( soa_type ) / sizeof( member_value_type<M> )>;

    //! An empty container. Allocates nothing.
    AoSoA( const std::string& label = "" ) : AoSoA( label, 0 ) {}

    //! A container of n particles, whose members are not set.
    AoSoA( const std::string& label, const size_type n )
        : _data( Kokkos::view_alloc( label, Kokkos::WithoutInitializing ), 0 )
    {
        static_assert( !memory_traits::is_unmanaged,
                       "Unmanaged memory must be given" );
        resize( n );
    }

    /*!
      \brief A container in memory that the caller owns.
      \param ptr The structs, in memory_space.
      \param num_soa Number of structs.
      \param n Number of particles.
    */
    AoSoA( soa_type* ptr, const size_type num_soa, const size_type n )
        : _size( n ), _capacity( num_soa * vector_length ), _num_soa( num_soa ),
          _data( ptr, num_soa )
    {
        static_assert( memory_traits::is_unmanaged,
                       "Only unmanaged memory can be given" );
    }

    //! Name of the allocation.
    std::string label() const { return _data.label(); }

    //! Number of particles.
    KOKKOS_FUNCTION size_type size() const { return _size; }

    //! True without particles.
    KOKKOS_FUNCTION bool empty() const { return _size == 0; }

    //! Number of particles that fit without reallocation.
    KOKKOS_FUNCTION size_type capacity() const { return _capacity; }

    /*!
      \brief Change the number of particles to n.

      The first min(n, size()) particles keep their values, new ones are not
      set. Slices stay valid unless n exceeds capacity().
    */
    void resize( const size_type n )
    {
        reserve( n );
        _size = n;
        _num_soa = index_type::numStruct( n );
    }

    //! Make room for n particles. Never shrinks; reallocates only to grow.
    void reserve( const size_type n )
    {
        if ( n > _capacity )
            reallocate( index_type::numStruct( n ) );
    }

    //! Give back the structs that no particle needs.
    void shrinkToFit()
    {
        if ( _data.extent( 0 ) > _num_soa )
            reallocate( _num_soa );
    }

    //! Number of structs in use.
    KOKKOS_FUNCTION size_type numSoA() const { return _num_soa; }

    //! Number of particles in struct s: the last one may be partly filled.
    KOKKOS_FUNCTION size_type arraySize( const size_type s ) const
    {
        const size_type before = s * vector_length;
        return _size - before < size_type( vector_length ) ? _size - before
                                                           : vector_length;
    }

    //! Struct s.
    KOKKOS_FORCEINLINE_FUNCTION soa_type& access( const size_type s ) const
    {
        return _data( s );
    }

    //! Particle i, by value.
    KOKKOS_FORCEINLINE_FUNCTION tuple_type getTuple( const size_type i ) const
    {
        assert( i < _size );
        tuple_type tuple;
        Impl::tupleCopy<member_types, 1, vector_length>(
            tuple, 0, access( index_type::s( i ) ), index_type::a( i ) );
        return tuple;
    }

    //! Overwrite particle i.
    KOKKOS_FORCEINLINE_FUNCTION void setTuple( const size_type i,
                                               const tuple_type& tuple ) const
    {
        assert( i < _size );
        Impl::tupleCopy<member_types, vector_length, 1>(
            access( index_type::s( i ) ), index_type::a( i ), tuple, 0 );
    }

    //! First struct; null when nothing is allocated.
    soa_type* data() const { return _data.data(); }

  private:
    // Move the structs in use to a new allocation of num_soa structs.
    void reallocate( const size_type num_soa )
    {
        static_assert( !memory_traits::is_unmanaged,
                       "Unmanaged memory cannot be reallocated" );
        soa_view data(
            Kokkos::view_alloc( _data.label(), Kokkos::WithoutInitializing ),
            num_soa );
        if ( _num_soa > 0 )
            Kokkos::deep_copy(
                Impl::bytesOf<MemorySpace>( data.data(), _num_soa ),
                Impl::bytesOf<MemorySpace>( _data.data(), _num_soa ) );
        _data = data;
        _capacity = num_soa * vector_length;
    }

    size_type _size = 0;
    size_type _capacity = 0;
    size_type _num_soa = 0;
    soa_view _data;
};

//! True for any AoSoA.
template <class T>
struct is_aosoa : std::false_type
{
};

template <class DataTypes, class MemorySpace, int VectorLength,
          class MemoryTraits>
struct is_aosoa<AoSoA<DataTypes, MemorySpace, VectorLength, MemoryTraits>>
    : std::true_type
{
};

template <class T>
struct is_aosoa<const T> : is_aosoa<T>
{
};

namespace Impl
{

//! Any AoSoA.
template <class T>
concept AnyAoSoA = is_aosoa<T>::value;

} // namespace Impl

/*!
  \brief Slice of member M of all particles. Invalid once aosoa reallocates.
  \param aosoa The particles.
  \param label Name for messages.
*/
template <std::size_t M, Impl::AnyAoSoA AoSoA_t>
typename AoSoA_t::template member_slice_type<M>
slice( const AoSoA_t& aosoa, const std::string& label = "" )
{
    using value_type = typename AoSoA_t::template member_value_type<M>;
    static_assert(
        sizeof( typename AoSoA_t::soa_type ) % sizeof( value_type ) == 0,
        "The struct's size must be a multiple of the value's" );
    return { Impl::soaMemberPtr<M>( aosoa.data() ), aosoa.size(),
             aosoa.numSoA(), label };
}

} // namespace Cabana

#endif
