#include <drivers/input.hpp>

#include <core/basis.hpp>
#include <core/communicator.hpp>
#include <core/exact.hpp>
#include <core/method_apic.hpp>
#include <core/method_conservative.hpp>
#include <core/method_paper.hpp>
#include <core/placement.hpp>
#include <core/registry.hpp>
#include <core/shape_input.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>

namespace Machpoint
{

namespace
{
//! Numbers of steps are counted as int.
constexpr double most_steps = 1e9;
//! Outputs of a run.
constexpr double most_outputs = 1e8;
} // namespace

Parameters methodParameters( const std::string& name, const int dimension )
{
    const bool is_any = name.empty();
    const bool has_parts = is_any || name == Conservative::name;
    using Names = std::vector<std::string>;
    Parameters method( "method", "numerical method", dimension );
    auto& names = method.choice(
        "name",
        is_any ? Names{ Paper::name, Apic::name, Conservative::name }
               : Names{ name },
        "time stepping method" );
    auto& basis = method.choice(
        "basis", { Linear::name, Quadratic::name, Cubic::name }, "B-splines" );
    auto& time = method.choice( "time",
                                has_parts ? Names{ "symplectic", "midpoint" }
                                          : Names{ "symplectic" },
                                "time integrator" );
    if ( is_any )
    {
        basis.optional( "linear of paper, else quadratic" );
        time.optional( "midpoint of conservative, else symplectic" );
        time.description += "; midpoint is of conservative alone";
    }
    else
    {
        basis.defaultsTo( name == Paper::name  ? Paper::default_basis
                          : name == Apic::name ? Apic::default_basis
                                               : Conservative::default_basis );
        time.defaultsTo( has_parts ? ConservativeParts::default_time
                                   : "symplectic" );
    }
    if ( !has_parts )
        return method;
    names.defaultsTo( Conservative::name );
    time.switches( "midpoint", "symplectic" );
    const auto parts = ConservativeParts::declare( dimension );
    const auto in_1d = ConservativeParts::declare( 1 );
    for ( std::size_t k = 0; k < parts.keys().size(); ++k )
    {
        const auto& part = parts.keys()[k];
        auto& key = part.kind == Parameter::Kind::Boolean
                        ? method.boolean( part.name, part.description )
                        : method.number( part.name, part.description );
        key = part;
        const auto& value = *part.default_value;
        const auto& line = *in_1d.keys()[k].default_value;
        const bool differs = dimension == 0 && line != value;
        // No default applies before method and dimension are known.
        if ( is_any || differs )
        {
            key.optional( differs ? fmt::format( "{} in 1D, else {}",
                                                 line.get<double>(),
                                                 value.get<double>() )
                                  : value.dump() );
            key.default_value.reset();
        }
        if ( is_any )
            key.description += " (of conservative alone)";
    }
    return method;
}

Parameters inputParameters( const int dimension )
{
    Parameters grid( "grid", "uniform Cartesian grid", dimension );
    grid.vector( "lower", "lower corner of the domain" ).unit( "length" );
    grid.vector( "upper", "upper corner of the domain" ).unit( "length" );
    grid.integerVector( "cells", "number of cells" ).atLeast( 1 ).atMost( 1e8 );

    Parameters particles( "particles", "the gas's particles", dimension );
    particles.integer( "per_cell", "particles per cell" )
        .atLeast( 1 )
        .atMost( 10000 );
    particles
        .choice( "placement", { "lattice", "jittered", "random" },
                 "where they start within a cell" )
        .defaultsTo( "lattice" );
    particles.integer( "seed", "of all random numbers" )
        .atLeast( 0 )
        .defaultsTo( 1 );
    particles
        .integer(
            "sort_every",
            "steps between sorts by cell, of particles that are out of order" )
        .atLeast( 1 )
        .atMost( most_steps )
        .defaultsTo( 20 );

    Parameters time( "time", "length of the run and of its steps", dimension );
    time.number( "end", "final time" ).unit( "time" ).above( 0 );
    time.number( "cfl", "Courant number: part of a cell that the fastest wave "
                        "crosses in a step" )
        .above( 0 )
        .atMost( 100 )
        .source( "stable up to the limits in docs/stability.md" )
        .optional( "0.8 of midpoint, 0.5 on the linear basis; else 0.4" );
    time.integer( "retries", "how often a step that breaks the gas is repeated "
                             "with half its length before the run ends" )
        .atLeast( 0 )
        .atMost( 50 )
        .switches( "retries", 0 )
        .defaultsTo( 10 );

    Parameters decomposition(
        "decomposition", "boxes of cells, one for each MPI rank", dimension );
    decomposition
        .integerVector( "ranks", "ranks along each axis; by default the boxes "
                                 "with the least area of cuts" )
        .atLeast( 1 )
        .atMost( 1e6 )
        .optional();
    Parameters balance( "balance", "boxes that follow the gas", dimension );
    balance
        .integer( "every", "steps between looks at the ranks' loads; 0: boxes "
                           "stay as they begin, of equal numbers of cells or, "
                           "in a restart, as its checkpoint has them" )
        .atLeast( 0 )
        .atMost( most_steps )
        .defaultsTo( 20 );
    balance
        .number( "threshold", "largest over mean load of the ranks above which "
                              "the cuts move" )
        .atLeast( 1 )
        .defaultsTo( 1.1 );
    balance.number( "cell_cost", "load of a cell; that of a particle is 1" )
        .unit( "particles" )
        .atLeast( 0 )
        .defaultsTo( 0.1 )
        .source( "measured: docs/ranks.md" );
    decomposition.object( "balance", balance,
                          "when the cuts between boxes move" );

    Parameters output( "output", "what is written, and when", dimension );
    output.number( "every", "time between outputs; by default start and end" )
        .unit( "time" )
        .above( 0 )
        .optional();
    output.boolean( "particles", "write particles" ).defaultsTo( true );
    output.boolean( "grid", "write node fields" ).defaultsTo( true );
    output
        .integer( "compression", "effort of compressing what is written "
                                 "(shuffle and deflate); 0: none" )
        .atLeast( 0 )
        .atMost( 9 )
        .defaultsTo( 0 );

    Parameters checkpoint( "checkpoint",
                           "when the state is kept to restart from; never, "
                           "unless one of the first three says so",
                           dimension );
    checkpoint.integer( "every_steps", "steps between checkpoints" )
        .atLeast( 1 )
        .optional();
    checkpoint
        .number( "every_time", "time between checkpoints; steps are not cut "
                               "for it" )
        .unit( "time" )
        .above( 0 )
        .optional();
    checkpoint
        .number( "every_wall_seconds", "seconds of the clock between "
                                       "checkpoints" )
        .unit( "s" )
        .above( 0 )
        .optional();
    checkpoint.integer( "keep", "how many checkpoints are kept, the last ones" )
        .atLeast( 1 )
        .atMost( most_steps )
        .defaultsTo( 2 );

    Parameters all( "input", "a run of machpoint", dimension );
    all.text( "scene", "name of the scene and of its output directory" )
        .nonEmpty();
    all.integer( "dimension", "number of axes" ).atLeast( 1 ).atMost( 3 );
    all.object( "grid", grid, "the domain and its cells" );
    all.object( "method", methodParameters( "", dimension ),
                "how the equations are solved" );
    all.object( "particles", particles, "how many particles, and where" );
    all.listOf( "physics", physicsFamily(),
                "the gas and the effects that act on it, in order" )
        .nonEmpty();
    all.listOf( "initial", initialFamily(),
                "what fills the domain; later entries overwrite earlier ones" )
        .nonEmpty();
    all.listOf( "boundary", boundaryFamily(), "sides and obstacles" )
        .nonEmpty();
    all.object( "time", time, "length of the run" );
    all.oneOf( "exact", exactFamily(), "exact solution to measure errors by" )
        .optional();
    all.object( "decomposition", decomposition,
                "which rank computes which part of the domain" );
    all.boolean( "reproducible", "the same bits on any number of ranks and "
                                 "threads, at a price (docs/ranks.md)" )
        .switches( "reproducible sums", false )
        .defaultsTo( false );
    all.object( "output", output, "what is written" );
    all.object( "checkpoint", checkpoint, "what to restart from, and when" );
    return all;
}

Json inputSchema()
{
    auto schema = jsonSchema( inputParameters( 0 ) );
    auto& method = schema["properties"]["method"];
    for ( const auto* name : { Paper::name, Apic::name } )
    {
        Json is_it, own;
        is_it["properties"]["name"]["const"] = name;
        is_it["required"] = Json::array( { "name" } );
        own["properties"] =
            jsonSchema( methodParameters( name, 0 ) )["properties"];
        own["additionalProperties"] = false;
        method["allOf"].push_back( { { "if", is_it }, { "then", own } } );
    }
    return schema;
}

std::string readFile( const std::string& file )
{
    std::ifstream stream( file, std::ios::binary );
    std::ostringstream text;
    if ( stream )
        text << stream.rdbuf();
    if ( !stream || stream.bad() || std::filesystem::is_directory( file ) )
        throw InputError( { file + ": cannot be read; check that the path is "
                                   "a readable file" } );
    return text.str();
}

namespace
{

//! What a resolved input says of its method.
MethodFacts methodFacts( const Json& input )
{
    const auto name = input.at( "method" ).at( "name" ).get<std::string>();
    return { name, name == Conservative::name };
}

//! The keys at an input's root with which nothing is wrong.
class SoundKeys
{
  public:
    //! \param resolved of `written`, perhaps incomplete
    //! \param errors that resolving has met
    SoundKeys( const Json& resolved, const Json& written,
               const std::string& file, const std::vector<std::string>& errors )
    {
        std::vector<std::string> known;
        for ( const auto all = inputParameters( 0 );
              const auto& key : all.keys() )
            known.push_back( key.name );
        for ( const auto& item : resolved.items() )
            _keys.insert( item.key() );
        remove( errors, file + ": " );
        // Of a key that is misspelt the default is not what was meant.
        if ( written.is_object() )
            for ( const auto& item : written.items() )
                if ( !resolved.contains( item.key() ) )
                    _keys.erase( nearest( item.key(), known ) );
    }

