/*!
  \file dry_run.hpp
  \brief Layer 7: what a run would take, without making it.
*/
#ifndef MACHPOINT_DRY_RUN_HPP
#define MACHPOINT_DRY_RUN_HPP

#include <drivers/companion.hpp>
#include <drivers/run.hpp>

namespace Machpoint
{

//! The first steps of a run.
struct Calibration
{
    std::vector<std::int64_t> cells; //!< [Dim]
    double fineness = 0;             //!< 1 / smallest spacing, 1/length
    std::int64_t first = 0;          //!< particles at the start, of all ranks
    std::vector<StepCost> costs;     //!< at least one
    double bytes_per_particle = 0;   //!< of all ranks
};

//! All steps of a run on a coarser grid.
struct Rung : Calibration
{
    double fixed =
        0; //!< steps whatever the grid: of start and outputs, at most
    //! Particles at the end, and at most, of all ranks.
    std::int64_t last = 0, most = 0;
    double seconds = 0; //!< set-up included
};

//! What a run is expected to be.
struct Forecast
{
    double steps = 0; //!< up to the end
    //! Particles at the end, and at most, of all ranks.
    double last = 0, most = 0;
    double seconds = 0; //!< of all steps, without outputs
};

/*!
  \brief The run that these rungs lead to.

  Steps are linear in the fineness, through the two finest rungs: some whatever
  the grid (none up to the finest rung's `fixed`; these, where the rungs tell
  nothing), the others by the time step. A calibration on the run's own grid
  bounds them from below: what it has taken, and as many for each step that the
  finest rung takes from there on as for each up to there, at least one. The
  number of particles grows as on the finest rung, and so does the time per
  particle and step from that of the calibration to that of the whole run.

  \param rungs at least one, coarsest first
  \param fineness of the grid, 1/length
  \param first particles at the start, of all ranks
*/
Forecast forecast( const std::vector<Rung>& rungs, double fineness,
                   double first, const Calibration& calibration );

/*!
  \brief Prints the time, steps, particles, memory and output that a run of the
  input would take on this machine, on so many ranks and threads; what it took,
  where its first steps are all of it. Writes no file. Collective.
  \return finished \throws InputError, NumericalFailure
*/
ExitCode dryRun( const Json& input );

} // namespace Machpoint

#endif
