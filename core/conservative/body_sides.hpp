/*!
  \file body_sides.hpp
  \brief `conservative`: what the domain's sides give to the images in bodies
  that meet them, and a body does not feel (docs/conservative.md, section 6).
*/
#ifndef MACHPOINT_CONSERVATIVE_BODY_SIDES_HPP
#define MACHPOINT_CONSERVATIVE_BODY_SIDES_HPP

#include <core/conservative/faces.hpp>

namespace Machpoint
{
namespace Impl
{

//! Faces on sides (Halo::facesOn) within bodies that have images.
template <int Dim>
struct BodyFaces
{
    IndexList rows;  //!< of the nodes before them [n]
    IndexList body;  //!< [n]
    NodeView shares; //!< of the face that this rank's part of it is [n][1]
};
//! On each side.
template <int Dim>
using BodySides = Kokkos::Array<BodyFaces<Dim>, 2 * Dim>;

/*!
  \brief Finds them. A face at the edge of a body is the body's as far as its
  surface, taken for a plane, leaves it.
*/
template <int Dim>
BodySides<Dim> findBodySides( const State<Dim>& state )
{
    BodySides<Dim> found;
    const auto bodies = state.bodies;
    if ( !bodies.have_images )
        return found;
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto weights = state.halo.weights();
    for ( int side = 0; side < 2 * Dim; ++side )
    {
        const int axis = side / 2;
        const bool is_upper = side % 2 == 1;
        for ( const auto kind :
              { SideKind::slip, SideKind::no_slip, SideKind::open } )
        {
            const auto faces = state.halo.facesOn( side, kind );
            const int n = faces.extent_int( 0 );
            if ( n == 0 )
                continue;
            auto& own = found[side];
            const int first = own.rows.extent_int( 0 );
            Kokkos::resize( own.rows, first + n );
            Kokkos::resize( own.body, first + n );
            Kokkos::resize( own.shares, first + n, 1 );
            const auto list = own;
            // The node inside, which tells whose the face is.
            const int inside = is_upper ? 0 : layout.stride[axis];
            forEach(
                "Machpoint::findBodySides", n, MACHPOINT_LAMBDA( const int k ) {
                    const auto i = layout.indices( faces( k ) + inside );
                    auto x = layout.position( i );
                    x[axis] = is_upper ? grid.upper[axis] : grid.lower[axis];
                    const int body = bodies.nearestBody( x, true );
                    const auto nearest = bodies.nearest( x, body );
                    Real across = 0; // extent of the face along the normal
                    for ( int d = 0; d < Dim; ++d )
                        if ( d != axis )
                            across += grid.spacing[d] *
                                      Kokkos::abs( nearest.normal[d] );
                    Real part = nearest.distance < 0 ? 1 : 0;
                    if ( across > 0 )
                        part = clip( 0.5_rt - nearest.distance / across, 0.0_rt,
                                     1.0_rt );
                    if ( bodies.image_reach( body ) == 0 )
                        part = 0;
                    list.rows( first + k ) = faces( k );
                    list.body( first + k ) = body;
                    list.shares( first + k, 0 ) = part * weights( i );
                } );
        }
    }
    return found;
}

/*!
  \brief dt h^Dim / h_a p_f over these faces, into the domain: what sides give
  to images; mass length/time. \param[in,out] state whose side_impulses it sets
*/
template <int Dim>
void findSideImpulses( State<Dim>& state, const BodySides<Dim>& sides,
                       const Real least_filling )
{
    const auto moments = state.nodes.moments;
    auto& impulses = state.side_impulses;
    impulses.assign( static_cast<std::size_t>( state.bodies.count ) * Dim, {} );
    for ( int side = 0; side < 2 * Dim; ++side )
    {
        const auto faces = sides[side];
        if ( faces.rows.extent( 0 ) == 0 )
            continue;
        const int axis = side / 2;
        const Real factor = static_cast<Real>( state.dt ) *
                            state.grid.cellVolume() * state.grid.inverse[axis] *
                            ( side % 2 == 1 ? -1.0_rt : 1.0_rt );
        for ( int own = 0; own < state.bodies.count; ++own )
        {
            ReproducibleSum given;
            reduceEach(
                "Machpoint::sideImpulses", faces.rows.extent_int( 0 ), few_rows,
                MACHPOINT_LAMBDA( const int k, ReproducibleSum& sum ) {
                    if ( faces.body( k ) != own || faces.shares( k, 0 ) == 0 )
                        return;
                    const int f = faces.rows( k );
                    sum += factor * faces.shares( k, 0 ) *
                           moments( f, pressure_column<Dim> + axis ) /
                           Kokkos::max( moments( f, theta_column<Dim> + axis ),
                                        least_filling );
                },
                given );
            impulses[static_cast<std::size_t>( own ) * Dim + axis] += given;
        }
    }
}

} // namespace Impl
} // namespace Machpoint

#endif
