/*!
  \file exact.cpp
  \brief The exact solutions that an input names.
*/
#include <core/exact.hpp>
#include <core/exact_input.hpp>
#include <core/sedov.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

ExactSolution::~ExactSolution() = default;

namespace
{
//! The entry of /initial of a type that lies on top: the last that fills the
//! domain, or else the last.
const Json& topOfType( const Json& input, const std::string& type )
{
    const Json* top = nullptr;
    for ( const Json& entry : input.at( "initial" ) )
        if ( entry.at( "type" ) == type &&
             ( !top || !entry.contains( "region" ) ||
               top->contains( "region" ) ) )
            top = &entry;
    if ( top )
        return *top;
    throw std::invalid_argument( "/exact: needs an entry of type \"" + type +
                                 "\" in /initial" );
}

//! Swaps the x axis and a unit vector by reflection; its own inverse.
Vector3 reflect( const Vector3& v, const Vector3& normal )
{
    const Vector3 w = { 1 - normal[0], -normal[1], -normal[2] };
    const double square = dot<3>( w, w );
    if ( square == 0 )
        return v;
    const double factor = 2 * dot<3>( w, v ) / square;
    return { v[0] - factor * w[0], v[1] - factor * w[1], v[2] - factor * w[2] };
}

//! A state with its velocity in the frame whose first axis is the normal.
GasState reflect( GasState gas, const Vector3& normal )
{
    gas.velocity = reflect( gas.velocity, normal );
    return gas;
}

//! x / t. At the start every point lies infinitely many speeds away.
double raySpeed( double x, double t )
{
    const double infinity = std::numeric_limits<double>::infinity();
    return t > 0 ? x / t : ( x < 0 ? -infinity : infinity );
}

//! Two uniform states that meet at a plane.
class RiemannExact : public ExactSolution
{
  public:
    RiemannExact( const Json& initial, const GasLaw& law )
        : _normal( unitNormal( initial ) ),
          _position( initial.at( "position" ).get<double>() ),
          _solution( reflect( toGasState( initial.at( "left" ) ), _normal ),
                     reflect( toGasState( initial.at( "right" ) ), _normal ),
                     law.gamma, law.pressure_offset )
    {
    }

    GasState state( const Vector3& x, double t ) const override
    {
        const double distance = dot<3>( _normal, x ) - _position;
        return reflect( _solution.sample( raySpeed( distance, t ) ), _normal );
    }

  private:
    Vector3 _normal;
    double _position;
    RiemannSolution _solution;
};

//! The same state everywhere and for ever.
class UniformExact : public ExactSolution
{
  public:
    explicit UniformExact( const GasState& gas ) : _gas( gas ) {}

    GasState state( const Vector3&, double ) const override { return _gas; }

  private:
    GasState _gas;
};

//! A column at rest: dp/dx = rho g with p / rho constant.
class HydrostaticExact : public ExactSolution
{
  public:
    explicit HydrostaticExact( const Json& initial )
        : _axis( axisVector( initial.at( "axis" ) ) ),
          _base( initial.at( "position" ).get<double>() ),
          _density( initial.at( "density" ).get<double>() ),
          _pressure( initial.at( "pressure" ).get<double>() ),
          _gravity( initial.at( "gravity" ).get<double>() )
    {
        if ( !( _density > 0 && _pressure > 0 ) )
            throw std::invalid_argument( "/exact: the hydrostatic entry in "
                                         "/initial needs a density and a "
                                         "pressure > 0" );
    }

    GasState state( const Vector3& x, double ) const override
    {
        const double height = dot<3>( _axis, x ) - _base;
        const double ratio =
            std::exp( _gravity * _density / _pressure * height );
        return { _density * ratio, { 0, 0, 0 }, _pressure * ratio };
    }

  private:
    Vector3 _axis;
    double _base;
    double _density;
    double _pressure;
    double _gravity;
};

/*!
  A piston that moves along an axis from t = 0, with uniform gas before it.

  The gas behaves as if its mirror image in the piston stood on the other side:
  the contact of that Riemann problem moves with the piston. So the shock obeys
  the jump conditions at any strength, and a piston that recedes draws a fan.
  Behind the piston there is no gas; asked there, the answer is the state at
  the piston.
*/
class PistonExact : public ExactSolution
{
  public:
    PistonExact( const Json& exact, const GasState& gas, const GasLaw& law )
        : _axis( axisVector( exact.at( "axis" ) ) ),
          _position( exact.at( "position" ).get<double>() ),
          _velocity( exact.at( "velocity" ).get<double>() ),
          _solution( mirrored( reflect( gas, _axis ), _velocity ),
                     reflect( gas, _axis ), law.gamma, law.pressure_offset )
    {
    }

    GasState state( const Vector3& x, double t ) const override
    {
        const double speed = std::max( rayTo( x, t ), _velocity );
        return reflect( _solution.sample( speed ), _axis );
    }

    bool hasGas( const Vector3& x, double t ) const override
    {
        return rayTo( x, t ) >= _velocity;
    }

  private:
    Vector3 _axis;
    double _position;
    double _velocity;
    RiemannSolution _solution;

