/*!
  \file grid.hpp
  \brief Layer 2: the uniform Cartesian grid, and the numbering of its nodes.
*/
#ifndef MACHPOINT_GRID_HPP
#define MACHPOINT_GRID_HPP

#include <core/lane_rows.hpp>
#include <core/lanes.hpp>

namespace Machpoint
{

//! A box of equal cells. Knot lines of every basis are cell boundaries.
template <int Dim>
struct Grid
{
    Vector<Dim> lower;   //!< lower corner [Dim], length
    Vector<Dim> upper;   //!< upper corner [Dim], length
    Vector<Dim> spacing; //!< cell size h [Dim], length
    Vector<Dim> inverse; //!< 1/h [Dim], 1/length
    Indices<Dim> cells;  //!< number of cells [Dim]

    Grid() = default;
    //! \param lower_corner, upper_corner [Dim] length, lower < upper
    //! \param number_of_cells [Dim] at least one each
    Grid( const Vector<Dim>& lower_corner, const Vector<Dim>& upper_corner,
          const Indices<Dim>& number_of_cells )
        : lower( lower_corner ), upper( upper_corner ), cells( number_of_cells )
    {
        for ( int d = 0; d < Dim; ++d )
        {
            spacing[d] = ( upper[d] - lower[d] ) / cells[d];
            inverse[d] = 1 / spacing[d];
        }
    }

    //! Cell of a position along one axis, clamped to cells first to last.
    //! \param x along axis d, length
    KOKKOS_INLINE_FUNCTION int cellWithin( const Real x, const int d,
                                           const int first,
                                           const int last ) const
    {
        const int c =
            static_cast<int>( Kokkos::floor( ( x - lower[d] ) / spacing[d] ) );
        return c < first ? first : ( c > last ? last : c );
    }

    //! Cell of a position along one axis, clamped to the domain, so that a
    //! particle exactly on the upper side still has a cell.
    KOKKOS_INLINE_FUNCTION int cell( const Real x, const int d ) const
    {
        return cellWithin( x, d, 0, cells[d] - 1 );
    }

    //! Volume of a cell, length^Dim.
    KOKKOS_INLINE_FUNCTION Real cellVolume() const
    {
        Real volume = 1;
        for ( int d = 0; d < Dim; ++d )
            volume *= spacing[d];
        return volume;
    }

    //! The smallest spacing: h in the time step and the viscosity, length.
    KOKKOS_INLINE_FUNCTION Real minSpacing() const
    {
        Real h = spacing[0];
        for ( int d = 1; d < Dim; ++d )
            h = Kokkos::min( h, spacing[d] );
        return h;
    }
    //! The largest spacing, length.
    KOKKOS_INLINE_FUNCTION Real maxSpacing() const
    {
        Real h = spacing[0];
        for ( int d = 1; d < Dim; ++d )
            h = Kokkos::max( h, spacing[d] );
        return h;
    }
};

//! The cells of one rank: `begin` to `end` - 1 along each axis, numbered as in
//! the whole domain.
template <int Dim>
struct CellBox
{
    Indices<Dim> begin; //!< first cell [Dim]
    Indices<Dim> end;   //!< one past the last [Dim]

    //! Number of cells along an axis.
    KOKKOS_INLINE_FUNCTION int cells( const int d ) const
    {
        return end[d] - begin[d];
    }

    //! Number of cells in all.
    KOKKOS_INLINE_FUNCTION int totalCells() const
    {
        int total = 1;
        for ( int d = 0; d < Dim; ++d )
            total *= cells( d );
        return total;
    }

    //! Number of a position's cell within the box, x fastest; of positions
    //! beyond, that of the nearest cell. \param x [Dim]
    template <class Number = Real>
    KOKKOS_INLINE_FUNCTION Bases<Number>
    flatCell( const Grid<Dim>& grid, const VectorOf<Dim, Number>& x ) const
    {
        Bases<Number> flat{};
        int stride = 1;
        for ( int d = 0; d < Dim; ++d )
        {
            const Number place = ( x[d] - grid.lower[d] ) * grid.inverse[d];
            const Number last( static_cast<Real>( cells( d ) - 1 ) );
            advance( flat,
                     clip( Number( Kokkos::floor( place ) -
                                   static_cast<Real>( begin[d] ) ),
                           Number( 0.0 ), last ),
                     stride );
            stride *= cells( d );
        }
        return flat;
    }

