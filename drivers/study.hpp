/*!
  \file study.hpp
  \brief Layer 7: `machpoint study`: what accuracy costs in time, and what
  effects cost.
*/
#ifndef MACHPOINT_STUDY_HPP
#define MACHPOINT_STUDY_HPP

#include <drivers/run.hpp>

#include <string>

namespace Machpoint
{

//! What the command line adds to a study.
struct StudyOptions
{
    std::string output; //!< directory; empty: `out/studies/<study>`
    std::string target; //!< NAME=VALUE of an error that is to be reached
    std::string budget; //!< time that is to be used, as in 20s, 3min, 1h
    std::string clock = "wall"; //!< or "processor": what counts as time
    bool dry_run = false;       //!< name the runs and end
};

/*!
  \brief Runs what a study file asks for, writes study.json and study.csv after
  each run, and prints what they tell. Runs that are in study.json are not
  repeated.
  \return finished; numerical_failure when every run failed, or when a target or
  budget is out of reach; stopped_early after SIGINT or SIGTERM
  \throws InputError, IoError
*/
ExitCode runStudy( const std::string& file, const StudyOptions& options );

} // namespace Machpoint

#endif
