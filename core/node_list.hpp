/*!
  \file node_list.hpp
  \brief Layer 3: the few nodes that a boundary acts on, found once.
*/
#ifndef MACHPOINT_NODE_LIST_HPP
#define MACHPOINT_NODE_LIST_HPP

#include <core/grid.hpp>

#include <string>

namespace Machpoint
{

/*!
  \brief The stored nodes whose position, NodeLayout::home, satisfies a
  predicate.
  \param label what the memory is called in a profile
  \param chosen callable on the device with a position [Dim]
  \return their rows in a NodeView, ascending
*/
template <int Dim, class Predicate>
IndexList listNodes( const std::string& label, const NodeLayout<Dim>& layout,
                     const Predicate& chosen )
{
    IndexList rows( label, layout.total );
    const int count = scanEach(
        "Machpoint::listNodes", layout.total, few_rows,
        MACHPOINT_LAMBDA( const int row, int& n, const bool final ) {
            const auto i = layout.home( layout.indices( row ) );
            if ( !chosen( layout.position( i ) ) )
                return;
            if ( final )
                rows( n ) = row;
            ++n;
        } );
    IndexList list( label, count );
    Kokkos::deep_copy( list,
                       Kokkos::subview( rows, Kokkos::make_pair( 0, count ) ) );
    return list;
}

} // namespace Machpoint

#endif
