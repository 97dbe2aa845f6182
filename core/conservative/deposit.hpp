/*!
  \file deposit.hpp
  \brief P2G of `conservative`: all that particles give to the grid in a step
  (docs/conservative.md, sections 2 to 4).
*/
#ifndef MACHPOINT_CONSERVATIVE_DEPOSIT_HPP
#define MACHPOINT_CONSERVATIVE_DEPOSIT_HPP

#include <core/conservative/drift.hpp>
#include <core/conservative/pressure.hpp>

namespace Machpoint
{
namespace Impl
{

//! Mass, momentum, theta and pressure on the faces of each axis, and the blend.
template <int Dim>
struct ConservativeTerms
{
    static constexpr int count = 2 + 3 * Dim;
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int column( const int t )
    {
        return t;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr bool isAffine( const int t )
    {
        return 0 < t && t <= Dim;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int axis( const int t )
    {
        return t <= Dim || t == blend_column<Dim> ? -1 : ( t - 1 ) % Dim;
    }
};

//! What of a particle is not its own state: p + q where it does work, and the
//! blend that it asks for.
template <class Number>
struct Acting
{
    Number pressure;
    Number blend; //!< kb phi h max(-D, 0) / c
};

//! A pack that is about to deposit, at the half step where there is one.
template <int Dim>
struct ReadyPack
{
    VectorOf<Dim, Lanes> x;
    Lanes volume;
    Acting<Lanes> acting;
};

//! Adds particles, or one image of one, to the moments.
//! \param p a particle's row or a pack \return what addProductsLater returns
template <class Basis, int Dim, class Number, class NodeAccess, class Particle>
KOKKOS_FORCEINLINE_FUNCTION auto depositMoments(
    const NodeAccess& nodes, const Grid<Dim>& grid,
    const NodeLayout<Dim>& layout, const Stencil<Basis, Dim, Number>& s,
    const Particle p, const Number& mass, const Number& volume,
    const VectorOf<Dim, Number>& v, const VectorOf<Dim, Number> ( &C )[Dim],
    const Acting<Number>& acting )
{
    Products<ConservativeTerms<Dim>, Dim, Number> terms;
    setMoments<Dim>( terms, mass, v, C );
    const Number filling = volume * ( 1 / grid.cellVolume() );
    for ( int a = 0; a < Dim; ++a )
    {
        terms.value[theta_column<Dim> + a] = filling;
        terms.value[pressure_column<Dim> + a] = filling * acting.pressure;
    }
    terms.value[blend_column<Dim>] = mass * acting.blend;
    return addProductsLater( nodes, p, s, layout,
                             FaceWeights<Basis, Dim, Number>( grid, s ).w,
                             terms );
}

/*!
  \brief P2G: m_i = sum m w, (mv)_i = sum m w (v + C (x_i - x)),
  theta^a_f = sum V w^a_f / h^Dim, the same of V (p + q), and on nodes
  sum m w kb phi h max(-D, 0) / c, over particles, at the half step where there
  is one. D and phi are what the last step's G2P left with the particle.
  \param half_step which has been reached \param sums the scatter of the moments
  \param state whose rates get the WorkingPressure
*/
template <class Basis, int Dim, class Sums>
void depositParticles( const State<Dim>& state, const WorkingGas& working,
                       const HalfStep<Basis, Dim>& half_step, const Sums& sums )
{
    const auto flow = sliceOfFlow<Divergence>( state );
    const auto limiter = sliceOfFlow<Limiter>( state );
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto acting =
        state.particles.written( sliceOfRates<WorkingPressure>( state ) );
    const auto grid = state.grid;
    const auto layout = state.layout;
    forEachDeposit<ReadyPack<Dim>, Basis>(
        "Machpoint::depositParticles", state, sums,
        MACHPOINT_LAMBDA( const Pack p, ReadyPack<Dim>& own ) MACHPOINT_INLINE {
            Lanes ahead;
            const Lanes volume = // at the step's start
                half_step( p, own.x, own.volume, ahead );
            const Lanes divergence = load( flow, p );
            const Lanes phi = load( limiter, p );
            const Lanes sound = load( c, p );
            const Lanes density = load( m, p ) / volume;
            const Lanes q = working.viscous( divergence, phi, density, sound );
            own.acting.pressure = working.pressure( load( pressure, p ), q,
                                                    density, sound, ahead );
            own.acting.blend = working.blend( divergence, phi, sound );
            store( acting, own.acting.pressure, p );
        },
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes,
                          const ReadyPack<Dim>& own ) MACHPOINT_INLINE {
            VectorOf<Dim, Lanes> affine[Dim];
            loadMatrix<Dim>( C, p, affine );
            return depositMoments<Basis, Dim>(
                nodes, grid, layout, s, p, load( m, p ), own.volume,
                loadVector<Dim>( v, p ), affine, own.acting );
        } );
}

//! P2G of the images, as that of their particles, which comes first.
template <class Basis, int Dim, class Sums>
void depositImages( const State<Dim>& state, const WorkingGas& working,
                    const Sums& sums )
{
    const auto images = state.images;
    if ( images.count == 0 )
        return;
    const auto flow = sliceOfFlow<Divergence>( state );
    const auto limiter = sliceOfFlow<Limiter>( state );
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto acting = sliceOfRates<WorkingPressure>( state );
    const auto grid = state.grid;
    const auto layout = state.layout;
    forEach(
        "Machpoint::depositImages", images.count,
        MACHPOINT_LAMBDA( const int k ) {
            const int p = images.particle( k );
            const auto mirror = images.mirror( k );
            const Stencil<Basis, Dim> s(
                grid, layout, mirror.point( loadVector<Dim>( x, p ) ) );
            Vector<Dim> affine[Dim];
            loadMatrix<Dim>( C, p, affine );
            mirrorAffine<Dim>( mirror, affine );
            Acting<Real> own;
            own.pressure = acting( p );
            own.blend = working.blend<Real>( flow( p ), limiter( p ), c( p ) );
            depositMoments<Basis, Dim>(
                accessTo( sums.thread(), p, s, layout ), grid, layout, s, p,
                load( m, p ), load( V, p ),
                mirror.direction( loadVector<Dim>( v, p ) ), affine, own );
        },
        few_particles );
}

} // namespace Impl
} // namespace Machpoint

#endif
