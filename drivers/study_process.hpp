/*!
  \file study_process.hpp
  \brief Layer 7: a run of this program as a process of its own.
*/
#ifndef MACHPOINT_STUDY_PROCESS_HPP
#define MACHPOINT_STUDY_PROCESS_HPP

#include <core/types.hpp>

#include <filesystem>
#include <string>

namespace Machpoint
{

//! How a process ended.
struct ProcessResult
{
    int code = 0;            //!< exit code; 128 + signal if one ended it
    Real cpu_seconds = 0;    //!< of all threads, user and system
    std::string first_words; //!< its first line of output, for a message
};

/*!
  \brief While it lives, SIGINT and SIGTERM end the running process instead of
  this one.
*/
class ProcessGuard
{
  public:
    ProcessGuard();
    ~ProcessGuard();
    ProcessGuard( const ProcessGuard& ) = delete;

    //! Was the end asked for?
    bool isInterrupted() const;

    /*!
      \brief `machpoint run INPUT --output DIR --overwrite --quiet`, by this
      very executable.
      \param log file for what it prints; removed where it succeeds
      \throws IoError when no process can be started
    */
    ProcessResult run( const std::filesystem::path& input,
                       const std::filesystem::path& output,
                       const std::filesystem::path& log ) const;

  private:
    void ( *_int )( int );
    void ( *_term )( int );
};

} // namespace Machpoint

#endif
