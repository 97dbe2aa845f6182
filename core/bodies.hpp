/*!
  \file bodies.hpp
  \brief Layer 3: the solid bodies in the gas, all at once, for what depends on
  more than one of them.
*/
#ifndef MACHPOINT_BODIES_HPP
#define MACHPOINT_BODIES_HPP

#include <core/grid.hpp>
#include <core/shape.hpp>

#include <vector>

namespace Machpoint
{

//! The bodies of a scene, for kernels.
template <int Dim>
struct Bodies
{
    Shape<Dim> shape; //!< all of them as one
    IndexList first;  //!< solid of the shape that each begins with [count + 1]
    //! Particles this near have an image, cells along the normal; 0: none has.
    //! [count]
    Kokkos::View<Real*, MemorySpace> image_reach;
    int count = 0;
    bool have_images = false; //!< has any?

    Bodies() = default;
    //! \param all the bodies' solids, one after the other
    //! \param solids how many each body has \param reach image_reach of each
    Bodies( const Shape<Dim>& all, const std::vector<int>& solids,
            const std::vector<Real>& reach )
        : shape( all ), first( "Machpoint::bodies", solids.size() + 1 ),
          image_reach( "Machpoint::imageReach", solids.size() ),
          count( static_cast<int>( solids.size() ) )
    {
        const auto begin = Kokkos::create_mirror_view( first );
        const auto cells = Kokkos::create_mirror_view( image_reach );
        begin( 0 ) = 0;
        for ( int b = 0; b < count; ++b )
        {
            begin( b + 1 ) = begin( b ) + solids[b];
            cells( b ) = reach[b];
            have_images = have_images || reach[b] > 0;
        }
        Kokkos::deep_copy( first, begin );
        Kokkos::deep_copy( image_reach, cells );
    }

    //! Is a place inside one of them? \param x [Dim]
    KOKKOS_FUNCTION bool contain( const Vector<Dim>& x ) const
    {
        return count > 0 && shape.distance( x ) < 0;
    }

    //! How deep a place is below the surface of them all that gas may touch:
    //! infinitely where that is a seam within, or beyond a side.
    //! \param seam width, length \param period cells; 0: not periodic
    KOKKOS_FUNCTION Real depth( const Vector<Dim>& x, const Real seam,
                                const Grid<Dim>& grid,
                                const Indices<Dim>& period ) const
    {
        const auto part = shape.nearest( x );
        auto outside = x;
        for ( int d = 0; d < Dim; ++d )
            outside[d] += ( seam - part.distance ) * part.normal[d];
        bool is_surface = true;
        for ( int d = 0; d < Dim; ++d )
        {
            const bool is_below = outside[d] < grid.lower[d];
            if ( !is_below && outside[d] <= grid.upper[d] )
                continue;
            const Real length = grid.upper[d] - grid.lower[d];
            outside[d] += is_below ? length : -length;
            is_surface = is_surface && period[d] > 0;
        }
        return is_surface && shape.distance( outside ) >= 0
                   ? -part.distance
                   : Kokkos::Experimental::infinity_v<Real>;
    }

    //! Signed distance and normal of one of them. \param x [Dim]
    KOKKOS_FUNCTION Nearest<Dim> nearest( const Vector<Dim>& x,
                                          const int body ) const
    {
        return shape.nearest( x, first( body ), first( body + 1 ) );
    }

    //! The one nearest to a place, of equals the first; 0 where there is none.
    //! \param with_images of those that have images alone
    KOKKOS_FUNCTION int nearestBody( const Vector<Dim>& x,
                                     const bool with_images = false ) const
    {
        int nearest_one = 0;
        Real least = Kokkos::Experimental::finite_max_v<Real>;
        for ( int b = 0; b < count; ++b )
        {
            if ( with_images && !( image_reach( b ) > 0 ) )
                continue;
            const Real distance = nearest( x, b ).distance;
            if ( distance < least )
            {
                least = distance;
                nearest_one = b;
            }
        }
        return nearest_one;
    }

    //! Is the part of a body's surface that is nearest to x the inside of
    //! another body, or its seam with one that is nearer to x, or as near and
    //! before it in the list?
    //! \param part the surface as x sees it \param seam width, length
    KOKKOS_FUNCTION bool covers( const Vector<Dim>& x, const Nearest<Dim>& part,
                                 const int body, const Real seam ) const
    {
        if ( count == 1 )
            return false;
        auto foot = x;
        for ( int d = 0; d < Dim; ++d )
            foot[d] -= part.distance * part.normal[d];
        for ( int b = 0; b < count; ++b )
            if ( b != body && nearest( foot, b ).distance < seam )
            {
                const Real distance = nearest( x, b ).distance;
                if ( distance < part.distance - seam ||
                     ( distance <= part.distance + seam && b < body ) )
                    return true;
            }
        return false;
    }
};

} // namespace Machpoint

#endif