    //! Does the cell of a position belong to the box? \param x [Dim]
    KOKKOS_INLINE_FUNCTION bool contains( const Grid<Dim>& grid,
                                          const Vector<Dim>& x ) const
    {
        for ( int d = 0; d < Dim; ++d )
        {
            const int c = grid.cell( x[d], d );
            if ( c < begin[d] || c >= end[d] )
                return false;
        }
        return true;
    }
};

//! All cells of a grid.
template <int Dim>
CellBox<Dim> wholeDomain( const Grid<Dim>& grid )
{
    return { Indices<Dim>{}, grid.cells };
}

/*!
  \brief Where node (i, j, k) stands in memory and in space.

  The only place that knows that nodes form one dense box. Nodes are numbered
  as in the whole domain, from 0 at its lower side. A rank owns those from
  `begin` to `begin + owned - 1` along each axis, one for each of its cells, and
  the last vertex too where its box ends at the domain's upper side.
*/
template <int Dim>
struct NodeLayout
{
    CellBox<Dim> box;      //!< the rank's cells
    Indices<Dim> cells;    //!< of the whole domain [Dim]
    Indices<Dim> owned;    //!< owned nodes along each axis [Dim]
    Indices<Dim> extent;   //!< stored nodes along each axis, halo included
    Indices<Dim> stride;   //!< distance of neighbours in memory [Dim]
    Vector<Dim> first;     //!< position of node 0 [Dim]
    Vector<Dim> spacing;   //!< distance of neighbours in space [Dim]
    Indices<Dim> halo{};   //!< layers of nodes beyond those of the box's cells
    Indices<Dim> period{}; //!< cells until nodes repeat themselves; 0: never
    Indices<Dim> reach{}; //!< cells beyond the box from which particles scatter
    //! \name As numbers, which packs compare and add
    //! @{
    Vector<Dim> first_cell{}, last_cell{}; //!< from which particles scatter
    Vector<Dim> first_node{};              //!< the first that is stored
    //! @}
    int total = 0;        //!< number of stored nodes
    bool centred = false; //!< nodes at cell centres rather than vertices

    NodeLayout() = default;
    //! \param grid the cells
    //! \param at_centres nodes at cell centres (even degree) or vertices
    //! \param halo_width layers of nodes that a particle in the box can reach
    NodeLayout( const Grid<Dim>& grid, const bool at_centres,
                const int halo_width )
        : NodeLayout( grid, wholeDomain( grid ), at_centres, halo_width, {} )
    {
    }
    //! \param own_cells those of this rank
    //! \param reach_beyond cells around them from which particles scatter; the
    //! halo is wider by as much [Dim]
    //! \param margin layers that it has besides, along each axis [Dim]
    NodeLayout( const Grid<Dim>& grid, const CellBox<Dim>& own_cells,
                const bool at_centres, const int halo_width,
                const Indices<Dim>& reach_beyond,
                const Indices<Dim>& margin = {} )
        : box( own_cells ), cells( grid.cells ), spacing( grid.spacing ),
          reach( reach_beyond ), centred( at_centres )
    {
        const int vertex = centred ? 0 : 1;
        // The rows of a domain that many ranks share may be too many to number;
        // nobody asks for them.
        std::int64_t rows = 1;
        for ( int d = 0; d < Dim; ++d )
        {
            halo[d] = halo_width + reach[d] + margin[d];
            first_cell[d] = static_cast<Real>( box.begin[d] - reach[d] );
            last_cell[d] = static_cast<Real>( box.end[d] - 1 + reach[d] );
            first_node[d] = static_cast<Real>( lowest( d ) );
            owned[d] = box.cells( d ) + ( box.end[d] == cells[d] ? vertex : 0 );
            extent[d] = box.cells( d ) + vertex + 2 * halo[d];
            stride[d] = static_cast<int>( rows );
            rows *= extent[d];
            first[d] =
                grid.lower[d] + ( centred ? 0.5_rt * spacing[d] : 0.0_rt );
        }
        total = static_cast<int>( rows );
    }

    //! Number of the first stored node along an axis.
    KOKKOS_INLINE_FUNCTION int lowest( const int d ) const
    {
        return box.begin[d] - halo[d];
    }

    //! Row of node i in a NodeView. \param i [Dim], owned or in the halo
    KOKKOS_INLINE_FUNCTION int operator()( const Indices<Dim>& i ) const
    {
        int flat = 0;
        for ( int d = 0; d < Dim; ++d )
            flat += ( i[d] - lowest( d ) ) * stride[d];
        return flat;
    }

    //! Coordinates of a row; the inverse of operator().
    KOKKOS_INLINE_FUNCTION Indices<Dim> indices( int flat ) const
    {
        Indices<Dim> i{};
        for ( int d = 0; d < Dim; ++d )
        {
            i[d] = flat % extent[d] + lowest( d );
            flat /= extent[d];
        }
        return i;
    }

    //! Position of node i [Dim], length.
    KOKKOS_INLINE_FUNCTION Vector<Dim> position( const Indices<Dim>& i ) const
    {
        Vector<Dim> x{};
        for ( int d = 0; d < Dim; ++d )
            x[d] = first[d] + i[d] * spacing[d];
        return x;
    }

    //! The node that i repeats where the domain is periodic; else i. [Dim]
    KOKKOS_INLINE_FUNCTION Indices<Dim> home( Indices<Dim> i ) const
    {
        for ( int d = 0; d < Dim; ++d )
            if ( i[d] < 0 )
                i[d] += period[d];
            else if ( i[d] >= cells[d] )
                i[d] -= period[d];
        return i;
    }

    //! Is node i owned, rather than in the halo?
    KOKKOS_INLINE_FUNCTION bool isOwned( const Indices<Dim>& i ) const
    {
        for ( int d = 0; d < Dim; ++d )
            if ( i[d] < box.begin[d] || i[d] >= box.begin[d] + owned[d] )
                return false;
        return true;
    }
};

} // namespace Machpoint

#endif
