/*!
  \file lane_rows.hpp
  \brief Layer 2: rows of node fields, of one particle or of each of a pack:
  where stencils begin, and columns that are read there.
*/
#ifndef MACHPOINT_LANE_ROWS_HPP
#define MACHPOINT_LANE_ROWS_HPP

#include <core/lanes.hpp>

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace Machpoint
{

/*!
  \brief Tells a CPU to fetch memory of a node field from the start of a row on.
  \tparam Writes are rows added to or written? \tparam Lines of the cache
*/
template <bool Writes, int Lines>
KOKKOS_FORCEINLINE_FUNCTION void
prefetchRow( [[maybe_unused]] const Real* const field,
             [[maybe_unused]] const std::ptrdiff_t columns,
             [[maybe_unused]] const int row )
{
#ifdef MACHPOINT_HAS_LANES
    const auto* const start =
        reinterpret_cast<const char*>( field + row * columns );
    __builtin_prefetch( start, Writes, 3 );
    if constexpr ( Lines > 1 )
        __builtin_prefetch( start + 64, Writes, 3 );
#endif
}

//! \name One particle
//! @{
//! Column c of a node.
KOKKOS_FORCEINLINE_FUNCTION Real at( const NodeView& nodes, const int row,
                                     const int c )
{
    return nodes( row, c );
}
/*!
  \brief K columns of a node from the first on.

  A GPU reads two at once where K is even; then the field has to have an even
  number of columns, and `first` to be even.
*/
template <std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void loadRow( const NodeView& nodes, const int row,
                                          Real ( &values )[K],
                                          const int first = 0 )
{
    const Real* const start = &nodes( row, first );
#ifndef MACHPOINT_HAS_LANES
    if constexpr ( K % 2 == 0 )
    {
        struct alignas( 2 * sizeof( Real ) ) Two
        {
            Real number[2];
        };
        assert( reinterpret_cast<std::uintptr_t>( start ) % sizeof( Two ) ==
                0 );
        const auto* const twos = reinterpret_cast<const Two*>( start );
        MACHPOINT_UNROLL
        for ( std::size_t c = 0; c < K; c += 2 )
        {
            const Two two = twos[c / 2];
            values[c] = two.number[0];
            values[c + 1] = two.number[1];
        }
        return;
    }
#endif
    for ( std::size_t c = 0; c < K; ++c )
        values[c] = start[c];
}
//! Node row: the stencil's first, and how far from it.
KOKKOS_FORCEINLINE_FUNCTION int rowAt( const int base, const int shift )
{
    return base + shift;
}
//! @}

#ifdef MACHPOINT_HAS_LANES

//! \name Several particles
//! @{
//! Node rows of the particles of a pack: row[l] + shift.
struct LaneRows
{
    const int* row; //!< [lane_count]
    int shift;      //!< from there, the same for all
};

//! Node rows of a pack, from a column on: row rows.row[l] starts its number of
//! rows behind this.
inline const Real* columnsFrom( const NodeView& nodes, const LaneRows& rows,
                                const int first )
{
    return nodes.data() +
           static_cast<std::size_t>( rows.shift ) * nodes.stride( 0 ) + first;
}

//! Column c of the nodes, one of each lane.
KOKKOS_FORCEINLINE_FUNCTION Lanes at( const NodeView& nodes,
                                      const LaneRows& rows, const int c )
{
    const std::size_t columns = nodes.stride( 0 );
    const Real* const first = columnsFrom( nodes, rows, c );
#ifdef MACHPOINT_HAS_REGISTERS
    return Lanes( Registers::gather( first, rows.row, columns ) );
#else
    return Lanes( [&]( const auto l )
                  { return first[rows.row[l] * columns]; } );
#endif
}

//! K columns of the nodes from the first on, four or two at a time where the
//! processor can.
template <std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void
loadRow( const NodeView& nodes, const LaneRows& rows, Lanes ( &values )[K],
         const int first = 0 )
{
#ifdef MACHPOINT_HAS_REGISTERS
    if constexpr ( K > 1 )
    {
        const std::size_t columns = nodes.stride( 0 );
        const Real* const start = columnsFrom( nodes, rows, first );
        constexpr std::size_t whole = K / 4 * 4;
        for ( std::size_t done = 0; done < whole; done += 4 )
        {
            LaneRegister four[4];
            Registers::loadColumns( start + done, rows.row, columns, four );
            for ( std::size_t c = 0; c < 4; ++c )
                values[done + c] = Lanes( four[c] );
        }
        // An odd one comes with its neighbour: alone it takes more shuffles.
        for ( std::size_t done = whole; done < K; done += 2 )
        {
            const std::size_t from = Kokkos::min( done, K - 2 );
            LaneRegister two[2];
            Registers::loadColumns( start + from, rows.row, columns, two );
            values[from] = Lanes( two[0] );
            values[from + 1] = Lanes( two[1] );
        }
        return;
    }
#endif
    for ( std::size_t c = 0; c < K; ++c )
        values[c] = at( nodes, rows, first + static_cast<int>( c ) );
}

//! Rows of stencils, one of each lane.
struct LaneBases
{
    int row[lane_count]; //!< of the first node
};
//! Node rows: of each lane the stencil's first, and how far from it.
KOKKOS_FORCEINLINE_FUNCTION LaneRows rowAt( const LaneBases& base,
                                            const int shift )
{
    return { base.row, shift };
}
//! @}

#endif

//! \name Rows of stencils, one of each particle
//! @{
//! int for a Real, LaneBases for Lanes.
template <class Number>
struct BasesOf
{
    using type = int;
};
template <class Number>
using Bases = typename BasesOf<Number>::type;

//! Moves on by whole numbers of rows that are `stride` apart.
KOKKOS_FORCEINLINE_FUNCTION void advance( int& base, const Real steps,
                                          const int stride )
{
    base += static_cast<int>( steps ) * stride;
}
#ifdef MACHPOINT_HAS_LANES
template <>
struct BasesOf<Lanes>
{
    using type = LaneBases;
};
KOKKOS_FORCEINLINE_FUNCTION void advance( LaneBases& bases, const Lanes& steps,
                                          const int stride )
{
#ifdef MACHPOINT_HAS_REGISTERS
    Registers::advance( bases.row, static_cast<LaneRegister>( steps ), stride );
#else
    Real values[lane_count];
    std::memcpy( values, static_cast<const void*>( &steps ), sizeof( Lanes ) );
    for ( int l = 0; l < lane_count; ++l )
        bases.row[l] += static_cast<int>( values[l] ) * stride;
#endif
}
#endif

//! Are the rows of all particles from `first` on, and before `end`? Asked of a
//! particle's row or a pack, whose idle lanes do not count.
template <class Particle>
KOKKOS_FORCEINLINE_FUNCTION bool areWithin( const Particle, const int base,
                                            const int first, const int end )
{
    return first <= base && base < end;
}
#ifdef MACHPOINT_HAS_LANES
KOKKOS_FORCEINLINE_FUNCTION bool areWithin( const Pack p,
                                            const LaneBases& bases,
                                            const int first, const int end )
{
    const unsigned counted = ( 1u << p.count ) - 1; // idle lanes hold anything
#ifdef MACHPOINT_HAS_REGISTERS
    return ( Registers::outside( bases.row, first, end ) & counted ) == 0;
#else
    unsigned outside = 0;
    for ( int l = 0; l < lane_count; ++l )
        outside |=
            static_cast<unsigned>( bases.row[l] < first || bases.row[l] >= end )
            << l;
    return ( outside & counted ) == 0;
#endif
}
#endif
//! A node's row in a kernel.
template <class Number>
using NodeRow = decltype( rowAt( std::declval<const Bases<Number>&>(), 0 ) );
#ifdef MACHPOINT_HAS_LANES
//! Of lane l.
inline int lane( const LaneBases& base, const int l )
{
    return base.row[l];
}
#endif
//! @}

} // namespace Machpoint

#endif
