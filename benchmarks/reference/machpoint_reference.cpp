/*!
  \file machpoint_reference.cpp
  \brief machpoint_reference INPUT.json: runs a scene of Machpoint with a
  finite-volume scheme, as a yardstick. See README.md.
*/
#include "finite_volume.hpp"

#include <core/kokkos_session.hpp>
#include <core/output.hpp>
#include <core/revision.hpp>
#include <drivers/input.hpp>
#include <drivers/run.hpp>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

namespace Machpoint::Reference
{

//! The command line.
struct Options
{
    std::string input;
    std::vector<std::string> overrides;
    std::string output;
    bool overwrite = false;
    double courant_number = usual_courant_number;
    std::vector<int> reference_cells;
};

//! \throws InputError naming everything in a scene that this program lacks
void checkSupported( const Json& input, const Options& options )
{
    std::vector<std::string> errors;
    const int dim = input.at( "dimension" );
    if ( dim > 2 )
        errors.push_back( "/dimension: machpoint_reference has 1 and 2" );
    // Artificial viscosity belongs to the particles: HLLC has its own.
    const std::pair<const char*, std::set<std::string>> lists[] = {
        { "physics", { "ideal_gas", "gravity", "artificial_viscosity" } },
        { "boundary",
          { "slip_wall", "periodic", "inflow", "outflow", "recycle",
            "obstacle" } } };
    for ( const auto& [list, supported] : lists )
        for ( std::size_t k = 0; k < input.at( list ).size(); ++k )
        {
            const auto type =
                input.at( list ).at( k ).at( "type" ).get<std::string>();
            if ( !supported.count( type ) )
                errors.push_back( fmt::format(
                    "/{}/{}/type: machpoint_reference has no {}; it has {}",
                    list, k, type, fmt::join( supported, ", " ) ) );
        }
    for ( std::size_t k = 0; k < input.at( "boundary" ).size(); ++k )
        if ( const auto& entry = input.at( "boundary" ).at( k );
             entry.at( "type" ) == "outflow" && entry.contains( "pressure" ) )
            errors.push_back( fmt::format(
                "/boundary/{}/pressure: machpoint_reference has no far gas, "
                "beyond its outflows the last cell's goes on",
                k ) );
    for ( int d = 0; d < dim; ++d )
        if ( input.at( "grid" ).at( "cells" ).at( d ).get<int>() <
             ghost_layers )
            errors.push_back( fmt::format( "/grid/cells/{}: must be >= {}", d,
                                           ghost_layers ) );
    const auto& reference = options.reference_cells;
    if ( !reference.empty() && static_cast<int>( reference.size() ) != dim )
        errors.push_back( fmt::format(
            "--reference-cells: needs {} numbers, one for each axis", dim ) );
    if ( !reference.empty() && input.contains( "exact" ) )
        errors.push_back( "--reference-cells: the scene has an exact solution "
                          "to measure errors by; leave one away" );
    for ( auto& error : errors )
        error = fmt::format( "{}: {}", options.input, error );
    if ( !errors.empty() )
        throw InputError( errors );
}

/*!
  \brief The fields of a finer grid in place of an exact solution: (bi)linear
  between the centres of its cells, at the one time that they belong to.
*/
template <int Dim>
class FineSolution : public ExactSolution
{
  public:
    explicit FineSolution( GridData fields ) : _fields( std::move( fields ) ) {}

    GasState state( const Vector<3>& x, Real ) const override
    {
        GasState sum{ 0, {}, 0 };
        Real total = 0;
        for ( int corner = 0; corner < 1 << Dim; ++corner )
        {
            std::size_t n = 0;
            Real weight = 1;
            for ( int d = Dim - 1; d >= 0; --d )
            {
                const auto size =
                    static_cast<int>( _fields.shape[Dim - 1 - d] );
                const Real place = std::clamp(
                    ( x[d] - _fields.lower[d] ) / _fields.spacing[d], 0.0,
                    static_cast<Real>( size - 1 ) );
                const int base =
                    std::min( static_cast<int>( place ), size - 2 );
                const int next = ( corner >> d ) & 1;
                weight *= next ? place - base : base + 1 - place;
                n = n * size + base + next;
            }
            if ( _fields.density[n] <= 0 )
                continue; // in a solid
            total += weight;
            sum.density += weight * _fields.density[n];
            sum.pressure += weight * _fields.pressure[n];
            for ( int d = 0; d < Dim; ++d )
                sum.velocity[d] += weight * _fields.velocity[n * Dim + d];
        }
        if ( total > 0 )
        {
            sum.density /= total;
            sum.pressure /= total;
            for ( int d = 0; d < Dim; ++d )
                sum.velocity[d] /= total;
        }
        return sum;
    }

