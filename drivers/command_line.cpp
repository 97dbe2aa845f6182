/*!
  \file command_line.cpp
  \brief The program: its options, what they ask for, and how it ends.
*/
#include <drivers/command_line.hpp>

#include <drivers/catalogue.hpp>
#include <drivers/dry_run.hpp>
#include <drivers/input.hpp>
#include <drivers/launch.hpp>
#include <drivers/run.hpp>
#include <drivers/study.hpp>
#include <drivers/tell.hpp>
#include <drivers/warnings.hpp>

#include <core/communicator.hpp>
#include <core/kokkos_session.hpp>
#include <core/output.hpp>
#include <core/revision.hpp>
#include <core/simulation.hpp>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <new>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace Machpoint
{

namespace
{

//! What this build is and stands on, a name and its value a line.
std::string versionText()
{
    return fmt::format( "machpoint {}\nrevision {}\nbackend {}\n"
                        "precision {}\n{}",
                        version, revision, ExecutionSpace::name(),
                        precision_name, libraries );
}

constexpr auto out_of_memory =
    "out of memory; take fewer cells or particles per cell";

//! Of an option's text: that of an unset shell variable is none.
const CLI::Validator
    not_empty( []( const std::string& text )
               { return text.empty() ? "must not be empty" : std::string(); },
               "" );

//! Makes an option's text one that CLI11 reads as it is meant: to it a number
//! that begins with 0 is octal, and one beyond the limit is the limit.
const CLI::Validator whole_number(
    []( std::string& text )
    {
        constexpr auto most = std::numeric_limits<std::int64_t>::max();
        std::int64_t number = 0;
        const char* end = text.data() + text.size();
        const auto [rest, error] = std::from_chars( text.data(), end, number );
        if ( error != std::errc() || rest != end || number < 0 )
            return fmt::format( "must be a whole number from 0 to {}, not "
                                "\"{}\"",
                                most, text );
        text = std::to_string( number );
        return std::string();
    },
    "" );

//! What `action` returns on the root, which alone calls it, on every rank; and
//! its errors, which then end all alike. \throws InputError
template <class Action>
Json ofRoot( const Communicator& ranks, const Action& action )
{
    if ( ranks.size() == 1 )
        return action();
    Json answer;
    if ( ranks.isRoot() )
        try
        {
            answer["result"] = action();
        }
        catch ( const InputError& error )
        {
            answer["errors"] = error.messages();
        }
    // A path may hold bytes that are no text.
    const auto text =
        answer.dump( -1, ' ', false, Json::error_handler_t::replace );
    answer = Json::parse( ranks.fromRoot( text ) );
    if ( answer.contains( "errors" ) )
        throw InputError( answer.at( "errors" ) );
    return answer.at( "result" );
}

//! Calls what the root alone does, likewise.
template <class Action>
void byRoot( const Communicator& ranks, const Action& action )
{
    ofRoot( ranks,
            [&]
            {
                action();
                return Json();
            } );
}

//! What `action` returns; its errors, which show only when a scene is built,
//! get the file's name.
template <class Action>
auto named( const std::string& file, const Action& action )
{
    try
    {
        return action();
    }
    catch ( const InputError& error )
    {
        auto messages = error.messages();
        for ( auto& message : messages )
            message = fmt::format( "{}: {}", file, message );
        throw InputError( messages );
    }
}

//! Validates an input, and warns.
void check( const std::string& file, const std::vector<std::string>& overrides )
{
    const Json input = loadInput( file, overrides );
    for ( const auto& warning :
          named( file, [&] { return findWarnings( input ); } ) )
        tell( "{}: warning: {}\n", file, warning );
    fmt::print( "{}: ok\n", file );
}

//! `run` and `check`, which have to have Kokkos.
int execute( const Communicator& ranks, const CLI::App& app,
             const std::string& file, const std::vector<std::string>& overrides,
             const RunOptions& options, const bool is_dry )
{
    if ( app.got_subcommand( "run" ) )
    {
        // A file that only the root's node has will do.
        const Json input =
            ofRoot( ranks, [&] { return loadInput( file, overrides ); } );
        return named(
            file,
            [&] { return is_dry ? dryRun( input ) : run( input, options ); } );
    }
    byRoot( ranks, [&] { check( file, overrides ); } );
    return finished;
}

//! `list`, `describe` and `schema`.
void answer( const CLI::App& app, const std::string& name )
{
    if ( app.got_subcommand( "list" ) )
        listEntries( "" );
    else if ( app.got_subcommand( "describe" ) )
        describeByName( name );
    else
        fmt::print( "{}\n", inputSchema().dump( 2 ) );
}

//! Runs a study, whose runs are processes of their own: this one needs no
//! Kokkos, and takes no memory of a device.
int study( const Communicator& ranks, const std::string& file,
           const StudyOptions& options )
{
    if ( ranks.size() > 1 )
        throw InputError( { "machpoint study: is one process; start it without "
                            "mpirun" } );
    return runStudy( file, options );
}

//! Ends a rank upon a failure that the others may not have met: they would wait
//! for it for ever.
int endAlone( const Communicator& ranks, const ExitCode code )
{
    if ( ranks.size() > 1 )
        ranks.abort( code );
    return code;
}

int failAlone( const Communicator& ranks, const std::string& message,
               const ExitCode code )
{
    const auto place =
        ranks.size() > 1 ? fmt::format( "rank {}: ", ranks.rank() ) : "";
    tell( "machpoint: {}{}\n", place, message );
    return endAlone( ranks, code );
}

//! The same upon a failure that all ranks meet, or should. \param place where
//! the message does not name one
int failTogether( const Communicator& ranks, const std::string& message,
                  const ExitCode code, const char* place = "machpoint: " )
{
    if ( !ranks.allArrive() )
        return failAlone( ranks, message, code );
    if ( ranks.isRoot() )
        tell( "{}{}\n", place, message );
    return code;
}

//! Refuses what CLI11 takes for something else, or says too little of.
//! \throws CLI::ParseError
void requireWords( const CLI::App& app,
                   const std::vector<std::string>& arguments )
{
    for ( const auto& word : arguments )
    {
        if ( word == "--" )
            break;
        // Of an unset shell variable; CLI11 would take the next word instead.
        if ( word.starts_with( "--" ) && word.find( '=' ) == word.size() - 1 )
            throw CLI::ValidationError( word.substr( 0, word.size() - 1 ),
                                        "must not be empty" );
    }
    if ( arguments.empty() )
        return;
    const auto& first = arguments.front();
    auto refuse =
        [&first]( const char* kind, const std::vector<std::string>& known )
    {
        const auto near = nearest( first, known );
        throw CLI::ParseError(
            fmt::format( "unknown {} \"{}\"{}", kind, first,
                         near.empty() ? ""
                                      : "; did you mean \"" + near + "\"?" ),
            CLI::ExitCodes::ExtrasError );
    };
    if ( first.starts_with( "-" ) )
    {
        if ( !app.get_option_no_throw( first ) )
            refuse( "option", { "--help", "--version" } );
        return;
    }
    std::vector<std::string> commands;
    for ( const auto* command : app.get_subcommands( nullptr ) )
        commands.push_back( command->get_name() );
    if ( std::find( commands.begin(), commands.end(), first ) ==
         commands.end() )
        refuse( "command", commands );
}

//! \return code; of a stdout that takes nothing, which stderr is told, that of
//! a failure
int flushed( const int code )
{
    if ( std::fflush( stdout ) == 0 && !std::ferror( stdout ) )
        return code;
    tell( "machpoint: cannot write to stdout: {}\n", std::strerror( errno ) );
    return io_failure;
}

} // namespace

int runCommandLine( int argc, char** argv )
{
    // A file that grows beyond what `ulimit -f` allows is then an error of
    // write, as a full disk is.
    std::signal( SIGXFSZ, SIG_IGN );
    // So is a log whose reader has gone, as `tee` has after a Ctrl-C: the run
    // that it was of still writes its checkpoint and its summary.
    std::signal( SIGPIPE, SIG_IGN );
    const Communicator ranks;
    CLI::App app( "Material Point Method for compressible gas flow",
                  "machpoint" );
    app.set_version_flag( "--version", versionText() );
    app.require_subcommand( 1 );
    std::string file;
    std::vector<std::string> overrides;
    RunOptions options;
    auto addInput = [&]( CLI::App& command )
    {
        command.add_option( "INPUT", file, "JSON file of the scene" )
            ->required();
        command
            .add_option( "--set", overrides,
                         "override a value of the input: path=value" )
            ->take_all()
            ->allow_extra_args( false );
    };
    bool is_dry = false;
    auto& run_command = *app.add_subcommand( "run", "run a scene" );
    addInput( run_command );
    run_command
        .add_option( "--output", options.output,
                     "directory for the results (default out/<scene>)" )
        ->check( not_empty );
    run_command.add_flag( "--overwrite", options.overwrite,
                          "replace the results of a former run" );
    run_command
        .add_option( "--restart", options.restart,
                     "go on from a checkpoint: a file, or \"latest\" for the "
                     "newest one of the output directory" )
        ->type_name( "FILE" )
        ->check( not_empty );
    run_command
        .add_option( "--max-steps", options.max_steps, "end after step STEPS" )
        ->type_name( "STEPS" )
        ->transform( whole_number );
    run_command.add_flag(
        "--estimate-error", options.estimate_error,
        "run the scene on half and a quarter of the cells along each axis, "
        "too, and tell the discretisation error and its order" );
    run_command.add_flag( "--quiet", options.quiet, "no progress, no table" );
    auto& estimate = *run_command.add_flag(
        "--estimate", is_dry,
        "make no run, but tell the time and the memory that it would take on "
        "this machine" );
    for ( const auto* name : { "--output", "--overwrite", "--restart",
                               "--max-steps", "--quiet", "--estimate-error" } )
        estimate.excludes( run_command.get_option( name ) );
    addInput( *app.add_subcommand( "check", "validate a scene, and warn" ) );
    StudyOptions study_options;
    auto& study_command =
        *app.add_subcommand( "study", "what accuracy costs in time, and "
                                      "what effects cost" );
    study_command.add_option( "STUDY", file, "JSON file of the study" )
        ->required();
    study_command
        .add_option( "--output", study_options.output,
                     "directory for the results (default "
                     "out/studies/<study>)" )
        ->check( not_empty );
    study_command
        .add_option( "--target", study_options.target,
                     "find and run what is fastest with such an error, as in "
                     "density.L1=1e-3" )
        ->type_name( "NAME=VALUE" )
        ->check( not_empty );
    study_command
        .add_option( "--budget", study_options.budget,
                     "find and run what is most accurate within a time, as in "
                     "20s, 3min, 1h" )
        ->type_name( "TIME" )
        ->check( not_empty );
    study_command
        .add_option( "--clock", study_options.clock,
                     "what a run's time is: wall, or processor, which a busy "
                     "machine disturbs less" )
        ->check( CLI::IsMember( { "wall", "processor" } ) );
    study_command.add_flag( "--dry-run", study_options.dry_run,
                            "check the study and name its runs" );
    app.add_subcommand( "list", "list methods, bases, physics, boundaries, "
                                "shapes, initial and exact states" );
    app.add_subcommand( "describe",
                        "parameters of what `list` names, or one of them" )
        ->add_option( "NAME", file, "as in `list`, or a key" )
        ->required();
    app.add_subcommand( "schema", "JSON Schema of an input" );
    try
    {
        requireWords( app, { argv + std::min( argc, 1 ), argv + argc } );
        app.parse( argc, argv );
    }
    catch ( const CLI::ParseError& error )
    {
        // All ranks were given the same words.
        std::ostringstream nowhere;
        const int code = ranks.isRoot() ? app.exit( error )
                                        : app.exit( error, nowhere, nowhere );
        return code == 0 ? flushed( finished ) : wrong_input;
    }

    try
    {
        requireAllProcesses( ranks );
        if ( const auto fault = faultOfThreads(); !fault.empty() )
            return failAlone( ranks, fault, wrong_input );
        if ( study_command.parsed() )
            return flushed( study( ranks, file, study_options ) );
        std::optional<KokkosSession> kokkos;
        int code = finished;
        if ( app.got_subcommand( "run" ) || app.got_subcommand( "check" ) )
        {
            if ( const auto fault = startKokkos( kokkos ); !fault.empty() )
                return failAlone( ranks, fault, wrong_input );
            code = execute( ranks, app, file, overrides, options, is_dry );
        }
        else
            byRoot( ranks, [&] { answer( app, file ); } );
        return flushed( code );
    }
    catch ( const InputError& error )
    {
        return failTogether( ranks, error.what(), wrong_input, "" );
    }
    catch ( const NumericalFailure& failure )
    {
        return failTogether( ranks, failure.what(), numerical_failure );
    }
    catch ( const IoError& error )
    {
        if ( error.isOnAllRanks() )
            return failTogether( ranks, error.what(), io_failure );
        return failAlone( ranks, error.what(), io_failure );
    }
    catch ( const std::filesystem::filesystem_error& error )
    {
        // Of a path that cannot be looked at: too long, or links in a circle.
        return failAlone( ranks,
                          fmt::format( "{}: {}", error.path1().string(),
                                       error.code().message() ),
                          io_failure );
    }
    catch ( const std::system_error& error )
    {
        // Of fmt: a closed pipe or a full disk.
        tell( "machpoint: cannot write to stdout: {}\n",
              error.code().message() );
        return endAlone( ranks, io_failure );
    }
    catch ( const std::bad_alloc& )
    {
        return failAlone( ranks, out_of_memory, wrong_input );
    }
    catch ( const std::exception& error )
    {
        // Kokkos has no type for it.
        if ( std::string( error.what() ).find( "failed to allocate" ) !=
             std::string::npos )
            return failAlone( ranks, out_of_memory, wrong_input );
        return failAlone( ranks,
                          fmt::format( "unexpected error: {}", error.what() ),
                          numerical_failure );
    }
}

} // namespace Machpoint
