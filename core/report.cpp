#include <core/communicator.hpp>
#include <core/price.hpp>
#include <core/profile.hpp>
#include <core/report.hpp>
#include <core/revision.hpp>
#include <core/scene.hpp>

#include <fmt/format.h>

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <string>

namespace Machpoint
{

double exactEnergy( const Json& input, const GasState& state )
{
    if ( state.density <= 0 )
        return 0; // vacuum
    const GasLaw gas = gasLaw( input );
    return ( state.pressure + gas.gamma * gas.pressure_offset ) /
           ( ( gas.gamma - 1 ) * state.density );
}

namespace
{

//! The particles of all ranks, on each of them.
ParticleData gatherAll( const Communicator& ranks, const ParticleData& own )
{
    return { .position = ranks.gatherAll( own.position ),
             .velocity = ranks.gatherAll( own.velocity ),
             .mass = ranks.gatherAll( own.mass ),
             .volume = ranks.gatherAll( own.volume ),
             .density = ranks.gatherAll( own.density ),
             .pressure = ranks.gatherAll( own.pressure ),
             .specific_internal_energy =
                 ranks.gatherAll( own.specific_internal_energy ),
             .id = ranks.gatherAll( own.id ) };
}

} // namespace

std::vector<FieldError> measureErrors( const ParticleData& own,
                                       const ExactSolution& exact,
                                       const Json& input, const double t )
{
    const Communicator ranks;
    const std::size_t dim = input.at( "dimension" ).get<std::size_t>();
    // On a line a particle's share ends at its neighbours, whose rank may be
    // another.
    const auto data = dim == 1 ? gatherAll( ranks, own ) : own;
    const std::size_t n = data.mass.size();
    std::vector<double> measure( data.volume.begin(), data.volume.end() );
    if ( dim == 1 && n > 0 )
    {
        std::vector<std::size_t> order( n );
        std::iota( order.begin(), order.end(), 0 );
        std::sort( order.begin(), order.end(),
                   [&]( const std::size_t a, const std::size_t b )
                   { return data.position[a] < data.position[b]; } );
        // The first and last particle stand for the gas up to the ends of the
        // domain, but not for empty space wider than a cell.
        const auto grid = makeGrid<1>( input );
        const double h = grid.spacing[0];
        double edge =
            std::max<double>( grid.lower[0], data.position[order.front()] - h );
        const double end =
            std::min<double>( grid.upper[0], data.position[order.back()] + h );
        for ( std::size_t k = 0; k < n; ++k )
        {
            const double next = k + 1 < n
                                    ? 0.5 * ( data.position[order[k]] +
                                              data.position[order[k + 1]] )
                                    : end;
            measure[order[k]] = next - edge;
            edge = next;
        }
    }

    std::vector<FieldError> errors = { { "density" },
                                       { "velocity" },
                                       { "pressure" },
                                       { "specific_internal_energy" } };
    // |difference| and its square, times the measure, of each field.
    std::vector<ReproducibleSum> sums( 2 * errors.size() );
    for ( std::size_t p = 0; p < n; ++p )
    {
        Vector3 x{};
        for ( std::size_t d = 0; d < dim; ++d )
            x[d] = data.position[p * dim + d];
        const auto state = exact.state( x, t );
        double square = 0;
        for ( std::size_t d = 0; d < dim; ++d )
            square +=
                std::pow( data.velocity[p * dim + d] - state.velocity[d], 2 );
        const double energy = exactEnergy( input, state );
        const double difference[] = {
            std::abs( data.density[p] - state.density ), std::sqrt( square ),
            std::abs( data.pressure[p] - state.pressure ),
            std::abs( data.specific_internal_energy[p] - energy ) };
        for ( std::size_t f = 0; f < errors.size(); ++f )
        {
            sums[2 * f] += measure[p] * difference[f];
            sums[2 * f + 1] += measure[p] * difference[f] * difference[f];
            errors[f].Linf = std::max( errors[f].Linf, difference[f] );
        }
    }
    if ( dim > 1 )
        sums = sumOfRanks( ranks, sums );
    for ( std::size_t f = 0; f < errors.size(); ++f )
    {
        errors[f].L1 = sums[2 * f].value();
        errors[f].L2 = std::sqrt( sums[2 * f + 1].value() );
        if ( dim > 1 )
            errors[f].Linf = ranks.max( errors[f].Linf );
    }
    return errors;
}

std::int64_t peakMemory()
{
    // Linux counts into ru_maxrss what the program had that started this one.
    std::ifstream status( "/proc/self/status" );
    for ( std::string line; std::getline( status, line ); )
        if ( line.starts_with( "VmHWM:" ) )
            return 1024 * std::stoll( line.substr( 6 ) ); // of KiB
    rusage usage{};
    getrusage( RUSAGE_SELF, &usage );
    return static_cast<std::int64_t>( usage.ru_maxrss ) * 1024;
}

namespace
{

//! Relative drift; null where walls, bodies or open sides exchange the
//! quantity and no balance can be drawn.
Json conservation( const Simulation& simulation, const RunFacts& facts )
{
    const auto now = simulation.totals();
    const auto& before = facts.initial;
    const auto& ledger = simulation.ledger();
    Json json;
    json["mass"] =
        ( now.mass - before.mass - ledger.mass_in + ledger.mass_out ) /
        before.mass;
    json["momentum"] = nullptr;
    const double scale =
        std::sqrt( 2 * before.mass * std::abs( now.energy() ) );
    for ( int d = 0; d < simulation.dimension(); ++d )
        if ( simulation.conservesMomentum( d ) && scale > 0 )
        {
            const double drift =
                std::abs( now.momentum[d] - before.momentum[d] ) / scale;
            const auto& known = json.at( "momentum" );
            json["momentum"] = known.is_null()
                                   ? drift
                                   : std::max( drift, known.get<double>() );
        }
    json["total_energy"] = nullptr;
    if ( !simulation.isOpen() && before.energy() != 0 )
        json["total_energy"] =
            ( now.energy() - before.energy() - ledger.energy_in ) /
            std::abs( before.energy() );
    json["final_mass"] = now.mass;
    json["mass_in"] = ledger.mass_in;
    json["mass_out"] = ledger.mass_out;
    json["work_on_gas"] = ledger.energy_in;
    return json;
}

//! What the ranks sent and waited for: of each, the sum and the largest.
Json communication( const Communicator& ranks, const Traffic& own )
{
    std::vector<double> values( own.seconds.begin(), own.seconds.end() );
    const std::size_t times = values.size();
    for ( const auto count :
          { own.halo_bytes, own.halo_messages, own.migrated_particles,
            own.migrated_bytes, own.collectives } )
        values.push_back( static_cast<double>( count ) );
    const auto sums = ranks.sum( values );
    const auto largest = ranks.max( values );
    auto seconds = Json::object();
    for ( std::size_t k = 0; k < times; ++k )
        seconds[activity_names[k]] = { { "sum", sums[k] },
                                       { "largest", largest[k] } };
    auto count = [&]( const std::size_t k )
    {
        return Json{ { "sum", std::llround( sums[times + k] ) },
                     { "largest", std::llround( largest[times + k] ) } };
    };
    return {
        { "halo_bytes", count( 0 ) },         { "halo_messages", count( 1 ) },
        { "migrated_particles", count( 2 ) }, { "migrated_bytes", count( 3 ) },
        { "collectives", own.collectives },   { "seconds", seconds } };
}

//! The same for the end table: seconds of the slowest rank.
std::string formatCommunication( const Json& c )
{
    std::string text = fmt::format(
        "  communication: halo {:.4g} MiB in {} messages, {} particles moved, "
        "{} collectives; MPI takes {}\n    largest seconds:",
        c.at( "halo_bytes" ).at( "sum" ).get<double>() / ( 1 << 20 ),
        c.at( "halo_messages" ).at( "sum" ).get<std::int64_t>(),
        c.at( "migrated_particles" ).at( "sum" ).get<std::int64_t>(),
        c.at( "collectives" ).get<std::int64_t>(),
        c.at( "gpu_aware" ).get<bool>() ? "the GPU's memory"
        : mpiReachesMemory()            ? "the host's memory"
                                        : "copies on the host" );
    for ( const auto& [name, s] : c.at( "seconds" ).items() )
        text +=
            fmt::format( " {} {:.3f}", name, s.at( "largest" ).get<double>() );
    return text + "\n";
}

//! A number for a table, or a dash where there is none.
std::string orDash( const Json& value )
{
    return value.is_null() ? "-" : fmt::format( "{:.3e}", value.get<double>() );
}

} // namespace

Json makeSummary( Simulation& simulation, const Json& input,
                  const RunFacts& facts )
{
    const Communicator ranks;
    Json json;
    json["scene"] = input.at( "scene" );
    json["backend"] = ExecutionSpace::name();
    json["precision"] = precision_name;
    json["ranks"] = ranks.size();
    json["threads"] = ExecutionSpace().concurrency();
    json["dimension"] = simulation.dimension();
    json["method"] = input.at( "method" ).at( "name" );
    json["basis"] = input.at( "method" ).at( "basis" );
    json["cells"] = input.at( "grid" ).at( "cells" );
    json["particles_initial"] = facts.particles_initial;
    json["particles_final"] = simulation.particles();
    json["steps"] = simulation.steps();
    json["final_time"] = simulation.time();
    json["ended"] = facts.ended;
    json["wall_seconds"] = facts.wall_seconds;
    json["first_step_seconds"] = facts.first_step_seconds;
    json["particle_updates_per_second"] =
        facts.wall_seconds > 0
            ? static_cast<double>( facts.particle_updates ) / facts.wall_seconds
            : 0;
    json["bytes_per_particle"] = simulation.bytesPerParticle();
    json["peak_memory_bytes"] = ranks.sum( peakMemory() );
    json["peak_array_bytes"] = ranks.sum( Profile::mostBytes() );
    json["kernels"] = Profile::kernels();
    json["errors"] = Json::object();
    for ( const auto& e : facts.errors )
        json["errors"][e.field] = {
            { "L1", e.L1 }, { "L2", e.L2 }, { "Linf", e.Linf } };
    json["conservation"] = conservation( simulation, facts );
    const auto& extrema = simulation.extrema();
    json["extrema"] = { { "min_density", extrema.min_density },
                        { "min_specific_internal_energy",
                          extrema.min_specific_internal_energy },
                        { "max_mach", extrema.max_mach } };
    json["retries"] = simulation.retries();
    const auto imbalance = simulation.imbalance();
    json["imbalance"] = { { "start", imbalance.start },
                          { "largest", imbalance.largest },
                          { "end", imbalance.end },
                          { "cuts_moved", imbalance.cuts_moved } };
    json["effects"] = Json::array();
    for ( const auto& e : Profile::effects() )
        json["effects"].push_back( { { "name", e.name },
                                     { "kernels", e.kernels },
                                     { "seconds", e.seconds },
                                     { "bytes", e.bytes } } );
    json["phases"] = Json::array();
    for ( const auto& e : Profile::phases() )
        json["phases"].push_back( { { "name", e.name },
                                    { "calls", e.calls },
                                    { "seconds", e.seconds } } );
    auto& sent = json["communication"];
    sent = communication( ranks, facts.traffic );
    sent["gpu_aware"] = mpiIsGpuAware();
    sent["after_first_step"] =
        communication( ranks, facts.traffic - facts.first_step_traffic );
    json["error_estimate"] = nullptr;
    json["price"] = makePrice( json, facts.process_seconds );
    json["input"] = input;
    json["revision"] = revision;
    return json;
}

std::string formatSummary( const Json& s )
{
    const double wall = s.at( "wall_seconds" );
    double total = 0; // wall_seconds is without set-up and first output
    for ( const auto& e : s.at( "phases" ) )
        total += e.at( "seconds" ).get<double>();
    auto share = [&]( const Json& e )
    {
        const double seconds = e.at( "seconds" );
        return fmt::format( "{:>10.3f} s {:>5.1f} %", seconds,
                            total > 0 ? 100 * seconds / total : 0.0 );
    };
    const int ranks = s.at( "ranks" );
    std::string text = fmt::format(
        "\n{} | {} {} {}D | {} x{}{}{} | {} steps to t = {:.6g} in {:.3f} s | "
        "{:.3g} M particle updates/s\n",
        s.at( "scene" ).get<std::string>(), s.at( "method" ).get<std::string>(),
        s.at( "basis" ).get<std::string>(), s.at( "dimension" ).get<int>(),
        s.at( "backend" ).get<std::string>(), s.at( "threads" ).get<int>(),
        ranks > 1 ? fmt::format( " on {} ranks", ranks ) : "",
        is_single ? " in single precision" : "",
        s.at( "steps" ).get<std::int64_t>(), s.at( "final_time" ).get<double>(),
        wall, s.at( "particle_updates_per_second" ).get<double>() / 1e6 );
    text += "\n  phase\n";
    for ( const auto& e : s.at( "phases" ) )
        text += fmt::format( "    {:<28}{}\n",
                             e.at( "name" ).get<std::string>(), share( e ) );
    text += fmt::format( "  effect {:>43} {:>10} {:>12}\n", "", "kernels",
                         "bytes" );
    for ( const auto& e : s.at( "effects" ) )
        text += fmt::format( "    {:<28}{}  {:>10} {:>12}\n",
                             e.at( "name" ).get<std::string>(), share( e ),
                             e.at( "kernels" ).get<std::int64_t>(),
                             e.at( "bytes" ).get<std::int64_t>() );
    if ( ranks > 1 )
    {
        const auto& b = s.at( "imbalance" );
        text += fmt::format(
            "  largest over mean load of the ranks: {:.3f} at the start, "
            "{:.3f} at most, {:.3f} at the end; cuts moved {} times\n",
            b.at( "start" ).get<double>(), b.at( "largest" ).get<double>(),
            b.at( "end" ).get<double>(),
            b.at( "cuts_moved" ).get<std::int64_t>() );
        text += formatCommunication( s.at( "communication" ) );
    }
    const auto& c = s.at( "conservation" );
    text += fmt::format( "  relative drift: mass {}, momentum {}, total energy "
                         "{}  (- : exchanged with walls or open sides)\n",
                         orDash( c.at( "mass" ) ), orDash( c.at( "momentum" ) ),
                         orDash( c.at( "total_energy" ) ) );
    if ( const double work = c.at( "work_on_gas" );
         work != 0 && !c.at( "total_energy" ).is_null() )
        text += fmt::format( "  of total energy less {:.4g}, the work of "
                             "effects and boundaries on the gas\n",
                             work );
    const auto& x = s.at( "extrema" );
    text += fmt::format(
        "  extrema: density >= {:.4g}, specific internal energy >= {:.4g}, "
        "Mach <= {:.4g}\n",
        x.at( "min_density" ).get<double>(),
        x.at( "min_specific_internal_energy" ).get<double>(),
        x.at( "max_mach" ).get<double>() );
    if ( !s.at( "errors" ).empty() )
    {
        text += fmt::format( "  error against exact {:>16} {:>12} {:>12}\n",
                             "L1", "L2", "Linf" );
        for ( const auto& [field, e] : s.at( "errors" ).items() )
            text += fmt::format( "    {:<24} {:>12.4e} {:>12.4e} {:>12.4e}\n",
                                 field, e.at( "L1" ).get<double>(),
                                 e.at( "L2" ).get<double>(),
                                 e.at( "Linf" ).get<double>() );
    }
    return text + formatPrice( s );
}

} // namespace Machpoint
