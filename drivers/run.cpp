#include <drivers/run.hpp>

#include <drivers/error_estimate.hpp>
#include <drivers/output_times.hpp>
#include <drivers/requests.hpp>
#include <drivers/resume.hpp>
#include <drivers/tell.hpp>

#include <core/checkpoint.hpp>
#include <core/exact.hpp>
#include <core/hdf5_file.hpp>
#include <core/output.hpp>
#include <core/price.hpp>
#include <core/profile.hpp>
#include <core/report.hpp>
#include <core/simulation.hpp>
#include <core/traffic.hpp>

#include <fmt/format.h>

#include <unistd.h>

#include <filesystem>
#include <optional>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

//! One line that refreshes on a terminal and appends in a log.
class Progress
{
  public:
    //! \param begin, end times \param updates before this run went on
    Progress( const bool quiet, const double begin, const double end,
              const std::int64_t updates )
        : _quiet( quiet ), _terminal( isatty( STDERR_FILENO ) ),
          _begin( begin ), _end( end ), _updates( updates ),
          _updates_shown( updates )
    {
    }

    void show( const Simulation& s, const bool last )
    {
        const double now = _timer.seconds();
        // Often enough to see that it lives, seldom enough not to fill a log.
        if ( _quiet || ( !last && now - _shown < ( _terminal ? 0.2 : 10 ) ) )
            return;
        const double done = s.time() / _end;
        const std::int64_t moved = _updates - _updates_shown;
        const double rate =
            now > _shown ? static_cast<double>( moved ) / ( now - _shown ) : 0;
        const auto step =
            s.timeStep() > 0
                ? fmt::format( "dt {:.3g} by {} | ", s.timeStep(), s.limiter() )
                : std::string();
        tell( "{}step {} | t {:.6g} / {:.6g} ({:.1f} %) | {}"
              "{:.3g} M particle updates/s | ETA {:.0f} s{}",
              _terminal ? "\r\033[K" : "", s.steps(), s.time(), _end,
              100 * done, step, rate / 1e6,
              s.time() > _begin
                  ? now * ( _end - s.time() ) / ( s.time() - _begin )
                  : 0,
              _terminal && !last ? "" : "\n" );
        _shown = now;
        _updates_shown = _updates;
    }

    void count( const std::int64_t particles ) { _updates += particles; }
    std::int64_t updates() const { return _updates; }

  private:
    bool _quiet;
    bool _terminal;
    double _begin, _end;
    Kokkos::Timer _timer;
    double _shown = 0;
    std::int64_t _updates;
    std::int64_t _updates_shown;
};

std::vector<Dataset> particleDatasets( const ParticleData& data, const int dim )
{
    const std::size_t n = data.mass.size();
    auto scalar = [&]<class T>( const char* name, const std::vector<T>& values )
    {
        return Dataset{ name, { n }, values.data(), datasetType<T>() };
    };
    auto vector = [&]( const char* name, const std::vector<Real>& values )
    {
        auto dataset = scalar( name, values );
        dataset.shape.push_back( dim );
        return dataset;
    };
    return {
        vector( "position", data.position ),
        vector( "velocity", data.velocity ),
        scalar( "mass", data.mass ),
        scalar( "density", data.density ),
        scalar( "pressure", data.pressure ),
        scalar( "specific_internal_energy", data.specific_internal_energy ),
        scalar( "id", data.id ) };
}

std::vector<Dataset> gridDatasets( const GridData& data, const int dim )
{
    auto scalar = [&]( const char* name, const std::vector<Real>& values )
    {
        return Dataset{ name,
                        data.shape,
                        values.data(),
                        datasetType<Real>(),
                        data.global_shape,
                        data.start };
    };
    auto velocity = scalar( "velocity", data.velocity );
    velocity.shape.push_back( dim );
    velocity.global_shape.push_back( dim );
    velocity.start.push_back( 0 );
    return {
        scalar( "density", data.density ), scalar( "pressure", data.pressure ),
        scalar( "specific_internal_energy", data.specific_internal_energy ),
        velocity };
}

