/*!
  \file warnings.cpp
  \brief The start of a scene, sampled: what its gas tells the modules, and what
  none of them would say.
*/
#include <drivers/warnings.hpp>

#include <drivers/body_doubts.hpp>
#include <drivers/exact_doubts.hpp>
#include <drivers/sample_grid.hpp>

#include <core/initial_gas.hpp>
#include <core/method_apic.hpp>
#include <core/method_conservative.hpp>
#include <core/method_paper.hpp>
#include <core/scene.hpp>
#include <physics/initial/blast.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace Machpoint
{

namespace
{

//! Pressure behind a wave over that ahead of it which makes it a shock.
constexpr double least_shock = 1.1;
//! Speed, in sound speeds, past which the flow about most bodies has shocks.
constexpr double critical_mach = 0.7;
//! Of time.cfl, up to which all hard cases were run (docs/method.md, section
//! 6).
constexpr double largest_cfl = 1.2;
//! Differences of a uniform gas, relative: what a few operations round.
constexpr double same = 1e-12;

//! The start of a scene, sampled.
template <int Dim>
class Survey
{
  public:
    explicit Survey( const Json& input )
        : _input( input ), _initial( input ), _law( findGasLaw( input ) ),
          _samples( input ), _grid( _samples.grid() )
    {
        int k = 0;
        for ( const auto& entry : input.at( "boundary" ) )
        {
            const auto place = fmt::format( "/boundary/{}", k++ );
            if ( const auto& hooks = boundaryHooks( entry, Dim ); hooks.solid )
                _bodies.push_back(
                    { place,
                      makeShape<Dim, Kokkos::HostSpace>( hooks.solid( entry ) ),
                      entry.contains( "treatment" ) &&
                          entry.at( "treatment" ) == "images" } );
        }
    }

    FlowFacts facts()
    {
        FlowFacts facts;
        facts.input = _input;
        facts.effects = static_cast<int>( _input.at( "physics" ).size() ) - 1;
        for ( int d = 0; d < Dim; ++d )
            facts.extent[d] = _grid.upper[d] - _grid.lower[d];
        if ( _law )
        {
            sample();
            facts.least_speed = _least_speed;
            facts.is_undisturbed = _first && _is_uniform && !mayHide() &&
                                   !sidesDisturb() && !isNoisy();
            facts.shock = findShock();
        }
        const auto& method = _input.at( "method" );
        const auto name = method.at( "name" ).get<std::string>();
        facts.shocks_need_viscosity =
            name == Paper::name  ? Paper::shocks_need_viscosity
            : name == Apic::name ? Apic::shocks_need_viscosity
                                 : Conservative::shocks_need_viscosity;
        facts.waves_grow =
            name == Conservative::name && method.at( "time" ) == "symplectic";
        return facts;
    }

    //! What no module would say, of a gas that facts() has looked at.
    std::vector<std::string> oddities() const
    {
        std::vector<std::string> odd;
        if ( !_law )
            return odd;
        if ( !_first )
            odd.push_back( "/initial: no gas is at any place that was looked "
                           "at, so a run may find no room for a particle; "
                           "fill the domain, or leave room beside bodies" );
        for ( const auto& doubt : findBodyDoubts( _input, _samples, _bodies ) )
            odd.push_back( doubt );
        tellOfSmallBlasts( odd );
        return odd;
    }

  private:
    //! Of energy that particles hardly take up, as they miss where it is.
    void tellOfSmallBlasts( std::vector<std::string>& odd ) const
    {
        const double per_cell = _input.at( "particles" ).at( "per_cell" );
        const double least = 0.5 * makeGrid<Dim>( _input ).maxSpacing() /
                             std::pow( per_cell, 1.0 / Dim );
        int k = 0;
        for ( const auto& entry : _input.at( "initial" ) )
        {
            const auto place = fmt::format( "/initial/{}", k++ );
            if ( entry.at( "type" ) != Blast::name )
                continue;
            if ( const double radius = entry.at( "radius" ); radius < least )
                odd.push_back( fmt::format(
                    "{}/radius: {:.3g} is so small that particles take up its "
                    "energy by chance; give it half their distance, {:.3g}, or "
                    "more",
                    place, radius, least ) );
        }
    }

    //! The gas at a place; of zero density in a body.
    GasState gasAt( const Vector<Dim>& x ) const
    {
        if ( isInBody<Dim>( _bodies, x ) )
            return {};
        Gradient gradient;
        return _initial.at( x, gradient );
    }

    static double speed( const GasState& gas )
    {
        return std::sqrt( dot<3>( gas.velocity, gas.velocity ) );
    }

    bool areSame( const GasState& a, const GasState& b ) const
    {
        double difference = 0;
        for ( int d = 0; d < 3; ++d )
            difference += std::abs( a.velocity[d] - b.velocity[d] );
        return std::abs( a.density - b.density ) <= same * a.density &&
               std::abs( a.pressure - b.pressure ) <= same * a.pressure &&
               difference <= same * ( speed( a ) + soundSpeed( a, *_law ) );
    }

    //! Asks for the gas everywhere.
    void sample()
    {
        _gas.resize( _samples.count() );
        _samples.forEach(
            [&]( const Indices<Dim>& i, const int flat )
            {
                const auto x = _samples.center( i );
                for ( auto& body : _bodies )
                {
                    const double distance = body.shape.distance( x );
                    if ( distance >= body.nearest_sample )
                        continue;
                    body.nearest_sample = distance;
                    body.sample = x;
                }
                const auto gas = gasAt( x );
                if ( const auto fault = _initial.fault( x, gas );
                     !fault.empty() )
                    throw InputError( { fault } );
                _gas[flat] = gas;
                if ( gas.density > 0 )
                {
                    _least_speed = std::min(
                        _least_speed, speed( gas ) + soundSpeed( gas, *_law ) );
                    if ( !_first )
                        _first = gas;
                    _is_uniform = _is_uniform && areSame( *_first, gas );
                }
                else if ( !isInBody<Dim>( _bodies, x ) )
                    _is_uniform = false; // it will flow there
            } );
    }

    //! May samples that are farther apart than cells miss a small region?
    bool mayHide() const
    {
        const auto& entries = _input.at( "initial" );
        return _grid.cells != makeGrid<Dim>( _input ).cells &&
               std::any_of( entries.begin(), entries.end(),
                            []( const Json& entry )
                            { return entry.contains( "region" ); } );
    }

    //! Would sides or bodies disturb the gas, were it uniform?
    bool sidesDisturb() const
    {
        const double still =
            same * ( speed( *_first ) + soundSpeed( *_first, *_law ) );
        if ( !_bodies.empty() && speed( *_first ) > still )
            return true;
        const auto& entries = _input.at( "boundary" );
        return std::any_of(
            entries.begin(), entries.end(),
            [&]( const Json& entry )
            {
                const auto& hooks = boundaryHooks( entry, Dim );
                if ( !hooks.keeps_uniform_gas )
                    return true; // nobody knows
                if ( !hooks.beyond )
                    return false; // a body, which was looked at above
                const auto sides = sidesOf( entry, Dim );
                return std::any_of(
                    sides.begin(), sides.end(),
                    [&]( const SideClaim& claim )
                    {
                        return !areSame(
                            *_first,
                            gasBeyond( entry, hooks, claim, *_first, *_law ) );
                    } );
            } );
    }

    //! Does a uniform gas not stay so, because its particles lie at random?
    bool isNoisy() const
    {
        return _input.at( "method" ).at( "name" ) != Conservative::name &&
               _input.at( "particles" ).at( "placement" ) != "lattice";
    }

    /*!
      \brief Pressure behind over that ahead of the strongest wave of two gases
      that meet, < 1 where none is a shock.
      \param axis along which b lies behind a
    */
    double strongest( GasState a, GasState b, const int axis ) const
    {
        if ( a.density <= 0 || b.density <= 0 )
            return 0; // it flows into a vacuum
        std::swap( a.velocity[0], a.velocity[axis] );
        std::swap( b.velocity[0], b.velocity[axis] );
        // Weak ones, without the work.
        const double before = a.pressure + _law->pressure_offset;
        const double behind = b.pressure + _law->pressure_offset;
        if ( std::abs( before - behind ) < 0.02 * std::min( before, behind ) &&
             a.velocity[0] - b.velocity[0] <
                 0.02 * std::min( soundSpeed( a, *_law ),
                                  soundSpeed( b, *_law ) ) )
            return 0;
        const RiemannSolution waves( a, b, _law->gamma, _law->pressure_offset );
        return ( waves.starPressure() + _law->pressure_offset ) /
               std::min( before, behind );
    }

    //! The same of what lies between two places. Where the gas is smooth, a
    //! sixteenth of the way shows no more than a sixteenth of the difference.
    double strongestBetween( Vector<Dim> a, Vector<Dim> b,
                             const int axis ) const
    {
        double strength = strongest( gasAt( a ), gasAt( b ), axis );
        for ( int halving = 0; halving < 4 && strength > least_shock;
              ++halving )
        {
            auto middle = a;
            middle[axis] = 0.5 * ( a[axis] + b[axis] );
            const double before =
                strongest( gasAt( a ), gasAt( middle ), axis );
            const double behind =
                strongest( gasAt( middle ), gasAt( b ), axis );
            ( before < behind ? a : b ) = middle;
            strength = std::max( before, behind );
        }
        return strength;
    }

    std::string tell( const Vector<Dim>& x, const std::string& what,
                      const double strength ) const
    {
        return fmt::format( "{} near {} sends off a shock, {:.3g} times the "
                            "pressure",
                            what, placeText<Dim>( x ), strength );
    }

    //! The first shock that is found, in words.
    std::string findShock() const
    {
        std::string found;
        _samples.forEach(
            [&]( const Indices<Dim>& i, const int flat )
            {
                if ( !found.empty() || _gas[flat].density <= 0 )
                    return;
                const auto x = _samples.center( i );
                int stride = 1;
                for ( int d = 0; d < Dim && found.empty(); ++d )
                {
                    found = shockBeyond( i, flat, stride, d );
                    stride *= _grid.cells[d];
                }
                if ( found.empty() )
                    found = shockOfBody( x, _gas[flat] );
            } );
        return found;
    }

    //! Between a sample and the next one along an axis, or at a side.
    std::string shockBeyond( const Indices<Dim>& i, const int flat,
                             const int stride, const int axis ) const
    {
        const auto x = _samples.center( i );
        if ( i[axis] + 1 < _grid.cells[axis] &&
             strongest( _gas[flat], _gas[flat + stride], axis ) > least_shock )
        {
            auto y = x;
            y[axis] += _grid.spacing[axis];
            const double strength = strongestBetween( x, y, axis );
            if ( strength > least_shock )
                return tell( x, "the gas", strength );
        }
        for ( const bool upper : { false, true } )
            if ( i[axis] == ( upper ? _grid.cells[axis] - 1 : 0 ) )
            {
                auto side = x;
                side[axis] = upper ? _grid.upper[axis] : _grid.lower[axis];
                const auto beyond =
                    gasBeyond<Dim>( _input, 2 * axis + ( upper ? 1 : 0 ), side,
                                    _gas[flat], *_law );
                const double strength =
                    upper ? strongest( _gas[flat], beyond, axis )
                          : strongest( beyond, _gas[flat], axis );
                if ( strength > least_shock )
                    return tell(
                        x,
                        fmt::format( "the side {}",
                                     sideNames( Dim )[2 * axis + upper] ),
                        strength );
            }
        return "";
    }

    //! Of fast gas that meets a body within a cell.
    std::string shockOfBody( const Vector<Dim>& x, const GasState& gas ) const
    {
        if ( speed( gas ) < critical_mach * soundSpeed( gas, *_law ) )
            return "";
        for ( const auto& body : _bodies )
        {
            const auto nearest = body.shape.nearest( x );
            if ( nearest.distance > _grid.minSpacing() )
                continue;
            // Along the normal, as axis 0, the gas meets its mirror image.
            Vector3 normal{};
            for ( int d = 0; d < Dim; ++d )
                normal[d] = nearest.normal[d];
            const double approach = -dot<3>( gas.velocity, normal );
            auto turned = gas, image = gas;
            turned.velocity = { approach, 0, 0 };
            image.velocity = { -approach, 0, 0 };
            const double strength = strongest( turned, image, 0 );
            if ( strength > least_shock )
                return tell( x, "the gas that meets the body", strength );
        }
        return "";
    }

    const Json& _input;
    InitialGas<Dim> _initial;
    std::optional<GasLaw> _law; // else nothing is known of sound and shocks
    SampleGrid<Dim> _samples;
    const Grid<Dim>& _grid; // its own
    std::vector<SampledBody<Dim>> _bodies;
    std::vector<GasState> _gas;
    std::optional<GasState> _first;
    double _least_speed = Kokkos::Experimental::infinity_v<double>;
    bool _is_uniform = true;
};

//! Facts for the modules, and what none of them would say.
using Findings = std::pair<FlowFacts, std::vector<std::string>>;

template <int Dim>
Findings surveyInput( const Json& input )
{
    Survey<Dim> survey( input );
    auto facts = survey.facts();
    return { std::move( facts ), survey.oddities() };
}

Findings surveyInput( const Json& input )
{
    switch ( input.at( "dimension" ).get<int>() )
    {
    case 1:
        return surveyInput<1>( input );
    case 2:
        return surveyInput<2>( input );
    default:
        return surveyInput<3>( input );
    }
}

//! What effects say of the scene, those that it leaves out, too.
template <class Factories>
void addRemarks( const Factories& factories, const Json& input,
                 const FlowFacts& facts, std::vector<std::string>& warnings )
{
    for ( const auto& factory : factories )
    {
        if ( !factory.input.remark )
            continue;
        const auto& physics = input.at( "physics" );
        std::string place = "/physics";
        const Json* entry = nullptr;
        for ( std::size_t k = 0; k < physics.size(); ++k )
            if ( physics[k].at( "type" ) == factory.name )
            {
                entry = &physics[k];
                place = fmt::format( "/physics/{}", k );
            }
        const auto remark = factory.input.remark( entry, facts );
        if ( !remark.empty() )
            warnings.push_back( fmt::format( "{}: {}", place, remark ) );
    }
}

} // namespace

std::vector<std::string> findWarnings( const Json& input )
{
    checkSides( input );
    auto [facts, warnings] = surveyInput( input );
    if ( const double cfl = input.at( "time" ).at( "cfl" ); cfl > largest_cfl )
        warnings.push_back( fmt::format(
            "/time/cfl: {:g} is more than all hard cases were run with: with "
            "midpoint they repeat 8 steps at 0.8, 15 at 1 and 288 at {:g} "
            "(docs/method.md, section 6), and symplectic and other methods "
            "stand less in some scenes (docs/stability.md); take {:g} or less",
            cfl, largest_cfl, largest_cfl ) );
    for ( const auto& doubt : findExactDoubts( input ) )
        warnings.push_back( doubt );
    switch ( input.at( "dimension" ).get<int>() )
    {
    case 1:
        addRemarks( physicsModules<1>(), input, facts, warnings );
        break;
    case 2:
        addRemarks( physicsModules<2>(), input, facts, warnings );
        break;
    default:
        addRemarks( physicsModules<3>(), input, facts, warnings );
    }
    return warnings;
}

} // namespace Machpoint
