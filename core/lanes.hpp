/*!
  \file lanes.hpp
  \brief Layer 2: numbers of several particles at once, so that kernels use the
  vector registers of a CPU. On a GPU, whose threads are lanes, one particle.

  A kernel is written once for a Number: Real with a particle's row `int p`, or
  Lanes with a `Pack p` of consecutive particles. choose takes either, and so do
  load and store of core/lane_members.hpp and at of core/lane_rows.hpp. Compare
  Lanes with < and <= alone: in Kokkos 4.7.0, > and >= of AVX-512 registers are
  the wrong way round (Kokkos' pull request 8797).
*/
#ifndef MACHPOINT_LANES_HPP
#define MACHPOINT_LANES_HPP

#include <core/for_each.hpp>

#include <type_traits>
#include <utility>

//! \def MACHPOINT_HAS_LANES
//! Do kernels take several particles at once? MACHPOINT_ONE_LANE lets a CPU run
//! what a GPU does, to test it.
#if !defined( KOKKOS_ENABLE_CUDA ) && !defined( KOKKOS_ENABLE_HIP ) &&         \
    !defined( KOKKOS_ENABLE_SYCL ) && !defined( MACHPOINT_ONE_LANE )
#define MACHPOINT_HAS_LANES
#include <core/avx512.hpp>

#include <Kokkos_SIMD.hpp>
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
//! @}

#ifdef MACHPOINT_HAS_LANES
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
//! @}
#endif

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

} // namespace Machpoint

#endif
