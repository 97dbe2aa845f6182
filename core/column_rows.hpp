/*!
  \file column_rows.hpp
  \brief Layer 3: on a CPU, rows of node fields in registers, a column in each
  place, and numbers of lanes in memory, which are taken to such rows lane after
  lane.
*/
#ifndef MACHPOINT_COLUMN_ROWS_HPP
#define MACHPOINT_COLUMN_ROWS_HPP

#include <core/lanes.hpp>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace Machpoint
{

#ifdef MACHPOINT_HAS_LANES
namespace Impl
{

//! An integer as long as a Real.
using LaneInteger = std::conditional_t<is_single, std::int32_t, std::int64_t>;

//! Places of a register for so many columns.
constexpr int rowWidth( const int columns )
{
    const int width = columns < 3 ? 2 : columns < 5 ? 4 : 8;
    return std::min( width, lane_count );
}

//! A row of a field of nodes in one register, a column in each place, and masks
//! of places. (One by one, as GCC 12 takes a register whose size depends on a
//! parameter for a number.)
template <int Width>
struct ColumnRow;
template <>
struct ColumnRow<2>
{
    using Row __attribute__( ( vector_size( 2 * sizeof( Real ) ) ) ) = Real;
    using Places __attribute__( ( vector_size( 2 * sizeof( Real ) ) ) ) =
        LaneInteger;
};
template <>
struct ColumnRow<4>
{
    using Row __attribute__( ( vector_size( 4 * sizeof( Real ) ) ) ) = Real;
    using Places __attribute__( ( vector_size( 4 * sizeof( Real ) ) ) ) =
        LaneInteger;
};
template <>
struct ColumnRow<8>
{
    using Row __attribute__( ( vector_size( 8 * sizeof( Real ) ) ) ) = Real;
    using Places __attribute__( ( vector_size( 8 * sizeof( Real ) ) ) ) =
        LaneInteger;
};

//! x in all places.
template <int Width>
KOKKOS_FORCEINLINE_FUNCTION auto rowOf( const Real x )
{
    using Row = typename ColumnRow<Width>::Row;
    if constexpr ( Width == 2 )
        return Row{ x, x };
    else if constexpr ( Width == 4 )
        return Row{ x, x, x, x };
    else
        return Row{ x, x, x, x, x, x, x, x };
}

#ifndef MACHPOINT_PAIRS_ARE_NEIGHBOURS
//! Puts x into some places of a row. \tparam Bits 1 << c for each place c
template <int Width, int Bits>
KOKKOS_FORCEINLINE_FUNCTION auto
replace( const typename ColumnRow<Width>::Row& row, const Real x )
{
    using Places = typename ColumnRow<Width>::Places;
    // -1 where the bit is set.
    constexpr auto at = []( const int c ) -> LaneInteger
    { return -( Bits >> c & 1 ); };
    if constexpr ( Width == 2 )
        return Places{ at( 0 ), at( 1 ) } ? rowOf<2>( x ) : row;
    else if constexpr ( Width == 4 )
        return Places{ at( 0 ), at( 1 ), at( 2 ), at( 3 ) } ? rowOf<4>( x )
                                                            : row;
    else
        return Places{ at( 0 ), at( 1 ), at( 2 ), at( 3 ),
                       at( 4 ), at( 5 ), at( 6 ), at( 7 ) }
                   ? rowOf<8>( x )
                   : row;
}
#endif

//! Calls visit with the constants 0 to N - 1.
template <int N, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void forEachConstant( const Visitor& visit )
{
    [&]<int... I>( std::integer_sequence<int, I...> ) MACHPOINT_INLINE
    {
        ( visit( std::integral_constant<int, I>() ), ... );
    }
    ( std::make_integer_sequence<int, N>() );
}

//! Calls visit with the first `count` lanes. Where there are four the compiler
//! knows them: it takes longer to find a lane's numbers than to add them.
template <class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void forEachLane( const int count,
                                              const Visitor& visit )
{
    if constexpr ( lane_count <= 4 )
        forEachConstant<lane_count>(
            [&]( const auto l ) MACHPOINT_INLINE
            {
                if ( l < count )
                    visit( l );
            } );
    else
        for ( int l = 0; l < count; ++l )
            visit( l );
}

/*!
  \brief Two numbers of every lane in memory, where a kernel takes those of one
  lane after the other to rows: out of registers it takes more shuffles.

  (Not the Lanes themselves: to read any one of these, the compiler would write
  all that they are a part of.)
*/
struct PairsInMemory
{
#ifdef MACHPOINT_PAIRS_ARE_NEIGHBOURS
    alignas( Lanes ) Real pairs[lane_count][2]; // of even lanes, then of odd

    KOKKOS_FORCEINLINE_FUNCTION void set( const Lanes& a, const Lanes& b )
    {
        Registers::storePairs( static_cast<LaneRegister>( a ),
                               static_cast<LaneRegister>( b ), pairs[0] );
    }
    KOKKOS_FORCEINLINE_FUNCTION const Real* of( const int l ) const
    {
        return pairs[( l & 1 ) * ( lane_count / 2 ) + ( l >> 1 )];
    }
#else
    alignas( Lanes ) Real first[lane_count];
    alignas( Lanes ) Real second[lane_count];

    KOKKOS_FORCEINLINE_FUNCTION void set( const Lanes& a, const Lanes& b )
    {
        std::memcpy( first, static_cast<const void*>( &a ), sizeof( first ) );
        std::memcpy( second, static_cast<const void*>( &b ), sizeof( second ) );
    }
#endif
};

//! A row of the first number of lane l, and of the second in some places.
//! \tparam Seconds 1 << c for each place c of the second
template <int Width, int Seconds>
KOKKOS_FORCEINLINE_FUNCTION auto choiceOf( const PairsInMemory& pairs,
                                           const int l )
{
#ifdef MACHPOINT_PAIRS_ARE_NEIGHBOURS
    return Registers::choiceOf<Width, Seconds>( pairs.of( l ) );
#else
    return replace<Width, Seconds>( rowOf<Width>( pairs.first[l] ),
                                    pairs.second[l] );
#endif
}

//! A row of the pairs of lane l, side by side, and 0 behind them.
//! \tparam Used 1 << c for each place c; the others have 0 in memory, too
template <int Width, int Used, std::size_t Pairs>
KOKKOS_FORCEINLINE_FUNCTION auto
joinedRow( const PairsInMemory ( &pairs )[Pairs], const int l )
{
#ifdef MACHPOINT_PAIRS_ARE_NEIGHBOURS
    const Real* numbers[Pairs];
    for ( std::size_t k = 0; k < Pairs; ++k )
        numbers[k] = pairs[k].of( l );
    return Registers::joinedRow<Width>( numbers );
#else
    typename ColumnRow<Width>::Row row{};
    forEachConstant<static_cast<int>( Pairs )>(
        [&]( const auto k ) MACHPOINT_INLINE
        {
            constexpr int first = Used & 1 << 2 * k;
            constexpr int second = Used & 2 << 2 * k;
            if constexpr ( first )
                row = replace<Width, first>( row, pairs[k].first[l] );
            if constexpr ( second )
                row = replace<Width, second>( row, pairs[k].second[l] );
        } );
    return row;
#endif
}

//! A number of every lane in memory, where nothing asks for a second one.
struct NumberInMemory
{
    alignas( Lanes ) Real number[lane_count];

    KOKKOS_FORCEINLINE_FUNCTION void set( const Lanes& a, const Lanes& )
    {
        std::memcpy( number, static_cast<const void*>( &a ), sizeof( number ) );
    }
};
template <int Width, int>
KOKKOS_FORCEINLINE_FUNCTION auto choiceOf( const NumberInMemory& numbers,
                                           const int l )
{
    return rowOf<Width>( numbers.number[l] );
}

} // namespace Impl
#endif

} // namespace Machpoint

#endif