    //! Those that messages tell of, as in "PREFIX/grid/cells/0: ...".
    void remove( const std::vector<std::string>& messages,
                 const std::string& prefix )
    {
        for ( const auto& message : messages )
            if ( const auto begin = prefix.size() + 1;
                 message.starts_with( prefix + "/" ) )
                _keys.erase( message.substr(
                    begin, message.find_first_of( "/:", begin ) - begin ) );
    }

    bool have( const std::initializer_list<const char*> keys ) const
    {
        return std::all_of( keys.begin(), keys.end(),
                            [&]( const char* key )
                            { return _keys.count( key ) > 0; } );
    }

  private:
    std::set<std::string> _keys;
};

//! Collects what no single key can tell: conflicts between keys. What needs a
//! key that is wrong itself is left out.
class Checker
{
  public:
    Checker( const Json& input, const SoundKeys& sound, const int dimension )
        : _input( input ), _sound( sound ), _dimension( dimension )
    {
    }

    //! \return one line for each conflict
    std::vector<std::string> check()
    {
        if ( _sound.have( { "scene" } ) )
            checkFileName( _input.at( "scene" ), "/scene" );
        if ( _sound.have( { "time", "output" } ) )
            checkOutput();
        if ( _sound.have( { "method" } ) )
            checkMethod();
        if ( _sound.have( { "reproducible" } ) && is_single &&
             _input.at( "reproducible" ) )
            error( "/reproducible",
                   "such sums are of doubles: build with "
                   "Machpoint_PRECISION=double, or give false" );
        if ( !_sound.have( { "dimension" } ) )
            return _errors; // nothing is known of axes
        if ( _sound.have( { "grid" } ) )
            checkGrid();
        if ( _sound.have( { "grid", "method" } ) )
            checkReach();
        if ( _sound.have( { "grid", "particles" } ) )
            checkSize();
        if ( _sound.have( { "particles" } ) )
            checkParticles();
        if ( _sound.have( { "physics" } ) )
            checkPhysics();
        if ( _sound.have( { "initial" } ) )
            checkInitial();
        if ( _sound.have( { "boundary" } ) )
            checkBoundary();
        _sound.remove( _errors, "" );
        if ( _sound.have( { "grid", "physics", "initial", "boundary", "time",
                            "exact" } ) )
            checkExact();
        return _errors;
    }

