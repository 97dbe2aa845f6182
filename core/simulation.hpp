/*!
  \file simulation.hpp
  \brief A run as its driver sees it, whatever its dimension, basis and method.
*/
#ifndef MACHPOINT_SIMULATION_HPP
#define MACHPOINT_SIMULATION_HPP

#include <core/archive.hpp>
#include <core/balance.hpp>
#include <core/errors.hpp>
#include <core/series.hpp>
#include <core/survey.hpp>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

//! \name Steps during which the time step is shortened, and to which part
//! A discontinuous start has no divergence yet for the viscosity to see.
//! @{
constexpr int start_up_steps = 10;
constexpr double start_up_factor = 0.2;
//! @}

//! Steps from one look at the time step that the particles' arrangement allows
//! to the next: it takes them dozens to be another one.
constexpr int stability_every = 4;

//! Sums over all particles.
struct Totals
{
    double mass = 0;
    Vector3 momentum{}; //!< components beyond Dim are 0
    //! \name Energies; the affine part is kinetic energy within a particle
    //! @{
    double internal = 0, kinetic = 0, affine = 0;
    //! @}
    //! Of all three kinds.
    double energy() const { return internal + kinetic + affine; }
};

//! What crossed the edges of the domain on any rank.
struct LedgerTotals
{
    //! \name As in Ledger
    //! @{
    double mass_in = 0, mass_out = 0, energy_in = 0;
    //! @}
};

//! This rank's particles on the host, for output and errors. Row-major; units
//! as of Member, density mass/length^Dim. The pressure is without q.
struct ParticleData
{
    std::vector<Real> position, velocity; //!< [n][Dim]
    std::vector<Real> mass, volume, density, pressure,
        specific_internal_energy; //!< [n]
    std::vector<std::int64_t> id; //!< [n]
};

//! This rank's block of node data on the host, for output. Row-major, x last.
struct GridData
{
    std::vector<std::size_t> shape;        //!< [nz][ny][nx]
    std::vector<std::size_t> global_shape; //!< the same of the whole domain
    std::vector<std::size_t> start;        //!< of the block in the whole
    //! Position of the whole's first node, and distance of neighbours, length.
    //! [Dim], x first
    std::vector<double> lower, spacing;
    //! [nz][ny][nx]
    std::vector<Real> density, pressure, specific_internal_energy;
    std::vector<Real> velocity; //!< [nz][ny][nx][Dim]
};

//! A run in progress. On many ranks totals and counts are those of all ranks,
//! and step, totals, ledger and the data for output are collective.
class Simulation
{
  public:
    virtual ~Simulation() = default;

    //! One time step, not beyond `until`. \throws NumericalFailure; with
    //! `time.retries` above 0 the state is then the last good one
    virtual void step( double until ) = 0;

    virtual int dimension() const = 0;
    //! Of the state as it is; that of the input, not of the clock.
    virtual double time() const = 0;
    //! Length of the last step, time; 0 before the first.
    virtual double timeStep() const = 0;
    //! Steps done since the run's true start.
    virtual std::int64_t steps() const = 0;
    virtual std::int64_t particles() const = 0;
    //! What limited the last time step: "wave speed", the name of a module,
    //! "stability", "a repeated step" or "output time".
    virtual const std::string& limiter() const = 0;
    //! Memory of all ranks' particles over their number, bytes; 0 without any.
    //! Collective.
    virtual double bytesPerParticle() const = 0;

    //! Of the state as it is.
    virtual Totals totals() const = 0;
    //! Of the states at the start of every step, and of what was surveyed last.
    virtual Extrema extrema() const = 0;
    //! Takes the state as it is into the extrema, until the next step starts:
    //! the last one starts none. Collective. \throws NumericalFailure where it
    //! is broken; then it is that of the step before, if `time.retries` keeps
    //! one
    virtual void surveyExtrema() = 0;
    //! Steps that were rejected and repeated with half the time step.
    virtual std::int64_t retries() const = 0;
    //! What entered, left and was done since the run's true start.
    virtual LedgerTotals ledger() const = 0;
    //! How evenly the ranks share the work. Collective.
    virtual Imbalance imbalance() = 0;
    //! Does gas enter or leave, so that energy cannot balance?
    virtual bool isOpen() const = 0;
    //! Is momentum along this axis free of walls, obstacles and forces?
    virtual bool conservesMomentum( int axis ) const = 0;

    //! \name Data for output; derived fields are brought up to date
    //! @{
    virtual ParticleData particleData() = 0;
    virtual GridData gridData() = 0;
    virtual std::vector<const Series*> series() const = 0;
    //! @}

    //! Writes all that the next steps depend on and what was recorded so far,
    //! or reads it into a run of the same input. \throws ArchiveError
    virtual void checkpoint( Archive& archive ) = 0;
};

//! Makes a run from a resolved input. \throws InputError
template <int Dim, class Basis, class Method>
std::unique_ptr<Simulation> makeSimulation( const Json& input );

//! The same for the dimension, basis and method that the input names.
//! \throws InputError when this build lacks them
std::unique_ptr<Simulation> makeSimulation( const Json& input );

} // namespace Machpoint

#endif
