/*!
  \file exact.cpp
  \brief Exact solutions: Riemann problem, simple wave, vortex, Noh's and
  Sedov's problems,
  uniform flow, hydrostatic column, piston.
*/
#include <core/exact.hpp>
#include <core/sedov.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

//---------------------------------------------------------------------------//
// Riemann problem
//---------------------------------------------------------------------------//
namespace
{
constexpr double infinity = std::numeric_limits<double>::infinity();

//! Refuses what no stiffened gas can be; pressure is the shifted one.
void requireGas( const GasState& gas, const std::string& side )
{
    const bool is_finite =
        std::isfinite( gas.density ) && std::isfinite( gas.pressure ) &&
        std::all_of( &gas.velocity[0], &gas.velocity[0] + 3,
                     []( double v ) { return std::isfinite( v ); } );
    if ( !is_finite )
        throw std::invalid_argument( side + " state is not finite" );
    if ( gas.density < 0 )
        throw std::invalid_argument( side + " density is negative" );
    if ( gas.density > 0 && gas.pressure < 0 )
        throw std::invalid_argument( side +
                                     " pressure is below that of a cold gas" );
}
} // namespace

RiemannSolution::RiemannSolution( GasState left, GasState right, double gamma,
                                  double pressure_offset )
    : _gamma( gamma ), _offset( pressure_offset )
{
    if ( !( gamma > 1 ) || !std::isfinite( gamma ) )
        throw std::invalid_argument( "gamma must be finite and > 1" );
    if ( !( pressure_offset >= 0 ) || !std::isfinite( pressure_offset ) )
        throw std::invalid_argument( "pressure offset must be finite, >= 0" );
    left.pressure += _offset;
    right.pressure += _offset;
    requireGas( left, "left" );
    requireGas( right, "right" );
    if ( left.density == 0 && right.density == 0 )
        throw std::invalid_argument( "both states are vacuum" );

    _left = makeSide( left, 1 );
    _right = makeSide( right, -1 );

    // Each gas can expand up to its escape velocity; where these leave a gap
    // there is vacuum (Toro 2009, section 4.6).
    const double escape = 2 / ( _gamma - 1 );
    _left.star_velocity = left.density > 0
                              ? _left.velocity + escape * _left.sound_speed
                              : -infinity;
    _right.star_velocity = right.density > 0
                               ? _right.velocity + escape * _right.sound_speed
                               : -infinity;
    // In the mirrored frame the right front stands at minus its velocity.
    const double gap = -_right.star_velocity - _left.star_velocity;
    _has_vacuum = gap > 0;
    if ( gap >= 0 )
    {
        _star_pressure = 0;
        if ( left.density == 0 )
            _star_velocity = -_right.star_velocity;
        else if ( right.density == 0 )
            _star_velocity = _left.star_velocity;
        else
            _star_velocity =
                0.5 * ( _left.star_velocity - _right.star_velocity );
    }
    else
    {
        _star_pressure = solvePressure();
        _star_velocity = 0.5 * ( _left.velocity - _right.velocity +
                                 jump( _right, _star_pressure ) -
                                 jump( _left, _star_pressure ) );
        _left.star_velocity = _star_velocity;
        _right.star_velocity = -_star_velocity;
    }
    closeSide( _left );
    closeSide( _right );
}

RiemannSolution::Side RiemannSolution::makeSide( const GasState& gas,
                                                 double sign ) const
{
    Side side = {};
    side.gas = gas;
    side.velocity = sign * gas.velocity[0];
    // A vacuum has neither pressure nor a sound speed.
    side.sound_speed =
        gas.density > 0 ? std::sqrt( _gamma * gas.pressure / gas.density ) : 0;
    return side;
}

//! How much a wave to the given pressure slows the gas down: through a shock
//! or a fan (Toro 2009, eq. 4.6 and 4.7).
double RiemannSolution::jump( const Side& side, double pressure ) const
{
    const double p = side.gas.pressure;
    if ( pressure > p )
        return ( pressure - p ) *
               std::sqrt( 2 / ( side.gas.density * ( ( _gamma + 1 ) * pressure +
                                                     ( _gamma - 1 ) * p ) ) );
    if ( p == 0 )
        return 0;
    // expm1 keeps its accuracy where the wave is weak.
    return 2 * side.sound_speed / ( _gamma - 1 ) *
           std::expm1( ( _gamma - 1 ) / ( 2 * _gamma ) *
                       std::log( pressure / p ) );
}

