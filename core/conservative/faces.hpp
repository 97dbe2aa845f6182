/*!
  \file faces.hpp
  \brief `conservative` on the grid: volumes and velocity differences on the
  faces between nodes (docs/conservative.md, sections 2 to 4).

  Column layout. moments: mass, momentum [Dim], theta [Dim], sum of V (p + q) on
  faces [Dim], sum of m times the blend.
  faces: FaceMotion for each axis, what particles gather together.
  velocities: v [Dim], v' [Dim], 1 - beta.
*/
#ifndef MACHPOINT_CONSERVATIVE_FACES_HPP
#define MACHPOINT_CONSERVATIVE_FACES_HPP

#include <core/transfer.hpp>

namespace Machpoint
{

//! Fields on faces: component a is staggered along axis a.
template <int Dim>
NodeComponents<Dim> faceComponents()
{
    NodeComponents<Dim> list{};
    for ( int a = 0; a < Dim; ++a )
        list[a] = { Parity::scalar, a, 1 << a };
    return list;
}

namespace Impl
{

//! Columns of a face's axis, with d the velocity difference over h.
enum FaceMotion : int
{
    MeanNormalised, //!< d / den of the mean of v and v', 1/time
    Normalised,     //!< theta d / den^2 of v', 1/time: over the filling, but
                    //!< none at the edge of a vacuum
    Excess,         //!< theta - 1
    Rough,          //!< (1 - psi) max(-d, 0) of v', 1/time
    face_columns
};

//! The columns of all axes.
template <int Dim>
NodeComponents<face_columns * Dim> allFaceComponents()
{
    NodeComponents<face_columns * Dim> list{};
    for ( int c = 0; c < face_columns * Dim; ++c )
        list[c] = faceComponents<Dim>()[c / face_columns];
    return list;
}

//! Columns of velocities; padded in 3D, as particles read columns by fours, and
//! on a GPU, where they read them by twos.
template <int Dim>
inline constexpr int velocity_columns = Dim == 3          ? 8
                                        : lane_count == 1 ? 2 * Dim + 2
                                                          : 2 * Dim + 1;

//! First columns of moments' theta, pressure and blend.
template <int Dim>
inline constexpr int theta_column = 1 + Dim;
template <int Dim>
inline constexpr int pressure_column = 1 + 2 * Dim;
template <int Dim>
inline constexpr int blend_column = 1 + 3 * Dim;

//! mass, momentum, theta, pressure, blend: what particles deposit
template <int Dim>
NodeComponents<2 + 3 * Dim> conservativeMoments()
{
    NodeComponents<2 + 3 * Dim> list{};
    for ( int a = 0; a < Dim; ++a )
    {
        list[1 + a] = { Parity::velocity, a };
        list[theta_column<Dim> + a] = faceComponents<Dim>()[a];
        list[pressure_column<Dim> + a] = faceComponents<Dim>()[a];
    }
    return list;
}

/*!
  \brief FaceMotion on every face, with den = max(theta, least filling).

  Where Limited also how far from smooth the compression by v' is, with psi
  Christensen's monotonic limiter (1990) of neighbouring differences along the
  face's axis: 1 where the velocity is linear, 0 at a jump.
  psi = max(0, min((l + r)/2, 1, 2 l, 2 r)) of the ratios l and r of the two
  neighbours' d to the face's; times max(-d, 0) it needs no ratio.
  \param[out] faces FaceMotion
*/
template <bool Limited, int Dim>
void measureMotion( const State<Dim>& state, const NodeView& faces,
                    const Real least_filling )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const auto inverse = state.grid.inverse;
    forEach(
        Limited ? "Machpoint::limitMotion" : "Machpoint::measureMotion",
        layout.total, MACHPOINT_LAMBDA( const int i ) MACHPOINT_INLINE {
            constexpr int ahead = 32;
            prefetchRow<false, 1>( moments.data(), moments.stride( 0 ),
                                   i + ahead );
            prefetchRow<true, 1>( faces.data(), faces.stride( 0 ), i + ahead );
            prefetchRow<false, 1>( velocities.data(), velocities.stride( 0 ),
                                   i + ahead + 2 * layout.stride[Dim - 1] );
            for ( int a = 0; a < Dim; ++a )
            {
                const int stride = layout.stride[a];
                // Of v or v' over the face behind a node, 1/time; 0 without a
                // second node.
                auto difference = [&]( const int row, const int column )
                {
                    return row + stride < layout.total
                               ? ( velocities( row + stride, column ) -
                                   velocities( row, column ) ) *
                                     inverse[a]
                               : 0.0_rt;
                };
                const int face = face_columns * a;
                const Real theta = moments( i, theta_column<Dim> + a );
                const Real per_filling =
                    1 / Kokkos::max( theta, least_filling );
                const Real d = difference( i, Dim + a );
                faces( i, face + MeanNormalised ) =
                    0.5_rt * ( difference( i, a ) + d ) * per_filling;
                faces( i, face + Normalised ) =
                    theta * per_filling * ( d * per_filling );
                faces( i, face + Excess ) = theta - 1;
                if ( !Limited )
                    continue;
                const Real closing = Kokkos::max( -d, 0.0_rt );
                Real smooth = closing;
                if ( i >= stride && i + stride < layout.total )
                {
                    const Real left = -difference( i - stride, Dim + a );
                    const Real right = -difference( i + stride, Dim + a );
                    smooth = Kokkos::min(
                        Kokkos::min( 0.5_rt * ( left + right ), closing ),
                        2 * Kokkos::min( left, right ) );
                }
                // closing - max(smooth, 0), but without a branch on the sign
                // of what is subtracted
                faces( i, face + Rough ) =
                    Kokkos::min( closing - smooth, closing );
            }
        } );
}

//! Faces beside space that nothing can fill are as full as they can be: that
//! space is no want of filling. \param[in,out] faces FaceMotion
template <int Dim>
void creditGaps( const State<Dim>& state, const NodeView& faces )
{
    const auto gaps = state.image_gaps;
    forEach(
        "Machpoint::creditGaps", gaps.nodes.extent_int( 0 ),
        MACHPOINT_LAMBDA( const int k ) {
            for ( int a = 0; a < Dim; ++a )
                faces( gaps.nodes( k ), face_columns * a + Excess ) +=
                    gaps.missing( k, a );
        },
        few_rows );
}

} // namespace Impl
} // namespace Machpoint

#endif