  private:
    void error( const std::string& place, const std::string& message )
    {
        _errors.push_back( place + ": " + message );
    }

    //! Scenes and obstacles give files and directories their names.
    void checkFileName( const Json& name, const std::string& place )
    {
        const auto text = name.get<std::string>();
        const bool is_printed =
            std::all_of( text.begin(), text.end(),
                         []( const unsigned char c ) { return c >= ' '; } );
        if ( text.find_first_of( "/\\" ) != std::string::npos || text == "." ||
             text == ".." || !is_printed )
            error( place, "names a file or directory, so it must hold no "
                          "slash and no control character" );
        // File systems take 255 bytes, of which an ending needs some.
        if ( constexpr std::size_t most = 200; text.size() > most )
            error( place, fmt::format( "names a file or directory, so it must "
                                       "have at most {} bytes, not {}",
                                       most, text.size() ) );
    }

    void checkOutput()
    {
        const double end = _input.at( "time" ).at( "end" );
        const double every = _input.at( "output" ).value( "every", end );
        if ( end / every > most_outputs )
            error( "/output/every",
                   fmt::format( "{:g} asks for {:.3g} outputs until time.end; "
                                "take {:.3g} or more",
                                every, end / every, end / most_outputs ) );
    }

    //! Keys that `conservative` alone understands.
    void checkMethod()
    {
        const auto& method = _input.at( "method" );
        const auto name = method.at( "name" ).get<std::string>();
        if ( name == Conservative::name )
            return;
        const std::string remedy = fmt::format(
            "conservative understands this, {} does not; leave it out", name );
        for ( const auto parts = ConservativeParts::declare( 0 );
              const auto& part : parts.keys() )
            if ( method.contains( part.name ) )
                error( "/method/" + part.name, remedy );
        if ( method.at( "time" ) != "symplectic" )
            error( "/method/time", remedy );
    }

