/*!
  \file drift.hpp
  \brief The integrator `midpoint` of `conservative`: drift, kick, drift
  (docs/conservative.md, section 1).
*/
#ifndef MACHPOINT_CONSERVATIVE_DRIFT_HPP
#define MACHPOINT_CONSERVATIVE_DRIFT_HPP

#include <core/basis.hpp>
#include <core/module.hpp>
#include <core/soundness.hpp>

namespace Machpoint
{

//! What a particle remembers of its last step; zero for one that has just
//! entered.
template <int Dim>
using DriftMembers = Cabana::MemberTypes<Real[Dim], Real, Real>;

//! Names of the members.
enum DriftMember : std::size_t
{
    ExtraVelocity, //!< velocity of motion less v [Dim], length/time
    LastExpansion, //!< D of the last step, 1/time
    NextExpansion  //!< D over the filling of its v', 1/time
};

namespace Impl
{

//! Volume before a particle drifts for `time` over that after it: 1 - time D,
//! so that neither P2G nor G2P has to divide by it.
KOKKOS_FORCEINLINE_FUNCTION Lanes driftFactor( const Real time,
                                               const Lanes& last_expansion )
{
    return Kokkos::max( 1 - time * last_expansion, Lanes( 0.5 ) );
}

/*!
  \brief Half a step of motion and expansion at the rates of the last step:
  x += dt/2 U, V /= 1 - dt/2 D.

  Transfer, force and work then act at the half step, which makes the step
  second order in any dimension; see gatherParticles for the other half. A
  particle may stand up to half a cell outside the box meanwhile: the halo's
  nodes carry what it deposits to where its image belongs. On hats, what the
  affine energy loses becomes heat.
*/
template <class Basis, int Dim>
void driftParticles( State<Dim>& state, Sidecar<DriftMembers<Dim>>& drift )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto V = state.particles.template slice<Volume>();
    const auto extra = Cabana::slice<ExtraVelocity>( drift.data() );
    const auto expansion = Cabana::slice<LastExpansion>( drift.data() );
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto next_x = state.particles.template next<Position>();
    const auto next_V = state.particles.template next<Volume>();
    const auto next_C = state.particles.template next<VelocityGradient>();
    const auto next_e = state.particles.template next<SpecificInternalEnergy>();
    const auto note = watch( state, 0.5_rt );
    const auto grid = state.grid;
    const Real half = 0.5_rt * state.dt;
    const int n = state.particles.size();
    forEachPack(
        "Machpoint::driftParticles", n,
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            Lanes heat( 0.0 );
            VectorOf<Dim, Lanes> way{};
            store( next_V,
                   load( V, p ) / driftFactor( half, load( expansion, p ) ),
                   p );
            for ( int b = 0; b < Dim; ++b )
            {
                const Lanes before = load( x, p, b );
                way[b] = half * ( load( v, p, b ) + load( extra, p, b ) );
                const Lanes after = before + way[b];
                store( next_x, after, p, b );
                if ( !Basis::constant_moment )
                {
                    const Lanes moment =
                        momentAt<Basis, Dim>( grid, before, b );
                    const Lanes moment_new =
                        momentAt<Basis, Dim>( grid, after, b );
                    const Lanes factor =
                        slopeFactor<Basis>( moment, moment_new );
                    for ( int a = 0; a < Dim; ++a )
                    {
                        const Lanes slope = load( C, p, a, b );
                        store( next_C, slope * factor, p, a, b );
                        heat += 0.5_rt * slope * slope *
                                ( moment - factor * factor * moment_new );
                    }
                }
            }
            note.lookAtMove( p, way );
            if ( !Basis::constant_moment )
                store( next_e, load( e, p ) + heat, p );
        } );
    state.particles.template reached<Position, Volume>();
    if ( !Basis::constant_moment )
        state.particles
            .template reached<VelocityGradient, SpecificInternalEnergy>();
}

} // namespace Impl
} // namespace Machpoint

#endif
