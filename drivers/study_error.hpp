/*!
  \file study_error.hpp
  \brief Layer 7: what a finished run is judged by. All of it comes from the
  files that the run left.
*/
#ifndef MACHPOINT_STUDY_ERROR_HPP
#define MACHPOINT_STUDY_ERROR_HPP

#include <core/parameters.hpp>

#include <filesystem>

namespace Machpoint
{

//! A run's errors against the exact solution, as `field.norm` -> number.
Json exactErrors( const Json& summary );

/*!
  \brief Means of the columns of all series over the second half of the run,
  weighted by the time steps, as `name.column` -> number.
  \param folder of a run \throws IoError
*/
Json seriesMeans( const std::filesystem::path& folder );

/*!
  \brief Differences of the last grid outputs of two runs of one scene, as
  `field.norm` -> number.

  At the centres of the first one's cells: see fieldDifferences.
  \param folder, finer of runs \param input resolved, of the first
  \throws IoError
*/
Json gridErrors( const std::filesystem::path& folder,
                 const std::filesystem::path& finer, const Json& input );

} // namespace Machpoint

#endif
