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
//! measure); velocity by the length of its error vector (docs/method.md,
//! section 10).
struct FieldError
{
    std::string field; //!< as in summary.json
    //! \name In the field's unit, L1 times length^Dim, L2 times its root
    //! @{
    double L1 = 0, L2 = 0, Linf = 0;
    //! @}
};

//! Specific internal energy of an exact state, energy/mass, by the equation of
//! state of a resolved input; 0 in vacuum. \throws std::invalid_argument: see
//! gasLaw
double exactEnergy( const Json& input, const GasState& state );

/*!
  \brief Errors of the particles of all ranks against the exact solution.

  1D: a particle stands for what is nearer to it than to its neighbours, the
  outermost ones for a cell at most towards the ends of the domain; 2D and 3D:
  particle volumes. Collective.
  \param own this rank's particles
  \param input resolved \param t time of the data
  \return of density, velocity, pressure and specific internal energy
  \throws std::invalid_argument: see gasLaw
*/
std::vector<FieldError> measureErrors( const ParticleData& own,
                                       const ExactSolution& exact,
                                       const Json& input, double t );

//! Largest resident memory of this process so far, bytes.
std::int64_t peakMemory();

//! What the driver alone knows of a run, over all ranks.
struct RunFacts
{
    std::string ended;                  //!< how: summary.json's key
    Totals initial;                     //!< at the run's true start
    std::int64_t particles_initial = 0; //!< likewise
    std::int64_t particle_updates = 0;  //!< particles moved, over all steps
    //! After set-up, in all processes that the run had, s.
    double wall_seconds = 0;
    double process_seconds = 0;     //!< of these, since the last restart
    double first_step_seconds = 0;  //!< of this process
    Traffic traffic;                //!< this rank's
    Traffic first_step_traffic;     //!< of this, until the first step's end
    std::vector<FieldError> errors; //!< empty: there is no exact solution
};

//! The content of summary.json; its keys are a contract (add, never rename).
//! Collective; of effects and phases each rank tells its own.
Json makeSummary( Simulation& simulation, const Json& input,
                  const RunFacts& facts );

//! The table at the end of a run.
std::string formatSummary( const Json& summary );

} // namespace Machpoint

#endif
