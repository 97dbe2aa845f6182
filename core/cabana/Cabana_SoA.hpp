/*!
  \file Cabana_SoA.hpp
  \brief A struct of arrays: VectorLength particles, member by member.
*/
#ifndef CABANA_SOA_HPP
#define CABANA_SOA_HPP

#include <Cabana_MemberTypes.hpp>
#include <impl/Cabana_ArrayStride.hpp>

#include <Kokkos_Core.hpp>

#include <bit>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace Cabana
{

template <typename Members, int VectorLength>
struct SoA;

//! True for any SoA (a Tuple, although it derives from one, is none).
template <class T>
struct is_soa : std::false_type
{
};

template <class Members, int VectorLength>
struct is_soa<SoA<Members, VectorLength>> : std::true_type
{
};

template <class T>
struct is_soa<const T> : is_soa<T>
{
};

namespace Impl
{

//! Any SoA.
template <class T>
concept AnySoA = is_soa<T>::value;

//! T with one more, innermost, dimension: the particles run fastest.
template <typename T, int VectorLength>
struct InnerArrayType
{
    using type = T[array_stride<T, VectorLength>];
};

template <typename T, std::size_t N, int VectorLength>
struct InnerArrayType<T[N], VectorLength>
{
    using type = typename InnerArrayType<T, VectorLength>::type[N];
};

//! Storage of member M, so that no array crosses a line of 64 bytes that could
//! do without, whatever the members before it are. M tells bases of equal type
//! apart.
template <std::size_t M, int VectorLength, typename T>
struct StructMember
{
    static constexpr std::size_t row =
        sizeof( std::remove_all_extents_t<T> ) * VectorLength;
    alignas( !std::has_single_bit( row ) ? alignof( T )
             : row < 64                  ? row
                                         : 64 )
        typename InnerArrayType<T, VectorLength>::type _data;
};

template <int VectorLength, typename Sequence, typename... Types>
struct SoAStorage;

template <int VectorLength, std::size_t... M, typename... Types>
struct SoAStorage<VectorLength, std::index_sequence<M...>, Types...>
    : StructMember<M, VectorLength, Types>...
{
};

//! Element of a (multi-dimensional) array, one index per dimension.
template <class Array, class... Rest>
KOKKOS_FORCEINLINE_FUNCTION auto&
element( Array& array, const std::size_t first, const Rest... rest )
{
    if constexpr ( sizeof...( Rest ) == 0 )
        return array[first];
    else
        return element( array[first], rest... );
}

} // namespace Impl

/*!
  \brief Arrays of VectorLength values, one for each component of each member:
  a `double[3]` member is stored as `double[3][VectorLength]`, long arrays with
  a gap behind each (Impl::array_stride). The struct is trivial and holds
  nothing else.
*/
template <typename... Types, int VectorLength>
struct SoA<MemberTypes<Types...>, VectorLength>
    : Impl::SoAStorage<VectorLength, std::index_sequence_for<Types...>,
                       Types...>
{
    //! Length of the arrays.
    static constexpr int vector_length = VectorLength;
    //! Types of the members.
    using member_types = MemberTypes<Types...>;
    //! Number of members.
    static constexpr std::size_t number_of_members = member_types::size;
    //! Most dimensions a member may have.
    static constexpr std::size_t max_supported_rank = 3;
    static_assert( ( ( std::rank_v<Types> <= max_supported_rank ) && ... ),
                   "A member may have at most three dimensions" );

    //! Type of member M as the user wrote it.
    template <std::size_t M>
    using member_data_type = typename MemberTypeAtIndex<M, member_types>::type;
    //! Number type of member M.
    template <std::size_t M>
    using member_value_type = std::remove_all_extents_t<member_data_type<M>>;
    //! Reference to one component of member M.
    template <std::size_t M>
    using member_reference_type = member_value_type<M>&;
    //! Read-only reference to one component of member M.
    template <std::size_t M>
    using member_const_reference_type = const member_value_type<M>&;
    //! Pointer to components of member M.
    template <std::size_t M>
    using member_pointer_type = std::add_pointer_t<member_value_type<M>>;
    //! The base that stores member M.
    template <std::size_t M>
    using base = Impl::StructMember<M, vector_length, member_data_type<M>>;

    //! Number of dimensions of member M.
    template <std::size_t M>
    KOKKOS_FORCEINLINE_FUNCTION constexpr std::size_t rank() const
    {
        return std::rank_v<member_data_type<M>>;
    }

    //! Extent of dimension D of member M.
    template <std::size_t M, std::size_t D>
    KOKKOS_FORCEINLINE_FUNCTION constexpr std::size_t extent() const
    {
        return std::extent_v<member_data_type<M>, D>;
    }
};

/*!
  \brief Component (d...) of member M at place a of a struct.
  \param soa The struct.
  \param a Place inside the arrays.
  \param d One index per dimension of the member.
*/
template <std::size_t M, Impl::AnySoA SoA_t, class... D>
KOKKOS_FORCEINLINE_FUNCTION typename SoA_t::template member_reference_type<M>
get( SoA_t& soa, const std::size_t a, const D... d )
{
    using base = typename SoA_t::template base<M>;
    return Impl::element( static_cast<base&>( soa )._data,
                          static_cast<std::size_t>( d )..., a );
}

//! Read-only component of member M at place a of a struct.
template <std::size_t M, Impl::AnySoA SoA_t, class... D>
KOKKOS_FORCEINLINE_FUNCTION
    typename SoA_t::template member_const_reference_type<M>
    get( const SoA_t& soa, const std::size_t a, const D... d )
{
    using base = typename SoA_t::template base<M>;
    return Impl::element( static_cast<const base&>( soa )._data,
                          static_cast<std::size_t>( d )..., a );
}

namespace Impl
{

//! Pointer to the first value of member M of an array of structs.
template <std::size_t M, class SoA_t>
typename SoA_t::template member_pointer_type<M> soaMemberPtr( SoA_t* soa )
{
    using Member = typename SoA_t::template base<M>;
    // The base holds the array and nothing else, so both start at one address;
    // null, of an empty container, stays null.
    void* const start = static_cast<Member*>( soa );
    return static_cast<typename SoA_t::template member_value_type<M>*>( start );
}

//! Copy member M of one particle.
template <std::size_t M, class Destination, class Source>
KOKKOS_FORCEINLINE_FUNCTION void
copyMember( Destination& destination, const std::size_t destination_a,
            const Source& source, const std::size_t source_a )
{
    using T = typename Source::template member_data_type<M>;
    auto copy = [&]( const auto... d )
    {
        get<M>( destination, destination_a, d... ) =
            get<M>( source, source_a, d... );
    };
    constexpr std::size_t rank = std::rank_v<T>;
    if constexpr ( rank == 0 )
        copy();
    else
        for ( std::size_t i = 0; i < std::extent_v<T, 0>; ++i )
            if constexpr ( rank == 1 )
                copy( i );
            else
                for ( std::size_t j = 0; j < std::extent_v<T, 1>; ++j )
                    if constexpr ( rank == 2 )
                        copy( i, j );
                    else
                        for ( std::size_t k = 0; k < std::extent_v<T, 2>; ++k )
                            copy( i, j, k );
}

template <class Destination, class Source, std::size_t... M>
KOKKOS_FORCEINLINE_FUNCTION void
copyMembers( Destination& destination, const std::size_t destination_a,
             const Source& source, const std::size_t source_a,
             std::index_sequence<M...> )
{
    ( copyMember<M>( destination, destination_a, source, source_a ), ... );
}

/*!
  \brief Copy one particle between structs of the same members, whose vector
  lengths may differ.
*/
template <class Members, int DestinationLength, int SourceLength>
KOKKOS_FORCEINLINE_FUNCTION void
tupleCopy( SoA<Members, DestinationLength>& destination,
           const std::size_t destination_a,
           const SoA<Members, SourceLength>& source,
           const std::size_t source_a )
{
    copyMembers( destination, destination_a, source, source_a,
                 std::make_index_sequence<Members::size>{} );
}

} // namespace Impl
} // namespace Cabana

#endif
