/*!
  \file images.hpp
  \brief Layer 3: mirror images of particles across curved walls, the wall's
  mirrored halo of core/halo.hpp for a surface that follows no grid line.
*/
#ifndef MACHPOINT_IMAGES_HPP
#define MACHPOINT_IMAGES_HPP

#include <core/grid.hpp>

namespace Machpoint
{

//! \name How far from a surface a particle with an image may be, cells
//! @{
inline constexpr double usual_image = 2.2; //!< if an input does not say
inline constexpr double farthest_image = 4;
//! @}

//! The same in length: cells as long as they are along the normal. With the
//! sign of the cells.
//! \param cells of reach \param normal of the surface
template <int Dim>
KOKKOS_INLINE_FUNCTION Real imageDistance( const Grid<Dim>& grid,
                                           const Real cells,
                                           const Vector<Dim>& normal )
{
    Real square = 0;
    for ( int d = 0; d < Dim; ++d )
        square += grid.spacing[d] * normal[d] * ( grid.spacing[d] * normal[d] );
    return cells * Kokkos::sqrt( square );
}

//! An image less deep than this part of its particle's distance lies behind
//! another part of the surface, and is left to the particles there.
inline constexpr Real same_surface = 0.99_rt;

//! Is a place beyond a side that mirrors the gas, the images in it, too, and
//! another one not? An image there would be one too many, unless its particle
//! has crossed the side, too. \param period cells; 0 where the side mirrors
template <int Dim>
KOKKOS_INLINE_FUNCTION bool
isBeyondMirrors( const Vector<Dim>& image, const Vector<Dim>& particle,
                 const Grid<Dim>& grid, const Indices<Dim>& period )
{
    for ( int d = 0; d < Dim; ++d )
        if ( period[d] == 0 &&
             ( ( image[d] < grid.lower[d] && particle[d] >= grid.lower[d] ) ||
               ( image[d] > grid.upper[d] && particle[d] <= grid.upper[d] ) ) )
            return true;
    return false;
}

//! Cells along an axis between a particle and its image at most, whatever the
//! normal: the most of 2 |(h_b n_b)_b| n_a / h_a. \param cells of reach
template <int Dim>
Real imageSpan( const Grid<Dim>& grid, const Real cells, const int axis )
{
    Real across = 0; // the longest other side of a cell, over this one
    for ( int d = 0; d < Dim; ++d )
        if ( d != axis )
            across =
                Kokkos::max( across, grid.spacing[d] / grid.spacing[axis] );
    // With t = n_a^2 that of t (t + across^2 (1 - t)).
    const Real square = across * across;
    return 2 * cells *
           ( square <= 2 ? 1.0_rt
                         : 0.5_rt * square / Kokkos::sqrt( square - 1 ) );
}

//! The mirror of one image: a plane with unit normal n at distance d.
template <int Dim>
struct Mirror
{
    Vector<Dim> normal; //!< n, away from the solid
    Real distance;      //!< of the particle from the plane, length

    //! Position behind the mirror: x - 2 d n.
    KOKKOS_INLINE_FUNCTION Vector<Dim> point( Vector<Dim> x ) const
    {
        for ( int d = 0; d < Dim; ++d )
            x[d] -= 2 * distance * normal[d];
        return x;
    }
    //! R v with R = I - 2 n n^T.
    KOKKOS_INLINE_FUNCTION Vector<Dim> direction( Vector<Dim> v ) const
    {
        const Real along = 2 * dot<Dim>( v, normal );
        for ( int d = 0; d < Dim; ++d )
            v[d] -= along * normal[d];
        return v;
    }
};

//! R C R, row by row: the affine matrix as a mirror shows it.
template <int Dim>
KOKKOS_FORCEINLINE_FUNCTION void mirrorAffine( const Mirror<Dim>& mirror,
                                               Vector<Dim> ( &rows )[Dim] )
{
    for ( int a = 0; a < Dim; ++a )
        rows[a] = mirror.direction( rows[a] ); // C R
    Vector<Dim> along{};                       // 2 n^T C R
    for ( int a = 0; a < Dim; ++a )
        for ( int b = 0; b < Dim; ++b )
            along[b] += 2 * mirror.normal[a] * rows[a][b];
    for ( int a = 0; a < Dim; ++a )
        for ( int b = 0; b < Dim; ++b )
            rows[a][b] -= mirror.normal[a] * along[b];
}

/*!
  \brief Nodes beside space that neither gas nor its images can fill, as it lies
  in bodies behind corners (core/image_gaps.hpp).
*/
struct ImageGaps
{
    IndexList nodes; //!< rows [n]
    //! What is missing of the sight of the face behind a node along each axis,
    //! 0 to 1. [n][Dim]
    NodeView missing;
    //! Axes along which a node is to stand still, a bit each. [n]
    IndexList held_axes;
};

/*!
  \brief The images of a step.

  Image k belongs to particle(k). Modules append to the list; whoever scatters
  to nodes scatters the images too.
*/
template <int Dim>
struct Images
{
    int count = 0;      //!< of this rank
    IndexList particle; //!< [>= count]
    //! Normal [Dim] and distance of each mirror, [>= count][Dim + 1]
    NodeView mirrors;
    NodeView impulses; //!< momentum that each image gained, [>= count][Dim]

    //! Makes room for `more` images beyond those there are.
    void reserve( const int more )
    {
        const auto needed = static_cast<std::size_t>( count + more );
        if ( particle.extent( 0 ) >= needed )
            return;
        Kokkos::resize( particle, needed + needed / 4 );
        Kokkos::resize( mirrors, needed + needed / 4, Dim + 1 );
        Kokkos::resize( impulses, needed + needed / 4, Dim );
    }

    //! That of image k.
    KOKKOS_INLINE_FUNCTION Mirror<Dim> mirror( const int k ) const
    {
        Mirror<Dim> m{};
        for ( int d = 0; d < Dim; ++d )
            m.normal[d] = mirrors( k, d );
        m.distance = mirrors( k, Dim );
        return m;
    }
};

} // namespace Machpoint

#endif