double RiemannSolution::jumpDerivative( const Side& side,
                                        double pressure ) const
{
    const double p = side.gas.pressure;
    if ( pressure > p )
    {
        const double sum = ( _gamma + 1 ) * pressure + ( _gamma - 1 ) * p;
        return std::sqrt( 2 / ( side.gas.density * sum ) ) *
               ( 1 - 0.5 * ( _gamma + 1 ) * ( pressure - p ) / sum );
    }
    return std::pow( pressure / p, -( _gamma + 1 ) / ( 2 * _gamma ) ) /
           ( side.gas.density * side.sound_speed );
}

//! The shifted pressure at which both waves lead to the same velocity. There
//! is one, because the caller has ruled vacuum out.
double RiemannSolution::solvePressure() const
{
    const double approach = _left.velocity + _right.velocity;
    const auto excess = [&]( double p )
    { return jump( _left, p ) + jump( _right, p ) - approach; };

    const double pl = _left.gas.pressure, pr = _right.gas.pressure;
    const double lowest = std::min( pl, pr );
    if ( lowest > 0 && excess( lowest ) >= 0 )
    {
        // Two fans, which have a closed solution (Toro 2009, eq. 4.46).
        const double z = ( _gamma - 1 ) / ( 2 * _gamma );
        const double sum = _left.sound_speed + _right.sound_speed +
                           0.5 * ( _gamma - 1 ) * approach;
        return pl *
               std::pow( sum / ( _left.sound_speed +
                                 _right.sound_speed * std::pow( pl / pr, z ) ),
                         1 / z );
    }

    // Otherwise Newton from a pressure that is too low: the excess increases
    // and is concave, so that no step goes too far and every one goes up.
    double p = lowest;
    if ( !( p > 0 ) )
    {
        p = std::max( pl, pr ) +
            std::max( _left.gas.density, _right.gas.density ) * approach *
                approach;
        while ( excess( p ) > 0 )
            p *= 1e-3;
    }
    // Ends where round-off stops the ascent; the count only guards it.
    for ( int i = 0; i < 200; ++i )
    {
        const double slope =
            jumpDerivative( _left, p ) + jumpDerivative( _right, p );
        const double next = p - excess( p ) / slope;
        if ( !( next > p ) )
            break;
        p = next;
    }
    return p;
}

//! Density behind the wave and its speeds, from pressure and velocity there
//! (Toro 2009, section 4.4).
void RiemannSolution::closeSide( Side& side ) const
{
    const double p = side.gas.pressure;
    side.star_density = side.gas.density;
    side.head = side.tail = side.velocity - side.sound_speed;
    if ( side.gas.density == 0 )
    {
        side.head = side.tail = side.star_velocity;
    }
    else if ( _star_pressure > p )
    {
        const double up = _gamma + 1, down = _gamma - 1;
        side.star_density *= ( up * _star_pressure + down * p ) /
                             ( down * _star_pressure + up * p );
        const double mass_flux = std::sqrt(
            0.5 * side.gas.density * ( up * _star_pressure + down * p ) );
        side.head = side.tail = side.velocity - mass_flux / side.gas.density;
    }
    else if ( _star_pressure < p )
    {
        const double ratio = _star_pressure / p;
        side.star_density *= std::pow( ratio, 1 / _gamma );
        side.tail = side.star_velocity -
                    side.sound_speed *
                        std::pow( ratio, ( _gamma - 1 ) / ( 2 * _gamma ) );
    }
}

//! The state on a ray that lies on the gas' side of the contact; speed and the
//! side are seen with that side on the left, sign leads back.
GasState RiemannSolution::sampleSide( const Side& side, double speed,
                                      double sign ) const
{
    GasState result = side.gas;
    if ( speed >= side.tail )
    {
        result.density = side.star_density;
        result.velocity[0] = sign * side.star_velocity;
        result.pressure = _star_pressure;
    }
    else if ( speed > side.head )
    {
        // Inside the fan (Toro 2009, eq. 4.56).
        const double c = side.sound_speed;
        // Rounding may take it below that of a vacuum, 0.
        const double ratio = std::max(
            0.0, ( 2 + ( _gamma - 1 ) * ( side.velocity - speed ) / c ) /
                     ( _gamma + 1 ) );
        result.density *= std::pow( ratio, 2 / ( _gamma - 1 ) );
        result.velocity[0] = sign * ( speed + ratio * c );
        result.pressure *= std::pow( ratio, 2 * _gamma / ( _gamma - 1 ) );
    }
    result.pressure -= _offset;
    return result;
}

