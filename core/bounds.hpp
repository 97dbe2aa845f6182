/*!
  \file bounds.hpp
  \brief Layer 2: when does a particle leave the domain, or a rank's box?
*/
#ifndef MACHPOINT_BOUNDS_HPP
#define MACHPOINT_BOUNDS_HPP

#include <core/grid.hpp>

namespace Machpoint
{

//! The position just inside the upper side that rounding cannot move onto it.
KOKKOS_INLINE_FUNCTION Real justInside( const Real lower, const Real upper )
{
    constexpr Real least = 4 * Kokkos::Experimental::epsilon_v<Real>;
    return upper -
           Kokkos::max<Real>( 1e-12_rt * ( upper - lower ),
                              least * Kokkos::max( Kokkos::abs( lower ),
                                                   Kokkos::abs( upper ) ) );
}

//! Positions from lower to upper. [Dim], length
template <int Dim>
struct Bounds
{
    Vector<Dim> lower;
    Vector<Dim> upper;

    //! Is a position, or each of a pack, beyond them along any axis?
    //! \param x [Dim]
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION auto
    excludes( const VectorOf<Dim, Number>& x ) const
    {
        auto beyond = x[0] < Number( lower[0] ) || Number( upper[0] ) < x[0];
        for ( int d = 1; d < Dim; ++d )
            beyond = beyond || x[d] < Number( lower[d] ) ||
                     Number( upper[d] ) < x[d];
        return beyond;
    }
};

//! Those of the domain, up to just inside its upper sides.
template <int Dim>
Bounds<Dim> domainBounds( const Grid<Dim>& grid )
{
    Bounds<Dim> bounds{ grid.lower, grid.upper };
    for ( int d = 0; d < Dim; ++d )
        bounds.upper[d] = justInside( grid.lower[d], grid.upper[d] );
    return bounds;
}

//! What is surely in a box of cells, whatever rounding says of its cuts, and
//! as much as domainBounds where it ends at the domain's sides.
template <int Dim>
Bounds<Dim> boxBounds( const Grid<Dim>& grid, const CellBox<Dim>& box )
{
    auto bounds = domainBounds( grid );
    const Real margin = 1e-2_rt; // cells
    for ( int d = 0; d < Dim; ++d )
    {
        if ( box.begin[d] > 0 )
            bounds.lower[d] =
                grid.lower[d] + ( box.begin[d] + margin ) * grid.spacing[d];
        if ( box.end[d] < grid.cells[d] )
            bounds.upper[d] =
                grid.lower[d] + ( box.end[d] - margin ) * grid.spacing[d];
    }
    return bounds;
}

} // namespace Machpoint

#endif
