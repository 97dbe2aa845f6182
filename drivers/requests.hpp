/*!
  \file requests.hpp
  \brief Layer 7: when a run writes a checkpoint, and when it ends early.
*/
#ifndef MACHPOINT_REQUESTS_HPP
#define MACHPOINT_REQUESTS_HPP

#include <core/communicator.hpp>
#include <core/simulation.hpp>

#include <filesystem>
#include <optional>
#include <string>

namespace Machpoint
{

//! What is due after a step; the larger one counts.
enum class Request : int
{
    none,       //!< goes on
    checkpoint, //!< write one and go on
    stop        //!< write one and end
};

/*!
  \brief Asks for checkpoints as the input says; while it lives, SIGUSR1 asks
  for one, and SIGINT, SIGTERM and the stop file ask for the end. A second
  SIGINT or SIGTERM half a second or more after one that no step has heeded ends
  the process at once.
*/
class Requests
{
  public:
    //! Forgets signals that came before.
    //! \param ranks which must outlive it
    //! \param checkpoint of a resolved input \param stop_file a path
    Requests( const Communicator& ranks, const Json& checkpoint,
              std::filesystem::path stop_file );
    ~Requests();
    Requests( const Requests& ) = delete;

    //! Does the input ask for checkpoints?
    bool isScheduled() const
    {
        return _every_steps || _every_time || _every_wall_seconds;
    }
    //! The run starts, or goes on, at this time.
    void start( double time );
    //! What is due after a step. Collective, and the same on all ranks.
    Request next( const Simulation& simulation );
    //! A checkpoint is written: the clock starts anew.
    void checkpointed();
    //! What asked for the end, for a message.
    const std::string& reason() const { return _reason; }
    //! Removes the stop file: it has had its effect.
    void finish() const;

  private:
    Request own( const Simulation& simulation );
    bool seesStopFile();

    const Communicator& _ranks;
    std::optional<std::int64_t> _every_steps;
    std::optional<double> _every_time;
    std::optional<double> _every_wall_seconds;
    std::filesystem::path _stop_file;
    std::string _reason;
    double _time = 0;     // of the last step
    Kokkos::Timer _clock; // since the last checkpoint
    Kokkos::Timer _since_start;
    double _next_look = 0; // for the stop file, s since the start
    void ( *_int )( int );
    void ( *_term )( int );
    void ( *_usr1 )( int );
};

} // namespace Machpoint

#endif