    //! Largest rounding of a position, in cells.
    static constexpr double widest_rounding = 5e-3;

    void checkGrid()
    {
        const auto& grid = _input.at( "grid" );
        for ( int d = 0; d < _dimension; ++d )
        {
            const double lower = grid.at( "lower" ).at( d );
            const double upper = grid.at( "upper" ).at( d );
            const std::int64_t cells = grid.at( "cells" ).at( d );
            if ( !( lower < upper ) )
                error( fmt::format( "/grid/upper/{}", d ),
                       fmt::format( "must be > lower ({}), got {}", lower,
                                    upper ) );
            if ( !std::isfinite( upper - lower ) )
                error( fmt::format( "/grid/upper/{}", d ),
                       "the domain is too large for floating point" );
            const double rounding =
                std::max( std::abs( lower ), std::abs( upper ) ) *
                std::numeric_limits<Real>::epsilon();
            const double spacing =
                ( upper - lower ) / static_cast<double>( cells );
            if ( lower < upper && std::isfinite( upper - lower ) &&
                 rounding > widest_rounding * spacing )
                error( fmt::format( "/grid/cells/{}", d ),
                       fmt::format(
                           "{} cells are too many for positions in {} "
                           "precision, which are known to {:.2g} of a cell "
                           "here, and {:g} is asked for: take fewer cells, put "
                           "the domain nearer to 0{}",
                           cells, precision_name, rounding / spacing,
                           widest_rounding,
                           is_single ? ", or build with "
                                       "Machpoint_PRECISION=double"
                                     : "" ) );
        }
    }

    //! Are there cells for what a method's basis reaches?
    void checkReach()
    {
        const auto& method = _input.at( "method" );
        const auto name = method.at( "name" ).get<std::string>();
        const auto basis = method.at( "basis" ).get<std::string>();
        const int least =
            ( basis == Linear::name ? 1 : 2 ) +
            ( name == Conservative::name ? Conservative::reach : 0 );
        for ( int d = 0; d < _dimension; ++d )
        {
            const std::int64_t cells =
                _input.at( "grid" ).at( "cells" ).at( d );
            if ( cells < least )
                error( fmt::format( "/grid/cells/{}", d ),
                       fmt::format( "{} on the {} basis needs at least {} "
                                    "cells along each axis, got {}",
                                    name, basis, least, cells ) );
        }
    }

    //! Can whole numbers count all cells and particles?
    void checkSize()
    {
        double cells_in_all = 1;
        for ( const auto& cells : _input.at( "grid" ).at( "cells" ) )
            cells_in_all *= cells.get<double>();
        const double places =
            cells_in_all *
            _input.at( "particles" ).at( "per_cell" ).get<double>();
        const int ranks = Communicator().size();
        auto require = [&]( const double number, const char* what,
                            const int most, const char* remedy )
        {
            if ( number / ranks > most )
                error( "/grid/cells",
                       fmt::format( "{:.3g} {} are more than {} can hold ({} "
                                    "each); take {}, or more ranks",
                                    number, what,
                                    ranks == 1
                                        ? "one process"
                                        : fmt::format( "{} ranks", ranks ),
                                    most, remedy ) );
        };
        constexpr int most = std::numeric_limits<int>::max();
        require( places, "particles", most,
                 "fewer cells or particles per cell" );
        // What marks the halves of cells has whole numbers, too.
        require( cells_in_all, "cells", most >> _dimension, "fewer cells" );
    }

