/*!
  \file modules.hpp
  \brief Every physics module and initial state: one line each.
*/
#ifndef MACHPOINT_PHYSICS_MODULES_HPP
#define MACHPOINT_PHYSICS_MODULES_HPP

#include <core/registry.hpp>

#include <physics/artificial_viscosity.hpp>
#include <physics/gravity.hpp>
#include <physics/ideal_gas.hpp>
#include <physics/initial/hydrostatic.hpp>
#include <physics/initial/riemann.hpp>
#include <physics/initial/uniform.hpp>
#include <physics/stiffened_gas.hpp>

#include <tuple>

namespace Machpoint
{

// clang-format off
using PhysicsModules = ModuleList<
    IdealGas,
    StiffenedGas,
    ArtificialViscosity,
    Gravity
>;

using InitialStates = std::tuple<
    Uniform,
    Riemann,
    Hydrostatic
>;
// clang-format on

} // namespace Machpoint

#endif
