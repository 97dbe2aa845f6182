/*!
  \file output.hpp
  \brief What a run leaves on disk: HDF5 files, XDMF collections, summary.

  The layer knows host arrays only. Every file is written beside its final
  name and renamed once it is whole and on the disk, so neither a kill nor a
  full disk leaves something half-written that looks finished.
*/
#ifndef MACHPOINT_CORE_OUTPUT_HPP
#define MACHPOINT_CORE_OUTPUT_HPP

#include <core/archive.hpp>
#include <core/communicator.hpp>
#include <core/file.hpp>
#include <core/hdf5_file.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace Machpoint
{

//! What happens to the results of a run that a directory holds already.
enum class FormerRun
{
    refuse,  //!< the directory is not taken
    replace, //!< they are removed, and nothing else
    go_on    //!< this run is its continuation
};

//! \param remedy ahead of "another directory with --output DIR"
//! \throws IoError If the directory holds a run.
void requireNoRun( const std::filesystem::path& directory, const char* remedy );

/*!
  \brief The output directory of one run.

  Files: `particles/<step>.h5`, `grid/<step>.h5`, `exact/<step>.h5` (the step
  in 8 digits), `particles.xdmf` and `grid.xdmf` (one temporal collection each,
  for ParaView), `series/<name>.csv` and, last, `summary.json`. All members
  throw IoError when the disk refuses, on all ranks alike, and
  std::invalid_argument when the caller passes data that does not fit the
  layout.

  All ranks make one and call its members together. Particles and grids are
  written by all ranks into one file, everything else by the root.
*/
class OutputDirectory
{
  public:
    /*!
      \brief Creates the directory and its parents, or takes an existing one.

      Nothing but a probe file is written, so that a wrong path shows before
      the run starts. Other runs are kept out of it as long as this exists.

      \param[in] directory Where the run writes.
      \param[in] former What to do with what a former run wrote there.
      \param[in] dimension 1, 2 or 3.
      \param[in] needs_fields Will particles or grids be written? Without them a
      build without HDF5 can run, too.
      \param[in] compression Of the HDF5 files: 0 (none) to 9.
      \param[in] lock Of the directory, the root's, where it is taken already.
      \throws IoError If the directory holds another run, or one is writing
      there, if it cannot be made or written to, or if this build lacks HDF5
      (several ranks: a parallel one).
    */
    OutputDirectory( const std::filesystem::path& directory, FormerRun former,
                     int dimension, bool needs_fields = true,
                     int compression = 0, DirectoryLock lock = {} );

    //! The directory.
    const std::filesystem::path& path() const { return _directory; }

    /*!
      \brief Writes `particles/<step>.h5` and renews `particles.xdmf`, which
      beyond 100 outputs may lack the last hundredth until the next checkpoint
      or the summary.

      In 1D the file also gets `xdmf/position [n][2]`, the positions with a zero
      beside each, because ParaView takes no points on a line.

      \param[in] step, time Attributes of the file.
      \param[in] datasets This rank's particles: scalars `[n]` and vectors
      `[n][Dim]`; one is `position [n][Dim]`, real. The file has those of rank 0
      first, then those of rank 1, ...
    */
    void writeParticles( std::int64_t step, double time,
                         const std::vector<Dataset>& datasets );

    /*!
      \brief Writes `grid/<step>.h5` and renews `grid.xdmf` likewise.

      \param[in] step, time Attributes of the file.
      \param[in] lower `[Dim]`, the first node's position, x first.
      \param[in] spacing `[Dim]`, the distance between nodes, x first.
      \param[in] datasets Scalars `[nz][ny][nx]` (as many axes as dimensions,
      x last) and vectors `[nz][ny][nx][Dim]`; on several ranks a block each.
    */
    void writeGrid( std::int64_t step, double time,
                    const std::vector<double>& lower,
                    const std::vector<double>& spacing,
                    const std::vector<Dataset>& datasets );

    /*!
      \brief Writes `exact/<step>.h5`, the exact solution of a 1D scene.

      \param[in] step, time Attributes of the file.
      \param[in] datasets `position`, `density`, `velocity`, `pressure` and
      `specific_internal_energy`, each `[n]`, the same on all ranks.
    */
    void writeExact( std::int64_t step, double time,
                     const std::vector<Dataset>& datasets );

    /*!
      \brief Writes a table as comma-separated values with a header line.

      \param[in] name `series/<name>.csv`.
      \param[in] columns The header.
      \param[in] rows `[rows][columns]`, written with every digit; the root's.
    */
    void writeSeries( const std::string& name,
                      const std::vector<std::string>& columns,
                      const std::vector<std::vector<double>>& rows );

    //! Writes `summary.json`. To be called last: its presence says that the
    //! run ended in an orderly way.
    void writeSummary( const std::string& json_text );

    /*!
      \brief Writes which outputs there are, or reads it.

      After reading, the directory is as it was then: outputs and a summary that
      came later are removed, and the .xdmf files list what is there.
      \throws ArchiveError if the archive lacks them; nothing is removed then
    */
    void checkpoint( Archive& archive );

    //! What checkpoint() writes and reads.
    static constexpr std::array<const char*, 2> entries = {
        "outputs/grid", "outputs/particles" };

  private:
    // A file below the directory, written by the root.
    void writeText( const std::filesystem::path& name,
                    const std::string& text ) const;
    // One HDF5 file, with `time` and `step` put before the other attributes.
    void writeStep( const std::string& kind, std::int64_t step, double time,
                    std::vector<Dataset> attributes,
                    const std::vector<Dataset>& datasets ) const;

    using Entries = std::map<std::int64_t, std::string>;
    // What an .xdmf file lists.
    struct Collection
    {
        Entries entries;        // XDMF of the outputs so far, by step
        std::size_t listed = 0; // of them in the file
    };

    // The .xdmf file lists all outputs up to 100, and then all but the last
    // hundredth: written anew for each, many would take their number squared.
    void renew( const std::string& kind, Collection& collection );
    // It lists all.
    void complete( const std::string& kind, Collection& collection );
    std::map<std::string, Collection*> collections();
    // Makes files and entries agree, and the .xdmf file.
    void takeUp( const std::string& kind, Collection& collection );
    // The first half of it; on the root.
    void removeLater( const std::string& kind, Entries& entries ) const;

    Communicator _ranks;
    std::filesystem::path _directory;
    DirectoryLock _lock; // of the root
    int _dimension;
    int _compression;
    Collection _particles, _grid;
};

} // end namespace Machpoint

#endif // MACHPOINT_CORE_OUTPUT_HPP
