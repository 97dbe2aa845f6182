/*!
  \file advance_pressure.hpp
  \brief Half-step pressure of the gases with p + p_inf ~ rho^gamma on an
  isentrope.
*/
#ifndef MACHPOINT_ADVANCE_PRESSURE_HPP
#define MACHPOINT_ADVANCE_PRESSURE_HPP

#include <core/module.hpp>

namespace Machpoint
{
namespace Impl
{

//! p = (p_0 + p_inf) J^-gamma - p_inf - (gamma - 1) time q D / J + q
//! (EquationOfState::advancePressure). A pressure below vacuum is vacuum's.
template <int Dim>
void advancePressure( const State<Dim>& state, const Real time,
                      const Real gamma, const Real p_inf )
{
    const auto pressure = state.particles.template slice<Pressure>();
    const auto divergence = Cabana::slice<Divergence>( state.rates->data() );
    const auto expansion = Cabana::slice<Expansion>( state.rates->data() );
    const auto viscous = Cabana::slice<ViscousPressure>( state.rates->data() );
    Kokkos::parallel_for(
        "Machpoint::advancePressure", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            const Real q = viscous( p );
            const Real J = Kokkos::max( 0.2, 1 + time * expansion( p ) );
            const Real advanced =
                ( pressure( p ) - q + p_inf ) * Kokkos::pow( J, -gamma ) -
                ( gamma - 1 ) * time * q * divergence( p ) / J;
            pressure( p ) = Kokkos::max( advanced, 0.0 ) - p_inf + q;
        } );
}

} // namespace Impl
} // namespace Machpoint

#endif
