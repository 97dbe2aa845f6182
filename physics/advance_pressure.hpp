/*!
  \file advance_pressure.hpp
  \brief Half-step pressure of the gases with p + p_inf ~ rho^gamma on an
  isentrope.
*/
#ifndef MACHPOINT_ADVANCE_PRESSURE_HPP
#define MACHPOINT_ADVANCE_PRESSURE_HPP

#include <core/module.hpp>
#include <core/power.hpp>

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
    const int n = state.particles.size();
    forEachPack(
        "Machpoint::advancePressure", n,
        KOKKOS_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            const Lanes q = load( viscous, p );
            const Lanes J =
                Kokkos::max( 1 + time * load( expansion, p ), Lanes( 0.2 ) );
            const Lanes advanced =
                ( load( pressure, p ) - q + p_inf ) * power( J, -gamma ) -
                ( gamma - 1 ) * time * q * load( divergence, p ) / J;
            store( pressure, Kokkos::max( advanced, Lanes( 0.0 ) ) - p_inf + q,
                   p );
        } );
}

} // namespace Impl
} // namespace Machpoint

#endif
