/*!
  \file faces.hpp
  \brief `conservative` on the grid: volumes and velocity differences on the
  faces between nodes (docs/conservative.md, sections 2 to 4).

  Column layout. moments: mass, momentum [Dim], theta [Dim], force [Dim].
  inverse filling: 1/den [Dim].
  faces: what particles gather together, side by side, for each axis: before the
  force FaceRate, before G2P FaceMotion.
  stress: pressure on faces [Dim], and the sum of m times the blend.
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

//! Columns of a face's axis: d, the velocity difference over h.
enum FaceRate : int
{
    Difference, //!< d, 1/time
    Normalised, //!< d / den, 1/time
    Closing,    //!< max(-d, 0), 1/time
    Rough,      //!< (1 - psi) max(-d, 0), 1/time
    face_columns
};

//! The same columns for G2P.
enum FaceMotion : int
{
    MeanNormalised, //!< d / den of the mean of v and v', 1/time
    Excess          //!< theta - 1
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

//! First columns of moments' theta and force.
template <int Dim>
inline constexpr int theta_column = 1 + Dim;
template <int Dim>
inline constexpr int force_column = 1 + 2 * Dim;

//! mass, momentum, theta: what particles deposit
template <int Dim>
NodeComponents<1 + 2 * Dim> conservativeMoments()
{
    NodeComponents<1 + 2 * Dim> list{};
    for ( int a = 0; a < Dim; ++a )
    {
        list[1 + a] = { Parity::velocity, a };
        list[theta_column<Dim> + a] = faceComponents<Dim>()[a];
    }
    return list;
}

//! Adds particles, or one image of one, to mass, momentum and theta.
//! \param p a particle's row or a pack \return what addProductsLater returns
template <class Basis, int Dim, class Number, class NodeAccess, class Particle>
KOKKOS_FORCEINLINE_FUNCTION auto depositMoments(
    const NodeAccess& nodes, const Grid<Dim>& grid,
    const NodeLayout<Dim>& layout, const Stencil<Basis, Dim, Number>& s,
    const Particle p, const Number& mass, const Number& volume,
    const VectorOf<Dim, Number>& v, const VectorOf<Dim, Number> ( &C )[Dim] )
{
    const FaceWeights<Basis, Dim, Number> faces( grid, s );
    Products<MomentTerms<Dim, true>, Dim, Number> terms;
    setMoments<Dim>( terms, mass, v, C );
    for ( int a = 0; a < Dim; ++a )
        terms.value[theta_column<Dim> + a] = volume * ( 1 / grid.cellVolume() );
    return addProductsLater( nodes, p, s, layout, faces.w, terms );
}

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
  \brief P2G: m_i = sum m w, (mv)_i = sum m w (v + C (x_i - x)),
  theta^a_f = sum V w^a_f / h^Dim, over particles and their images.
  \param sums the scatter of the moments
*/
template <class Basis, int Dim, class Sums>
void depositParticles( const State<Dim>& state, const Sums& sums )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto images = state.images;
    forEachDeposit<Basis>(
        "Machpoint::depositParticles", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes ) MACHPOINT_INLINE {
            VectorOf<Dim, Lanes> affine[Dim];
            loadMatrix<Dim>( C, p, affine );
            return depositMoments<Basis, Dim>(
                nodes, grid, layout, s, p, load( m, p ), load( V, p ),
                loadVector<Dim>( v, p ), affine );
        } );
    if ( images.count > 0 )
        Kokkos::parallel_for(
            "Machpoint::depositImages", Range( 0, images.count ),
            MACHPOINT_LAMBDA( const int k ) {
                const int p = images.particle( k );
                const auto mirror = images.mirror( k );
                const Stencil<Basis, Dim> s( grid, layout,
                                             mirror.point( get<Dim>( x, p ) ) );
                Vector<Dim> affine[Dim];
                loadMatrix<Dim>( C, p, affine );
                mirrorAffine<Dim>( mirror, affine );
                depositMoments<Basis, Dim>(
                    accessTo( sums.thread(), p, s, layout ), grid, layout, s, p,
                    load( m, p ), load( V, p ),
                    mirror.direction( get<Dim>( v, p ) ), affine );
            } );
}

/*!
  \brief FaceRate on every face, and 1/den with den = max(theta, least filling).

  Where Limited also how far from smooth the compression is, with psi
  Christensen's monotonic limiter (1990) of neighbouring differences along the
  face's axis: 1 where the velocity is linear, 0 at a jump.
  psi = max(0, min((l + r)/2, 1, 2 l, 2 r)) of the ratios l and r of the two
  neighbours' d to the face's; times max(-d, 0) it needs no ratio.
  \param[out] faces FaceRate \param[out] inverse_filling 1/den
*/
template <bool Limited, int Dim>
void measureFaces( const State<Dim>& state, const NodeView& faces,
                   const NodeView& inverse_filling, const Real least_filling )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const auto inverse = state.grid.inverse;
    forEach(
        Limited ? "Machpoint::limitFaces" : "Machpoint::measureFaces",
        layout.total, MACHPOINT_LAMBDA( const int i ) MACHPOINT_INLINE {
            for ( int a = 0; a < Dim; ++a )
            {
                const int stride = layout.stride[a];
                // 0 without a second node
                auto difference = [&]( const int row )
                {
                    return row + stride < layout.total
                               ? ( velocities( row + stride, a ) -
                                   velocities( row, a ) ) *
                                     inverse[a]
                               : 0.0_rt;
                };
                const int face = face_columns * a;
                const Real d = difference( i );
                const Real scale =
                    1 / Kokkos::max( moments( i, theta_column<Dim> + a ),
                                     least_filling );
                inverse_filling( i, a ) = scale;
                faces( i, face + Difference ) = d;
                faces( i, face + Normalised ) = d * scale;
                if ( !Limited )
                    continue;
                const Real closing = Kokkos::max( -d, 0.0_rt );
                Real smooth = closing;
                if ( i >= stride && i + stride < layout.total )
                {
                    const Real left = -difference( i - stride );
                    const Real right = -difference( i + stride );
                    smooth = Kokkos::min(
                        Kokkos::min( 0.5_rt * ( left + right ), closing ),
                        2 * Kokkos::min( left, right ) );
                }
                faces( i, face + Closing ) = closing;
                // closing - max(smooth, 0), but without a branch on the sign
                // of what is subtracted
                faces( i, face + Rough ) =
                    Kokkos::min( closing - smooth, closing );
            }
        } );
}

//! FaceMotion on every face, in the place of FaceRate.
//! \param inverse_filling 1/den
template <int Dim>
void measureMotion( const State<Dim>& state, const NodeView& faces,
                    const NodeView& inverse_filling )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const auto inverse = state.grid.inverse;
    forEach(
        "Machpoint::measureMotion", layout.total,
        MACHPOINT_LAMBDA( const int i ) MACHPOINT_INLINE {
            auto mean = [&]( const int row, const int a ) {
                return 0.5_rt *
                       ( velocities( row, a ) + velocities( row, Dim + a ) );
            };
            for ( int a = 0; a < Dim; ++a )
            {
                const int next = i + layout.stride[a];
                const int face = face_columns * a;
                faces( i, face + MeanNormalised ) =
                    next < layout.total
                        ? inverse_filling( i, a ) *
                              ( mean( next, a ) - mean( i, a ) ) * inverse[a]
                        : 0.0_rt;
                faces( i, face + Excess ) =
                    moments( i, theta_column<Dim> + a ) - 1;
            }
        } );
}

} // namespace Impl
} // namespace Machpoint

#endif
