/*!
  \file study_run.hpp
  \brief Layer 7: what reading a study and making one of its runs share:
  settings, lines, and names of errors; for the sources of drivers/study_input
  alone.
*/
#ifndef MACHPOINT_STUDY_RUN_HPP
#define MACHPOINT_STUDY_RUN_HPP

#include <drivers/study_input.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

//! The setting that is no part of the input.
inline constexpr auto solver_key = "solver";

//! The programs that a study can run, by name; machpoint first.
extern const std::vector<std::string> solver_names;

//! Puts a setting into an input. \param path as in --set \throws InputError
//! where the input has no such place
void setValue( Json& input, const std::string& path, const Json& value );

//! The name of the line of a run with these settings.
//! \param settings path -> value
std::string lineOf( const Json& settings, const Study& study );

//! Has each line a name of its own?
bool areLinesTold( const std::vector<StudyRun>& runs );

//! Errors against a solution over the domain, as `field.norm`.
std::vector<std::string> fieldErrors();

//! Columns of the modules' series and of the probes. \param input resolved
//! \param probes resolved
std::vector<std::string> columnErrors( const Json& input, const Json& probes );

} // namespace Machpoint

#endif
