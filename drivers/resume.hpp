/*!
  \file resume.hpp
  \brief Layer 7: how a run goes on from a checkpoint of a former one.
*/
#ifndef MACHPOINT_RESUME_HPP
#define MACHPOINT_RESUME_HPP

#include <core/checkpoint.hpp>
#include <core/output.hpp>
#include <core/report.hpp>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace Machpoint
{

//! Can checkpoints be written?
bool hasHdf5( const Communicator& ranks );

//! What the summary tells of the run from its true start on.
void checkpointFacts( Archive& archive, RunFacts& facts );

//! The checkpoint that --restart names. Collective; the root tells what was
//! passed over. \param name a file or "latest" \param folder of checkpoints
//! \param input resolved \throws IoError, InputError: see readCheckpoint
Checkpoint findCheckpoint( const Communicator& ranks, const std::string& name,
                           const std::filesystem::path& folder,
                           const Json& input );

//! \throws InputError where the run is to end before its checkpoint
void requireLaterEnd( const Checkpoint& restart, double end,
                      std::int64_t max_steps );

//! Reads a checkpoint but for what the output directory has of it, and before
//! that removes anything. \param checkpoint visits an archive
//! \throws IoError where there is more in it, or less, or something else
void resume( Checkpoint& restart,
             const std::function<void( Archive& )>& checkpoint );

//! What to do with results that are in the output directory. Collective.
FormerRun formerRun( const Communicator& ranks,
                     const std::optional<Checkpoint>& restart,
                     const std::filesystem::path& directory, bool overwrite );

} // namespace Machpoint

#endif
