/*!
  \file Cabana_Tuple.hpp
  \brief One particle by value.
*/
#ifndef CABANA_TUPLE_HPP
#define CABANA_TUPLE_HPP

#include <Cabana_MemberTypes.hpp>
#include <Cabana_SoA.hpp>

#include <Kokkos_Core.hpp>

#include <cstddef>
#include <type_traits>

namespace Cabana
{

//! All members of one particle: a struct of arrays of length one.
template <typename Members>
struct Tuple;

template <typename... Types>
struct Tuple<MemberTypes<Types...>> : SoA<MemberTypes<Types...>, 1>
{
    //! The struct that stores the members.
    using base = SoA<MemberTypes<Types...>, 1>;
};

//! True for any Tuple.
template <class T>
struct is_tuple : std::false_type
{
};

template <class Members>
struct is_tuple<Tuple<Members>> : std::true_type
{
};

template <class T>
struct is_tuple<const T> : is_tuple<T>
{
};

namespace Impl
{

//! Any Tuple.
template <class T>
concept AnyTuple = is_tuple<T>::value;

} // namespace Impl

/*!
  \brief Component (d...) of member M of a tuple.
  \param tuple The particle.
  \param d One index per dimension of the member.
*/
template <std::size_t M, Impl::AnyTuple Tuple_t, class... D>
KOKKOS_FORCEINLINE_FUNCTION typename Tuple_t::template member_reference_type<M>
get( Tuple_t& tuple, const D... d )
{
    return get<M>( static_cast<typename Tuple_t::base&>( tuple ), 0, d... );
}

//! Read-only component of member M of a tuple.
template <std::size_t M, Impl::AnyTuple Tuple_t, class... D>
KOKKOS_FORCEINLINE_FUNCTION
    typename Tuple_t::template member_const_reference_type<M>
    get( const Tuple_t& tuple, const D... d )
{
    return get<M>( static_cast<const typename Tuple_t::base&>( tuple ), 0,
                   d... );
}

} // namespace Cabana

#endif
