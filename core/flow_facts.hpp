/*!
  \file flow_facts.hpp
  \brief Layer 4: what an input alone tells of the flow, so that an effect can
  say beforehand whether the scene will feel it.
*/
#ifndef MACHPOINT_FLOW_FACTS_HPP
#define MACHPOINT_FLOW_FACTS_HPP

#include <core/parameters.hpp>
#include <core/types.hpp>

#include <string>

namespace Machpoint
{

/*!
  \brief The start of a scene, before anything is built.

  `machpoint check` makes it up for the physics modules that have a `remark`
  (input_hooks.hpp).

  Of a gas whose law is not known here (findGasLaw) the start is not looked at:
  speed, disturbance and shock are those below.
*/
struct FlowFacts
{
    Json input;             //!< resolved
    int effects = 0;        //!< entries of `physics` less the equation of state
    Vector3 extent{};       //!< of the domain, 0 beyond its dimension, length
    double least_speed = 0; //!< of |v| + c, c the speed of sound, length/time
    //! Is the gas in one state everywhere, and will nothing but an effect
    //! disturb it?
    bool is_undisturbed = false;
    //! Where the gas sends off a shock, in words; empty: nothing tells of one.
    std::string shock;
    //! Do shocks in this method call for artificial viscosity?
    bool shocks_need_viscosity = true;
    //! Do waves that nothing damps grow in this method?
    bool waves_grow = false;
};

} // namespace Machpoint

#endif