//! The exact solution of a 1D scene on a fine lattice, for pictures.
void writeExactProfile( OutputDirectory& directory, const Simulation& s,
                        const ExactSolution& exact, const Json& input )
{
    constexpr auto points = profile_points;
    const double lower = input.at( "grid" ).at( "lower" ).at( 0 );
    const double upper = input.at( "grid" ).at( "upper" ).at( 0 );
    std::vector<double> x( points ), rho( points ), v( points ), p( points ),
        e( points );
    for ( std::size_t k = 0; k < points; ++k )
    {
        x[k] = lower + ( upper - lower ) * static_cast<double>( k ) /
                           static_cast<double>( points - 1 );
        const auto state = exact.state( { x[k], 0, 0 }, s.time() );
        rho[k] = state.density;
        v[k] = state.velocity[0];
        p[k] = state.pressure;
        e[k] = exactEnergy( input, state );
    }
    directory.writeExact(
        s.steps(), s.time(),
        { { "position", { points }, x.data() },
          { "density", { points }, rho.data() },
          { "velocity", { points }, v.data() },
          { "pressure", { points }, p.data() },
          { "specific_internal_energy", { points }, e.data() } } );
}

} // namespace

ExitCode run( const Json& input, const RunOptions& options )
{
    const Communicator ranks;
    if ( options.estimate_error )
        requireCompanions( input );
    Profile::start();
    Kokkos::Timer timer;
    const auto scene = input.at( "scene" ).get<std::string>();
    const int dim = input.at( "dimension" );
    const double end = input.at( "time" ).at( "end" );
    const auto& output = input.at( "output" );
    const bool writes_particles = output.at( "particles" );
    const bool writes_grid = output.at( "grid" );
    const fs::path folder =
        options.output.empty() ? "out/" + scene : options.output;
    const auto checkpoints = folder / "checkpoints";
    Requests requests( ranks, input.at( "checkpoint" ), folder / "stop" );
    std::optional<Checkpoint> restart;
    DirectoryLock lock;
    if ( !options.restart.empty() )
    {
        // First of all: a run that is still writing there writes checkpoints.
        onRoot( ranks, [&] { lock = DirectoryLock( folder ); } );
        restart = findCheckpoint( ranks, options.restart, checkpoints, input );
        requireLaterEnd( *restart, end, options.max_steps );
    }
    auto simulation = makeSimulation( input );
    const auto exact = makeExact( input );
    RunFacts facts;
    facts.initial = simulation->totals();
    facts.particles_initial = simulation->particles();
    std::int64_t written = -1; // step of the last output
    auto checkpoint_run = [&]( Archive& archive )
    {
        simulation->checkpoint( archive );
        const Archive::Group group( archive, "run" );
        checkpointFacts( archive, facts );
        archive( "last_output", written );
    };
    if ( restart )
    {
        resume( *restart, checkpoint_run );
        simulation->surveyExtrema(); // it may be at its end
    }
    const auto former = formerRun( ranks, restart, folder, options.overwrite );
    OutputDirectory directory( folder, former, dim,
                               writes_particles || writes_grid ||
                                   requests.isScheduled(),
                               output.at( "compression" ), std::move( lock ) );
    auto write = [&]
    {
        Profile::Phase phase( "output" );
        const Traffic::Timer activity( Activity::output );
        simulation->surveyExtrema(); // nothing broken gets into a file
        if ( writes_particles )
            directory.writeParticles(
                simulation->steps(), simulation->time(),
                particleDatasets( simulation->particleData(), dim ) );
        if ( writes_grid )
        {
            const auto data = simulation->gridData();
            directory.writeGrid( simulation->steps(), simulation->time(),
                                 data.lower, data.spacing,
                                 gridDatasets( data, dim ) );
        }
        if ( exact && dim == 1 && writes_particles )
            writeExactProfile( directory, *simulation, *exact, input );
        for ( const auto* series : simulation->series() )
            directory.writeSeries( "series/" + series->name + ".csv",
                                   series->columns, series->rows );
        written = simulation->steps();
    };

    if ( restart )
    {
        directory.checkpoint( restart->archive );
        onRoot( ranks,
                [&]
                {
                    setAside( restart->passed_over );
                    removeCheckpointsAfter( checkpoints, simulation->steps() );
                } );
        if ( former != FormerRun::go_on )
            written = -1;
        if ( !options.quiet && ranks.isRoot() )
            tell( "machpoint: goes on from {}, t = {:.6g}\n",
                  restart->file.string(), simulation->time() );
    }
    else
    {
        write();
    }
    const double seconds_before = facts.wall_seconds;
    ExitCode code = finished;
    Progress progress( options.quiet || !ranks.isRoot(), simulation->time(),
                       end, facts.particle_updates );
    std::int64_t kept = -1; // step of the last checkpoint
    const bool can_keep = hasHdf5( ranks );
    auto keep = [&]
    {
        Profile::Phase phase( "checkpoint" );
        const Traffic::Timer activity( Activity::output );
        simulation->surveyExtrema();
        facts.wall_seconds = seconds_before + timer.seconds();
        facts.particle_updates = progress.updates();
        Archive archive;
        checkpoint_run( archive );
        directory.checkpoint( archive );
        writeCheckpoint( ranks, checkpoints, input, archive );
        onRoot( ranks,
                [&] {
                    keepCheckpoints( checkpoints,
                                     input.at( "checkpoint" ).at( "keep" ) );
                } );
        kept = simulation->steps();
        requests.checkpointed();
    };
    timer.reset();
    Traffic::start();
    requests.start( simulation->time() );
    OutputTimes outputs( input, simulation->time() );
    try
    {
        while ( simulation->time() < end &&
                simulation->steps() < options.max_steps )
        {
            const double next = outputs.next();
            simulation->step( next );
            if ( facts.first_step_seconds == 0 )
            {
                facts.first_step_seconds = timer.seconds();
                facts.first_step_traffic = Traffic::upToNow();
            }
            progress.count( simulation->particles() );
            progress.show( *simulation, false );
            if ( simulation->time() >= next )
            {
                outputs.pass();
                write();
            }
            const auto request = requests.next( *simulation );
            if ( request == Request::checkpoint && can_keep )
                keep();
            else if ( request == Request::checkpoint && ranks.isRoot() )
                tell( "machpoint: no checkpoint, as this build "
                      "lacks HDF5\n" );
            if ( request == Request::stop )
            {
                if ( simulation->time() < end )
                    code = stopped_early;
                else // it came during the last step
                    requests.finish();
                break;
            }
        }
        // Before what a full disk may keep from being written.
        if ( code == stopped_early )
            requests.finish();
        // What is written below is no output of an uninterrupted run.
        if ( ( code == stopped_early && can_keep ) ||
             ( simulation->time() < end && requests.isScheduled() &&
               kept != simulation->steps() ) )
            keep();
        if ( written != simulation->steps() )
            write();
    }
    catch ( const NumericalFailure& failure )
    {
        // Without retries there is no copy to return to: what is in memory is
        // broken, and the last output is the last good state.
        if ( input.at( "time" ).at( "retries" ) > 0 &&
             written != simulation->steps() )
            write();
        if ( ranks.isRoot() )
            tell( "\nmachpoint: {}\n{}\n", failure.what(),
                  written < 0
                      ? fmt::format( "It went on from {}, the last good state",
                                     restart->file.string() )
                      : fmt::format( "The last good state, that of step {}, "
                                     "is in {}",
                                     written, directory.path().string() ) );
        code = numerical_failure;
    }
    progress.show( *simulation, true );
    facts.ended = code == numerical_failure  ? "broken down"
                  : code == stopped_early    ? "stopped"
                  : simulation->time() < end ? "max steps"
                                             : "finished";
    facts.process_seconds = timer.seconds();
    facts.wall_seconds = seconds_before + facts.process_seconds;
    facts.traffic = Traffic::upToNow();
    facts.particle_updates = progress.updates();
    if ( exact && code != numerical_failure )
        facts.errors = measureErrors( simulation->particleData(), *exact, input,
                                      simulation->time() );
    Json summary = makeSummary( *simulation, input, facts );
    // Also written before companion runs: this run is done, whatever they meet.
    directory.writeSummary( summary.dump( 2 ) + "\n" );
    if ( options.estimate_error && code == finished )
    {
        if ( !options.quiet && ranks.isRoot() )
            tell( "machpoint: runs coarser grids to estimate the "
                  "error\n" );
        const auto fine = simulation->gridData();
        const double time = simulation->time();
        simulation.reset(); // makes room
        summary["error_estimate"] =
            estimateError( input, fine, time,
                           [&]( const Simulation& companion )
                           {
                               const bool stop =
                                   requests.next( companion ) == Request::stop;
                               if ( stop )
                                   requests.finish();
                               return stop;
                           } );
        summary["price"] = makePrice( summary, facts.process_seconds );
        directory.writeSummary( summary.dump( 2 ) + "\n" );
    }
    if ( !ranks.isRoot() )
        return code;
    if ( !options.quiet )
        fmt::print( "{}", formatSummary( summary ) );
    fmt::print( "output: {}\n", directory.path().string() );
    if ( code == stopped_early )
        tell( "machpoint: stopped by {} after step {}; {}\n", requests.reason(),
              summary.at( "steps" ).get<std::int64_t>(),
              can_keep ? "to go on, repeat the command with --restart "
                         "latest"
                       : "there is no checkpoint, because this build "
                         "lacks HDF5" );
    return code;
}

} // namespace Machpoint
