/*!
  \file run.hpp
  \brief Layer 7: a run from resolved input to summary.
*/
#ifndef MACHPOINT_RUN_HPP
#define MACHPOINT_RUN_HPP

#include <core/parameters.hpp>

#include <cstdint>
#include <limits>
#include <string>

namespace Machpoint
{

//! Exit codes of the program.
enum ExitCode
{
    finished = 0,
    numerical_failure = 1, //!< the gas broke down, or an unexpected error
    wrong_input = 2,       //!< or a wrong command line
    stopped_early = 3,     //!< by a signal or the stop file
    io_failure = 4         //!< the disk refused
};

//! What the command line adds to the input.
struct RunOptions
{
    std::string output;          //!< directory; empty: `out/<scene>`
    bool overwrite = false;      //!< replace a former run's output
    bool quiet = false;          //!< no progress and no end table
    bool estimate_error = false; //!< by companion runs on coarser grids
    std::string restart;         //!< checkpoint to go on from, "latest" or none
    //! Those before a restart count, too.
    std::int64_t max_steps = std::numeric_limits<std::int64_t>::max();
};

//! Points of an exact profile that goes with each output of particles in 1D.
inline constexpr std::size_t profile_points = 2001;

/*!
  \brief Runs a resolved input to its end, on all ranks together.
  \return on all ranks: finished, also when max_steps ended it; stopped_early,
  with a checkpoint, after SIGINT, SIGTERM or the stop file; numerical_failure
  when the gas broke down
  \throws InputError, IoError
*/
ExitCode run( const Json& input, const RunOptions& options );

} // namespace Machpoint

#endif
