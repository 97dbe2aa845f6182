/*!
  \file collect.hpp
  \brief Layer 2: lists of the few rows among many that something is true of.
*/
#ifndef MACHPOINT_COLLECT_HPP
#define MACHPOINT_COLLECT_HPP

#include <core/for_each.hpp>
#include <core/lanes.hpp>

#include <algorithm>
#include <string>

namespace Machpoint
{

//! A number that kernels change.
using SharedNumber = Kokkos::View<int, MemorySpace>;

//! What kernels left in it. Waits for them: for those of this space, where
//! Kokkos would, unasked, wait for all spaces, and twice. (A CPU's are done
//! when they return.)
inline int fetch( const SharedNumber& number )
{
    if constexpr ( runs_on_host )
        return number();
    const ExecutionSpace space;
    int value = 0;
    Kokkos::deep_copy( space, value, number );
    space.fence( "Machpoint::fetch" );
    return value;
}

//! Sets it between kernels, without a wait.
inline void put( const SharedNumber& number, const int value )
{
    if constexpr ( runs_on_host )
        number() = value;
    else
        Kokkos::deep_copy( ExecutionSpace(), number, value );
}

/*!
  \brief Memory of a list that every step makes anew, each time of another
  length: allocated where a list is longer than all before it.
*/
template <class Value>
class Reused
{
  public:
    //! [n], of its memory.
    using list_type = Kokkos::View<Value*, MemorySpace>;

    //! \param label what the memory is called in a profile
    explicit Reused( const std::string& label ) : _memory( label, 0 ) {}

    //! A list of n entries, whatever they are; until the next call.
    list_type take( const int n )
    {
        if ( _memory.extent_int( 0 ) < n )
            Kokkos::realloc( Kokkos::WithoutInitializing, _memory, n + n / 4 );
        return Kokkos::subview( _memory, Kokkos::make_pair( 0, n ) );
    }

  private:
    list_type _memory;
};

//! Rows where the host sorts them; on a CPU those of the list itself.
using HostRowList = IndexList::HostMirror;

namespace Impl
{
//! The rows of a short list that are not negative, ascending, each once.
//! \param copy as many or more; where the host has them meanwhile
inline IndexList sortRows( const IndexList& list, const HostRowList& copy )
{
    const int n = list.extent_int( 0 );
    if ( n == 0 )
        return list;
    const ExecutionSpace space;
    const auto host = Kokkos::subview( copy, Kokkos::make_pair( 0, n ) );
    Kokkos::deep_copy( space, host, list );
    space.fence( "Machpoint::sortRows" );
    int* const end = host.data() + n;
    std::sort( host.data(), end );
    int* const first = std::lower_bound( host.data(), end, 0 );
    int* const last = std::unique( first, end );
    // Without a fence: what next changes the host's rows is a copy in this
    // order.
    Kokkos::deep_copy( space, list, host );
    return Kokkos::subview(
        list, Kokkos::make_pair( first - host.data(), last - host.data() ) );
}
} // namespace Impl

/*!
  \brief The rows from 0 to n - 1 that a test finds, ascending.

  One pass over all rows where a scan takes two; threads append what they find
  and the list, which is short, is sorted after.
  \param test of a row, callable on the device
*/
template <class Test>
IndexList collect( const char* label, const int n, const Test& test )
{
    const IndexList rows(
        Kokkos::view_alloc( std::string( label ), Kokkos::WithoutInitializing ),
        n );
    const SharedNumber count( "Machpoint::rowsFound" );
    forEach(
        label, n, MACHPOINT_LAMBDA( const int p ) {
            if ( test( p ) )
                rows( Kokkos::atomic_fetch_add( &count(), 1 ) ) = p;
        } );
    const auto list =
        Kokkos::subview( rows, Kokkos::make_pair( 0, fetch( count ) ) );
    const auto sorted =
        Impl::sortRows( list, Kokkos::create_mirror_view( list ) );
    ExecutionSpace().fence( "Machpoint::collect" ); // the mirror goes
    return sorted;
}

/*!
  \brief Rows that kernels note in passing, so that nobody has to look for them.
  Holds the few of a usual step; where there are more, it looks at all.
*/
class RowList
{
  public:
    //! \param label of its memory and of the kernel that tests what was noted
    explicit RowList( const std::string& label = "Machpoint::notedRows" )
        : _noted( label, 0 ), _rows( label, 0 ), _count( label )
    {
    }

    //! Before the kernels: forgets all. \param n rows that there are
    void clear( const int n )
    {
        const int room = 1024 + n / 16;
        if ( _noted.extent_int( 0 ) < room )
        {
            Kokkos::realloc( Kokkos::WithoutInitializing, _noted,
                             room + room / 4 );
            Kokkos::realloc( Kokkos::WithoutInitializing, _rows,
                             room + room / 4 );
            _host = hostRows( _rows );
        }
        put( _count, 0 );
    }

    //! On the device.
    KOKKOS_FORCEINLINE_FUNCTION void note( const int p ) const
    {
        const int k = Kokkos::atomic_fetch_add( &_count(), 1 );
        if ( k < static_cast<int>( _noted.extent( 0 ) ) )
            _noted( k ) = p;
    }

    //! The same for some particles of a pack.
    KOKKOS_FORCEINLINE_FUNCTION void note( const Pack p,
                                           const LaneMask& which ) const
    {
        if ( any( which ) )
            for ( int l = 0; l < p.count; ++l )
                if ( lane( which, l ) )
                    note( p.first + l );
    }

    //! After the kernels: how many were noted.
    int count() const { return fetch( _count ); }

    //! After the kernels: those of the rows noted that a test is true of,
    //! ascending, each once; until the next call. \param n rows that there are
    //! \param test callable on the device
    template <class Test>
    IndexList rows( const int n, const Test& test ) const
    {
        const int noted = count();
        if ( noted > _noted.extent_int( 0 ) )
            return collect( "Machpoint::manyRows", n, test );
        const IndexList list =
            Kokkos::subview( _rows, Kokkos::make_pair( 0, noted ) );
        const auto all = _noted;
        forEach(
            _noted.label().c_str(), noted, MACHPOINT_LAMBDA( const int k ) {
                list( k ) = test( all( k ) ) ? all( k ) : -1;
            } );
        return Impl::sortRows( list, _host );
    }

  private:
    //! Called as the rows are, so that who reads a profile knows whose they
    //! are.
    template <class List>
    static HostRowList hostRows( const List& rows )
    {
        if constexpr ( runs_on_host )
            return rows;
        else
            return HostRowList(
                Kokkos::view_alloc( rows.label(), Kokkos::WithoutInitializing ),
                rows.extent( 0 ) );
    }

    IndexList _noted;
    IndexList _rows;   // those of the last test
    HostRowList _host; // the same while they are sorted
    SharedNumber _count;
};

} // namespace Machpoint

#endif