    void checkParticles()
    {
        const auto& particles = _input.at( "particles" );
        const int n = particles.at( "per_cell" );
        if ( particles.at( "placement" ) != "random" &&
             latticeSize( n, _dimension ) == 0 )
        {
            const int q = std::max(
                1, static_cast<int>( std::pow( n, 1.0 / _dimension ) ) );
            error( "/particles/per_cell",
                   fmt::format( "a lattice in {0}D needs q^{0} particles per "
                                "cell, for example {1}, got {2}; or choose "
                                "placement random",
                                _dimension,
                                static_cast<int>( std::pow( q, _dimension ) ),
                                n ) );
        }
    }

    //! What the entry's own type finds, which may depend on the method.
    void checkEntry( const Json& entry, const InputHooks& hooks,
                     const std::string& place )
    {
        if ( !hooks.fault || !_sound.have( { "method" } ) )
            return;
        const auto fault = hooks.fault( entry, methodFacts( _input ) );
        if ( !fault.empty() )
            _errors.push_back( place + fault );
    }

    void checkPhysics()
    {
        std::set<std::string> seen;
        int gases = 0;
        int k = 0;
        for ( const auto& entry : _input.at( "physics" ) )
        {
            const auto place = fmt::format( "/physics/{}", k++ );
            const auto& factory = findFactory( physicsModules<3>(), entry );
            if ( !seen.insert( factory.name ).second )
                error( place, "a second " + factory.name + "; keep one" );
            gases += factory.is_equation_of_state ? 1 : 0;
            checkEntry( entry, physicsHooks( entry, _dimension ), place );
        }
        if ( gases != 1 )
            error( "/physics",
                   fmt::format( "one equation of state is needed, got {}; for "
                                "example {{ \"type\": \"ideal_gas\" }}",
                                gases ) );
    }

    void checkInitial()
    {
        int k = 0;
        for ( const auto& entry : _input.at( "initial" ) )
        {
            const auto place = fmt::format( "/initial/{}", k++ );
            if ( entry.contains( "region" ) )
                checkShape( entry.at( "region" ), place + "/region", _errors );
            if ( entry.contains( "normal" ) )
            {
                double length = 0;
                for ( const double n : entry.at( "normal" ) )
                    length += n * n;
                if ( !( length > 0 && std::isfinite( length ) ) )
                    error( place + "/normal", "must have a length" );
            }
        }
    }

    void checkBoundary()
    {
        const auto names = sideNames( _dimension );
        std::vector<int> entries( names.size() ), whole( names.size() ),
            periodic( names.size() );
        std::set<std::string> reported;
        int k = 0;
        for ( const auto& entry : _input.at( "boundary" ) )
        {
            const auto place = fmt::format( "/boundary/{}", k++ );
            checkEntry( entry, boundaryHooks( entry, _dimension ), place );
            for ( const auto* key : { "shape", "region" } )
                if ( entry.contains( key ) && entry.at( key ).is_object() )
                    checkShape( entry.at( key ), place + "/" + key, _errors );
            if ( entry.contains( "name" ) && entry.at( "name" ).is_string() )
            {
                checkFileName( entry.at( "name" ), place + "/name" );
                if ( !reported.insert( entry.at( "name" ).get<std::string>() )
                          .second )
                    error( place + "/name",
                           "a second entry of this name; its report would "
                           "replace the first one's" );
            }
            for ( const auto& claim : sidesOf( entry, _dimension ) )
            {
                ++entries[claim.side];
                whole[claim.side] += entry.contains( "region" ) ? 0 : 1;
                periodic[claim.side] +=
                    claim.kind == SideKind::periodic ? 1 : 0;
            }
        }
        for ( std::size_t side = 0; side < names.size(); ++side )
        {
            if ( entries[side] == 0 )
                error( "/boundary",
                       fmt::format(
                           "no entry for side {}; add one, for example {{ "
                           "\"type\": \"slip_wall\", \"side\": \"{}\" }}",
                           names[side], names[side] ) );
            if ( whole[side] > 1 || ( whole[side] == 1 && entries[side] > 1 ) )
                error( "/boundary", "more than one entry for side " +
                                        names[side] +
                                        "; keep one, or give all regions" );
            if ( periodic[side] && !periodic[side ^ 1] )
                error( "/boundary", names[side] +
                                        " is periodic, so its partner " +
                                        names[side ^ 1] + " must be too" );
        }
    }

