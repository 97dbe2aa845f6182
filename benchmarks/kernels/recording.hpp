/*!
  \file recording.hpp
  \brief What is measured: a periodic box of smooth flow, advanced by one
  method, basis and order of particles, and the seconds of each part of its
  steps.
*/
#ifndef MACHPOINT_BENCHMARKS_RECORDING_HPP
#define MACHPOINT_BENCHMARKS_RECORDING_HPP

#include <core/types.hpp>

#include <map>
#include <string>
#include <vector>

namespace Machpoint
{

//! One setting of the matrix.
struct Case
{
    std::string method; //!< paper, apic, conservative_symplectic, .._midpoint
    std::string basis;
    int dim;
    int per_cell;
    //! ordered: a lattice, as it was placed. mixed: at random places in their
    //! cells and shuffled in memory before the first step; the code's own sort
    //! is on. unsorted: the same with the sort off.
    std::string order;

    std::string name() const;
    //! Is there such a part?
    bool has( const std::string& part ) const;
};

//! Sizes of all cases.
struct Sizes
{
    //! Of a case, about: a GPU must have work for all its threads, and more
    //! than its cache holds.
    int particles = runs_on_host ? 1 << 16 : 1 << 22;
    int cycles = 1;  //!< of a sample: times `sort_every` steps
    int samples = 3; //!< after one to warm up
};

//! Some steps.
struct Sample
{
    Real seconds = 0;                  //!< of a step
    std::map<std::string, Real> parts; //!< seconds of a step, by part
};

//! All that is measured of a case.
struct Recording
{
    std::vector<Sample> samples;
    Real particles = 0;      //!< on all ranks
    int sort_every = 0;      //!< steps
    int particle_bytes = 0;  //!< of the AoSoA alone, for one particle
    Real bytes_held = 0;     //!< for one particle, copies and sidecars included
    Real halo_bytes = 0;     //!< sent in a step by one rank
    Real migrated_bytes = 0; //!< the same
};

//! The parts of a step that are measured by themselves, and `other`, which is
//! the rest of it. What ranks tell each other, `halo` and `migrate`, lies
//! within them.
const std::vector<std::string>& partNames();

//! Runs a case. Collective. \throws NumericalFailure, and InputError where
//! there are too many ranks
Recording record( const Case& setting, const Sizes& sizes );

} // namespace Machpoint

#endif
