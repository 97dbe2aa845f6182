/*!
  \file grid.hpp
  \brief Layer 2: the uniform Cartesian grid, and the numbering of its nodes.
*/
#ifndef MACHPOINT_GRID_HPP
#define MACHPOINT_GRID_HPP

#include <core/types.hpp>

namespace Machpoint
{

//! A box of equal cells. Knot lines of every basis are cell boundaries.
template <int Dim>
struct Grid
{
    Vector<Dim> lower;   //!< lower corner [Dim], length
    Vector<Dim> upper;   //!< upper corner [Dim], length
    Vector<Dim> spacing; //!< cell size h [Dim], length
    Indices<Dim> cells;  //!< number of cells [Dim]

    Grid() = default;
    //! \param lower_corner, upper_corner [Dim] length, lower < upper
    //! \param number_of_cells [Dim] at least one each
    Grid( const Vector<Dim>& lower_corner, const Vector<Dim>& upper_corner,
          const Indices<Dim>& number_of_cells )
        : lower( lower_corner ), upper( upper_corner ), cells( number_of_cells )
    {
        for ( int d = 0; d < Dim; ++d )
            spacing[d] = ( upper[d] - lower[d] ) / cells[d];
    }

    //! Cell of a position along one axis, clamped to the box and `beyond`
    //! cells around it, so that a particle exactly on the upper side still has
    //! a cell.
    KOKKOS_INLINE_FUNCTION int cell( const Real x, const int d,
                                     const int beyond = 0 ) const
    {
        const int c =
            static_cast<int>( Kokkos::floor( ( x - lower[d] ) / spacing[d] ) );
        const int last = cells[d] - 1 + beyond;
        return c < -beyond ? -beyond : ( c > last ? last : c );
    }

    //! Flat cell number, x fastest. \param x position [Dim].
    KOKKOS_INLINE_FUNCTION int flatCell( const Vector<Dim>& x ) const
    {
        int flat = 0;
        for ( int d = Dim - 1; d >= 0; --d )
            flat = flat * cells[d] + cell( x[d], d );
        return flat;
    }

    //! Number of cells in all.
    KOKKOS_INLINE_FUNCTION int totalCells() const
    {
        int total = 1;
        for ( int d = 0; d < Dim; ++d )
            total *= cells[d];
        return total;
    }

    //! Volume of a cell, length^Dim.
    KOKKOS_INLINE_FUNCTION Real cellVolume() const
    {
        Real volume = 1;
        for ( int d = 0; d < Dim; ++d )
            volume *= spacing[d];
        return volume;
    }

    //! The smallest spacing: h in the time step and the viscosity.
    KOKKOS_INLINE_FUNCTION Real minSpacing() const
    {
        Real h = spacing[0];
        for ( int d = 1; d < Dim; ++d )
            h = Kokkos::min( h, spacing[d] );
        return h;
    }
};

/*!
  \brief Where node (i, j, k) stands in memory and in space.

  The only place that knows that nodes form one dense box. Owned nodes are
  numbered from 0 to owned - 1 along each axis; `halo` more lie on both sides.
*/
template <int Dim>
struct NodeLayout
{
    Indices<Dim> owned;   //!< owned nodes along each axis [Dim]
    Indices<Dim> extent;  //!< stored nodes along each axis, halo included
    Indices<Dim> stride;  //!< distance of neighbours in memory [Dim]
    Vector<Dim> first;    //!< position of owned node 0 [Dim]
    Vector<Dim> spacing;  //!< distance of neighbours in space [Dim]
    int halo = 0;         //!< layers of nodes beyond the owned box
    int total = 0;        //!< number of stored nodes
    bool centred = false; //!< nodes at cell centres rather than vertices

    NodeLayout() = default;
    //! \param grid the cells
    //! \param at_centres nodes at cell centres (even degree) or vertices
    //! \param halo_width layers of nodes that a particle in the box can reach
    NodeLayout( const Grid<Dim>& grid, const bool at_centres,
                const int halo_width )
        : spacing( grid.spacing ), halo( halo_width ), total( 1 ),
          centred( at_centres )
    {
        for ( int d = 0; d < Dim; ++d )
        {
            owned[d] = grid.cells[d] + ( centred ? 0 : 1 );
            extent[d] = owned[d] + 2 * halo;
            stride[d] = total;
            total *= extent[d];
            first[d] = grid.lower[d] + ( centred ? 0.5 * spacing[d] : 0.0 );
        }
    }

    //! Row of node i in a NodeView. \param i [Dim], -halo <= i < owned + halo
    KOKKOS_INLINE_FUNCTION int operator()( const Indices<Dim>& i ) const
    {
        int flat = 0;
        for ( int d = 0; d < Dim; ++d )
            flat += ( i[d] + halo ) * stride[d];
        return flat;
    }

    //! Coordinates of a row; the inverse of operator().
    KOKKOS_INLINE_FUNCTION Indices<Dim> indices( int flat ) const
    {
        Indices<Dim> i{};
        for ( int d = 0; d < Dim; ++d )
        {
            i[d] = flat % extent[d] - halo;
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

    //! Is node i owned, rather than in the halo?
    KOKKOS_INLINE_FUNCTION bool isOwned( const Indices<Dim>& i ) const
    {
        for ( int d = 0; d < Dim; ++d )
            if ( i[d] < 0 || i[d] >= owned[d] )
                return false;
        return true;
    }
};

} // namespace Machpoint

#endif
