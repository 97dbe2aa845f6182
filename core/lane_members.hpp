/*!
  \file lane_members.hpp
  \brief Layer 2: members of particles, of one or of all of a pack: read from
  slices, and written to them.
*/
#ifndef MACHPOINT_LANE_MEMBERS_HPP
#define MACHPOINT_LANE_MEMBERS_HPP

#include <core/lanes.hpp>

#include <cstring>

namespace Machpoint
{

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

//! \name One particle
//! @{
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
#ifdef MACHPOINT_PACKS_FILL_LINES
    static_assert( Slice::soa_stride % lane_count == 0 );
    // By parts they take longer, as where numbers are shorter in memory.
    if constexpr ( sizeof( typename Slice::value_type ) == sizeof( Real ) )
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
//! @}

#endif

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
