/*!
  \file study_probe.hpp
  \brief Layer 7: numbers that a study reads off the grid outputs of its runs,
  alike for particles and for finite volumes.
*/
#ifndef MACHPOINT_STUDY_PROBE_HPP
#define MACHPOINT_STUDY_PROBE_HPP

#include <core/parameters.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace Machpoint
{

//! The kinds of probes.
Family probeFamily();

//! What a probe tells, as `name.column`. \param probe resolved
std::string probeColumn( const Json& probe );

//! Places of a probe that have not as many coordinates as the scene has axes,
//! by key. \param probe resolved
std::vector<std::string> misfitPlaces( const Json& probe, int dimension );

/*!
  \brief Means of all probes over the grid outputs of the second half of a run,
  as `name.column` -> number; null where none of them shows what is looked for.
  \param folder of a run \param probes resolved \throws IoError
*/
Json probeMeans( const std::filesystem::path& folder, const Json& probes );

} // namespace Machpoint

#endif
