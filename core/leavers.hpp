/*!
  \file leavers.hpp
  \brief Layer 2: when does a particle leave the domain?
*/
#ifndef MACHPOINT_LEAVERS_HPP
#define MACHPOINT_LEAVERS_HPP

#include <core/grid.hpp>

namespace Machpoint
{

//! The position just inside the upper side that rounding cannot move onto it.
KOKKOS_INLINE_FUNCTION Real justInside( const Real lower, const Real upper )
{
    return upper - 1e-12 * ( upper - lower );
}

//! Is a position, or each of a pack, below the domain's lower side or not just
//! inside its upper one, along any axis? \param x [Dim]
template <int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION auto leaves( const Grid<Dim>& grid,
                                         const VectorOf<Dim, Number>& x )
{
    auto beyond = x[0] < Number( grid.lower[0] );
    for ( int d = 0; d < Dim; ++d )
        beyond = beyond || x[d] < Number( grid.lower[d] ) ||
                 Number( justInside( grid.lower[d], grid.upper[d] ) ) < x[d];
    return beyond;
}

} // namespace Machpoint

#endif
