#include <drivers/study_process.hpp>

#include <core/file.hpp>

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <vector>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

volatile std::sig_atomic_t interrupted = 0;
volatile std::sig_atomic_t running = 0; // process, 0: none

extern "C" void passOn( int )
{
    interrupted = 1;
    if ( running > 0 )
        kill( running, SIGTERM );
}

//! The first line that says something.
std::string firstWords( const fs::path& log )
{
    const std::string speaker = "machpoint: ";
    std::ifstream stream( log );
    std::string line;
    while ( std::getline( stream, line ) )
        if ( !line.empty() )
            return line.substr( line.starts_with( speaker ) ? speaker.size()
                                                            : 0 );
    return "";
}

//! The environment, without what makes a process believe that mpirun or srun
//! started it: its MPI would wait for them.
std::vector<char*> environmentOfOne()
{
    std::vector<char*> variables;
    for ( char** entry = environ; *entry; ++entry )
    {
        const std::string text = *entry;
        const bool is_launchers =
            text.starts_with( "OMPI_" ) || text.starts_with( "PMIX_" ) ||
            text.starts_with( "PMI_" ) || text.starts_with( "MPI_LOCAL" );
        if ( !is_launchers )
            variables.push_back( *entry );
    }
    variables.push_back( nullptr );
    return variables;
}

} // namespace

fs::path executable( const Solver solver )
{
    // Under its own name even where its file has been replaced meanwhile.
    constexpr auto self = "/proc/self/exe";
    return solver == Solver::machpoint
               ? fs::path( self )
               : fs::read_symlink( self ).parent_path() / "machpoint_reference";
}

ProcessGuard::ProcessGuard()
{
    interrupted = 0;
    _int = std::signal( SIGINT, passOn );
    _term = std::signal( SIGTERM, passOn );
    _usr1 = std::signal( SIGUSR1, SIG_IGN ); // which asks for a checkpoint
}

ProcessGuard::~ProcessGuard()
{
    std::signal( SIGINT, _int );
    std::signal( SIGTERM, _term );
    std::signal( SIGUSR1, _usr1 );
}

bool ProcessGuard::isInterrupted() const
{
    return interrupted != 0;
}

ProcessResult ProcessGuard::run( const Solver solver, const fs::path& input,
                                 const fs::path& output,
                                 const fs::path& log ) const
{
    const auto program = executable( solver );
    std::vector<std::string> words = { "machpoint", "run", "--quiet" };
    if ( solver == Solver::finite_volume )
        words = { program.filename().string(), "--cfl", finite_volume_cfl };
    words.insert( words.end(), { input.string(), "--output", output.string(),
                                 "--overwrite" } );
    std::vector<char*> arguments;
    for ( auto& word : words )
        arguments.push_back( word.data() );
    arguments.push_back( nullptr );
    auto environment = environmentOfOne();

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init( &files );
    posix_spawn_file_actions_addopen( &files, STDIN_FILENO, "/dev/null",
                                      O_RDONLY, 0 );
    posix_spawn_file_actions_addopen( &files, STDOUT_FILENO, log.c_str(),
                                      O_WRONLY | O_CREAT | O_TRUNC, 0666 );
    posix_spawn_file_actions_adddup2( &files, STDOUT_FILENO, STDERR_FILENO );
    pid_t process = 0;
    const int error = posix_spawn( &process, program.c_str(), &files, nullptr,
                                   arguments.data(), environment.data() );
    posix_spawn_file_actions_destroy( &files );
    if ( error != 0 )
        throw IoError( log, "cannot start a run that prints to the file",
                       error );

    running = process;
    // A signal between the start and this line has met nobody.
    if ( interrupted )
        kill( process, SIGTERM );
    int status = 0;
    rusage usage{};
    while ( wait4( process, &status, 0, &usage ) < 0 && errno == EINTR )
        ;
    running = 0;

    ProcessResult result;
    result.code =
        WIFEXITED( status ) ? WEXITSTATUS( status ) : 128 + WTERMSIG( status );
    auto seconds = []( const timeval& time )
    {
        return static_cast<double>( time.tv_sec ) +
               1e-6 * static_cast<double>( time.tv_usec );
    };
    result.cpu_seconds = seconds( usage.ru_utime ) + seconds( usage.ru_stime );
    result.peak_memory = static_cast<std::int64_t>( usage.ru_maxrss ) * 1024;
    result.first_words = firstWords( log );
    if ( result.code == 0 )
        removeFile( log );
    return result;
}

} // namespace Machpoint
