/*!
  \file Cabana_Index.hpp
  \brief Which struct and which place in its arrays a particle has.
*/
#ifndef CABANA_INDEX_HPP
#define CABANA_INDEX_HPP

#include <Kokkos_Core.hpp>

#include <cstddef>

namespace Cabana
{
namespace Impl
{

//! True for 1, 2, 4, 8, ...: division by such a length is a shift.
template <int VectorLength>
struct IsVectorLengthValid
{
    //! The verdict.
    static constexpr bool value = VectorLength > 0 &&
                                  ( VectorLength & ( VectorLength - 1 ) ) == 0;
};

/*!
  \brief Conversion between a particle's number i and its pair (s, a).
  \tparam VectorLength Length of the arrays inside a struct.
*/
template <int VectorLength>
class Index
{
  public:
    static_assert( IsVectorLengthValid<VectorLength>::value,
                   "The vector length must be a power of two" );

    //! Length of the arrays inside a struct.
    static constexpr int vector_length = VectorLength;

    //! Struct of particle i.
    KOKKOS_FORCEINLINE_FUNCTION
    static constexpr std::size_t s( const std::size_t i )
    {
        // The divisor is unsigned and a power of two: this is a shift.
        return i / static_cast<std::size_t>( VectorLength );
    }

    //! Place of particle i inside its struct's arrays.
    KOKKOS_FORCEINLINE_FUNCTION
    static constexpr std::size_t a( const std::size_t i )
    {
        return i % static_cast<std::size_t>( VectorLength );
    }

    //! Number of the particle at place a of struct s.
    KOKKOS_FORCEINLINE_FUNCTION
    static constexpr std::size_t i( const std::size_t s, const std::size_t a )
    {
        return s * static_cast<std::size_t>( VectorLength ) + a;
    }

    //! Structs that n particles need. The last one may be partly filled.
    KOKKOS_FORCEINLINE_FUNCTION
    static constexpr std::size_t numStruct( const std::size_t n )
    {
        return s( n + VectorLength - 1 );
    }
};

} // namespace Impl
} // namespace Cabana

#endif
