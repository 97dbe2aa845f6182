/*!
  \file study_error.hpp
  \brief Layer 7: what a finished run is judged by. All of it comes from the
  files that the run left.
*/
#ifndef MACHPOINT_STUDY_ERROR_HPP
#define MACHPOINT_STUDY_ERROR_HPP

#include <core/parameters.hpp>
#include <drivers/grid_fields.hpp>

#include <filesystem>
#include <vector>

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

//! A grid output of a run.
struct GridOutput
{
    double time = 0;            //!< that of the scene
    std::filesystem::path file; //!< for readGrid
};

//! All of a run, in order. \throws IoError without any
std::vector<GridOutput> gridOutputs( const std::filesystem::path& folder );

//! The fields of a grid output. \throws IoError
GridFields readGrid( const std::filesystem::path& file );

/*!
  \brief Differences of the last grid outputs of two runs of one scene, as
  `field.norm` -> number.

  At the centres of the first one's cells: see fieldDifferences.
  \param folder, finer of runs \param input resolved, of the first
  \throws IoError
*/
Json gridErrors( const std::filesystem::path& folder,
                 const std::filesystem::path& finer, const Json& input );

/*!
  \brief By how much the last grid output of a run differs from that of
  another one, as `field.change` -> L1 of the difference over L1 of the other
  one's field; null where that is 0.

  Density, pressure and velocity; taken like gridErrors.
  \param folder, whole of runs \param input resolved, of the first
  \throws IoError
*/
Json gridChanges( const std::filesystem::path& folder,
                  const std::filesystem::path& whole, const Json& input );

} // namespace Machpoint

#endif
