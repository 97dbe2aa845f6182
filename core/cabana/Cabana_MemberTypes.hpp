/*!
  \file Cabana_MemberTypes.hpp
  \brief The list of types that one particle carries.
*/
#ifndef CABANA_MEMBERTYPES_HPP
#define CABANA_MEMBERTYPES_HPP

#include <cstddef>
#include <tuple>
#include <type_traits>

namespace Cabana
{

/*!
  \brief Types of a particle's members, e.g.
  `MemberTypes<double[3][3], double[3], int>`.
*/
template <typename... Types>
struct MemberTypes
{
    //! Number of members.
    static constexpr std::size_t size = sizeof...( Types );
};

//! True for any MemberTypes.
template <class T>
struct is_member_types : std::false_type
{
};

template <typename... Types>
struct is_member_types<MemberTypes<Types...>> : std::true_type
{
};

template <class T>
struct is_member_types<const T> : is_member_types<T>
{
};

//! Type of member M.
template <std::size_t M, typename Members>
struct MemberTypeAtIndex;

template <std::size_t M, typename... Types>
struct MemberTypeAtIndex<M, MemberTypes<Types...>>
{
    //! The member's type as the user wrote it, extents included.
    using type = typename std::tuple_element<M, std::tuple<Types...>>::type;
};

/*!
  \brief True when every member is a number or a fixed-size array of numbers,
  so that tuples may be moved between memory spaces byte by byte.
*/
template <typename Members>
struct CheckMemberTypes;

template <typename... Types>
struct CheckMemberTypes<MemberTypes<Types...>>
{
    //! Number of members.
    static constexpr int size = sizeof...( Types );
    //! The verdict.
    static constexpr bool value =
        size > 0 &&
        ( std::is_arithmetic_v<std::remove_all_extents_t<Types>> && ... );
};

} // namespace Cabana

#endif
