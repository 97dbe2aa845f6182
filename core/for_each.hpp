/*!
  \file for_each.hpp
  \brief Layer 1: the loop of a kernel.

  On a CPU, Kokkos calls a functor of some size anew for each turn of a loop.
  What a kernel has captured, and what follows from it, is then loaded and
  computed in every turn, as the compiler cannot know that no turn writes to it.
  Here a thread's turns are one call, which works with copies that nobody else
  knows; MACHPOINT_INLINE behind a kernel's parameters makes it a part of the
  loop.
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

//! Turns of each of some threads: thread t takes those from t times as many on.
inline int shareOf( const int count, const int threads )
{
    return threads > 0 ? ( count + threads - 1 ) / threads : 0;
}

namespace Impl
{
template <class Turns>
struct Shares
{
    Turns turns;
    int count;
    int share; //!< turns of a thread

    KOKKOS_FUNCTION void operator()( const int thread ) const
    {
        if constexpr ( runs_on_host )
        {
            const int first = Kokkos::min( thread * share, count );
            turns( first, Kokkos::min( first + share, count ) );
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
} // namespace Impl

/*!
  \brief Calls turns( first, last ) for parts of 0 to count - 1, in parallel; on
  a GPU for one number each.
  \tparam Blocks see RangeOf \param label of the kernel in profiles
*/
template <int Blocks = 1, class Turns>
void forEachShare( const char* label, const int count, const Turns& turns )
{
    const int threads = runs_on_host ? ExecutionSpace().concurrency() : count;
    Kokkos::parallel_for(
        label, RangeOf<Blocks>( 0, threads ),
        Impl::Shares<Turns>{ turns, count, shareOf( count, threads ) } );
}

//! Calls body( i ) for i from 0 to count - 1, in parallel.
template <class Body>
void forEach( const char* label, const int count, const Body& body )
{
    forEachShare( label, count, Impl::Turns<Body>{ body } );
}

} // namespace Machpoint

#endif