GasState RiemannSolution::sample( double x_over_t ) const
{
    if ( x_over_t <= _left.star_velocity )
        return sampleSide( _left, x_over_t, 1 );
    // Without vacuum both star velocities are the contact's.
    if ( x_over_t >= -_right.star_velocity )
        return sampleSide( _right, -x_over_t, -1 );
    return { 0, { x_over_t, 0, 0 }, -_offset };
}

std::array<double, 5> RiemannSolution::waveSpeeds() const
{
    std::array<double, 5> speeds = { _left.head, _left.tail, _star_velocity,
                                     -_right.tail, -_right.head };
    if ( _left.gas.density == 0 )
        speeds[0] = speeds[1] = _star_velocity;
    if ( _right.gas.density == 0 )
        speeds[3] = speeds[4] = _star_velocity;
    return speeds;
}

//---------------------------------------------------------------------------//
// Smooth waves, vortex, implosion
//---------------------------------------------------------------------------//
namespace
{
//! The gas that has c / c0 times the sound speed at the same entropy.
GasState atSoundSpeed( const GasState& gas, double ratio, const GasLaw& law )
{
    const double exponent = 2 / ( law.gamma - 1 );
    const double offset = law.pressure_offset;
    return { gas.density * std::pow( ratio, exponent ), gas.velocity,
             ( gas.pressure + offset ) *
                     std::pow( ratio, law.gamma * exponent ) -
                 offset };
}
} // namespace

AcousticWave::AcousticWave( const GasState& background,
                            const Vector3& direction, double position,
                            double amplitude, double wavelength,
                            const GasLaw& law )
    : _background( background ), _direction( direction ), _position( position ),
      _amplitude( amplitude ),
      _wave_number( 2 * std::numbers::pi / wavelength ), _law( law ),
      _sound_speed(
          std::sqrt( law.gamma * ( background.pressure + law.pressure_offset ) /
                     background.density ) )
{
    if ( !( amplitude >= 0 && amplitude * ( law.gamma - 1 ) < 2 ) )
        throw std::invalid_argument( "the amplitude of acoustic_wave must be "
                                     ">= 0 and < 2 / (gamma - 1), where the "
                                     "gas turns to vacuum" );
}

GasState AcousticWave::state( const Vector3& x, double t ) const
{
    // Seen from the background, a value that left s travels with
    // c0 + (gamma + 1) / 2 v( s ); s + speed( s ) t = target has one root.
    const double growth = 0.5 * ( _law.gamma + 1 ) * _amplitude * _sound_speed;
    const double target = dot<3>( _direction, x ) - _position -
                          dot<3>( _direction, _background.velocity ) * t -
                          _sound_speed * t;
    double low = target - growth * t, high = target + growth * t;
    double s = target;
    // Newton, halving the bracket where it would leave it; quadratic at the
    // end, so that the count only guards against the breaking time.
    for ( int i = 0; i < 100; ++i )
    {
        const double excess =
            s + growth * t * std::sin( _wave_number * s ) - target;
        ( excess > 0 ? high : low ) = s;
        const double slope =
            1 + growth * t * _wave_number * std::cos( _wave_number * s );
        double next = s - excess / slope;
        if ( !( next > low && next < high ) )
            next = 0.5 * ( low + high );
        if ( std::abs( next - s ) <= 1e-16 * ( 1 / _wave_number ) )
            break;
        s = next;
    }
    const double mach = _amplitude * std::sin( _wave_number * s );
    GasState gas =
        atSoundSpeed( _background, 1 + 0.5 * ( _law.gamma - 1 ) * mach, _law );
    for ( int d = 0; d < 3; ++d )
        gas.velocity[d] += mach * _sound_speed * _direction[d];
    return gas;
}

double AcousticWave::initialSlope( const Vector3& x ) const
{
    const double s = dot<3>( _direction, x ) - _position;
    return _amplitude * _sound_speed * _wave_number *
           std::cos( _wave_number * s );
}

double AcousticWave::breakingTime() const
{
    return 2 /
           ( ( _law.gamma + 1 ) * _amplitude * _sound_speed * _wave_number );
}

