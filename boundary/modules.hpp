/*!
  \file modules.hpp
  \brief Every boundary: one line each.
*/
#ifndef MACHPOINT_BOUNDARY_MODULES_HPP
#define MACHPOINT_BOUNDARY_MODULES_HPP

#include <core/registry.hpp>

#include <boundary/inflow.hpp>
#include <boundary/obstacle.hpp>
#include <boundary/outflow.hpp>
#include <boundary/periodic.hpp>
#include <boundary/recycle.hpp>
#include <boundary/walls.hpp>

namespace Machpoint
{

// clang-format off
//! All boundaries of this repository, in the order of `machpoint list`.
using BoundaryModules = ModuleList<
    SlipWall,
    NoSlipWall,
    Periodic,
    Inflow,
    Outflow,
    Recycle,
    Obstacle
>;
// clang-format on

} // namespace Machpoint

#endif
