#include <drivers/output_times.hpp>
#include <drivers/requests.hpp>

#include <fmt/format.h>

#include <atomic>
#include <csignal>
#include <ctime>

namespace Machpoint
{

namespace
{

//! Seconds from one look for the stop file to the next: file systems of
//! clusters are slow, and steps can be fast.
constexpr double look_every = 0.02;

//! Seconds after which a further signal is one of its own: `timeout` and some
//! schedulers send one to a process and again to its group.
constexpr double same_signal = 0.5;

std::atomic<int> stop_signal{ 0 };
std::atomic<double> stop_time{ 0 };        // when it came
std::atomic<bool> is_stop_heeded{ false }; // by a step
std::atomic<bool> checkpoint_signal{ false };
static_assert( std::atomic<int>::is_always_lock_free &&
               std::atomic<bool>::is_always_lock_free &&
               std::atomic<double>::is_always_lock_free );

//! Seconds on a clock that a handler of signals may look at.
double monotonicSeconds()
{
    timespec now{};
    clock_gettime( CLOCK_MONOTONIC, &now );
    return static_cast<double>( now.tv_sec ) +
           1e-9 * static_cast<double>( now.tv_nsec );
}

void rememberSignal( const int signal )
{
    if ( signal == SIGUSR1 )
    {
        checkpoint_signal = true;
        return;
    }
    const double now = monotonicSeconds();
    if ( stop_signal == 0 || is_stop_heeded )
    {
        stop_time = now;
        is_stop_heeded = false;
        stop_signal = signal;
    }
    // No step has ended since: the run may be far from the next one's end.
    else if ( now - stop_time > same_signal )
    {
        std::signal( signal, SIG_DFL );
        std::raise( signal ); // delivered when this returns
    }
}

template <class T>
std::optional<T> optional( const Json& json, const char* key )
{
    if ( !json.contains( key ) )
        return {};
    return json.at( key ).get<T>();
}

} // namespace

Requests::Requests( const Communicator& ranks, const Json& checkpoint,
                    std::filesystem::path stop_file )
    : _ranks( ranks ),
      _every_steps( optional<std::int64_t>( checkpoint, "every_steps" ) ),
      _every_time( optional<double>( checkpoint, "every_time" ) ),
      _every_wall_seconds(
          optional<double>( checkpoint, "every_wall_seconds" ) ),
      _stop_file( std::move( stop_file ) )
{
    stop_signal = 0;
    is_stop_heeded = false;
    checkpoint_signal = false;
    _int = std::signal( SIGINT, &rememberSignal );
    _term = std::signal( SIGTERM, &rememberSignal );
    _usr1 = std::signal( SIGUSR1, &rememberSignal );
}

Requests::~Requests()
{
    std::signal( SIGINT, _int );
    std::signal( SIGTERM, _term );
    std::signal( SIGUSR1, _usr1 );
}

void Requests::start( const double time )
{
    _time = time;
    _clock.reset();
}

Request Requests::next( const Simulation& simulation )
{
    // Ranks may see a signal, the file or the clock at different steps.
    const auto request = static_cast<Request>( static_cast<int>(
        _ranks.max( static_cast<double>( own( simulation ) ) ) ) );
    _time = simulation.time();
    if ( request == Request::stop )
    {
        const int signal = static_cast<int>( _ranks.max( stop_signal ) );
        _reason =
            signal ? fmt::format( "signal {}", signal ) : _stop_file.string();
        is_stop_heeded = true;
    }
    return request;
}

Request Requests::own( const Simulation& simulation )
{
    if ( stop_signal || ( _ranks.isRoot() && seesStopFile() ) )
        return Request::stop;
    const bool is_due =
        ( _every_steps && simulation.steps() % *_every_steps == 0 ) ||
        ( _every_time && multiplesUpTo( simulation.time(), *_every_time ) >
                             multiplesUpTo( _time, *_every_time ) ) ||
        ( _every_wall_seconds && _clock.seconds() >= *_every_wall_seconds );
    return checkpoint_signal.exchange( false ) || is_due ? Request::checkpoint
                                                         : Request::none;
}

bool Requests::seesStopFile()
{
    const double now = _since_start.seconds();
    if ( now < _next_look )
        return false;
    _next_look = now + look_every;
    std::error_code error;
    return std::filesystem::exists( _stop_file, error );
}

void Requests::checkpointed()
{
    _clock.reset();
}

void Requests::finish() const
{
    std::error_code error;
    if ( _ranks.isRoot() )
        std::filesystem::remove( _stop_file, error );
}

} // namespace Machpoint
