/*!
  \file node_list.hpp
  \brief Layer 3: rows of the node fields: which of them a kernel serves, and
  the few nodes that a boundary acts on, found once.
*/
#ifndef MACHPOINT_NODE_LIST_HPP
#define MACHPOINT_NODE_LIST_HPP

#include <core/grid.hpp>

#include <string>

namespace Machpoint
{

/*!
  \brief Which rows of the node fields a kernel serves: all, or some that are
  listed.
*/
class NodeRows
{
  public:
    //! All. \param total that there are
    explicit NodeRows( const int total ) : _count( total ) {}
    //! \param rows ascending
    explicit NodeRows( const IndexList& rows )
        : _rows( rows ), _count( rows.extent_int( 0 ) ), _is_listed( true )
    {
    }

    //! \param label of the kernel \param kernel called with a row, on the
    //! device
    template <class Kernel>
    void forEach( const char* label, const Kernel& kernel ) const
    {
        const auto rows = _rows;
        if ( _is_listed )
            Machpoint::forEach(
                label, _count,
                MACHPOINT_LAMBDA( const int k ) { kernel( rows( k ) ); } );
        else
            Machpoint::forEach( label, _count, kernel );
    }

  private:
    IndexList _rows;
    int _count;
    bool _is_listed = false;
};

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
