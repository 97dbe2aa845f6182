/*!
  \file image_cover.hpp
  \brief Where mirror images leave the inside of a body empty, so that a node
  there has to stand for the wall (docs/conservative.md, section 6).
*/
#ifndef MACHPOINT_IMAGE_COVER_HPP
#define MACHPOINT_IMAGE_COVER_HPP

#include <boundary/shape.hpp>
#include <core/images.hpp>

namespace Machpoint
{

/*!
  \brief How much of the space that a face looks at is filled by gas, by its
  images in a body and by those in the sides of the domain, wherever gas may be.

  A place in the body is filled if its mirror image is in the gas and has its
  own image there: not behind acute corners, cusps and notches, where that image
  is in another wall.
*/
template <int Dim>
struct ImageCover
{
    Shape<Dim> shape;
    Grid<Dim> grid;
    Indices<Dim> period; //!< of the nodes; 0: the side mirrors
    Real reach;          //!< particles this near have an image, cells
    int stencil_nodes;   //!< of the basis, along an axis

    //! Half the width of a node's weight, cells.
    KOKKOS_INLINE_FUNCTION Real support() const
    {
        return 0.5_rt * stencil_nodes;
    }

    //! Is there gas, if it is everywhere?
    KOKKOS_FUNCTION bool isGas( const Vector<Dim>& x ) const
    {
        for ( int d = 0; d < Dim; ++d )
            if ( x[d] < grid.lower[d] || x[d] > grid.upper[d] )
                return false;
        return shape.distance( x ) >= -round_off * grid.minSpacing();
    }

    //! Is there an image of gas? \param x in the domain or beyond its sides
    KOKKOS_FUNCTION bool isImage( const Vector<Dim>& x ) const
    {
        for ( int d = 0; d < Dim; ++d )
            if ( x[d] < grid.lower[d] - grid.spacing[d] ||
                 x[d] >= grid.upper[d] + grid.spacing[d] )
                return false; // those are left out
        const auto nearest = shape.nearest( x );
        if ( nearest.distance >= 0 )
            return false;
        auto isMirror = [&]( const Nearest<Dim>& part )
        {
            if ( part.distance >= 0 ||
                 part.distance <
                     -imageDistance<Dim>( grid, reach, part.normal ) )
                return false;
            auto gas = x;
            for ( int d = 0; d < Dim; ++d )
                gas[d] -= 2 * part.distance * part.normal[d];
            // Nearer to another part of the surface, that is what mirrors it.
            return isGas( gas ) &&
                   shape.distance( gas ) > -0.99_rt * part.distance;
        };
        return isMirror( nearest ) || shape.anyPart( x, isMirror );
    }

    //! A place's image beyond the sides of the axes in `axes`, a bit each.
    KOKKOS_FUNCTION Vector<Dim> beyond( Vector<Dim> x, const int axes ) const
    {
        for ( int d = 0; d < Dim; ++d )
            if ( axes & ( 1 << d ) )
            {
                const Real length = grid.upper[d] - grid.lower[d];
                const bool is_upper =
                    x[d] > 0.5_rt * ( grid.lower[d] + grid.upper[d] );
                x[d] = period[d] > 0
                           ? x[d] + ( is_upper ? -length : length )
                           : 2 * ( is_upper ? grid.upper[d] : grid.lower[d] ) -
                                 x[d];
            }
        return x;
    }

    //! Is there gas or an image of it?
    KOKKOS_FUNCTION bool isFilled( const Vector<Dim>& x ) const
    {
        int outside = 0;
        for ( int d = 0; d < Dim; ++d )
            if ( x[d] < grid.lower[d] || x[d] > grid.upper[d] )
                outside |= 1 << d;
        const auto home = beyond( x, outside );
        if ( isGas( home ) )
            return true;
        for ( int axes = 0; axes < 1 << Dim; ++axes )
            if ( isImage( beyond( home, axes ) ) )
                return true;
        return false;
    }

    //! B-spline of a degree around 0, but for a factor; s within its support.
    //! (Boundaries are compiled once for all bases, so it is a number here.)
    KOKKOS_FUNCTION static Real spline( const Real s, const int degree )
    {
        Real sum = 0, binomial = 1;
        for ( int j = 0; j <= degree + 1; ++j )
        {
            const Real t = s + 0.5_rt * ( degree + 1 ) - j;
            if ( t <= 0 )
                break;
            Real power = 1;
            for ( int n = 0; n < degree; ++n )
                power *= t;
            sum += binomial * power;
            binomial *= -( degree + 1 - j ) / Real( j + 1 );
        }
        return sum;
    }

    //! The filled part of what a face sees: of degree one less along its axis.
    KOKKOS_FUNCTION Real ofFace( const Vector<Dim>& face, const int axis ) const
    {
        constexpr int samples = Dim == 3 ? 2 : 4; // along a cell's side
        Indices<Dim> count{};
        int all = 1;
        for ( int d = 0; d < Dim; ++d )
        {
            count[d] = samples * ( stencil_nodes - ( d == axis ? 1 : 0 ) );
            all *= count[d];
        }
        Real filled = 0, whole = 0;
        for ( int k = 0; k < all; ++k )
        {
            auto x = face;
            Real weight = 1;
            int rest = k;
            for ( int d = 0; d < Dim; ++d )
            {
                const Real width = 0.5_rt * count[d] / samples;
                const Real s = ( rest % count[d] + 0.5_rt ) / samples - width;
                rest /= count[d];
                x[d] += s * grid.spacing[d];
                weight *= spline( s, count[d] / samples - 1 );
            }
            whole += weight;
            if ( isFilled( x ) )
                filled += weight;
        }
        return filled / whole;
    }

    //! The face before (side -1) or behind (1) a node along an axis.
    KOKKOS_FUNCTION Vector<Dim> faceBeside( Vector<Dim> x, const int axis,
                                            const Real side ) const
    {
        x[axis] += side * 0.5_rt * grid.spacing[axis];
        return x;
    }

    //! Might a face beside a node look at space that is not filled, and a
    //! particle see the node? Also of a face itself. \param x of the node
    KOKKOS_FUNCTION bool mayLack( const Vector<Dim>& x ) const
    {
        const Real h = grid.maxSpacing();
        const Real sight = Kokkos::sqrt( Real( Dim ) ) * support() * h;
        const Real distance = shape.distance( x );
        return -sight <= distance && distance <= sight + 0.5_rt * h;
    }

    //! The part of what a node's face behind it along an axis looks at that is
    //! never filled. \param x of the node
    KOKKOS_FUNCTION Real missing( const Vector<Dim>& x, const int axis ) const
    {
        const auto face = faceBeside( x, axis, 1 );
        return mayLack( face ) ? 1 - ofFace( face, axis ) : 0.0_rt;
    }

    /*!
      \brief The axes along which a node is to stand still, a bit each: those
      along which a face beside it is less filled than `least`, so that its
      pressure fades as that of a vacuum.
      \param x of the node
    */
    KOKKOS_FUNCTION int heldAxes( const Vector<Dim>& x, const Real least ) const
    {
        if ( !mayLack( x ) )
            return 0;
        int axes = 0;
        for ( int a = 0; a < Dim; ++a )
            for ( const Real side : { -1.0_rt, 1.0_rt } )
                if ( ofFace( faceBeside( x, a, side ), a ) < least )
                    axes |= 1 << a;
        return axes;
    }
};

} // namespace Machpoint

#endif