  private:
    GridData _fields;
};

//! The gas' cells as points that carry their cell's volume, for
//! measureErrors(): sums over cell centres times cell volume.
template <int Dim>
ParticleData asPoints( const GridData& fields )
{
    ParticleData points;
    Real volume = 1;
    for ( int d = 0; d < Dim; ++d )
        volume *= fields.spacing[d];
    for ( std::size_t n = 0; n < fields.density.size(); ++n )
    {
        if ( fields.density[n] <= 0 )
            continue; // in a solid
        std::size_t rest = n;
        for ( int d = 0; d < Dim; ++d )
        {
            const auto size = fields.shape[Dim - 1 - d];
            points.position.push_back( fields.lower[d] +
                                       static_cast<Real>( rest % size ) *
                                           fields.spacing[d] );
            points.velocity.push_back( fields.velocity[n * Dim + d] );
            rest /= size;
        }
        points.volume.push_back( volume );
        points.mass.push_back( fields.density[n] * volume );
        points.density.push_back( fields.density[n] );
        points.pressure.push_back( fields.pressure[n] );
        points.specific_internal_energy.push_back(
            fields.specific_internal_energy[n] );
    }
    return points;
}

//! Fields as they are written. (A function without Dim: in a template nvcc
//! loses the inner braces.)
std::vector<Dataset> datasetsOf( const GridData& data,
                                 const std::vector<std::size_t>& vector_shape )
{
    return { { "density", data.shape, data.density.data() },
             { "pressure", data.shape, data.pressure.data() },
             { "specific_internal_energy", data.shape,
               data.specific_internal_energy.data() },
             { "velocity", vector_shape, data.velocity.data() } };
}

template <int Dim>
void writeFields( OutputDirectory& directory, const FiniteVolume<Dim>& solver )
{
    const auto data = solver.fields();
    auto vector_shape = data.shape;
    vector_shape.push_back( Dim );
    directory.writeGrid( solver.steps(), solver.time(), data.lower,
                         data.spacing, datasetsOf( data, vector_shape ) );
}

//! Runs a checked scene to its end and writes what it found.
template <int Dim>
void runScene( const Json& input, const Options& options )
{
    const auto scene = input.at( "scene" ).get<std::string>();
    const Real end = input.at( "time" ).at( "end" );
    const bool writes = input.at( "output" ).at( "grid" );
    const Real every = input.at( "output" ).value( "every", end );
    OutputDirectory directory(
        options.output.empty() ? "out/" + scene + "_reference" : options.output,
        options.overwrite ? FormerRun::replace : FormerRun::refuse, Dim,
        writes );

    auto exact = makeExact( input );
    if ( !options.reference_cells.empty() )
    {
        Indices<Dim> cells;
        for ( int d = 0; d < Dim; ++d )
            cells[d] = options.reference_cells[d];
        FiniteVolume<Dim> fine( input, cells );
        while ( fine.time() < end )
            fine.step( end );
        exact = std::make_unique<FineSolution<Dim>>( fine.fields() );
    }

    Kokkos::Timer timer;
    FiniteVolume<Dim> solver( input, makeGrid<Dim>( input ).cells,
                              static_cast<Real>( options.courant_number ) );
    if ( writes )
        writeFields( directory, solver );
    for ( std::int64_t output = 1; solver.time() < end; ++output )
    {
        // Counted, not summed; what rounding puts before the end is the end.
        const Real planned = every * static_cast<Real>( output );
        const Real next = planned < end * ( 1 - 1e-12 ) ? planned : end;
        while ( solver.time() < next )
            solver.step( next );
        if ( writes )
            writeFields( directory, solver );
    }
    Kokkos::fence();
    const Real wall = timer.seconds();

    Json summary;
    summary["scene"] = scene;
    summary["backend"] = ExecutionSpace::name();
    summary["threads"] = ExecutionSpace().concurrency();
    summary["dimension"] = Dim;
    summary["method"] = "muscl_hllc";
    summary["cfl"] = options.courant_number;
    summary["cells"] = input.at( "grid" ).at( "cells" );
    if ( !options.reference_cells.empty() )
        summary["reference_cells"] = options.reference_cells;
    summary["steps"] = solver.steps();
    summary["final_time"] = solver.time();
    summary["wall_seconds"] = wall;
    summary["cell_updates_per_second"] =
        static_cast<Real>( solver.steps() ) * solver.cells() / wall;
    std::vector<FieldError> errors;
    if ( exact )
        errors = measureErrors( asPoints<Dim>( solver.fields() ), *exact, input,
                                solver.time() );
    summary["errors"] = Json::object();
    for ( const auto& e : errors )
        summary["errors"][e.field] = {
            { "L1", e.L1 }, { "L2", e.L2 }, { "Linf", e.Linf } };
    summary["input"] = input;
    summary["revision"] = revision;
    directory.writeSummary( summary.dump( 2 ) + "\n" );

    fmt::print(
        "{}: {} steps to t = {:.6g} in {:.3f} s, {:.3g} M cell updates/s\n",
        scene, solver.steps(), solver.time(), wall,
        static_cast<Real>( solver.steps() ) * solver.cells() / wall / 1e6 );
    for ( const auto& e : errors )
        fmt::print( "  {:<24} L1 {:.4e}  L2 {:.4e}  Linf {:.4e}\n", e.field,
                    e.L1, e.L2, e.Linf );
    fmt::print( "output: {}\n", directory.path().string() );
}

//! Exit codes are machpoint's.
int run( const Options& options )
{
    try
    {
        const Json input = loadInput( options.input, options.overrides );
        checkSupported( input, options );
        if ( input.at( "dimension" ) == 1 )
            runScene<1>( input, options );
        else
            runScene<2>( input, options );
        return finished;
    }
    catch ( const InputError& error )
    {
        fmt::print( stderr, "{}\n", error.what() );
        return wrong_input;
    }
    catch ( const IoError& error )
    {
        fmt::print( stderr, "machpoint_reference: {}\n", error.what() );
        return io_failure;
    }
    catch ( const NumericalFailure& failure )
    {
        fmt::print( stderr, "{}\n", failure.what() );
        return numerical_failure;
    }
}

} // namespace Machpoint::Reference

