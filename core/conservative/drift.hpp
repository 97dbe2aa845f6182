/*!
  \file drift.hpp
  \brief The integrator `midpoint` of `conservative`: drift, kick, drift
  (docs/conservative.md, section 1).
*/
#ifndef MACHPOINT_CONSERVATIVE_DRIFT_HPP
#define MACHPOINT_CONSERVATIVE_DRIFT_HPP

#include <core/basis.hpp>
#include <core/soundness.hpp>
#include <core/state.hpp>

namespace Machpoint
{

namespace Impl
{

//! Volume before a particle drifts for `time` over that after it: 1 - time
//! D-bar of the last step, so that neither P2G nor G2P has to divide by it.
KOKKOS_FORCEINLINE_FUNCTION Lanes driftFactor( const Real time,
                                               const Lanes& last_expansion )
{
    return Kokkos::max( 1 - time * last_expansion, Lanes( 0.5 ) );
}

/*!
  \brief Half a step of motion and expansion at the rates of the last step:
  x += dt/2 U, V /= 1 - dt/2 D-bar (docs/conservative.md, section 1).

  Transfer, force and work then act at the half step, which makes the step
  second order in any dimension; see gatherParticles for the other half. A
  particle may stand up to half a cell outside the box meanwhile: the halo's
  nodes carry what it deposits to where its image belongs. On hats, what the
  affine energy loses becomes heat.

  To be made ahead of `reach`, and asked for every pack by the kernel that needs
  the new places first: that gets them from here, as they go past the cache.
*/
template <class Basis, int Dim>
class HalfStep
{
    static constexpr bool on_hats = !Basis::constant_moment;

  public:
    //! Without state.drift there is no such half.
    explicit HalfStep( const State<Dim>& state )
        : _note( watch( state, 0.5_rt ) ), _grid( state.grid ),
          _half( 0.5_rt * static_cast<Real>( state.dt ) ),
          _is_taken( state.drift != nullptr ),
          _x( state.particles.template slice<Position>() ),
          _v( state.particles.template slice<Velocity>() ),
          _old_V( state.particles.template slice<Volume>() ),
          _old_C( state.particles.template slice<VelocityGradient>() ),
          _e( state.particles.template slice<SpecificInternalEnergy>() ),
          _extra( sliceOfDrift<ExtraVelocity>( state ) ),
          _expansion( sliceOfDrift<LastExpansion>( state ) ),
          _next_expansion( sliceOfDrift<NextExpansion>( state ) ),
          _next_x( state.particles.template next<Position>() ),
          _next_V( state.particles.template next<Volume>() ),
          _next_C( state.particles.template next<VelocityGradient>().slice ),
          _next_e(
              state.particles.template next<SpecificInternalEnergy>().slice )
    {
    }

    //! From here on slices of the particles are at the half step.
    void reach( State<Dim>& state ) const
    {
        if ( !_is_taken )
            return;
        state.particles.template reached<Position, Volume>();
        if ( on_hats )
            state.particles
                .template reached<VelocityGradient, SpecificInternalEnergy>();
    }

    //! Moves a pack, if there is such a half.
    //! \param[out] x [Dim], volume where it is then
    //! \param[out] expansion NextExpansion, 0 without such a half
    //! \return its volume before
    KOKKOS_FORCEINLINE_FUNCTION Lanes operator()( const Pack p,
                                                  VectorOf<Dim, Lanes>& x,
                                                  Lanes& volume,
                                                  Lanes& expansion ) const
    {
        x = loadVector<Dim>( _x, p );
        const Lanes volume_before = volume = load( _old_V, p );
        expansion = Lanes( 0.0 );
        if ( !_is_taken )
            return volume_before;
        expansion = load( _next_expansion, p );
        Lanes heat( 0.0 );
        VectorOf<Dim, Lanes> way{};
        for ( int b = 0; b < Dim; ++b )
        {
            const Lanes before = x[b];
            way[b] = _half * ( load( _v, p, b ) + load( _extra, p, b ) );
            const Lanes after = x[b] = before + way[b];
            store( _next_x, after, p, b );
            if constexpr ( on_hats )
            {
                const Lanes moment = momentAt<Basis, Dim>( _grid, before, b );
                const Lanes moment_new =
                    momentAt<Basis, Dim>( _grid, after, b );
                const Lanes factor = slopeFactor<Basis>( moment, moment_new );
                for ( int a = 0; a < Dim; ++a )
                {
                    const Lanes slope = load( _old_C, p, a, b );
                    const Lanes kept = asDeviation( slope * factor );
                    store( _next_C, kept, p, a, b );
                    heat += 0.5_rt * ( slope * slope * moment -
                                       kept * kept * moment_new );
                }
            }
        }
        _note.lookAtMove( p, way );
        if constexpr ( on_hats )
            store( _next_e, load( _e, p ) + heat, p );
        volume /= driftFactor( _half, load( _expansion, p ) );
        store( _next_V, volume, p );
        return volume_before;
    }

  private:
    template <std::size_t M>
    using Old =
        decltype( std::declval<State<Dim>>().particles.template slice<M>() );
    template <std::size_t M>
    using Next =
        decltype( std::declval<State<Dim>>().particles.template next<M>() );
    template <std::size_t M>
    using Drift =
        decltype( sliceOf<M>( std::declval<Sidecar<DriftMembers<Dim>>*>() ) );

    Watch<Dim> _note;
    Grid<Dim> _grid;
    Real _half;
    bool _is_taken;
    Old<Position> _x;
    Old<Velocity> _v;
    Old<Volume> _old_V;
    Old<VelocityGradient> _old_C;
    Old<SpecificInternalEnergy> _e;
    Drift<ExtraVelocity> _extra;
    Drift<LastExpansion> _expansion;
    Drift<NextExpansion> _next_expansion;
    Next<Position> _next_x;
    Next<Volume> _next_V;
    // Read again by the kernel that asks, so they stay in the cache.
    Old<VelocityGradient> _next_C;
    Old<SpecificInternalEnergy> _next_e;
};

} // namespace Impl
} // namespace Machpoint

#endif
