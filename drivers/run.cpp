#include <drivers/run.hpp>

#include <core/communicator.hpp>
#include <core/exact.hpp>
#include <core/output.hpp>
#include <core/profile.hpp>
#include <core/report.hpp>
#include <core/simulation.hpp>

#include <fmt/format.h>

#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>

namespace Machpoint
{

namespace
{

std::atomic<int> signal_received{ 0 };
static_assert( std::atomic<int>::is_always_lock_free );

void rememberSignal( const int signal )
{
    signal_received = signal;
}

//! Takes SIGINT and SIGTERM while it lives: the step is finished first.
class SignalGuard
{
  public:
    SignalGuard()
    {
        signal_received = 0;
        _int = std::signal( SIGINT, &rememberSignal );
        _term = std::signal( SIGTERM, &rememberSignal );
    }
    ~SignalGuard()
    {
        std::signal( SIGINT, _int );
        std::signal( SIGTERM, _term );
    }
    SignalGuard( const SignalGuard& ) = delete;

  private:
    void ( *_int )( int );
    void ( *_term )( int );
};

//! One line that refreshes on a terminal and appends in a log.
class Progress
{
  public:
    Progress( const bool quiet, const Real end )
        : _quiet( quiet ), _terminal( isatty( STDERR_FILENO ) ), _end( end )
    {
    }

    void show( const Simulation& s, const bool last )
    {
        const Real now = _timer.seconds();
        // Often enough to see that it lives, seldom enough not to fill a log.
        if ( _quiet || ( !last && now - _shown < ( _terminal ? 0.2 : 10 ) ) )
            return;
        const Real done = s.time() / _end;
        const std::int64_t moved = _updates - _updates_shown;
        const Real rate =
            now > _shown ? static_cast<Real>( moved ) / ( now - _shown ) : 0;
        fmt::print(
            stderr,
            "{}step {} | t {:.6g} / {:.6g} ({:.1f} %) | dt {:.3g} by {} | "
            "{:.3g} M particle updates/s | ETA {:.0f} s{}",
            _terminal ? "\r\033[K" : "", s.steps(), s.time(), _end, 100 * done,
            s.timeStep(), s.limiter(), rate / 1e6,
            done > 0 ? now * ( 1 - done ) / done : 0,
            _terminal && !last ? "" : "\n" );
        std::fflush( stderr );
        _shown = now;
        _updates_shown = _updates;
    }

    void count( const std::int64_t particles ) { _updates += particles; }
    std::int64_t updates() const { return _updates; }

  private:
    bool _quiet;
    bool _terminal;
    Real _end;
    Kokkos::Timer _timer;
    Real _shown = 0;
    std::int64_t _updates = 0;
    std::int64_t _updates_shown = 0;
};

std::vector<Dataset> particleDatasets( const ParticleData& data, const int dim )
{
    const std::size_t n = data.mass.size();
    const std::size_t d = dim;
    return { { "position", { n, d }, data.position.data() },
             { "velocity", { n, d }, data.velocity.data() },
             { "mass", { n }, data.mass.data() },
             { "density", { n }, data.density.data() },
             { "pressure", { n }, data.pressure.data() },
             { "specific_internal_energy",
               { n },
               data.specific_internal_energy.data() },
             { "id", { n }, data.id.data(), Dataset::Type::integer } };
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
    constexpr std::size_t points = 2001;
    const Real lower = input.at( "grid" ).at( "lower" ).at( 0 );
    const Real upper = input.at( "grid" ).at( "upper" ).at( 0 );
    std::vector<Real> x( points ), rho( points ), v( points ), p( points ),
        e( points );
    for ( std::size_t k = 0; k < points; ++k )
    {
        x[k] = lower + ( upper - lower ) * static_cast<Real>( k ) /
                           static_cast<Real>( points - 1 );
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
    const SignalGuard guard;
    Profile::start();
    Kokkos::Timer timer;
    const auto scene = input.at( "scene" ).get<std::string>();
    const int dim = input.at( "dimension" );
    const Real end = input.at( "time" ).at( "end" );
    const auto& output = input.at( "output" );
    const bool writes_particles = output.at( "particles" );
    const bool writes_grid = output.at( "grid" );
    const Real every = output.value( "every", end );
    const auto simulation = makeSimulation( input );
    const auto exact = makeExact( input );
    OutputDirectory directory(
        options.output.empty() ? "out/" + scene : options.output,
        options.overwrite, dim, writes_particles || writes_grid,
        output.at( "compression" ) );

    RunFacts facts;
    facts.initial = simulation->totals();
    facts.particles_initial = simulation->particles();
    auto write = [&]
    {
        Profile::Phase phase( "output" );
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
    };

    write();
    ExitCode code = finished;
    Progress progress( options.quiet || !ranks.isRoot(), end );
    std::int64_t outputs = 1;
    std::int64_t written = simulation->steps();
    try
    {
        while ( simulation->time() < end &&
                simulation->steps() < options.max_steps )
        {
            // Times are counted, not summed, so that none drifts; one that
            // rounding puts just before the end is the end.
            const Real planned = every * static_cast<Real>( outputs );
            const Real next = planned < end * ( 1 - 1e-12 ) ? planned : end;
            simulation->step( next );
            progress.count( simulation->particles() );
            progress.show( *simulation, false );
            if ( simulation->time() >= next )
            {
                ++outputs;
                write();
                written = simulation->steps();
            }
            // Launchers may tell one rank only, or all of them one by one.
            if ( ranks.any( signal_received != 0 ) )
            {
                code = stopped_early;
                break;
            }
        }
    }
    catch ( const NumericalFailure& failure )
    {
        // Without retries there is no copy to return to: what is in memory is
        // broken, and the last output is the last good state.
        if ( input.at( "time" ).at( "retries" ) > 0 &&
             written != simulation->steps() )
        {
            write();
            written = simulation->steps();
        }
        if ( ranks.isRoot() )
            fmt::print(
                stderr,
                "\nmachpoint: {}\nThe last good state, that of step {}, is "
                "in {}\n",
                failure.what(), written, directory.path().string() );
        code = numerical_failure;
    }
    progress.show( *simulation, true );
    if ( code != numerical_failure && written != simulation->steps() )
        write();
    facts.wall_seconds = timer.seconds();
    facts.particle_updates = progress.updates();
    if ( exact && code != numerical_failure )
        facts.errors = measureErrors( simulation->particleData(), *exact, input,
                                      simulation->time() );
    const Json summary = makeSummary( *simulation, input, facts );
    directory.writeSummary( summary.dump( 2 ) + "\n" );
    const auto signal = ranks.max( signal_received );
    if ( !ranks.isRoot() )
        return code;
    if ( !options.quiet )
        fmt::print( "{}", formatSummary( summary ) );
    fmt::print( "output: {}\n", directory.path().string() );
    if ( code == stopped_early )
        fmt::print(
            stderr,
            "machpoint: stopped by signal {:.0f} after step {}; the state "
            "is written\n",
            signal, simulation->steps() );
    return code;
}

} // namespace Machpoint