IsentropicVortex::IsentropicVortex( const GasState& stream,
                                    const Vector3& center, double strength,
                                    double radius, const GasLaw& law )
    : _stream( stream ), _center( center ), _strength( strength ),
      _radius( radius ), _law( law )
{
    if ( !( stateAt( { 0, 0, 0 } ).density > 0 ) )
        throw std::invalid_argument(
            "the isentropic_vortex would be hollow: lower its strength or "
            "raise the pressure" );
}

GasState IsentropicVortex::stateAt( const Vector3& offset ) const
{
    const double x = offset[0] / _radius, y = offset[1] / _radius;
    const double swirl = _strength / ( 2 * std::numbers::pi ) *
                         std::exp( 0.5 * ( 1 - x * x - y * y ) );
    const double square = _law.gamma *
                          ( _stream.pressure + _law.pressure_offset ) /
                          _stream.density;
    // c^2 falls by (gamma - 1) / 2 swirl^2.
    const double ratio = 1 - 0.5 * ( _law.gamma - 1 ) * swirl * swirl / square;
    GasState gas =
        atSoundSpeed( _stream, std::sqrt( std::max( ratio, 0.0 ) ), _law );
    gas.velocity[0] -= swirl * y;
    gas.velocity[1] += swirl * x;
    return gas;
}

std::array<std::array<double, 2>, 2>
IsentropicVortex::gradientAt( const Vector3& offset ) const
{
    const double x = offset[0] / _radius, y = offset[1] / _radius;
    const double rate = _strength / ( 2 * std::numbers::pi * _radius ) *
                        std::exp( 0.5 * ( 1 - x * x - y * y ) );
    return { { { rate * x * y, rate * ( y * y - 1 ) },
               { rate * ( 1 - x * x ), -rate * x * y } } };
}

NohSolution::NohSolution( int dimension, const Vector3& center, double density,
                          double speed, double pressure, double gamma )
    : _dimension( dimension ), _center( center ), _density( density ),
      _speed( speed ), _pressure( pressure ), _gamma( gamma )
{
}

std::pair<Vector3, double> NohSolution::radial( const Vector3& x ) const
{
    Vector3 n = { 0, 0, 0 };
    for ( int d = 0; d < _dimension; ++d )
        n[d] = x[d] - _center[d];
    const double r = std::hypot( n[0], n[1], n[2] );
    if ( r > 0 )
        for ( int d = 0; d < 3; ++d )
            n[d] /= r;
    return { n, r };
}

GasState NohSolution::state( const Vector3& x, double t ) const
{
    const auto [n, r] = radial( x );
    if ( t > 0 && r < 0.5 * ( _gamma - 1 ) * _speed * t )
    {
        const double density =
            _density * std::pow( ( _gamma + 1 ) / ( _gamma - 1 ), _dimension );
        return { density,
                 { 0, 0, 0 },
                 0.5 * ( _gamma - 1 ) * density * _speed * _speed };
    }
    const double ratio =
        t > 0 ? std::pow( 1 + _speed * t / r, _dimension - 1 ) : 1;
    return { _density * ratio,
             { -_speed * n[0], -_speed * n[1], -_speed * n[2] },
             _pressure * std::pow( ratio, _gamma ) };
}

//---------------------------------------------------------------------------//
// Solutions by name
//---------------------------------------------------------------------------//
ExactSolution::~ExactSolution() = default;

Vector3 periodsOf( const Json& input )
{
    Vector3 periods{};
    for ( const Json& entry : input.at( "boundary" ) )
        if ( entry.at( "type" ) == "periodic" )
        {
            const int axis =
                entry.at( "side" ).get<std::string>().at( 0 ) - 'x';
            const Json& grid = input.at( "grid" );
            periods[axis] = grid.at( "upper" ).at( axis ).get<double>() -
                            grid.at( "lower" ).at( axis ).get<double>();
        }
    return periods;
}

Vector3 toNearestImage( Vector3 offset, const Vector3& periods )
{
    for ( int d = 0; d < 3; ++d )
        if ( periods[d] > 0 )
            offset[d] = std::remainder( offset[d], periods[d] );
    return offset;
}