int main( int argc, char** argv )
{
    using namespace Machpoint;
    Reference::Options options;
    CLI::App app( "Finite-volume yardstick for the scenes of Machpoint",
                  "machpoint_reference" );
    app.add_option( "INPUT", options.input, "JSON file of the scene" )
        ->required();
    app.add_option( "--set", options.overrides,
                    "override a value of the input: path=value" )
        ->take_all()
        ->allow_extra_args( false );
    app.add_option(
        "--output", options.output,
        "directory for the results (default out/<scene>_reference)" );
    app.add_flag( "--overwrite", options.overwrite,
                  "replace the results of a former run" );
    app.add_option( "--cfl", options.courant_number,
                    "Courant number of the sum over the axes, whatever the "
                    "scene's particles take (default 0.4)" )
        ->check( CLI::Range( 1e-6, 1.0, "CFL" ) );
    app.add_option( "--reference-cells", options.reference_cells,
                    "measure errors against a run on this finer grid: one "
                    "number for each axis" )
        ->check( CLI::Range( Reference::ghost_layers, 100000000, "CELLS" ) );
    try
    {
        app.parse( argc, argv );
    }
    catch ( const CLI::ParseError& error )
    {
        return app.exit( error ) == 0 ? finished : wrong_input;
    }
    const KokkosSession kokkos;
    return Reference::run( options );
}