    double rayTo( const Vector3& x, double t ) const
    {
        return raySpeed( dot<3>( _axis, x ) - _position, t );
    }

    static GasState mirrored( GasState gas, double piston_velocity )
    {
        gas.velocity[0] = 2 * piston_velocity - gas.velocity[0];
        return gas;
    }
};

//! A simple wave, until it breaks.
class AcousticWaveExact : public ExactSolution
{
  public:
    explicit AcousticWaveExact( const Json& input )
        : _wave( makeAcousticWave( topOfType( input, "acoustic_wave" ),
                                   gasLaw( input ) ) )
    {
        const double end = input.at( "time" ).at( "end" );
        if ( end > _wave.breakingTime() )
            throw std::invalid_argument(
                "/exact: the wave breaks at t = " +
                std::to_string( _wave.breakingTime() ) +
                ", before /time/end; lower its amplitude" );
    }

    GasState state( const Vector3& x, double t ) const override
    {
        return _wave.state( x, t );
    }

  private:
    AcousticWave _wave;
};

//! A vortex in a stream; what leaves through a periodic side comes back.
class VortexExact : public ExactSolution
{
  public:
    explicit VortexExact( const Json& input )
        : _vortex( makeIsentropicVortex(
              topOfType( input, "isentropic_vortex" ), gasLaw( input ) ) ),
          _periods( periodsOf( input ) )
    {
    }

    GasState state( const Vector3& x, double t ) const override
    {
        Vector3 offset{};
        for ( int d = 0; d < 3; ++d )
            offset[d] =
                x[d] - _vortex.center()[d] - _vortex.stream().velocity[d] * t;
        return _vortex.stateAt( toNearestImage( offset, _periods ) );
    }

  private:
    IsentropicVortex _vortex;
    Vector3 _periods;
};

//! The blast of a point explosion in uniform gas, which may move.
class SedovExact : public ExactSolution
{
  public:
    explicit SedovExact( const Json& input )
        : _blast( topOfType( input, "blast" ) ),
          _ambient( ambient( input, _blast ) ),
          _center( toVector3( _blast.at( "center" ) ) ),
          _periods( periodsOf( input ) ),
          _dimension( static_cast<int>( _blast.at( "center" ).size() ) ),
          _solution( _dimension, _blast.at( "energy" ), _ambient.density,
                     gasLaw( input ).gamma )
    {
        if ( gasLaw( input ).pressure_offset != 0 )
            throw std::invalid_argument( "/exact: sedov needs an ideal gas" );
        const double end = input.at( "time" ).at( "end" );
        const double most =
            1e-3 *
            _solution.inside( _solution.shockRadius( end ), end ).pressure;
        if ( _ambient.pressure > most )
            throw std::invalid_argument( fmt::format(
                "/exact: sedov is of a cold gas; the pressure around the blast "
                "must not exceed {:.3g}, a thousandth of that behind the shock "
                "at /time/end",
                most ) );
    }

    GasState state( const Vector3& x, double t ) const override
    {
        Vector3 n = { 0, 0, 0 };
        for ( int d = 0; d < _dimension; ++d )
            n[d] = x[d] - _center[d] - _ambient.velocity[d] * t;
        n = toNearestImage( n, _periods );
        const double r = std::hypot( n[0], n[1], n[2] );
        GasState gas = _ambient;
        if ( !( t > 0 ) || r >= _solution.shockRadius( t ) )
            return gas;
        const auto radial = _solution.inside( r, t );
        gas.density = radial.density;
        gas.pressure = radial.pressure;
        for ( int d = 0; d < 3 && r > 0; ++d )
            gas.velocity[d] += radial.velocity * n[d] / r;
        return gas;
    }
    bool holdsAtStart() const override { return false; }

  private:
    const Json _blast;
    GasState _ambient;
    Vector3 _center;
    Vector3 _periods;
    int _dimension;
    SedovSolution _solution;

    //! What the blast says of the gas, or else the uniform entry below it, or
    //! else the blast's defaults.
    static GasState ambient( const Json& input, const Json& blast )
    {
        GasState gas = { 1, { 0, 0, 0 }, 1e-5 };
        bool is_uniform = true;
        for ( const Json& entry : input.at( "initial" ) )
        {
            if ( entry == blast )
                break;
            is_uniform =
                entry.at( "type" ) == "uniform" && !entry.contains( "region" );
            if ( is_uniform )
                gas = toGasState( entry );
        }
        if ( !is_uniform &&
             !( blast.contains( "density" ) && blast.contains( "velocity" ) &&
                blast.contains( "pressure" ) ) )
            throw std::invalid_argument(
                "/exact: sedov needs uniform gas around the blast: give the "
                "blast a density, a velocity and a pressure, or nothing but a "
                "uniform entry without a region before it" );
        if ( blast.contains( "density" ) )
            gas.density = blast.at( "density" );
        if ( blast.contains( "velocity" ) )
            gas.velocity = toVector3( blast.at( "velocity" ) );
        if ( blast.contains( "pressure" ) )
            gas.pressure = blast.at( "pressure" );
        return gas;
    }
};

//! Noh's implosion.
class NohExact : public ExactSolution
{
  public:
    explicit NohExact( const Json& input )
        : _noh( makeNoh( topOfType( input, "noh" ), gasLaw( input ) ) )
    {
        const auto initial = topOfType( input, "noh" );
        const double speed = initial.at( "speed" );
        const double inertia =
            initial.at( "density" ).get<double>() * speed * speed;
        if ( gasLaw( input ).pressure_offset != 0 )
            throw std::invalid_argument( "/exact: noh needs an ideal gas" );
        if ( initial.at( "pressure" ).get<double>() > 1e-3 * inertia )
            throw std::invalid_argument( fmt::format(
                "/exact: noh is of a cold gas; its pressure must not exceed "
                "{:g}, a thousandth of density speed^2",
                1e-3 * inertia ) );
    }

