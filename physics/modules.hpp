/*!
  \file modules.hpp
  \brief Every physics module and initial state: one line each.
*/
#ifndef MACHPOINT_PHYSICS_MODULES_HPP
#define MACHPOINT_PHYSICS_MODULES_HPP

#include <core/registry.hpp>

#include <physics/artificial_viscosity.hpp>
#include <physics/gravity.hpp>
#include <physics/heat_conduction.hpp>
#include <physics/ideal_gas.hpp>
#include <physics/initial/acoustic_wave.hpp>
#include <physics/initial/blast.hpp>
#include <physics/initial/hydrostatic.hpp>
#include <physics/initial/isentropic_vortex.hpp>
#include <physics/initial/kelvin_helmholtz.hpp>
#include <physics/initial/noh.hpp>
#include <physics/initial/rayleigh_taylor.hpp>
#include <physics/initial/riemann.hpp>
#include <physics/initial/shu_osher.hpp>
#include <physics/initial/taylor_green.hpp>
#include <physics/initial/two_blasts.hpp>
#include <physics/initial/uniform.hpp>
#include <physics/initial/viscous_shock.hpp>
#include <physics/stiffened_gas.hpp>
#include <physics/viscosity.hpp>

#include <tuple>

namespace Machpoint
{

// clang-format off
//! All effects of this repository, in the order of `machpoint list`.
using PhysicsModules = ModuleList<
    IdealGas,
    StiffenedGas,
    ArtificialViscosity,
    Gravity,
    NewtonianViscosity,
    HeatConduction
>;

//! All initial states, likewise.
using InitialStates = std::tuple<
    Uniform,
    Riemann,
    Hydrostatic,
    Blast,
    IsentropicVortexState,
    AcousticWaveState,
    Noh,
    ShuOsher,
    TwoBlasts,
    TaylorGreen,
    KelvinHelmholtz,
    RayleighTaylor,
    ViscousShockState
>;
// clang-format on

} // namespace Machpoint

#endif
