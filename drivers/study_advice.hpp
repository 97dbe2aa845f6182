/*!
  \file study_advice.hpp
  \brief Layer 7: what the fits of a study advise, and what becomes of it.
*/
#ifndef MACHPOINT_STUDY_ADVICE_HPP
#define MACHPOINT_STUDY_ADVICE_HPP

#include <drivers/run.hpp>
#include <drivers/study_laboratory.hpp>

#include <string>

namespace Machpoint
{

/*!
  \name Finds a run by the fits, makes it, and prints both.
  \param laboratory whose runs have all been made
  \param error its name
  \return finished; numerical_failure where it is out of reach or was missed;
  stopped_early when interrupted
*/
//!@{

//! The fastest run with such an error. \param target most of the error
ExitCode reachTarget( Laboratory& laboratory, const std::string& error,
                      double target );

//! The most accurate run within such a time. \param budget seconds
ExitCode spendBudget( Laboratory& laboratory, const std::string& error,
                      double budget );
//!@}

} // namespace Machpoint

#endif
