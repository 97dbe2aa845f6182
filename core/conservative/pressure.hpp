/*!
  \file pressure.hpp
  \brief `conservative`: the pressure that exerts force and does work, and the
  velocity of nodes that follows from it (docs/conservative.md, sections 1, 3
  and 4).
*/
#ifndef MACHPOINT_CONSERVATIVE_PRESSURE_HPP
#define MACHPOINT_CONSERVATIVE_PRESSURE_HPP

#include <core/conservative/faces.hpp>
#include <core/power.hpp>

namespace Machpoint
{
namespace Impl
{

//! How the pressure that exerts force and does work differs from the
//! particles'.
struct WorkingGas
{
    Viscosity viscosity;
    PressureResponse response;
    Real ahead;    //!< time that it is ahead of the particles' state
    Real spacing;  //!< h
    Real blending; //!< kb

    //! q = rho phi h |D| (c1 c + c2 h |D|) of compressed gas, 0 elsewhere.
    KOKKOS_FORCEINLINE_FUNCTION Lanes viscous( const Lanes& divergence,
                                               const Lanes& limiter,
                                               const Lanes& density,
                                               const Lanes& sound ) const
    {
        if ( !viscosity.acts )
            return Lanes( 0.0 );
        return -spacing * density * divergence *
               viscosity.speed( divergence, limiter, sound, spacing );
    }

    /*!
      \brief p + q after `ahead` of isentropic change, and q's heat:
      p + K ((1 + a)^-g - 1) - gruneisen q a + q with K = rho c^2 / g and
      a = max(-.6, ahead D_h). A pressure below vacuum is vacuum's, p - K.
      \param p, density, sound the particle's at the step's start
      \param expansion D_h, 1/time
    */
    KOKKOS_FORCEINLINE_FUNCTION Lanes pressure( const Lanes& p, const Lanes& q,
                                                const Lanes& density,
                                                const Lanes& sound,
                                                const Lanes& expansion ) const
    {
        if ( ahead == 0 )
            return p + q;
        const Lanes growth = Kokkos::max( ahead * expansion, Lanes( -0.6 ) );
        const Lanes K = density * sound * sound * ( 1 / response.exponent );
        const Lanes advanced = K * powerNearOne( growth, -response.exponent ) -
                               response.gruneisen * q * growth;
        return Kokkos::max( advanced, Lanes( 0.0 ) ) + ( p - K ) + q;
    }

    //! kb phi h max(-D, 0) / c, 0 without sound.
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION Number blend( const Number& divergence,
                                              const Number& limiter,
                                              const Number& sound ) const
    {
        const Number zero( 0.0 );
        return choose( zero < sound,
                       Number( blending * spacing * limiter *
                               Kokkos::max( Number( -divergence ), zero ) /
                               sound ),
                       zero );
    }
};

/*!
  \brief v_i = (mv)_i / m_i on nodes, 0 where there is no gas, and 1 - beta_i
  with the blend beta_i = min(1, beta_0 + kb-sum / m_i).
  \param blend beta_0
  \param state of whose nodes.velocities columns 0 to Dim - 1 and 2 Dim are set
*/
template <int Dim>
void velocityAndBlend( const State<Dim>& state, const NodeRows& rows,
                       const Real blend )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const Real own = 1 - blend;
    rows.forEach(
        "Machpoint::gridVelocity",
        MACHPOINT_LAMBDA( const int i ) MACHPOINT_INLINE {
            const Real per_mass = perMass( 1, moments( i, 0 ) );
            for ( int d = 0; d < Dim; ++d )
                velocities( i, d ) = moments( i, 1 + d ) * per_mass;
            velocities( i, 2 * Dim ) = Kokkos::max(
                0.0_rt, own - moments( i, blend_column<Dim> ) * per_mass );
        } );
}

/*!
  \brief v'_i = v_i + dt f_i / m_i (Algorithm 1, line 5) with the pressure's
  force f_(i,a) = h^Dim / h_a (p^a_(i-1/2) - p^a_(i+1/2)). The force telescopes,
  so momentum is exact. p^a_f = sum / max(theta, least filling).
  \param state of whose nodes.velocities columns Dim to 2 Dim - 1 are set
*/
template <int Dim>
void applyPressure( const State<Dim>& state, const Real least_filling )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const auto inverse = state.grid.inverse;
    const Real dt = state.dt;
    const Real cell_volume = state.grid.cellVolume();
    forEach(
        "Machpoint::applyPressure", layout.total,
        MACHPOINT_LAMBDA( const int i ) MACHPOINT_INLINE {
            // Of the faces before and behind the node along each axis; one
            // after the other their divisions would take longer than memory.
            Real pressure[2 * Dim], filling[2 * Dim];
            for ( int f = 0; f < 2 * Dim; ++f )
            {
                const int a = f / 2;
                const int row = i - ( f % 2 == 0 ? layout.stride[a] : 0 );
                const int known = Kokkos::max( row, 0 ); // 0 ahead of the first
                pressure[f] = row < 0
                                  ? 0.0_rt
                                  : moments( known, pressure_column<Dim> + a );
                filling[f] = Kokkos::max(
                    moments( known, theta_column<Dim> + a ), least_filling );
            }
            for ( int f = 0; f < 2 * Dim; ++f )
                pressure[f] /= filling[f];
            const Real per_mass = perMass( 1, moments( i, 0 ) );
            for ( int a = 0; a < Dim; ++a )
            {
                const Real force = cell_volume * inverse[a] *
                                   ( pressure[2 * a] - pressure[2 * a + 1] );
                velocities( i, Dim + a ) =
                    velocities( i, a ) + dt * force * per_mass;
            }
        } );
}

} // namespace Impl
} // namespace Machpoint

#endif
