/*!
  \file for_each.hpp
  \brief Layer 1: the loop of a kernel.

  On a CPU, Kokkos calls a functor of some size anew for each turn of a loop.
  What a kernel has captured, and what follows from it, is then loaded and
  computed in every turn, as the compiler cannot know that no turn writes to it.
  Here a thread's turns are one call, which works with copies that nobody else
  knows; MACHPOINT_INLINE behind a kernel's parameters makes it a part of the
  loop. A loop, a sum or a scan that is too short to be shared is a call by the
  host itself. Profilers hear of each pass over the turns as of a parallel_for.
*/
#ifndef MACHPOINT_FOR_EACH_HPP
#define MACHPOINT_FOR_EACH_HPP

#include <core/types.hpp>

#include <tuple>
#include <utility>
#include <vector>

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

//! Are these shared all the same? For tests, whose scenes are small: they set
//! it, between loops.
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
void take( const void* turns, const int first, const int last )
{
    ( *static_cast<const Turns*>( turns ) )( first, last );
}

/*!
  \brief Calls take( turns, first, last ) for the parts of a loop on a CPU's
  threads, and returns when all are done.

  Kokkos' loop and all that belongs to it (copies of what a kernel has captured,
  the words for profilers) would else be compiled for each kernel, and was a
  quarter of the library.
*/
void shareTurns( const char* label, int count, int share, const void* turns,
                 void ( *take )( const void*, int, int ) );

//! The same of turns whose type is known. \param share turns of a thread
template <class Turns>
void shareTurns( const char* label, const int count, const int share,
                 const Turns& turns )
{
    shareTurns( label, count, share, static_cast<const void*>( &turns ),
                &take<Turns> );
}

//! A loop of a GPU.
template <class Turns>
struct OneTurn
{
    Turns turns;

    KOKKOS_FUNCTION void operator()( const int i ) const { turns( i, i + 1 ); }
};

template <class Body>
struct Turns
{
    //! On a CPU the caller's, which is there until the loop is done.
    std::conditional_t<runs_on_host, const Body&, const Body> body;

    KOKKOS_FORCEINLINE_FUNCTION void operator()( const int first,
                                                 const int last ) const
    {
        Own<Body> own = body;
        for ( int i = first; i < last; ++i )
            own( i );
    }
};

//! What each thread of a CPU finds, in a cache line of its own.
template <class Found>
class Parts
{
  public:
    //! Of the threads that share some turns. \param share of each
    Parts( const int count, const int share, const Found& start )
        : _share( share ), _first( start ),
          _others( count > share ? ( count - 1 ) / share : 0, Part{ start } )
    {
    }

    //! That of the thread whose turns begin with this one.
    Found& of( const int first )
    {
        return first == 0 ? _first : _others[first / _share - 1].found;
    }
    //! Visits that of the first thread, then of the second, ...
    template <class Visitor>
    void forEach( const Visitor& visit )
    {
        visit( _first );
        for ( auto& part : _others )
            visit( part.found );
    }

  private:
    struct alignas( 64 ) Part
    {
        Found found;
    };

    int _share;
    Found _first; // no memory is asked for where there is no other
    std::vector<Part> _others;
};

//! \name What a reduction begins with, adds up, and leaves
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
void joinTo( const Result& result, Value& value, const Value& part )
{
    if constexpr ( Kokkos::is_reducer<Result>::value )
        result.join( value, part );
    else
        value += part;
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
        Impl::shareTurns( label, count, shareOf( count, loopThreads(), few ),
                          turns );
    else
        Kokkos::parallel_for( label, RangeOf<Blocks>( 0, count ),
                              Impl::OneTurn<Turns>{ turns } );
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
    if constexpr ( runs_on_host )
    {
        const int share = shareOf( count, loopThreads(), few );
        const auto neutral = std::make_tuple( Impl::neutralOf( results )... );
        Impl::Parts parts( count, share, neutral );
        Impl::shareTurns( label, count, share,
                          [&]( const int first, const int last )
                          {
                              Own<Body> own = body;
                              auto found = neutral;
                              std::apply(
                                  [&]( auto&... values )
                                  {
                                      for ( int i = first; i < last; ++i )
                                          own( i, values... );
                                  },
                                  found );
                              parts.of( first ) = found;
                          } );
        auto sum = neutral;
        std::apply(
            [&]( auto&... sums )
            {
                parts.forEach(
                    [&]( const auto& part )
                    {
                        std::apply(
                            [&]( const auto&... values )
                            { ( Impl::joinTo( results, sums, values ), ... ); },
                            part );
                    } );
                ( Impl::assignTo( results, sums ), ... );
            },
            sum );
    }
    else
        Kokkos::parallel_reduce( label, Range( 0, count ), body, results... );
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
    if constexpr ( runs_on_host )
    {
        const int share = shareOf( count, loopThreads(), few );
        Impl::Parts ahead( count, share, 0 ); // of each thread's turns
        const auto pass = [&]( const bool final )
        {
            Impl::shareTurns( label, count, share,
                              [&]( const int first, const int last )
                              {
                                  Own<Body> own = body;
                                  int k = ahead.of( first );
                                  for ( int i = first; i < last; ++i )
                                      own( i, k, final );
                                  ahead.of( first ) = k;
                              } );
        };
        if ( share < count )
        {
            pass( false );
            ahead.forEach( [&]( int& part )
                           { sum += std::exchange( part, sum ); } );
        }
        pass( true );
        ahead.forEach( [&]( const int part ) { sum = part; } );
    }
    else
        Kokkos::parallel_scan( label, Range( 0, count ), body, sum );
    return sum;
}

} // namespace Machpoint

#endif
