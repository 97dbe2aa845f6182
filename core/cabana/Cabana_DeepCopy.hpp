/*!
  \file Cabana_DeepCopy.hpp
  \brief Mirrors and copies of particles between memory spaces.
*/
#ifndef CABANA_DEEPCOPY_HPP
#define CABANA_DEEPCOPY_HPP

#include <Cabana_AoSoA.hpp>
#include <Cabana_Slice.hpp>
#include <Cabana_Types.hpp>

#include <Kokkos_Core.hpp>

#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace Cabana
{
namespace Impl
{

//! The same members and vector length in the memory of Space.
template <class AoSoA_t, class Space>
using MirrorOf = AoSoA<typename AoSoA_t::member_types,
                       typename Space::memory_space, AoSoA_t::vector_length>;

//! True when a mirror in Space would be the container itself.
template <class AoSoA_t, class Space>
constexpr bool is_own_mirror = std::is_same_v<typename AoSoA_t::memory_space,
                                              typename Space::memory_space>;

//! Throw unless two containers hold equally many particles.
template <class Destination, class Source>
void requireSameSize( const Destination& destination, const Source& source )
{
    if ( destination.size() != source.size() )
        throw std::runtime_error(
            "Cabana::deep_copy: \"" + source.label() + "\" holds " +
            std::to_string( source.size() ) + " particles, \"" +
            destination.label() + "\" " +
            std::to_string( destination.size() ) );
}

//! Bytes of the structs in use.
template <class AoSoA_t>
auto bytesOf( const AoSoA_t& aosoa )
{
    return bytesOf<typename AoSoA_t::memory_space>( aosoa.data(),
                                                    aosoa.numSoA() );
}

//! Copy particle by particle where both memories are accessible.
template <class Destination, class Source>
CABANA_LAUNCHES void copyTuples( const Destination& destination,
                                 const Source& source )
{
    Kokkos::parallel_for(
        "Cabana::deep_copy",
        Kokkos::RangePolicy<typename Destination::execution_space>(
            0, source.size() ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            destination.setTuple( i, source.getTuple( i ) );
        } );
    Kokkos::fence( "Cabana::deep_copy" );
}

//! First component of particle i; the next ones lie an array_stride apart.
template <class Slice_t>
KOKKOS_FORCEINLINE_FUNCTION typename Slice_t::pointer_type
firstComponent( const Slice_t& slice, const std::size_t i )
{
    using index = typename Slice_t::index_type;
    return slice.data() + index::s( i ) * Slice_t::soa_stride + index::a( i );
}

//! An AoSoA of just the member that a slice shows, in the same memory space.
template <class Slice_t>
struct PackedSlice;

template <typename DataType, typename MemorySpace, typename MemoryAccessType,
          int VectorLength, int Stride>
struct PackedSlice<
    Slice<DataType, MemorySpace, MemoryAccessType, VectorLength, Stride>>
{
    using data_type = DataType;
    using type = AoSoA<MemberTypes<DataType>, MemorySpace, VectorLength>;
};

//! Number of components of one particle's member.
template <class Slice_t>
constexpr std::size_t
    num_components = sizeof( typename PackedSlice<Slice_t>::data_type ) /
                     sizeof( typename Slice_t::value_type );

//! Copy value by value where both memories are accessible.
template <class ExecutionSpace, class Destination, class Source>
CABANA_LAUNCHES void copyValues( const Destination& destination,
                                 const Source& source )
{
    constexpr std::size_t components = num_components<Source>;
    Kokkos::parallel_for(
        "Cabana::deep_copy",
        Kokkos::RangePolicy<ExecutionSpace>( 0, source.size() ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            const auto to = firstComponent( destination, i );
            const auto from = firstComponent( source, i );
            for ( std::size_t n = 0; n < components; ++n )
                to[n * Destination::array_stride] =
                    from[n * Source::array_stride];
        } );
    Kokkos::fence( "Cabana::deep_copy" );
}

//! Set all values.
template <class Slice_t>
CABANA_LAUNCHES void fillValues( const Slice_t& slice,
                                 const typename Slice_t::value_type scalar )
{
    constexpr std::size_t components = num_components<Slice_t>;
    Kokkos::parallel_for(
        "Cabana::deep_copy",
        Kokkos::RangePolicy<typename Slice_t::execution_space>( 0,
                                                                slice.size() ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            const auto to = firstComponent( slice, i );
            for ( std::size_t n = 0; n < components; ++n )
                to[n * Slice_t::array_stride] = scalar;
        } );
    Kokkos::fence( "Cabana::deep_copy" );
}

} // namespace Impl

/*!
  \brief An AoSoA of src's size in the memory of another Space; values are not
  set.
*/
template <class Space, Impl::AnyAoSoA SrcAoSoA>
Impl::MirrorOf<SrcAoSoA, Space> create_mirror( const Space&,
                                               const SrcAoSoA& src )
{
    static_assert( !Impl::is_own_mirror<SrcAoSoA, Space>,
                   "create_mirror is for another memory space" );
    return Impl::MirrorOf<SrcAoSoA, Space>( src.label() + "_mirror",
                                            src.size() );
}

//! src itself if it lives in Space, else a mirror whose values are not set.
template <class Space, Impl::AnyAoSoA SrcAoSoA>
auto create_mirror_view( const Space& space, const SrcAoSoA& src )
{
    if constexpr ( Impl::is_own_mirror<SrcAoSoA, Space> )
        return src;
    else
        return create_mirror( space, src );
}

//! src itself if it lives in Space, else a mirror with its values.
template <class Space, Impl::AnyAoSoA SrcAoSoA>
auto create_mirror_view_and_copy( const Space& space, const SrcAoSoA& src )
{
    auto mirror = create_mirror_view( space, src );
    if constexpr ( !Impl::is_own_mirror<SrcAoSoA, Space> )
        Kokkos::deep_copy( Impl::bytesOf( mirror ), Impl::bytesOf( src ) );
    return mirror;
}

/*!
  \brief Copy all particles. Members must agree; memory space and vector
  length may differ.
  \throws std::runtime_error if the sizes differ.
*/
template <Impl::AnyAoSoA DstAoSoA, Impl::AnyAoSoA SrcAoSoA>
void deep_copy( DstAoSoA& dst, const SrcAoSoA& src )
{
    static_assert( std::is_same_v<typename DstAoSoA::member_types,
                                  typename SrcAoSoA::member_types>,
                   "Cabana::deep_copy needs equal members" );
    Impl::requireSameSize( dst, src );
    if constexpr ( std::is_same_v<typename DstAoSoA::soa_type,
                                  typename SrcAoSoA::soa_type> )
        Kokkos::deep_copy( Impl::bytesOf( dst ), Impl::bytesOf( src ) );
    else
        // Other arrays: move the bytes first, then sort them in.
        Impl::copyTuples( dst, create_mirror_view_and_copy(
                                   typename DstAoSoA::memory_space{}, src ) );
}

//! Set every particle to a tuple.
template <Impl::AnyAoSoA AoSoA_t>
CABANA_LAUNCHES void deep_copy( AoSoA_t& aosoa,
                                const typename AoSoA_t::tuple_type& tuple )
{
    Kokkos::parallel_for(
        "Cabana::deep_copy",
        Kokkos::RangePolicy<typename AoSoA_t::execution_space>( 0,
                                                                aosoa.size() ),
        KOKKOS_LAMBDA( const std::size_t i ) { aosoa.setTuple( i, tuple ); } );
    Kokkos::fence( "Cabana::deep_copy" );
}

/*!
  \brief Copy one member of all particles. Its type must agree; memory space,
  vector length and stride may differ.
  \throws std::runtime_error if the sizes differ.
*/
template <Impl::AnySlice DstSlice, Impl::AnySlice SrcSlice>
void deep_copy( DstSlice& dst, const SrcSlice& src )
{
    using Packed = typename Impl::PackedSlice<SrcSlice>::type;
    static_assert(
        std::is_same_v<
            typename Packed::member_types,
            typename Impl::PackedSlice<DstSlice>::type::member_types>,
        "Cabana::deep_copy needs members of equal type" );
    using SrcExecution = typename SrcSlice::execution_space;
    using DstExecution = typename DstSlice::execution_space;
    Impl::requireSameSize( dst, src );
    if constexpr ( is_accessible_from<typename SrcSlice::memory_space,
                                      DstExecution>::value )
        Impl::copyValues<DstExecution>( dst, src );
    else
    {
        const Packed packed( "Cabana::deep_copy", src.size() );
        Impl::copyValues<SrcExecution>( slice<0>( packed ), src );
        const auto moved = create_mirror_view_and_copy(
            typename DstSlice::memory_space{}, packed );
        Impl::copyValues<DstExecution>( dst, slice<0>( moved ) );
    }
}

//! Set every component of every particle's member to a number.
template <Impl::AnySlice Slice_t>
void deep_copy( Slice_t& slice, const typename Slice_t::value_type scalar )
{
    Impl::fillValues( slice, scalar );
}

} // namespace Cabana

#endif