    GasState state( const Vector3& x, double t ) const override
    {
        return _noh.state( x, t );
    }

  private:
    NohSolution _noh;
};

//! A shock within its width.
class ViscousShockExact : public ExactSolution
{
  public:
    explicit ViscousShockExact( const Json& input )
        : _shock(
              makeViscousShock( topOfType( input, "viscous_shock" ), input ) )
    {
    }

    GasState state( const Vector3& x, double t ) const override
    {
        return _shock.state( x, t );
    }

  private:
    ViscousShock _shock;
};
} // namespace

std::unique_ptr<ExactSolution> makeExact( const Json& resolved_input )
{
    if ( !resolved_input.contains( "exact" ) )
        return nullptr;
    const Json& exact = resolved_input.at( "exact" );
    const std::string type = exact.at( "type" ).get<std::string>();
    const auto initial = [&]( const std::string& name ) -> const Json&
    { return topOfType( resolved_input, name ); };

    try
    {
        // The energy of any of them is compared.
        const GasLaw law = gasLaw( resolved_input );
        if ( type == "acoustic_wave" )
            return std::make_unique<AcousticWaveExact>( resolved_input );
        if ( type == "isentropic_vortex" )
            return std::make_unique<VortexExact>( resolved_input );
        if ( type == "sedov" )
            return std::make_unique<SedovExact>( resolved_input );
        if ( type == "noh" )
            return std::make_unique<NohExact>( resolved_input );
        if ( type == "viscous_shock" )
            return std::make_unique<ViscousShockExact>( resolved_input );
        if ( type == "riemann" )
            return std::make_unique<RiemannExact>( initial( "riemann" ), law );
        if ( type == "uniform" )
            return std::make_unique<UniformExact>(
                toGasState( initial( "uniform" ) ) );
        if ( type == "hydrostatic" )
            return std::make_unique<HydrostaticExact>(
                initial( "hydrostatic" ) );
        if ( type == "piston_shock" )
            return std::make_unique<PistonExact>(
                exact, toGasState( initial( "uniform" ) ), law );
    }
    catch ( const std::invalid_argument& error )
    {
        const std::string what = error.what();
        // The Riemann solution knows nothing of an input and its places.
        throw std::invalid_argument(
            what.starts_with( "/" ) ? what : "/exact: " + what );
    }
    throw std::invalid_argument( "/exact/type: there is no exact solution \"" +
                                 type + "\"" );
}

Family exactFamily()
{
    const auto members = []( int dimension )
    {
        std::vector<Parameters> solutions;
        solutions.emplace_back(
            "riemann", "two states that meet at a plane, from /initial",
            dimension );
        solutions.emplace_back(
            "uniform", "the uniform state of /initial, for ever", dimension );
        solutions.emplace_back( "hydrostatic", "the column of /initial at rest",
                                dimension );

        Parameters piston( "piston_shock",
                           "piston that moves into the uniform state of "
                           "/initial",
                           dimension );
        const std::vector<std::string> axes = { "x", "y", "z" };
        piston
            .choice( "axis",
                     { axes.begin(),
                       axes.begin() + ( dimension == 0 ? 3 : dimension ) },
                     "axis along which it moves" )
            .defaultsTo( "x" );
        piston.number( "position", "where it starts" ).unit( "length" );
        piston
            .number( "velocity", "its velocity, along the axis; the gas lies "
                                 "on the upper side" )
            .unit( "length/time" );
        solutions.push_back( piston );
        solutions.emplace_back(
            "acoustic_wave", "the acoustic_wave of /initial, until it breaks",
            dimension );
        if ( dimension != 1 )
            solutions.emplace_back( "isentropic_vortex",
                                    "the isentropic_vortex of /initial, "
                                    "carried along by its stream",
                                    dimension );
        solutions.emplace_back(
            "noh", "the noh of /initial: shock and infalling gas", dimension );
        solutions.emplace_back(
            "sedov", "the blast of /initial from a point, in cold uniform gas",
            dimension );
        solutions.emplace_back(
            "viscous_shock", "the viscous_shock of /initial, in infinite space",
            dimension );
        return solutions;
    };
    return { "exact", members };
}

} // namespace Machpoint
