/*!
  \file limits.hpp
  \brief What the machine allows: memory bandwidth and arithmetic, measured by
  the program that is held against them.
*/
#ifndef MACHPOINT_BENCHMARKS_LIMITS_HPP
#define MACHPOINT_BENCHMARKS_LIMITS_HPP

#include <core/lanes.hpp>

#include <Kokkos_Timer.hpp>

#include <algorithm>

namespace Machpoint
{

//! Best rate of a kernel that is repeated for a while: what others take from
//! the machine meanwhile is no limit of it.
//! \param work of one call \param seconds to go on for, after one call to warm
//! up
template <class Kernel>
Real bestRate( const Real work, const Real seconds, const Kernel& kernel )
{
    kernel();
    Real best = 0;
    const Kokkos::Timer all;
    for ( int calls = 0; calls < 5 || all.seconds() < seconds; ++calls )
    {
        ExecutionSpace().fence();
        const Kokkos::Timer timer;
        kernel();
        ExecutionSpace().fence();
        best = std::max( best, work / timer.seconds() );
    }
    return best;
}

//! a = b + s c: threads of a CPU have contiguous shares, those of a GPU
//! neighbouring elements. Kernels are functions of their own, as nvcc wants no
//! device lambda within another lambda.
inline void addArrays( const Kokkos::View<Real*, MemorySpace>& a,
                       const Kokkos::View<Real*, MemorySpace>& b,
                       const Kokkos::View<Real*, MemorySpace>& c,
                       const int lanes )
{
    const std::int64_t n = a.extent_int( 0 );
    Kokkos::parallel_for(
        "Machpoint::triad", Range( 0, lanes ), KOKKOS_LAMBDA( const int lane ) {
            const std::int64_t first = runs_on_host ? n * lane / lanes : lane;
            const std::int64_t end =
                runs_on_host ? n * ( lane + 1 ) / lanes : n;
            const int step = runs_on_host ? 1 : lanes;
            for ( std::int64_t i = first; i < end; i += step )
                a( i ) = b( i ) + 0.5 * c( i );
        } );
}

/*!
  \brief Triad over arrays that no cache holds (McCalpin's STREAM).
  \param lanes that share the work: 1 for one thread
  \return bytes/s, three numbers for each element, as STREAM counts
*/
inline Real triad( const int lanes, const int elements, const Real seconds )
{
    const Kokkos::View<Real*, MemorySpace> a( "a", elements ),
        b( "b", elements ), c( "c", elements );
    return bestRate( 3.0 * sizeof( Real ) * elements, seconds,
                     [&] { addArrays( a, b, c, lanes ); } );
}

//! Chains of multiply-adds: enough to hide the latency of the units. Kernels
//! compute with Lanes, so that is what they are held against.
constexpr int chains = lane_count > 1 ? 16 : 64;

//! Independent chains of multiply-adds in registers. \return their sum
inline Real multiplyAddChains( const int lanes, const int rounds )
{
    constexpr int n = chains;
    Real sum = 0;
    Kokkos::parallel_reduce(
        "Machpoint::multiplyAdd", Range( 0, lanes ),
        KOKKOS_LAMBDA( const int lane, Real& total ) {
            Lanes x[n];
            for ( int k = 0; k < n; ++k )
                x[k] = Lanes( static_cast<Real>( 1e-9 * ( lane + k ) ) );
            const Lanes factor( static_cast<Real>( 0.999999 ) );
            const Lanes summand( static_cast<Real>( 1e-6 ) );
            for ( int r = 0; r < rounds; ++r )
            {
                MACHPOINT_UNROLL
                for ( int k = 0; k < n; ++k )
                    x[k] = x[k] * factor + summand;
            }
            for ( int k = 0; k < n; ++k )
                total += largest( x[k] );
        },
        sum );
    return sum;
}

//! Multiply-adds in registers as wide as the kernels'.
//! \param lanes as above \return flops/s, two for each multiply-add
inline Real multiplyAdd( const int lanes, const int rounds, const Real seconds )
{
    return bestRate( 2.0 * chains * lane_count * rounds * lanes, seconds,
                     [&] { multiplyAddChains( lanes, rounds ); } );
}

//! Rates of one lane, 0 on a GPU, and of all.
struct Limits
{
    Real triad_one, triad_all; //!< bytes/s
    Real fma_one, fma_all;     //!< flops/s
};

//! Measures the limits. \param small does it work?, in milliseconds
inline Limits measureLimits( const bool small )
{
    const int all = ExecutionSpace().concurrency();
    const int elements = small ? 1 << 16 : 1 << 24; // 128 MiB an array
    const int rounds = small ? 1000 : 1000000;
    const Real seconds = small ? 0 : 0.3;
    Limits limits{};
    limits.triad_all = triad( all, elements, seconds );
    limits.fma_all = multiplyAdd( all, rounds, seconds );
    // One thread of a GPU is no limit of anything.
    limits.triad_one = runs_on_host ? triad( 1, elements, seconds ) : 0;
    limits.fma_one = runs_on_host ? multiplyAdd( 1, rounds, seconds ) : 0;
    return limits;
}

} // namespace Machpoint

#endif
