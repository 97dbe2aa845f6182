/*!
  \file viscous_shock.cpp
  \brief A shock of viscous, heat-conducting gas.
*/
#include <core/viscous_shock.hpp>

#include <cmath>
#include <stdexcept>

namespace Machpoint
{

ViscousShock::ViscousShock( const GasState& ahead, const Vector3& direction,
                            const double position, const double mach,
                            const double viscosity, const double gamma,
                            const double pressure_offset )
    : _ahead( ahead ), _direction( direction ), _position( position ),
      _gamma( gamma ), _offset( pressure_offset )
{
    if ( !( mach > 1 && viscosity > 0 ) )
        throw std::invalid_argument(
            "a viscous shock has a Mach number > 1 and a viscosity > 0" );
    const double sound = std::sqrt(
        gamma * ( ahead.pressure + pressure_offset ) / ahead.density );
    _before = mach * sound;
    _after = _before * ( gamma - 1 + 2 / ( mach * mach ) ) / ( gamma + 1 );
    _velocity = dot<3>( ahead.velocity, direction ) + _before;
    _length =
        2 * gamma * viscosity / ( ( gamma + 1 ) * ahead.density * _before );
}

double ViscousShock::speedAt( const double s ) const
{
    // u = u_2 + (u_1 - u_2) / (1 + exp z): in z the integral of the equation,
    // u_1 z / (u_1 - u_2) - log(1 + exp z), rises and has no poles. Newton's
    // steps come from below, as it is concave.
    const double jump = _before - _after;
    const auto integral = [&]( const double z )
    {
        const double softplus = z > 0 ? z + std::log1p( std::exp( -z ) )
                                      : std::log1p( std::exp( z ) );
        return _before * z / jump - softplus;
    };
    const auto part = []( const double z )
    { return 1 / ( 1 + std::exp( z ) ); };
    // Where u is the mean of u_1 and u_2 in the geometric sense.
    const double middle = std::log( std::sqrt( _before / _after ) );
    const double target = integral( middle ) - s / _length;
    double z = middle;
    for ( int k = 0; k < 100; ++k )
    {
        const double step =
            ( target - integral( z ) ) / ( _before / jump - 1 + part( z ) );
        z += step;
        if ( std::abs( step ) < 1e-14 * ( 1 + std::abs( z ) ) )
            break;
    }
    return _after + jump * part( z );
}

GasState ViscousShock::state( const Vector3& x, const double t ) const
{
    const double u =
        speedAt( dot<3>( _direction, x ) - _position - _velocity * t );
    GasState gas = _ahead;
    gas.density = _ahead.density * _before / u;
    for ( int d = 0; d < 3; ++d )
        gas.velocity[d] += ( _before - u ) * _direction[d];
    // p = rho (gamma - 1) / gamma (H - u^2 / 2)
    const double heat =
        ( _ahead.pressure + _offset ) / _ahead.density +
        ( _gamma - 1 ) / ( 2 * _gamma ) * ( _before * _before - u * u );
    gas.pressure = gas.density * heat - _offset;
    return gas;
}

double ViscousShock::initialSlope( const Vector3& x ) const
{
    const double u = speedAt( dot<3>( _direction, x ) - _position );
    return ( u - _before ) * ( u - _after ) / ( u * _length );
}

} // namespace Machpoint
