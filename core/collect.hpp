/*!
  \file collect.hpp
  \brief Layer 2: a list of the few rows that a test finds among many.
*/
#ifndef MACHPOINT_COLLECT_HPP
#define MACHPOINT_COLLECT_HPP

#include <core/types.hpp>

#include <algorithm>
#include <string>

namespace Machpoint
{

/*!
  \brief The rows from begin to end - 1 that a test finds, ascending.

  One pass over all rows where a scan takes two; threads append what they find
  and the list, which is short, is sorted after.
  \param most as many as there can be, known from the pass that marked them
  \param test of a row, callable on the device
*/
template <class Test>
IndexList collect( const char* label, const int begin, const int end,
                   const int most, const Test& test )
{
    const IndexList rows(
        Kokkos::view_alloc( std::string( label ), Kokkos::WithoutInitializing ),
        most );
    const Kokkos::View<int, MemorySpace> count( "Machpoint::rowsFound" );
    Kokkos::parallel_for(
        label, Range( begin, end ), KOKKOS_LAMBDA( const int p ) {
            if ( test( p ) )
                rows( Kokkos::atomic_fetch_add( &count(), 1 ) ) = p;
        } );
    int found = 0;
    Kokkos::deep_copy( found, count );
    const IndexList list =
        Kokkos::subview( rows, Kokkos::make_pair( 0, found ) );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), list );
    std::sort( host.data(), host.data() + found );
    Kokkos::deep_copy( list, host );
    return list;
}

} // namespace Machpoint

#endif
