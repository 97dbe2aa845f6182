/*!
  \file faces.hpp
  \brief `conservative` on the grid: volumes and pressures on the faces between
  nodes (docs/conservative.md, sections 2 to 4).

  Column layout. moments: mass, momentum [Dim], force [Dim], theta [Dim].
  faces: 1/den [Dim], velocity difference [Dim], limiter 1 - psi [Dim].
  stress: pressure on faces [Dim], and the sum of m times the blend.
  velocities: v [Dim], v' [Dim], beta.
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

//! 1/den, differences and limiter: three fields on faces
template <int Dim>
NodeComponents<3 * Dim> allFaceComponents()
{
    NodeComponents<3 * Dim> list{};
    for ( int c = 0; c < 3 * Dim; ++c )
        list[c] = faceComponents<Dim>()[c % Dim];
    return list;
}

//! mass, momentum, force, theta
template <int Dim>
NodeComponents<1 + 3 * Dim> conservativeMoments()
{
    NodeComponents<1 + 3 * Dim> list{};
    const auto moments = momentComponents<Dim>();
    for ( int c = 0; c < 1 + 2 * Dim; ++c )
        list[c] = moments[c];
    for ( int a = 0; a < Dim; ++a )
        list[1 + 2 * Dim + a] = faceComponents<Dim>()[a];
    return list;
}

//! Adds one particle, or one image of it, to mass, momentum and theta.
template <class Basis, int Dim, class NodeAccess>
KOKKOS_FORCEINLINE_FUNCTION void
depositMoments( const NodeAccess& nodes, const Grid<Dim>& grid,
                const NodeLayout<Dim>& layout, const Stencil<Basis, Dim>& s,
                const Real mass, const Real volume, const Vector<Dim>& v,
                const Vector<Dim> ( &C )[Dim] )
{
    forEachNode( s, layout,
                 [&]( const auto& i )
                 {
                     const Real mw = mass * i.weight;
                     nodes( i.row, 0 ) += mw;
                     for ( int a = 0; a < Dim; ++a )
                         nodes( i.row, 1 + a ) +=
                             mw * ( v[a] + dot<Dim>( C[a], i.dx ) );
                 } );
    const Real filling = volume / grid.cellVolume();
    forEachFace( s, HalfwayWeights<Basis, Dim>( grid, s ), layout,
                 [&]( const auto& f ) {
                     nodes( f.row, 1 + 2 * Dim + f.axis ) += filling * f.weight;
                 } );
}

//! Affine matrix of particle p, row by row.
template <int Dim, class GradientSlice>
KOKKOS_FORCEINLINE_FUNCTION void
loadAffine( const GradientSlice& C, const int p, Vector<Dim> ( &rows )[Dim] )
{
    for ( int a = 0; a < Dim; ++a )
        for ( int b = 0; b < Dim; ++b )
            rows[a][b] = C( p, a, b );
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
    Kokkos::parallel_for(
        "Machpoint::depositParticles", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            const auto nodes = sums.access();
            const Stencil<Basis, Dim> s( grid, layout, get<Dim>( x, p ) );
            Vector<Dim> affine[Dim];
            loadAffine<Dim>( C, p, affine );
            depositMoments<Basis, Dim>( nodes, grid, layout, s, m( p ), V( p ),
                                        get<Dim>( v, p ), affine );
        } );
    if ( images.count > 0 )
        Kokkos::parallel_for(
            "Machpoint::depositImages", Range( 0, images.count ),
            KOKKOS_LAMBDA( const int k ) {
                const auto nodes = sums.access();
                const int p = images.particle( k );
                const auto mirror = images.mirror( k );
                const Stencil<Basis, Dim> s( grid, layout,
                                             mirror.point( get<Dim>( x, p ) ) );
                Vector<Dim> affine[Dim];
                loadAffine<Dim>( C, p, affine );
                mirrorAffine<Dim>( mirror, affine );
                depositMoments<Basis, Dim>(
                    nodes, grid, layout, s, m( p ), V( p ),
                    mirror.direction( get<Dim>( v, p ) ), affine );
            } );
}

//! 1/den with den = max(theta, least filling), on every face.
template <int Dim>
void normaliseFaces( const State<Dim>& state, const NodeView& faces,
                     const Real least_filling )
{
    const auto moments = state.nodes.moments;
    Kokkos::parallel_for(
        "Machpoint::normaliseFaces", Range( 0, state.layout.total ),
        KOKKOS_LAMBDA( const int i ) {
            for ( int a = 0; a < Dim; ++a )
                faces( i, a ) = 1 / Kokkos::max( moments( i, 1 + 2 * Dim + a ),
                                                 least_filling );
        } );
}

/*!
  \brief Velocity differences d^a_f = (u_(i+1) - u_i)_a / h_a, 1/time, of
  u = v + part (v' - v), on every face that has two nodes.
  \param part 0 for v, 1/2 for the mean of v and v'
*/
template <int Dim>
void differenceVelocity( const State<Dim>& state, const NodeView& faces,
                         const Real part )
{
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const auto spacing = state.grid.spacing;
    Kokkos::parallel_for(
        "Machpoint::differenceVelocity", Range( 0, layout.total ),
        KOKKOS_LAMBDA( const int i ) {
            auto u = [&]( const int row, const int a )
            {
                const Real v = velocities( row, a );
                return v + part * ( velocities( row, Dim + a ) - v );
            };
            for ( int a = 0; a < Dim; ++a )
            {
                const int next = i + layout.stride[a];
                faces( i, Dim + a ) =
                    next < layout.total
                        ? ( u( next, a ) - u( i, a ) ) / spacing[a]
                        : 0.0;
            }
        } );
}