std::optional<GasLaw> findGasLaw( const Json& input )
{
    for ( const Json& effect : input.at( "physics" ) )
    {
        if ( effect.at( "type" ) == "ideal_gas" )
            return GasLaw{ effect.at( "gamma" ).get<double>(), 0 };
        if ( effect.at( "type" ) == "stiffened_gas" )
            return GasLaw{ effect.at( "gamma" ).get<double>(),
                           effect.at( "reference_pressure" ).get<double>() };
    }
    return {};
}

GasLaw gasLaw( const Json& input )
{
    if ( const auto law = findGasLaw( input ) )
        return *law;
    throw std::invalid_argument( "needs an entry of type \"ideal_gas\" or "
                                 "\"stiffened_gas\" in /physics" );
}

namespace
{
Vector3 axisVector( const Json& axis )
{
    Vector3 result = { 0, 0, 0 };
    result[axis.get<std::string>().at( 0 ) - 'x'] = 1;
    return result;
}

//! Unit vector of the keys `normal`, or else `axis`.
Vector3 unitNormal( const Json& initial )
{
    if ( !initial.contains( "normal" ) )
        return axisVector( initial.at( "axis" ) );
    Vector3 normal = toVector3( initial.at( "normal" ) );
    const double length = std::hypot( normal[0], normal[1], normal[2] );
    if ( !( length > 0 ) )
        throw std::invalid_argument( "/exact: the normal of the " +
                                     initial.at( "type" ).get<std::string>() +
                                     " entry in /initial is zero" );
    for ( int d = 0; d < 3; ++d )
        normal[d] /= length;
    return normal;
}

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
        // At the start every point lies infinitely many speeds away.
        const double speed =
            t > 0 ? distance / t : ( distance < 0 ? -infinity : infinity );
        return reflect( _solution.sample( speed ), _normal );
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

//! An isothermal column at rest: dp/dx = rho g with p / rho constant.
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
        const double distance = dot<3>( _axis, x ) - _position;
        double speed = infinity;
        if ( t > 0 )
            speed = distance / t;
        else if ( distance < 0 )
            speed = -infinity;
        return reflect( _solution.sample( std::max( speed, _velocity ) ),
                        _axis );
    }

  private:
    Vector3 _axis;
    double _position;
    double _velocity;
    RiemannSolution _solution;

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

AcousticWave makeAcousticWave( const Json& initial, const GasLaw& law )
{
    return { toGasState( initial ),      unitNormal( initial ),
             initial.at( "position" ),   initial.at( "amplitude" ),
             initial.at( "wavelength" ), law };
}

IsentropicVortex makeIsentropicVortex( const Json& initial, const GasLaw& law )
{
    return { toGasState( initial ), toVector3( initial.at( "center" ) ),
             initial.at( "strength" ), initial.at( "radius" ), law };
}

NohSolution makeNoh( const Json& initial, const GasLaw& law )
{
    const Json& center = initial.at( "center" );
    return { static_cast<int>( center.size() ), toVector3( center ),
             initial.at( "density" ),           initial.at( "speed" ),
             initial.at( "pressure" ),          law.gamma };
}

ViscousShock makeViscousShock( const Json& initial, const Json& resolved_input )
{
    const GasLaw law = gasLaw( resolved_input );
    double viscosity = 0, conductivity = 0;
    for ( const Json& effect : resolved_input.at( "physics" ) )
        if ( effect.at( "type" ) == "viscosity" )
            viscosity += 4 * effect.at( "shear" ).get<double>() / 3 +
                         effect.at( "bulk" ).get<double>();
        else if ( effect.at( "type" ) == "heat_conduction" )
            conductivity += effect.at( "conductivity" ).get<double>();
    if ( !( viscosity > 0 ) )
        throw std::invalid_argument(
            "/physics: a viscous_shock needs an effect of the type viscosity" );
    const double due = law.gamma * viscosity;
    if ( std::abs( conductivity - due ) > 1e-6 * due )
        throw std::invalid_argument( fmt::format(
            "/physics: a viscous_shock needs heat_conduction with a "
            "conductivity of gamma (4/3 shear + bulk) = {:.8g}, and here it is "
            "{:g}",
            due, conductivity ) );
    return { toGasState( initial ),
             unitNormal( initial ),
             initial.at( "position" ),
             initial.at( "mach" ),
             viscosity,
             law.gamma,
             law.pressure_offset };
}

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
        solutions.emplace_back( "hydrostatic",
                                "the isothermal column of /initial at rest",
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
            .unit( "velocity" );
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
