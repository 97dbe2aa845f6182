/*!
  \file report.hpp
  \brief Layer 6: what a run says of itself: errors against the exact solution,
  the summary, and the end table.
*/
#ifndef MACHPOINT_REPORT_HPP
#define MACHPOINT_REPORT_HPP

#include <core/exact.hpp>
#include <core/simulation.hpp>
#include <core/traffic.hpp>

#include <string>

namespace Machpoint
{

//! Norms of one field's error, integrated over the domain (not divided by its
//! measure); velocity by the length of its error vector.
struct FieldError
{
    std::string field;
    double L1 = 0, L2 = 0, Linf = 0;
};

//! Specific internal energy of an exact state, by the equation of state of a
//! resolved input; 0 in vacuum. \throws std::invalid_argument: see gasLaw
double exactEnergy( const Json& input, const GasState& state );

/*!
  \brief Errors of the particles of all ranks against the exact solution.

  1D: trapezoid of sorted positions, the ends of the domain included; 2D and
  3D: particle volumes. Collective.
  \param own this rank's particles
  \param input resolved \param t time of the data
*/
std::vector<FieldError> measureErrors( const ParticleData& own,
                                       const ExactSolution& exact,
                                       const Json& input, double t );

//! Largest resident memory of this process so far, bytes.
std::int64_t peakMemory();

//! What the driver alone knows of a run, over all ranks.
struct RunFacts
{
    Totals initial;
    std::int64_t particles_initial = 0;
    std::int64_t particle_updates = 0; //!< particles moved, over all steps
    double wall_seconds = 0;
    double process_seconds = 0;    //!< of these, since the last restart
    double first_step_seconds = 0; //!< of this process
    Traffic traffic;               //!< this rank's
    Traffic first_step_traffic;    //!< of this, until the first step's end
    std::vector<FieldError> errors;
};

//! The content of summary.json; its keys are a contract (add, never rename).
//! Collective; of effects and phases each rank tells its own.
Json makeSummary( Simulation& simulation, const Json& input,
                  const RunFacts& facts );

//! The table at the end of a run.
std::string formatSummary( const Json& summary );

} // namespace Machpoint

#endif
