/*!
  \file for_each.hpp
  \brief Layer 1: the loop of a kernel.

  On a CPU, Kokkos calls a functor of some size anew for each turn of a loop.
  What a kernel has captured, and what follows from it, is then loaded and
  computed in every turn, as the compiler cannot know that no turn writes to it.
  Here a thread's turns are one call, which works with copies that nobody else
  knows; MACHPOINT_INLINE behind a kernel's parameters makes it a part of the
  loop. A loop that is too short to be shared is a call by the host itself.
*/
#ifndef MACHPOINT_FOR_EACH_HPP
#define MACHPOINT_FOR_EACH_HPP

#include <core/types.hpp>

namespace Machpoint
{

//! What a loop works with: a copy; on a GPU, which has it in constant memory,
//! the thing itself.
template <class Captured>
using Own = std::conditional_t<runs_on_host, const Captured, const Captured&>;

//! \name Turns that are not worth a second thread of a CPU
//! To call it and to wait for it takes .7 us, and 2 in slow hours of a host.
//! @{
inline constexpr int few_rows = 512;     //!< nodes, or rows of a list
inline constexpr int few_particles = 64; //!< each as a whole, or packs
//! Packs that see their stencils, which take longer where these are larger.
template <int Dim>
inline constexpr int few_stencils = Dim == 1   ? 192
                                    : Dim == 2 ? 64
                                               : 16;
//! @}

//! Are these shared all the same? For tests, whose scenes are small.
inline bool& sharesFewTurns()
{
    static bool shares = false;
    return shares;
}

//! Threads that share a loop on a CPU.
inline int loopThreads()
{
    static const int threads = ExecutionSpace().concurrency();
    return threads;
}

//! Turns of each of some threads: thread t takes those from t times as many on.
//! \param few are left to the first one
inline int shareOf( const int count, const int threads, const int few )
{
    return count <= few && !sharesFewTurns()
               ? count
               : ( count + threads - 1 ) / threads;
}

namespace Impl
{
//! A thread's turns on a CPU: compiled once, whoever calls it.
template <class Turns>
[[gnu::noinline]] void take( const Turns& turns, const int first,
                             const int last )
{
    turns( first, last );
}

template <class Turns>
struct Shares
{
    Turns turns;
    //! \name On a CPU
    //! @{
    int count = 0;
    int share = 0; //!< turns of a thread
    //! @}

    KOKKOS_FUNCTION void operator()( const int thread ) const
    {
        if constexpr ( runs_on_host )
        {
            const int first = Kokkos::min( thread * share, count );
            take( turns, first, Kokkos::min( first + share, count ) );
        }
        else
            turns( thread, thread + 1 );
    }
};

template <class Body>
struct Turns
{
    Body body;

    KOKKOS_FORCEINLINE_FUNCTION void operator()( const int first,
                                                 const int last ) const
    {
        Own<Body> own = body;
        for ( int i = first; i < last; ++i )
            own( i );
    }
};

//! All turns of a kernel, by the host itself; profilers are told as of any
//! other.
template <class Turns>
void runHere( const char* label, const int count, const Turns& turns )
{
    static const std::uint32_t device =
        Kokkos::Tools::Experimental::device_id( ExecutionSpace() );
    const bool is_told = Kokkos::Tools::profileLibraryLoaded();
    std::uint64_t id = 0;
    if ( is_told )
        Kokkos::Tools::beginParallelFor( label, device, &id );
    take( turns, 0, count );
    if ( is_told )
        Kokkos::Tools::endParallelFor( id );
}
} // namespace Impl

/*!
  \brief Calls turns( first, last ) for parts of 0 to count - 1, in parallel; on
  a GPU for one number each.
  \tparam Blocks see RangeOf \param label of the kernel in profiles
  \param few turns that are not worth a second thread
*/
template <int Blocks = 1, class Turns>
void forEachShare( const char* label, const int count,
                   [[maybe_unused]] const int few, const Turns& turns )
{
    if constexpr ( runs_on_host )
    {
        const int threads = loopThreads();
        const int share = shareOf( count, threads, few );
        if ( share == count )
            return Impl::runHere( label, count, turns );
        Kokkos::parallel_for( label, RangeOf<Blocks>( 0, threads ),
                              Impl::Shares<Turns>{ turns, count, share } );
    }
    else
        Kokkos::parallel_for( label, RangeOf<Blocks>( 0, count ),
                              Impl::Shares<Turns>{ turns } );
}

//! Calls body( i ) for i from 0 to count - 1, in parallel. \param few see above
template <class Body>
void forEach( const char* label, const int count, const Body& body,
              const int few = few_rows )
{
    forEachShare( label, count, few, Impl::Turns<Body>{ body } );
}

} // namespace Machpoint

#endif
