/*!
  \file lanes.hpp
  \brief Layer 2: numbers of several particles at once, so that kernels use the
  vector registers of a CPU. On a GPU, whose threads are lanes, one particle.

  A kernel is written once for a Number: Real with a particle's row `int p`, or
  Lanes with a `Pack p` of consecutive particles. load, store, choose and at
  take either. Compare Lanes with < and <= alone: in Kokkos 4.7.0, > and >= of
  AVX-512 registers are the wrong way round (Kokkos' pull request 8797).
*/
#ifndef MACHPOINT_LANES_HPP
#define MACHPOINT_LANES_HPP

#include <core/for_each.hpp>

#include <cassert>
#include <cstdint>

//! \def MACHPOINT_HAS_LANES
//! Do kernels take several particles at once? MACHPOINT_ONE_LANE lets a CPU run
//! what a GPU does, to test it.
#if !defined( KOKKOS_ENABLE_CUDA ) && !defined( KOKKOS_ENABLE_HIP ) &&         \
    !defined( KOKKOS_ENABLE_SYCL ) && !defined( MACHPOINT_ONE_LANE )
#define MACHPOINT_HAS_LANES
#include <core/avx512.hpp>

#include <Kokkos_SIMD.hpp>

#include <cstring>
#endif

namespace Machpoint
{

//! Vector [Dim] of any Number.
template <int Dim, class Number>
using VectorOf = Kokkos::Array<Number, Dim>;

#ifdef MACHPOINT_HAS_LANES

//! A number of each particle of a pack.
#if KOKKOS_VERSION_LESS( 4, 7, 0 )
using Lanes = Kokkos::Experimental::native_simd<Real>;
#else
// A whole register; Kokkos' own choice for a float is half of one.
using Lanes = Kokkos::Experimental::simd<
    Real, static_cast<int>( Kokkos::Experimental::simd<double>::size() *
                            ( sizeof( double ) / sizeof( Real ) ) )>;
#endif
#ifdef MACHPOINT_HAS_REGISTERS
//! The register of Lanes.
using LaneRegister =
    decltype( Registers::gather( std::declval<const Real*>(), nullptr, 0 ) );
#endif
//! A truth value of each particle of a pack.
using LaneMask = typename Lanes::mask_type;
//! Particles of a pack.
inline constexpr int lane_count = static_cast<int>( Lanes::size() );

//! Node rows of the particles of a pack: row[l] + shift.
struct LaneRows
{
    const int* row; //!< [lane_count]
    int shift;      //!< from there, the same for all
};

#else

using Lanes = Real;
using LaneMask = bool;
inline constexpr int lane_count = 1;

#endif

//! Particles first to first + count - 1, at most lane_count. The last pack of a
//! loop may have fewer; its other lanes hold memory of no particle, which is
//! there to be read and written, as an AoSoA allocates whole tiles.
struct Pack
{
    int first;
    int count;

