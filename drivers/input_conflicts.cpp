/*!
  \file input_conflicts.cpp
  \brief Conflicts between the keys of an input.
*/
#include <drivers/input_conflicts.hpp>

#include <drivers/input.hpp>

#include <core/basis.hpp>
#include <core/communicator.hpp>
#include <core/exact.hpp>
#include <core/method_conservative.hpp>
#include <core/placement.hpp>
#include <core/registry.hpp>
#include <core/shape_input.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

namespace Machpoint
{

MethodFacts methodFacts( const Json& input )
{
    const auto name = input.at( "method" ).at( "name" ).get<std::string>();
    return { name, name == Conservative::name };
}

std::string fileNameFault( const std::string& name )
{
    if ( name.empty() )
        return "names a file or directory, so it must not be empty";
    const bool is_printed =
        std::all_of( name.begin(), name.end(),
                     []( const unsigned char c ) { return c >= ' '; } );
    if ( name.find_first_of( "/\\" ) != std::string::npos || name == "." ||
         name == ".." || !is_printed )
        return "names a file or directory, so it must hold no slash and no "
               "control character";
    // File systems take 255 bytes, of which an ending needs some.
    if ( constexpr std::size_t most = 200; name.size() > most )
        return fmt::format( "names a file or directory, so it must have at "
                            "most {} bytes, not {}",
                            most, name.size() );
    return "";
}

namespace
{

//! Outputs of a run.
constexpr double most_outputs = 1e8;

//! Collects the conflicts of an input.
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
        checkShapes( _input, inputParameters( _dimension ), "" );
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

    //! Scenes and series give files and directories their names.
    void checkFileName( const Json& name, const std::string& place )
    {
        const auto fault = fileNameFault( name.get<std::string>() );
        if ( !fault.empty() )
            error( place, fault );
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
            _errors.push_back(
                place + ( fault.find_first_of( "/:" ) == 0 ? "" : ": " ) +
                fault );
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
            checkSeries( entry, place );
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
            periodic( names.size() ), imposed( names.size() );
        int k = 0;
        for ( const auto& entry : _input.at( "boundary" ) )
        {
            const auto place = fmt::format( "/boundary/{}", k++ );
            const auto& hooks = boundaryHooks( entry, _dimension );
            checkEntry( entry, hooks, place );
            checkSeries( entry, place );
            const int layers =
                hooks.imposedCells ? hooks.imposedCells( entry ) : 0;
            for ( const auto& claim : sidesOf( entry, _dimension ) )
            {
                imposed[claim.side] = std::max( imposed[claim.side], layers );
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
        if ( _sound.have( { "grid" } ) )
            checkImposed( imposed );
    }

    //! Layers that the domain has no room for. \param imposed of cells at each
    //! side
    void checkImposed( const std::vector<int>& imposed )
    {
        const auto names = sideNames( _dimension );
        for ( int axis = 0; axis < _dimension; ++axis )
        {
            const auto cells = _input.at( "grid" )
                                   .at( "cells" )
                                   .at( axis )
                                   .get<std::int64_t>();
            const std::int64_t lower = imposed[2 * axis];
            const std::int64_t upper = imposed[2 * axis + 1];
            if ( lower + upper > cells )
                error( "/boundary",
                       fmt::format( "{} and {} keep {} layers of cells in a "
                                    "state of their own, and there are {}; "
                                    "take a smaller buffer",
                                    names[2 * axis], names[2 * axis + 1],
                                    lower + upper, cells ) );
        }
    }

    //! Modules' `name` is that of their series.
    void checkSeries( const Json& entry, const std::string& place )
    {
        if ( !entry.contains( "name" ) )
            return;
        const auto& name = entry.at( "name" );
        checkFileName( name, place + "/name" );
        const auto [first, is_new] =
            _series.emplace( name.get<std::string>(), place + "/name" );
        if ( !is_new )
            error( place + "/name",
                   fmt::format( "a second entry of the name \"{}\" (the first "
                                "is at {}); its report would replace that one",
                                first->first, first->second ) );
    }

    //! Shapes wherever they are declared. \param place of the object
    void checkShapes( const Json& object, const Parameters& declared,
                      const std::string& place )
    {
        for ( const auto& key : declared.keys() )
        {
            const auto value = object.find( key.name );
            const bool is_at_root = place.empty();
            if ( value == object.end() ||
                 ( is_at_root && !_sound.have( { key.name.c_str() } ) ) )
                continue;
            const auto there = place + "/" + key.name;
            if ( key.kind == Parameter::Kind::Object )
                checkShapes( *value, *key.nested, there );
            else if ( key.kind == Parameter::Kind::OneOf )
                checkShapesOfMember( *value, key.family, there );
            else if ( key.kind == Parameter::Kind::ListOf )
                for ( std::size_t k = 0; k < value->size(); ++k )
                    checkShapesOfMember( value->at( k ), key.family,
                                         fmt::format( "{}/{}", there, k ) );
        }
    }

    //! The same of an object that is one of a family.
    void checkShapesOfMember( const Json& object, const Family& family,
                              const std::string& place )
    {
        if ( family.name == shapeFamily().name )
            return checkShape( object, place, _errors );
        for ( const auto& member : family.members( _dimension ) )
            if ( object.at( "type" ) == member.name() )
                checkShapes( object, member, place );
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
    std::map<std::string, std::string> _series; // names and their places
};

} // namespace

std::vector<std::string>
findConflicts( const Json& input, const SoundKeys& sound, const int dimension )
{
    return Checker( input, sound, dimension ).check();
}

} // namespace Machpoint
