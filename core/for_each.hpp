/*!
  \file for_each.hpp
  \brief Layer 1: the loop of a kernel.

  On a CPU, Kokkos calls a functor of some size anew for each turn of a loop.
  What a kernel has captured, and what follows from it, is then loaded and
  computed in every turn, as the compiler cannot know that no turn writes to it.
  Here a thread's turns are one call, which works with copies that nobody else
  knows; MACHPOINT_INLINE behind a kernel's parameters makes it a part of the
  loop. A loop, a sum or a scan that is too short to be shared is a call by the
  host itself.
*/
#ifndef MACHPOINT_FOR_EACH_HPP
#define MACHPOINT_FOR_EACH_HPP

#include <core/types.hpp>

#include <tuple>

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

//! A kernel that the host runs itself; profilers are told as of any other.
//! \param begin,end Kokkos' functions that tell them
template <class Begin, class End, class Kernel>
void runHere( const char* label, Begin* begin, End* end, const Kernel& kernel )
{
    static const std::uint32_t device =
        Kokkos::Tools::Experimental::device_id( ExecutionSpace() );
    const bool is_told = Kokkos::Tools::profileLibraryLoaded();
    std::uint64_t id = 0;
    if ( is_told )
        begin( label, device, &id );
    kernel();
    if ( is_told )
        end( id );
}

//! Are all turns of a loop the host's own?
inline bool runsHere( const int count, const int few )
{
    return runs_on_host && shareOf( count, loopThreads(), few ) == count;
}

//! \name What a reduction begins with, and where it leaves what it found
//! \tparam Result a number or struct with +=, or a reducer of Kokkos
//! @{
template <class Result>
auto neutralOf( const Result& result )
{
    if constexpr ( Kokkos::is_reducer<Result>::value )
    {
        typename Result::value_type value;
        result.init( value );
        return value;
    }
    else
        return Result{};
}

template <class Result, class Value>
void assignTo( Result& result, const Value& value )
{
    if constexpr ( Kokkos::is_reducer<Result>::value )
        result.reference() = value;
    else
        result = value;
}
//! @}
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
            return Impl::runHere( label, &Kokkos::Tools::beginParallelFor,
                                  &Kokkos::Tools::endParallelFor,
                                  [&] { Impl::take( turns, 0, count ); } );
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

/*!
  \brief Calls body( i, results... ) for i from 0 to count - 1, in parallel;
  each thread has results of its own, which are then joined. Waits for it.
  \param few see above
  \param[out] results one struct with +=, or some numbers, which are added up,
  or reducers of Kokkos
*/
template <class Body, class... Results>
void reduceEach( const char* label, const int count, const int few,
                 const Body& body, Results&&... results )
{
    if ( !Impl::runsHere( count, few ) )
        return Kokkos::parallel_reduce( label, Range( 0, count ), body,
                                        results... );
    if constexpr ( runs_on_host )
        Impl::runHere( label, &Kokkos::Tools::beginParallelReduce,
                       &Kokkos::Tools::endParallelReduce,
                       [&]
                       {
                           auto found =
                               std::make_tuple( Impl::neutralOf( results )... );
                           std::apply(
                               [&]( auto&... values )
                               {
                                   for ( int i = 0; i < count; ++i )
                                       body( i, values... );
                                   ( Impl::assignTo( results, values ), ... );
                               },
                               found );
                       } );
}

/*!
  \brief Calls body( i, k, true ) for i from 0 to count - 1, in parallel, where
  k is what the turns before i have added to it. A loop that is shared first
  asks each turn, with false instead of true, what it will add. Waits for it.
  \param few see above
  \return what all turns added
*/
template <class Body>
int scanEach( const char* label, const int count, const int few,
              const Body& body )
{
    int sum = 0;
    if ( !Impl::runsHere( count, few ) )
        Kokkos::parallel_scan( label, Range( 0, count ), body, sum );
    else if constexpr ( runs_on_host )
        Impl::runHere( label, &Kokkos::Tools::beginParallelScan,
                       &Kokkos::Tools::endParallelScan,
                       [&]
                       {
                           for ( int i = 0; i < count; ++i )
                               body( i, sum, true );
                       } );
    return sum;
}

} // namespace Machpoint

#endif
