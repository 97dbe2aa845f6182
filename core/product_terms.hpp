/*!
  \file product_terms.hpp
  \brief Layer 3: what a particle adds to the nodes of its stencil, as products
  of one-dimensional weights.

  Term t of a particle adds to a column of node i, at dx from it,

    ( value[t] + slope[t] . dx ) prod_d W_td(i_d),

  where W_td are the stencil's weights, or along one axis others: derivatives,
  or weights of faces. A struct says what the terms are:

    static constexpr int count;              // terms
    static constexpr int column( int t );    // of the nodes; increasing
    static constexpr bool isAffine( int t ); // has it a slope?
    static constexpr int axis( int t );      // of the other weights, or -1
*/
#ifndef MACHPOINT_PRODUCT_TERMS_HPP
#define MACHPOINT_PRODUCT_TERMS_HPP

#include <core/lanes.hpp>

#include <algorithm>

namespace Machpoint
{

//! The values of terms, and their slopes along each axis.
template <class Terms, int Dim, class Number>
struct Products
{
    //! Says what they are.
    using terms_type = Terms;
    //! Columns from the first term's to the last one's.
    static constexpr int width =
        Terms::column( Terms::count - 1 ) - Terms::column( 0 ) + 1;

    Number value[Terms::count];      //!< at the particle
    Number slope[Terms::count][Dim]; //!< of those that are affine
};

//! Terms without slopes that all take the stencil's weights.
template <int Count>
struct ValueTerms
{
    //! \name As this file's comment asks
    //! @{
    static constexpr int count = Count;
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int column( const int t )
    {
        return t;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr bool isAffine( int )
    {
        return false;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int axis( int ) { return -1; }
    //! @}
};

#ifdef MACHPOINT_HAS_LANES
namespace Impl
{

//! Some of the terms: Count of them from First on.
template <class Terms, int First, int Count>
struct SomeTerms
{
    static constexpr int count = Count;
    static constexpr int column( const int t )
    {
        return Terms::column( First + t );
    }
    static constexpr bool isAffine( const int t )
    {
        return Terms::isAffine( First + t );
    }
    static constexpr int axis( const int t )
    {
        return Terms::axis( First + t );
    }
};

//! Terms that go to a node at once: as many as a register has lanes.
inline constexpr int most_terms = std::min( lane_count, 8 );

//! So many of the terms, or the last ones, from First on.
template <int First, class Terms, int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION decltype( auto )
partOf( const Products<Terms, Dim, Number>& terms )
{
    constexpr int count = std::min( Terms::count - First, most_terms );
    if constexpr ( count == Terms::count )
        return ( terms );
    else
    {
        Products<SomeTerms<Terms, First, count>, Dim, Number> part;
        for ( int t = 0; t < count; ++t )
        {
            part.value[t] = terms.value[First + t];
            if ( Terms::isAffine( First + t ) )
                for ( int d = 0; d < Dim; ++d )
                    part.slope[t][d] = terms.slope[First + t][d];
        }
        return part;
    }
}

//! The places, as bits, whose weights along an axis are others.
template <class Terms>
constexpr int placesAlong( const int axis )
{
    int bits = 0;
    for ( int t = 0; t < Terms::count; ++t )
        if ( Terms::axis( t ) == axis )
            bits |= 1 << ( Terms::column( t ) - Terms::column( 0 ) );
    return bits;
}

//! The places, as bits, of the terms that have a slope.
template <class Terms>
constexpr int placesWithSlope()
{
    int bits = 0;
    for ( int t = 0; t < Terms::count; ++t )
        if ( Terms::isAffine( t ) )
            bits |= 1 << ( Terms::column( t ) - Terms::column( 0 ) );
    return bits;
}

} // namespace Impl
#endif

} // namespace Machpoint

#endif