/*!
  \brief 1 - psi on faces, where psi is Christensen's monotonic limiter (1990)
  of neighbouring velocity differences along the face's axis: 1 where the
  velocity is linear, 0 at a jump.
*/
template <int Dim>
void limitFaces( const State<Dim>& state, const NodeView& faces )
{
    const auto layout = state.layout;
    const Real least = 1e-100; // 1/time; ratios to less would overflow
    Kokkos::parallel_for(
        "Machpoint::limitFaces", Range( 0, layout.total ),
        KOKKOS_LAMBDA( const int i ) {
            for ( int a = 0; a < Dim; ++a )
            {
                const int stride = layout.stride[a];
                Real psi = 1;
                const Real d = faces( i, Dim + a );
                if ( i >= stride && i + stride < layout.total &&
                     Kokkos::abs( d ) > least )
                {
                    const Real left = faces( i - stride, Dim + a ) / d;
                    const Real right = faces( i + stride, Dim + a ) / d;
                    psi =
                        Kokkos::min( Kokkos::min( 0.5 * ( left + right ), 1.0 ),
                                     2 * Kokkos::min( left, right ) );
                }
                faces( i, 2 * Dim + a ) = 1 - Kokkos::max( psi, 0.0 );
            }
        } );
}

/*!
  \brief What the particles see of the grid velocity: D, the divergence of
  normalised volume, and how far from smooth the flow is,
  phi = |D| / (|D| + |curl C| + 1e-4 c/h) times the mean of 1 - psi over the
  faces that compress (Balsara 1995 and Christensen 1990). Without a limiter
  phi is 1.
  \param[out] state.rates
*/
template <class Basis, bool Limited, int Dim>
void gatherRates( const State<Dim>& state, const NodeView& faces,
                  const Part& part = {} )
{
    const auto x = state.particles.template slice<Position>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto sound_speed = state.particles.template slice<SoundSpeed>();
    const auto divergence = Cabana::slice<Divergence>( state.rates->data() );
    const auto expansion = Cabana::slice<Expansion>( state.rates->data() );
    const auto limiter = Cabana::slice<Limiter>( state.rates->data() );
    const auto q = Cabana::slice<ViscousPressure>( state.rates->data() );
    const auto grid = state.grid;
    const auto layout = state.layout;
    const Real h = grid.minSpacing();
    Kokkos::parallel_for(
        "Machpoint::gatherRates", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            if ( !part.contains( p ) )
                return;
            const Stencil<Basis, Dim> s( grid, layout, get<Dim>( x, p ) );
            Real D = 0;
            Real normalised = 0;
            Real compression = 0; // sum w |min(d, 0)|
            Real rough = 0;       // sum w (1 - psi) |min(d, 0)|
            forEachFace(
                s, HalfwayWeights<Basis, Dim>( grid, s ), layout,
                [&]( const auto& f )
                {
                    const Real d = f.weight * faces( f.row, Dim + f.axis );
                    D += d;
                    normalised += d * faces( f.row, f.axis );
                    const Real closing = Kokkos::max( -d, 0.0 );
                    compression += closing;
                    rough +=
                        closing *
                        ( Limited ? faces( f.row, 2 * Dim + f.axis ) : 1.0 );
                } );
            divergence( p ) = D;
            expansion( p ) = normalised;
            q( p ) = 0;
            Real phi = 1;
            if ( Limited && compression > 0 && sound_speed( p ) > 0 )
            {
                Real curl = 0;
                for ( int a = 0; a < Dim; ++a )
                    for ( int b = a + 1; b < Dim; ++b )
                    {
                        const Real spin = C( p, a, b ) - C( p, b, a );
                        curl += spin * spin;
                    }
                const Real slow = 1e-4 * sound_speed( p ) / h;
                phi = Kokkos::abs( D ) /
                      ( Kokkos::abs( D ) + Kokkos::sqrt( curl ) + slow ) *
                      rough / compression;
            }
            limiter( p ) = phi;
        } );
}

