/*!
  \file study_process.hpp
  \brief Layer 7: a run of this program as a process of its own.
*/
#ifndef MACHPOINT_STUDY_PROCESS_HPP
#define MACHPOINT_STUDY_PROCESS_HPP

#include <core/types.hpp>
#include <drivers/study_input.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace Machpoint
{

//! How a process ended.
struct ProcessResult
{
    int code = 0;                 //!< exit code; 128 + signal if one ended it
    double cpu_seconds = 0;       //!< of all threads, user and system
    std::int64_t peak_memory = 0; //!< bytes
    std::string first_words;      //!< its first line of output, for a message
};

//! Courant number of finite volumes in a study: that of the particles they are
//! held against. At their own of 0.4 they take twice the time, for errors a few
//! percent smaller.
inline constexpr const char* finite_volume_cfl = "0.8";

//! The program of a solver: this very executable, or the one beside it.
//! \throws std::filesystem::filesystem_error where the system does not tell
std::filesystem::path executable( Solver solver );

/*!
  \brief While it lives, SIGINT and SIGTERM end the running process instead of
  this one, and SIGUSR1 does nothing.
*/
class ProcessGuard
{
  public:
    //! Forgets signals that came before.
    ProcessGuard();
    ~ProcessGuard();
    ProcessGuard( const ProcessGuard& ) = delete;

    //! Was the end asked for?
    bool isInterrupted() const;

    /*!
      \brief `machpoint run INPUT --output DIR --overwrite --quiet`, or the same
      by another solver.
      \param log file for what it prints; removed where it succeeds
      \throws IoError when no process can be started
    */
    ProcessResult run( Solver solver, const std::filesystem::path& input,
                       const std::filesystem::path& output,
                       const std::filesystem::path& log ) const;

  private:
    void ( *_int )( int );
    void ( *_term )( int );
    void ( *_usr1 )( int );
};

} // namespace Machpoint

#endif
