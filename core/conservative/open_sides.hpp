/*!
  \file open_sides.hpp
  \brief `conservative`: faces on open sides, where no particle stands beyond
  (docs/conservative.md, section 3).
*/
#ifndef MACHPOINT_CONSERVATIVE_OPEN_SIDES_HPP
#define MACHPOINT_CONSERVATIVE_OPEN_SIDES_HPP

#include <core/conservative/faces.hpp>

namespace Machpoint
{
namespace Impl
{

//! For each side the rows of the faces on its open part (Halo::facesOn).
template <int Dim>
using OpenFaces = Kokkos::Array<IndexList, 2 * Dim>;

template <int Dim>
OpenFaces<Dim> findOpenFaces( const State<Dim>& state )
{
    OpenFaces<Dim> faces;
    for ( int side = 0; side < 2 * Dim; ++side )
        faces[side] = state.halo.facesOn( side, SideKind::open );
    return faces;
}

//! Steps in memory from a face on a side to the next one inside.
template <int Dim>
int inward( const NodeLayout<Dim>& layout, const int side )
{
    return side % 2 ? -layout.stride[side / 2] : layout.stride[side / 2];
}

/*!
  \brief What a face on an open side lacks of the least filling presses as the
  next face inside: theta_f = theta_min, and the sum of pressure gains
  (theta_min - theta_f) p_g.

  The same gas goes on beyond the side, where a gap between particles that leave
  is no vacuum. On bases with nodes on the side no face lies on it.
*/
template <int Dim>
void fillOpenSides( const State<Dim>& state, const OpenFaces<Dim>& open,
                    const Real least_filling )
{
    if ( !state.layout.centred )
        return;
    const auto moments = state.nodes.moments;
    for ( int side = 0; side < 2 * Dim; ++side )
    {
        const auto faces = open[side];
        const int inner = inward( state.layout, side );
        const int theta = theta_column<Dim> + side / 2;
        const int pressure = pressure_column<Dim> + side / 2;
        if ( faces.extent( 0 ) > 0 )
            forEach(
                "Machpoint::fillOpenSides", faces.extent_int( 0 ),
                MACHPOINT_LAMBDA( const int k ) {
                    const int f = faces( k );
                    const int g = f + inner;
                    const Real lacking = least_filling - moments( f, theta );
                    if ( lacking <= 0 )
                        return;
                    moments( f, pressure ) +=
                        lacking * moments( g, pressure ) /
                        Kokkos::max( moments( g, theta ), least_filling );
                    moments( f, theta ) = least_filling;
                },
                few_rows );
    }
}

/*!
  \brief Within a cell of an open side no face is too full or too empty: the
  mirror image beyond does not fit particles that move through the side, and
  what it claims must not hold them back. \param[in,out] faces FaceMotion
*/
template <int Dim>
void levelOpenSides( const State<Dim>& state, const OpenFaces<Dim>& open,
                     const NodeView& faces )
{
    const bool centred = state.layout.centred;
    for ( int side = 0; side < 2 * Dim; ++side )
    {
        const auto rows = open[side];
        const int inner = inward( state.layout, side );
        const int excess = face_columns * ( side / 2 ) + Excess;
        if ( rows.extent( 0 ) > 0 )
            forEach(
                "Machpoint::levelOpenSides", rows.extent_int( 0 ),
                MACHPOINT_LAMBDA( const int k ) {
                    faces( rows( k ), excess ) = 0;
                    if ( centred )
                        faces( rows( k ) + inner, excess ) = 0;
                },
                few_rows );
    }
}

} // namespace Impl
} // namespace Machpoint

#endif
