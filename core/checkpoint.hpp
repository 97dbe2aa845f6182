/*!
  \file checkpoint.hpp
  \brief Layer 6: archives on the disk, to go on with a run.

  A checkpoint is one HDF5 file, `<step, 8 digits>.h5`. Attributes:
  `machpoint_checkpoint` (its format), `time`, `step` and `checksum`. Datasets:
  `header`, a JSON text with the revision, the resolved input and the types of
  the entries; `shared/<name>`, what all ranks share; `rows/<name>`, the rows of
  rank 0, then those of rank 1, ...; `rows_of_ranks`, how many each rank had.
*/
#ifndef MACHPOINT_CHECKPOINT_HPP
#define MACHPOINT_CHECKPOINT_HPP

#include <core/archive.hpp>
#include <core/communicator.hpp>
#include <core/parameters.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace Machpoint
{

//! Of the files that this program writes, and the only one that it reads.
constexpr std::int64_t checkpoint_format = 4;

/*!
  \brief Writes a checkpoint, whole or not at all. Collective.
  \param folder where it goes; it is made
  \param input resolved
  \param archive written; holds the real `time` and the integer `step`
  \return the file
  \throws IoError; former checkpoints are whole then
*/
std::filesystem::path writeCheckpoint( const Communicator& ranks,
                                       const std::filesystem::path& folder,
                                       const Json& input,
                                       const Archive& archive );

//! An archive to read, and where it comes from.
struct Checkpoint
{
    std::filesystem::path file; //!< that was read
    Archive archive;      //!< which reads rows from the file as it is asked
    std::string revision; //!< that wrote it
    //! Newer files of the folder, which could not be read.
    std::vector<std::filesystem::path> passed_over;
    std::vector<std::string> complaints; //!< why, a line each
};

/*!
  \brief Reads a checkpoint of a run of this input. Collective.

  As many ranks as wrote it get back their own rows, else each gets as many as
  the others. `time.end`, `output`, `checkpoint` and `decomposition` of the
  input may differ.
  \throws IoError when the file cannot be read, is no checkpoint or is damaged
  \throws InputError when its format, its precision or its input is another
  one
*/
Checkpoint readCheckpoint( const Communicator& ranks,
                           const std::filesystem::path& file,
                           const Json& input );

//! The same for the newest one of a folder that can be read.
//! \throws IoError when there is none \throws InputError as above, of the
//! newest whose file is sound
Checkpoint readNewestCheckpoint( const Communicator& ranks,
                                 const std::filesystem::path& folder,
                                 const Json& input );

//! Removes all checkpoints of a folder but the last ones. One rank.
//! \param keep how many \throws IoError
void keepCheckpoints( const std::filesystem::path& folder, std::size_t keep );

//! Adds `.unread` to the names of files that were passed over, as what kept
//! them from being read may pass. One rank. \throws IoError
void setAside( const std::vector<std::filesystem::path>& files );

//! Removes the checkpoints of later steps, and what is left of one that a
//! killed run was writing. One rank. \throws IoError
void removeCheckpointsAfter( const std::filesystem::path& folder,
                             std::int64_t step );

} // namespace Machpoint

#endif
