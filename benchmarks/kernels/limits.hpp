/*!
  \file limits.hpp
  \brief What the machine allows: memory bandwidth and arithmetic, measured by
  the program that is held against them, on all ranks at once.
*/
#ifndef MACHPOINT_BENCHMARKS_LIMITS_HPP
#define MACHPOINT_BENCHMARKS_LIMITS_HPP

#include <core/communicator.hpp>
#include <core/lane_members.hpp>
#include <core/particle_array.hpp>

#include <Kokkos_Timer.hpp>

#include <algorithm>

namespace Machpoint
{

//! Best rate of a kernel that is repeated for a while, of all ranks together:
//! what others take from the machine meanwhile is no limit of it. Collective.
//! \param work of one call, on one rank \param seconds to go on for, after one
//! call to warm up
template <class Kernel>
Real bestRate( const Real work, const Real seconds, const Kernel& kernel )
{
    const Communicator ranks;
    kernel();
    Real best = 0;
    const Kokkos::Timer all;
    for ( int calls = 0; calls < 5 || ranks.max( all.seconds() ) < seconds;
          ++calls )
    {
        ExecutionSpace().fence();
        const Kokkos::Timer timer;
        kernel();
        ExecutionSpace().fence();
        // The slowest rank counts, and the others wait for it.
        best =
            std::max( best, static_cast<Real>( work * ranks.size() /
                                               ranks.max( timer.seconds() ) ) );
    }
    return best;
}

//! Numbers a, b and c of a triad: in memory, loaded and stored as particles
//! are.
using Triads = ParticleArray<Cabana::MemberTypes<Real, Real, Real>>;

//! Can this build's kernels write past the cache?
#ifdef MACHPOINT_PACKS_FILL_LINES
inline constexpr bool can_stream = true;
#else
inline constexpr bool can_stream = false;
#endif

//! b = c = 1. Kernels are functions of their own, as nvcc wants no device
//! lambda within another lambda.
inline void fillTriads( const Triads& triads )
{
    const auto b = Cabana::slice<1>( triads );
    const auto c = Cabana::slice<2>( triads );
    forEachPack(
        "Machpoint::fillTriads", static_cast<int>( triads.size() ),
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            store( b, Lanes( 1.0 ), p );
            store( c, Lanes( 1.0 ), p );
        } );
}

//! a = b + c / 2.
//! \param streams past the cache \param few packs that one thread takes
inline void addTriads( const Triads& triads, const bool streams, const int few )
{
    const auto a = Cabana::slice<0>( triads );
    const auto b = Cabana::slice<1>( triads );
    const auto c = Cabana::slice<2>( triads );
    const Written<decltype( a )> written{ a, streams };
    forEachPack(
        "Machpoint::triad", static_cast<int>( triads.size() ),
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            store( written, load( b, p ) + 0.5_rt * load( c, p ), p );
        },
        few );
}

//! Bandwidths of one thread of each rank, 0 on a GPU, and of all, bytes/s.
struct Bandwidth
{
    Real one, all;
};

/*!
  \brief Triad over more numbers than a cache holds (McCalpin's STREAM).
  \param streams are sums stored past the cache? Else their lines are read
  first, which does not count.
  \return bytes/s, three numbers for each sum, as STREAM counts
*/
inline Bandwidth measureTriad( const Triads& triads, const bool streams,
                               const Real seconds )
{
    const int n = static_cast<int>( triads.size() );
    auto rate = [&]( const int few )
    {
        return bestRate( 3.0 * sizeof( Real ) * n, seconds,
                         [&] { addTriads( triads, streams, few ); } );
    };
    // One thread of a GPU is no limit of anything.
    return { runs_on_host ? rate( n ) : 0.0_rt, rate( few_particles ) };
}

//! Chains of multiply-adds: as many as hide the latency of the units, and as
//! registers hold beside two constants: AVX2 has 16 of four doubles. Kernels
//! compute with Lanes, so that is what they are held against; of single numbers
//! a compiler makes registers itself.
constexpr int chains = lane_count == 1 ? 48 : sizeof( Lanes ) == 32 ? 12 : 16;

//! Independent chains of multiply-adds in registers. \return their sum
inline Real multiplyAddChains( const int threads, const int rounds )
{
    constexpr int n = chains;
    Real sum = 0;
    Kokkos::parallel_reduce(
        "Machpoint::multiplyAdd", Range( 0, threads ),
        KOKKOS_LAMBDA( const int thread, Real& total ) {
            Lanes x[n];
            for ( int k = 0; k < n; ++k )
                x[k] = Lanes( static_cast<Real>( 1e-9 * ( thread + k ) ) );
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
//! \param threads that share the work
//! \return flops/s, two for each multiply-add
inline Real multiplyAdd( const int threads, const int rounds,
                         const Real seconds )
{
    return bestRate( 2.0 * chains * lane_count * rounds * threads, seconds,
                     [&] { multiplyAddChains( threads, rounds ); } );
}

//! Of all ranks together.
struct Limits
{
    Bandwidth ordinary;    //!< of a triad
    Bandwidth streamed;    //!< past the cache; 0 where kernels cannot
    Real fma_one, fma_all; //!< flops/s of one thread of each rank, and of all

    //! The larger bandwidth.
    Bandwidth triad() const
    {
        return { std::max( ordinary.one, streamed.one ),
                 std::max( ordinary.all, streamed.all ) };
    }
};

//! Measures the limits. Collective. \param small does it work?, in milliseconds
inline Limits measureLimits( const bool small )
{
    const int all = ExecutionSpace().concurrency();
    const int numbers = small ? 1 << 16 : 1 << 24; // of 128 MiB an array
    const int rounds = small ? 1000 : 1000000;
    const Real seconds = small ? 0 : 0.3;
    const Triads triads( "triads", numbers / Communicator().size() );
    fillTriads( triads );
    Limits limits{};
    limits.ordinary = measureTriad( triads, false, seconds );
    if ( can_stream )
        limits.streamed = measureTriad( triads, true, seconds );
    limits.fma_all = multiplyAdd( all, rounds, seconds );
    limits.fma_one = runs_on_host ? multiplyAdd( 1, rounds, seconds ) : 0;
    return limits;
}

} // namespace Machpoint

#endif
