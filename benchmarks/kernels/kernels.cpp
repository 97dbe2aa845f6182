/*!
  \file kernels.cpp
  \brief machpoint_kernels: how long a step and its parts take, for every
  method, basis, dimension and order of particles, beside what the machine
  allows.

  Usage: machpoint_kernels [--particles NUMBER] [--cycles NUMBER]
             [--samples NUMBER] [--small] [--benchmark_filter=REGEX] ...

  Names are method/basis/dimension/per_cell/order/part. The parts of a case are
  measured in the same steps: whichever is asked for first runs them. A row is
  the median of the samples, `spread` how far these lie apart. Under mpirun the
  slowest rank counts, and limits are those of all ranks at once. Exit code: 0,
  or 1 where nothing matches REGEX.
*/
#include "limits.hpp"
#include "recording.hpp"
#include "work.hpp"

#include <core/communicator.hpp>
#include <core/kokkos_session.hpp>
#include <core/revision.hpp>
#include <core/stepper_list.hpp>

#include <CLI/CLI.hpp>
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <stdexcept>

using namespace Machpoint;

namespace
{

#ifdef MACHPOINT_ENABLE_MPI
constexpr bool has_mpi = true;
#else
constexpr bool has_mpi = false;
#endif

Sizes sizes;
Limits limits;

const Recording& recordingOf( const Case& setting )
{
    static std::map<std::string, Recording> kept;
    const auto found = kept.find( setting.name() );
    if ( found != kept.end() )
        return found->second;
    return kept[setting.name()] = record( setting, sizes );
}

//! What a part has to do for one particle step; `step`: all parts.
Work workOf( const Case& setting, const Recording& r, const std::string& part )
{
    const int nodes = setting.basis == "linear"      ? 2
                      : setting.basis == "quadratic" ? 3
                                                     : 4;
    const WorkOfStep work(
        { setting.method.substr( 0, setting.method.find( '_' ) ),
          setting.method == "conservative_midpoint", setting.dim, nodes,
          setting.per_cell, r.sort_every, r.particle_bytes } );
    const Real own = r.particles / Communicator().size();
    if ( part == "halo" )
        return { r.halo_bytes / own, 0 };
    if ( part == "migrate" )
        return { r.migrated_bytes / own, 0 };
    if ( part != "step" )
        return work.of( part );
    Work all;
    for ( const auto& name : partNames() )
    {
        if ( !setting.has( name ) )
            continue;
        all.bytes += work.of( name ).bytes;
        all.flops += work.of( name ).flops;
    }
    return all;
}

//! One row.
void report( benchmark::State& state, const Case& setting,
             const std::string& part )
try
{
    const auto& r = recordingOf( setting );
    std::vector<Real> times;
    for ( const auto& sample : r.samples )
        times.push_back( part == "step" ? sample.seconds
                                        : sample.parts.at( part ) );
    std::sort( times.begin(), times.end() );
    const auto n = times.size();
    const Real seconds = 0.5_rt * ( times[( n - 1 ) / 2] + times[n / 2] );
    if ( seconds <= 0 )
    {
        state.SkipWithError( "the profile has no such phase: correct "
                             "benchmarks/kernels/recording.cpp" );
        return;
    }
    for ( auto _ : state )
        state.SetIterationTime( seconds );
    const auto work = workOf( setting, r, part );
    auto& counters = state.counters;
    counters["spread"] = ( times.back() - times.front() ) / seconds;
    counters["updates_per_second"] = r.particles / seconds;
    counters["bytes"] = work.bytes;
    counters["flops"] = work.flops;
    counters["of_triad"] =
        work.bytes * r.particles / seconds / limits.triad().all;
    counters["of_fma"] = work.flops * r.particles / seconds / limits.fma_all;
    if ( part != "step" )
        return;
    counters["particles"] = r.particles;
    counters["particle_bytes"] = r.particle_bytes;
    counters["bytes_held"] = r.bytes_held;
}
catch ( const std::runtime_error& error )
{
    state.SkipWithError( error.what() );
}

void add( const Case& setting, const std::string& part )
{
    benchmark::RegisterBenchmark( ( setting.name() + '/' + part ).c_str(),
                                  [setting, part]( benchmark::State& state )
                                  { report( state, setting, part ); } )
        ->Iterations( 1 )
        ->UseManualTime()
        ->Unit( benchmark::kMillisecond );
}

//! Name of a basis or a method from that of its type.
std::string lowerCase( std::string name )
{
    std::transform( name.begin(), name.end(), name.begin(),
                    []( const unsigned char c ) { return std::tolower( c ); } );
    return name;
}

void addAll( const int dim, const std::string& basis,
             const std::string& method )
{
    std::vector<std::string> methods = { method };
    if ( method == "conservative" )
        methods = { method + "_symplectic", method + "_midpoint" };
    const std::vector<std::vector<int>> per_cell = { { 3 }, { 4, 9 }, { 8 } };
    std::vector<std::string> orders = { "ordered", "mixed" };
    if ( basis == "quadratic" )
        orders.push_back( "unsorted" );
    for ( const auto& name : methods )
        for ( const int n : per_cell[dim - 1] )
            for ( const auto& order : orders )
            {
                const Case setting{ name, basis, dim, n, order };
                add( setting, "step" );
                for ( const auto& part : partNames() )
                    if ( setting.has( part ) )
                        add( setting, part );
            }
}

//! What the ranks but the root print.
class Silent : public benchmark::BenchmarkReporter
{
    bool ReportContext( const Context& ) override { return true; }
    void ReportRuns( const std::vector<Run>& ) override {}
};

void addContext( const std::string& key, const Real value )
{
    benchmark::AddCustomContext( key, fmt::format( "{:.6e}", value ) );
}

//! What all rows are of.
void addContext()
{
    benchmark::AddCustomContext( "revision", revision );
    benchmark::AddCustomContext( "backend", ExecutionSpace::name() );
    addContext( "threads", ExecutionSpace().concurrency() );
    addContext( "ranks", Communicator().size() );
    benchmark::AddCustomContext( "mpi", has_mpi ? "yes" : "no" );
    addContext( "triad_one", limits.triad().one );
    addContext( "triad_all", limits.triad().all );
    addContext( "ordinary_one", limits.ordinary.one );
    addContext( "ordinary_all", limits.ordinary.all );
    addContext( "streamed_one", limits.streamed.one );
    addContext( "streamed_all", limits.streamed.all );
    addContext( "fma_one", limits.fma_one );
    addContext( "fma_all", limits.fma_all );
}

//! The command line: sizes, and the words of Google Benchmark.
//! \param small is set where asked for \return exit code, if the program is
//! done
std::optional<int> parse( int argc, char** argv, bool& small )
{
    CLI::App app( "Times a step and its parts", "machpoint_kernels" );
    app.add_option( "--particles", sizes.particles, "of a case, about" )
        ->check( CLI::Range( 1, 1 << 30 ) )
        ->capture_default_str();
    app.add_option( "--cycles", sizes.cycles,
                    "of a sample; one has particles.sort_every steps" )
        ->check( CLI::Range( 1, 1000 ) )
        ->capture_default_str();
    app.add_option( "--samples", sizes.samples, "after one to warm up" )
        ->check( CLI::Range( 1, 1000 ) )
        ->capture_default_str();
    app.add_flag( "--small", small, "limits in milliseconds: does it work?" );
    app.footer( "And those of Google Benchmark, as --option=value:" );
    app.allow_extras();
    try
    {
        app.parse( argc, argv );
    }
    catch ( const CLI::CallForHelp& help )
    {
        app.exit( help );
        benchmark::PrintDefaultHelp();
        return 0;
    }
    catch ( const CLI::ParseError& error )
    {
        return app.exit( error );
    }
    // The words that are Google Benchmark's.
    auto others = app.remaining();
    std::vector<char*> words = { argv[0] };
    for ( auto& word : others )
        if ( Communicator().isRoot() || // one file, and the root writes it
             word.rfind( "--benchmark_out", 0 ) != 0 )
            words.push_back( word.data() );
    int count = static_cast<int>( words.size() );
    benchmark::Initialize( &count, words.data() );
    if ( benchmark::ReportUnrecognizedArguments( count, words.data() ) )
        return 1;
    return {};
}

} // namespace

int main( int argc, char** argv )
{
    const MpiSession mpi( argc, argv );
    const Communicator ranks;
    if ( launchedProcesses() > ranks.size() )
    {
        fmt::print( stderr, "built without the launcher's MPI: run it without "
                            "mpirun\n" );
        return 1;
    }
    bool small = false;
    if ( const auto code = parse( argc, argv, small ) )
        return *code;

    const KokkosSession kokkos;
    limits = measureLimits( small );
    addContext();
#define MACHPOINT_ADD( DIM, BASIS, METHOD )                                    \
    addAll( DIM, lowerCase( #BASIS ), lowerCase( #METHOD ) );
    MACHPOINT_FOR_EACH_STEPPER( MACHPOINT_ADD )
#undef MACHPOINT_ADD
    Silent silent;
    const auto matched =
        benchmark::RunSpecifiedBenchmarks( ranks.isRoot() ? nullptr : &silent );
    return matched > 0 ? 0 : 1;
}
