/*!
  \file companion.hpp
  \brief Layer 7: runs in memory that leave no files: coarser ones that tell of
  a run what it will cost, or how far it is from the truth.
*/
#ifndef MACHPOINT_COMPANION_HPP
#define MACHPOINT_COMPANION_HPP

#include <core/simulation.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace Machpoint
{

//! A time step and what it moved.
struct StepCost
{
    double seconds = 0;         //!< wall time of this rank
    std::int64_t particles = 0; //!< after the step, of all ranks
    double time = 0;            //!< after the step
};

//! Is a run to end at once?
using IsStopped = std::function<bool( const Simulation& )>;

/*!
  \brief Runs a simulation to a time, stopping at its input's output times
  without writing. Collective.
  \param input resolved \param end time
  \param stop asked after each step
  \return each step's cost; fewer steps when stopped \throws NumericalFailure
*/
std::vector<StepCost> stepTo( Simulation& simulation, const Json& input,
                              double end, const IsStopped& stop );

//! Cells along the axis that has most of them: what refines a grid.
//! \param input resolved
std::int64_t resolution( const Json& input );

/*!
  \brief The same scene with fewer cells along each axis.

  Short axes keep as many as every method can do with.
  \param input resolved \param factor > 1
*/
Json coarsened( const Json& input, std::int64_t factor );

/*!
  \brief Makes a run of a coarsened input. Collective.
  \param input resolved \param option that asks for it
  \throws InputError that names the option and the cells, where these are too
  few for the scene, or for so many ranks
*/
std::unique_ptr<Simulation> makeCompanion( const Json& input,
                                           const char* option );

} // namespace Machpoint

#endif