    void checkExact()
    {
        try
        {
            static_cast<void>( makeExact( _input ) );
        }
        catch ( const std::invalid_argument& e )
        {
            _errors.push_back( e.what() );
        }
    }

    const Json& _input;
    SoundKeys _sound;
    int _dimension;
    std::vector<std::string> _errors;
};

//! Defaults that depend on the method, of what is sound.
void fillMethodDefaults( Json& input, const SoundKeys& sound )
{
    if ( !sound.have( { "dimension", "method" } ) )
        return;
    const int dimension = input.at( "dimension" );
    auto& method = input.at( "method" );
    auto fill = []( Json& object, const std::string& key, const Json& value )
    {
        if ( !object.contains( key ) )
            object[key] = value;
    };
    for ( const auto own = methodParameters( method.at( "name" ), dimension );
          const auto& key : own.keys() )
        if ( key.default_value )
            fill( method, key.name, *key.default_value );
    if ( sound.have( { "time" } ) )
        fill( input.at( "time" ), "cfl",
              ConservativeParts::defaultCfl( method.at( "time" ),
                                             method.at( "basis" ) ) );
    auto complete = [&]( const char* key, const auto& hooksOfEntry )
    {
        if ( !sound.have( { key } ) )
            return;
        for ( auto& entry : input.at( key ) )
            if ( const auto& hooks = hooksOfEntry( entry, dimension );
                 hooks.complete )
                hooks.complete( entry, methodFacts( input ) );
    };
    complete( "boundary", boundaryHooks );
    complete( "physics", physicsHooks );
}

//! The key with one value that an override reaches into, if it does: what the
//! file leaves out, applyOverride does not know. Empty: none.
std::string valueReachedInto( const std::string& assignment )
{
    auto text = assignment.substr( 0, assignment.find( '=' ) );
    std::replace( text.begin(), text.end(), '[', '.' );
    std::istringstream path( text );
    const auto all = inputParameters( 0 );
    const Parameters* place = &all;
    std::string name, step;
    while ( place && std::getline( path, step, '.' ) && !path.eof() )
    {
        name += ( name.empty() ? "" : "." ) + step;
        const auto& keys = place->keys();
        const auto key =
            std::find_if( keys.begin(), keys.end(),
                          [&]( const auto& k ) { return k.name == step; } );
        if ( key == keys.end() )
            return "";
        using Kind = Parameter::Kind;
        for ( const auto kind : { Kind::Number, Kind::Integer, Kind::Boolean,
                                  Kind::Text, Kind::Choice } )
            if ( key->kind == kind )
                return name;
        place = key->nested.get();
    }
    return "";
}

} // namespace

Json resolveInput( const Json& input, const std::string& file,
                   std::vector<std::string> errors )
{
    if ( input.is_object() && input.contains( "study" ) &&
         !input.contains( "scene" ) )
        throw InputError( { file + ": a study, not an input of one run; give "
                                   "it to machpoint study" } );
    int dimension = 0;
    if ( input.is_object() && input.contains( "dimension" ) )
    {
        const auto& value = input.at( "dimension" );
        if ( value.is_number_integer() && value >= 1 && value <= 3 )
            dimension = value;
    }
    Json resolved =
        resolve( input, inputParameters( dimension ), file, errors );
    const SoundKeys sound( resolved, input, file, errors );
    fillMethodDefaults( resolved, sound );
    for ( const auto& conflict : Checker( resolved, sound, dimension ).check() )
        errors.push_back( file + ": " + conflict );
    if ( !errors.empty() )
        throw InputError( errors );
    return resolved;
}

Json loadInput( const std::string& file,
                const std::vector<std::string>& overrides )
{
    std::vector<std::string> errors;
    Json input = parseJson( readFile( file ), file, errors );
    for ( const auto& assignment : overrides )
        try
        {
            if ( const auto key = valueReachedInto( assignment ); !key.empty() )
                throw InputError( { fmt::format(
                    "--set {}: {} is no object; set it itself, --set {}=VALUE",
                    assignment, key, key ) } );
            applyOverride( input, assignment );
        }
        catch ( const InputError& error )
        {
            errors.insert( errors.end(), error.messages().begin(),
                           error.messages().end() );
        }
    return resolveInput( input, file, std::move( errors ) );
}

} // namespace Machpoint
