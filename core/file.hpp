/*!
  \file file.hpp
  \brief Layer 6: files that are whole or absent, and failures of the disk that
  all ranks learn of.
*/
#ifndef MACHPOINT_FILE_HPP
#define MACHPOINT_FILE_HPP

#include <core/communicator.hpp>
#include <core/errors.hpp>

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace Machpoint
{

/*!
  \brief A file or directory that could not be read or written.

  The message names the file, the operation, the system's reason and a remedy.
*/
class IoError : public std::runtime_error, public KnownError
{
  public:
    using std::runtime_error::runtime_error;

    /*!
      \param[in] file What was being read, written or listed.
      \param[in] operation What failed, e.g. "cannot create the file".
      \param[in] error The errno of the failure; 0 when there is none.
    */
    IoError( const std::filesystem::path& file, const std::string& operation,
             int error );

    //! The same error, thrown on every rank.
    static IoError onAll( const std::string& message )
    {
        IoError error( message );
        error._on_all_ranks = true;
        return error;
    }
    //! Do all ranks throw it? Otherwise the others still wait for this one.
    bool isOnAllRanks() const { return _on_all_ranks; }

  private:
    bool _on_all_ranks = false;
};

/*!
  \brief Runs an action on every rank, and ends it alike on all of them.

  Collective. The action may be one that only some ranks do. What else than an
  IoError an action throws is its rank's alone, which then has to end the others
  (Communicator::abort): they wait for it.
  \throws IoError on every rank, that of the first rank whose action threw one
*/
template <class Action>
void together( const Communicator& ranks, Action&& action )
{
    std::string message;
    bool failed = false;
    try
    {
        std::forward<Action>( action )();
    }
    catch ( const IoError& error )
    {
        message = error.what();
        failed = true;
    }
    const int first =
        static_cast<int>( ranks.min( failed ? ranks.rank() : ranks.size() ) );
    if ( first == ranks.size() )
        return;
    if ( first != ranks.rank() )
        message.clear();
    const auto text =
        ranks.gatherAll( std::vector<char>( message.begin(), message.end() ) );
    throw IoError::onAll( { text.begin(), text.end() } );
}

//! The same for an action of the root alone.
template <class Action>
void onRoot( const Communicator& ranks, Action&& action )
{
    together( ranks,
              [&]
              {
                  if ( ranks.isRoot() )
                      std::forward<Action>( action )();
              } );
}

//! Is it called as what a run writes at a step: `<step>.h5`, with eight digits
//! to eighteen?
bool isStepFile( const std::filesystem::path& file );

//! The name under which a file is written before it is whole: `<target>.tmp`.
std::filesystem::path temporaryName( const std::filesystem::path& target );

/*!
  \brief Writes a whole file or none: beside the target, forced to the disk,
  renamed. One rank. \throws IoError
*/
void writeFile( const std::filesystem::path& target, const void* data,
                std::size_t size );

/*!
  \brief Makes the file of the temporary name, and takes `size` bytes of the
  disk for it. One rank.

  File systems that cannot do so are believed to have room. \throws IoError
*/
void requireRoom( const std::filesystem::path& target, std::size_t size );

//! The same for a file that is there, and stays as long as it is. \throws
//! IoError, and then it is still there: HDF5 may have it open.
void reserveFile( const std::filesystem::path& target, std::size_t size );

//! Can this rank write to the file of the temporary name, too? That stays.
//! \throws IoError
void requireReachable( const std::filesystem::path& target );

//! Gives the room of the file of the temporary name back, if it is there.
void emptyTemporary( const std::filesystem::path& target );

//! Removes the file of the temporary name, if it is there.
void dropTemporary( const std::filesystem::path& target );

//! Forces the file of the temporary name to the disk, without what is reserved
//! beyond its end, and gives it its final name. One rank. \throws IoError, and
//! then neither file is there
void finishFile( const std::filesystem::path& target );

//! Removes a file, also under its temporary name, if it is there.
//! \throws IoError
void removeFile( const std::filesystem::path& file );

//! Makes a directory and its parents. \throws IoError
void makeDirectory( const std::filesystem::path& directory );

/*!
  \brief Keeps other programs that lock a directory out of it, and is gone with
  this one, however that ends. One rank.

  It leaves nothing in the directory. File systems without locks (flock(2)) are
  believed to be free.
*/
class DirectoryLock
{
  public:
    //! Of no directory.
    DirectoryLock() = default;
    //! \param directory which exists; one that cannot be opened is not locked
    //! \throws IoError another lock holds it
    explicit DirectoryLock( const std::filesystem::path& directory );
    DirectoryLock( DirectoryLock&& other ) noexcept
        : _file( std::exchange( other._file, -1 ) )
    {
    }
    DirectoryLock& operator=( DirectoryLock&& other ) noexcept
    {
        std::swap( _file, other._file );
        return *this;
    }
    ~DirectoryLock();

    //! Of a directory?
    bool isHeld() const { return _file >= 0; }

  private:
    int _file = -1;
};

} // namespace Machpoint

#endif