    //! Pack k of n particles.
    KOKKOS_FORCEINLINE_FUNCTION static Pack of( const int k, const int n )
    {
        const int first = k * lane_count;
        return { first, n - first < lane_count ? n - first : lane_count };
    }
};

//! Calls visit( p ) for every particle of a pack.
template <class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void forEachOf( const Pack pack,
                                            const Visitor& visit )
{
    for ( int p = pack.first; p < pack.first + pack.count; ++p )
        visit( p );
}

/*!
  \brief A slice of a new state, which kernels write by whole packs.

  Where there are so many particles that the cache loses them before the next
  kernel reads them, it need not fetch the lines that are written either. The
  barrier at the end of a kernel orders such stores, too.
*/
template <class Slice>
struct Written
{
    Slice slice;
    bool streams; //!< past the cache, where the processor can
};

//! The number of packs of n particles.
inline int countPacks( const int n )
{
    return ( n + lane_count - 1 ) / lane_count;
}

namespace Impl
{
template <class Body>
struct OverPacks
{
    Body body;
    int n;
    KOKKOS_FORCEINLINE_FUNCTION void operator()( const int k ) const
    {
        body( Pack::of( k, n ) );
    }
};
} // namespace Impl

//! Calls body( p ) for the packs of n particles, in parallel: see forEach.
//! \param few packs that are not worth a second thread
template <class Body>
void forEachPack( const char* label, const int n, const Body& body,
                  const int few = few_particles )
{
    forEach( label, countPacks( n ), Impl::OverPacks<Body>{ body, n }, few );
}

//! values[k] in a loop behind MACHPOINT_KEEP_LOOP; on a GPU chosen, not
//! indexed.
template <class Number, std::size_t N>
KOKKOS_FORCEINLINE_FUNCTION Number pick( const Number ( &values )[N],
                                         const int k )
{
#ifndef MACHPOINT_HAS_LANES
    Number value = values[0];
    MACHPOINT_UNROLL
    for ( std::size_t q = 1; q < N; ++q )
        value = k == static_cast<int>( q ) ? values[q] : value;
    return value;
#else
    return values[k];
#endif
}

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
KOKKOS_FORCEINLINE_FUNCTION Real choose( const bool first, const Real a,
                                         const Real b )
{
    return first ? a : b;
}
KOKKOS_FORCEINLINE_FUNCTION bool any( const bool mask )
{
    return mask;
}

//! Component d... of particle p.
template <class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION Real load( const Slice& slice, const int p,
                                       const D... d )
{
    return slice( p, d... );
}
template <class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION void store( const Slice& slice, const Real value,
                                        const int p, const D... d )
{
    slice( p, d... ) = static_cast<typename Slice::value_type>( value );
}
//! A number as it will be read from a Deviation.
KOKKOS_FORCEINLINE_FUNCTION Real asDeviation( const Real value )
{
    return static_cast<Deviation>( value );
}
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

#ifndef MACHPOINT_HAS_LANES

template <class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION Real load( const Slice& slice, const Pack p,
                                       const D... d )
{
    return slice( p.first, d... );
}
template <class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION void store( const Slice& slice, const Real value,
                                        const Pack p, const D... d )
{
    store( slice, value, p.first, d... );
}
template <class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION void store( const Written<Slice>& written,
                                        const Real value, const Pack p,
                                        const D... d )
{
    store( written.slice, value, p, d... );
}

#else

//! \name Several particles
//! @{
inline Lanes choose( const LaneMask& first, const Lanes& a, const Lanes& b )
{
    return Kokkos::Experimental::condition( first, a, b );
}
inline bool any( const LaneMask& mask )
{
    return Kokkos::Experimental::any_of( mask );
}

//! Tiles, or registers of one tile, ahead of a kernel that the processor is
//! told to fetch. A register's particles take 40 ns in 1D, 100 to 250 in 2D.
//! Fewer on Zens before Zen 5, as measured there.
inline constexpr int tiles_ahead = is_zen && !is_zen5 ? 4 : 8;

//! Fetches a member of the particles some way ahead of row p, in the tile where
//! that is long; into the second cache on Zens before Zen 5, whose first one
//! has too few places for what is on its way.
template <bool Writes = false, class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION void prefetch( const Slice& slice, const int p,
                                           const D... d )
{
    constexpr int within = tiles_ahead * ( lane_count > 8 ? lane_count : 8 );
    constexpr int ahead = Slice::vector_length > within
                              ? within
                              : tiles_ahead * Slice::soa_stride;
    __builtin_prefetch( &slice( p, d... ) + ahead, Writes,
                        is_zen && !is_zen5 ? 2 : 3 );
}

//! \name A number of each lane, neighbours in memory, rounded where it is
//! shorter there
//! @{
template <class Value>
KOKKOS_FORCEINLINE_FUNCTION Lanes loadLanes( const Value* const place )
{
    if constexpr ( sizeof( Value ) == sizeof( Real ) )
    {
        Lanes value;
        std::memcpy( static_cast<void*>( &value ), place, sizeof( Lanes ) );
        return value;
    }
    else
    {
#ifdef MACHPOINT_HAS_REGISTERS
        return Lanes( Registers::loadFloats( place ) );
#else
        return Lanes( [&]( const auto l )
                      { return static_cast<Real>( place[l] ); } );
#endif
    }
}
template <class Value>
KOKKOS_FORCEINLINE_FUNCTION void storeLanes( Value* const place,
                                             const Lanes& value )
{
    if constexpr ( sizeof( Value ) == sizeof( Real ) )
        std::memcpy( place, static_cast<const void*>( &value ),
                     sizeof( Lanes ) );
    else
    {
#ifdef MACHPOINT_HAS_REGISTERS
        Registers::storeFloats( place, static_cast<LaneRegister>( value ) );
#else
        for ( int l = 0; l < lane_count; ++l )
            place[l] = static_cast<Value>( value[l] );
#endif
    }
}
//! @}

//! Component d... of the particles of a pack; fetches the memory ahead. A slice
//! of an AoSoA holds as many neighbours as its tiles are long, and packs never
//! cross tiles.
template <class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION Lanes load( const Slice& slice, const Pack p,
                                        const D... d )
{
    static_assert( Slice::vector_length % lane_count == 0 );
    prefetch( slice, p.first, d... );
    return loadLanes( &slice( p.first, d... ) );
}
//! Writes it, idle lanes included.
template <class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION void store( const Slice& slice, const Lanes& value,
                                        const Pack p, const D... d )
{
    static_assert( Slice::vector_length % lane_count == 0 );
    storeLanes( &slice( p.first, d... ), value );
}
//! As they will be read from Deviations.
KOKKOS_FORCEINLINE_FUNCTION Lanes asDeviation( const Lanes& value )
{
    if constexpr ( is_mixed )
    {
        alignas( Lanes ) Deviation places[lane_count];
        storeLanes( places, value );
        return loadLanes( places );
    }
    else
        return value;
}

//! The same, past the cache where the slice is written so.
template <class Slice, class... D>
KOKKOS_FORCEINLINE_FUNCTION void store( const Written<Slice>& written,
                                        const Lanes& value, const Pack p,
                                        const D... d )
{
#ifdef MACHPOINT_PACKS_FILL_LINES // by parts they take longer
    static_assert( Slice::soa_stride % lane_count == 0 );
    if ( written.streams )
    {
        Registers::stream( &written.slice( p.first, d... ),
                           static_cast<LaneRegister>( value ) );
        return;
    }
#endif
    prefetch<true>( written.slice, p.first, d... );
    store( written.slice, value, p, d... );
}

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
//! @}

//! \name Over the particles of a pack
//! Idle lanes count, too, in largest and smallest: see active.
//! @{
#ifdef MACHPOINT_HAS_LANES
//! Which lanes stand for particles.
inline LaneMask active( const Pack p )
{
    if ( p.count == lane_count )
        return LaneMask( true );
    return Lanes( []( const auto l ) { return static_cast<Real>( l ); } ) <
           Lanes( static_cast<Real>( p.count ) );
}
inline Real largest( const Lanes& x )
{
    return Kokkos::Experimental::reduce_max( x );
}
inline Real smallest( const Lanes& x )
{
    return Kokkos::Experimental::reduce_min( x );
}
//! Of lane l.
inline Real lane( const Lanes& x, const int l )
{
    return x[l];
}
inline bool lane( const LaneMask& mask, const int l )
{
    return mask[l];
}
inline int lane( const LaneBases& base, const int l )
{
    return base.row[l];
}
#else
KOKKOS_FORCEINLINE_FUNCTION bool active( const Pack )
{
    return true;
}
KOKKOS_FORCEINLINE_FUNCTION Real largest( const Real x )
{
    return x;
}
KOKKOS_FORCEINLINE_FUNCTION Real smallest( const Real x )
{
    return x;
}
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number lane( const Number x, const int )
{
    return x;
}
#endif
//! @}

//! x, but not below `least` nor above `most`; `least` for a NaN.
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number clip( const Number& x, const Number& least,
                                         const Number& most )
{
    const Number raised = choose( least < x, x, least );
    return choose( raised < most, raised, most );
}

//! The Number of a particle's row.
template <class Particle>
using NumberOf =
    std::conditional_t<std::is_same_v<Particle, Pack>, Lanes, Real>;

//! Position, velocity or other vector [Dim] of a particle or pack.
template <int Dim, class Slice, class Particle>
KOKKOS_FORCEINLINE_FUNCTION VectorOf<Dim, NumberOf<Particle>>
loadVector( const Slice& slice, const Particle p )
{
    VectorOf<Dim, NumberOf<Particle>> x{};
    for ( int d = 0; d < Dim; ++d )
        x[d] = load( slice, p, d );
    return x;
}

//! Matrix [Dim][Dim] of a particle or pack, row by row.
template <int Dim, class Slice, class Particle>
KOKKOS_FORCEINLINE_FUNCTION void
loadMatrix( const Slice& slice, const Particle p,
            VectorOf<Dim, NumberOf<Particle>> ( &rows )[Dim] )
{
    for ( int a = 0; a < Dim; ++a )
        for ( int b = 0; b < Dim; ++b )
            rows[a][b] = load( slice, p, a, b );
}

} // namespace Machpoint

#endif
