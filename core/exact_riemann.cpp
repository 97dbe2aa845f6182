/*!
  \file exact_riemann.cpp
  \brief Exact solution of the Riemann problem.
*/
#include <core/exact.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace Machpoint
{

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

} // namespace Machpoint