//! Adds one particle, or one image of it, to the pressure on faces and, where
//! `mixed` is not 0, to the blend on nodes.
template <class Basis, int Dim, class NodeAccess>
KOKKOS_FORCEINLINE_FUNCTION void
depositStress( const NodeAccess& nodes, const Grid<Dim>& grid,
               const NodeLayout<Dim>& layout, const Stencil<Basis, Dim>& s,
               const Real volume_pressure, const Real mixed )
{
    const Real share = volume_pressure / grid.cellVolume();
    forEachFace( s, HalfwayWeights<Basis, Dim>( grid, s ), layout,
                 [&]( const auto& f )
                 { nodes( f.row, f.axis ) += share * f.weight; } );
    if ( mixed > 0 )
        forEachNode( s, layout,
                     [&]( const auto& i )
                     { nodes( i.row, Dim ) += mixed * i.weight; } );
}

//! m kb phi h max(-D, 0) / c of particle p, 0 without sound.
template <class Mass, class Sound, class Rate>
struct BlendSource
{
    Mass m;
    Sound c;
    Rate divergence, limiter;
    Real scale; //!< kb h

    KOKKOS_INLINE_FUNCTION Real operator()( const int p ) const
    {
        return scale > 0 && divergence( p ) < 0 && c( p ) > 0
                   ? -m( p ) * scale * limiter( p ) * divergence( p ) / c( p )
                   : 0.0;
    }
};

/*!
  \brief sum V (p + q) w^a_f / h^Dim on faces and, where kb > 0,
  sum m w kb phi h max(-D, 0) / c on nodes, over particles and images.
  \param sums the scatter of the stress
*/
template <class Basis, int Dim, class Sums>
void depositStress( const State<Dim>& state, const Real kb, const Sums& sums )
{
    const auto x = state.particles.template slice<Position>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto divergence = Cabana::slice<Divergence>( state.rates->data() );
    const auto limiter = Cabana::slice<Limiter>( state.rates->data() );
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto images = state.images;
    const Real scale = kb * grid.minSpacing();
    const BlendSource mixed{ m, c, divergence, limiter, scale };
    Kokkos::parallel_for(
        "Machpoint::depositStress", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            const Stencil<Basis, Dim> s( grid, layout, get<Dim>( x, p ) );
            depositStress<Basis, Dim>( sums.access(), grid, layout, s,
                                       V( p ) * pressure( p ), mixed( p ) );
        } );
    if ( images.count > 0 )
        Kokkos::parallel_for(
            "Machpoint::depositImageStress", Range( 0, images.count ),
            KOKKOS_LAMBDA( const int k ) {
                const int p = images.particle( k );
                const Stencil<Basis, Dim> s(
                    grid, layout,
                    images.mirror( k ).point( get<Dim>( x, p ) ) );
                depositStress<Basis, Dim>( sums.access(), grid, layout, s,
                                           V( p ) * pressure( p ), mixed( p ) );
            } );
}

/*!
  \brief Force f_(i,a) += h^Dim / h_a (p^a_(i-1/2) - p^a_(i+1/2)) and blend
  beta_i = min(1, beta_0 + kb-sum / m_i). It telescopes, so momentum is exact.
*/
template <int Dim>
void pressureForce( const State<Dim>& state, const NodeView& faces,
                    const NodeView& stress, const Real blend )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const auto spacing = state.grid.spacing;
    const Real cell_volume = state.grid.cellVolume();
    const bool blends = stress.extent( 1 ) > Dim;
    Kokkos::parallel_for(
        "Machpoint::pressureForce", Range( 0, layout.total ),
        KOKKOS_LAMBDA( const int i ) {
            auto pressure = [&]( const int row, const int a )
            { return row < 0 ? 0.0 : stress( row, a ) * faces( row, a ); };
            for ( int a = 0; a < Dim; ++a )
                moments( i, 1 + Dim + a ) +=
                    cell_volume / spacing[a] *
                    ( pressure( i - layout.stride[a], a ) - pressure( i, a ) );
            const Real m = moments( i, 0 );
            velocities( i, 2 * Dim ) =
                blends && m > 0
                    ? Kokkos::min( 1.0, blend + stress( i, Dim ) / m )
                    : blend;
        } );
}

} // namespace Impl
} // namespace Machpoint

#endif
