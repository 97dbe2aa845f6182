/*!
  \file sedov.cpp
  \brief Kamm and Timmes 2007, equations 27 to 38, for uniform density.
*/
#include <core/sedov.hpp>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace Machpoint
{

SedovSolution::SedovSolution( int dimension, double energy, double density,
                              double gamma )
    : _dimension( dimension ), _density( density ), _gamma( gamma )
{
    if ( !( energy > 0 ) )
        throw std::invalid_argument( "a blast needs energy" );
    // At gamma = 2 two exponents diverge and cancel; beyond the other bound
    // the centre is empty, and the solution is another one.
    if ( std::abs( gamma - 2 ) < 1e-6 ||
         !( gamma * ( dimension - 2 ) < 3 * dimension - 2 ) )
        throw std::invalid_argument(
            "sedov needs a gamma other than 2, and below 7 in 3D" );
    // w = c V - 1, from V = 2 / ((j + 2) gamma) at the centre to
    // 4 / ((j + 2) (gamma + 1)) at the shock.
    _shock_parameter = ( gamma - 1 ) / ( gamma + 1 );

    // The integral of both energies over the radius, by Simpson's rule.
    const double surface[] = { 2, 2 * std::numbers::pi, 4 * std::numbers::pi };
    const int n = 2000;
    double integral = 0;
    for ( int k = 1; k <= n; ++k ) // nothing at the centre but for j = 1
    {
        const double radius = static_cast<double>( k ) / n;
        const Profile p = profileAt( radius );
        const double weight = ( k == n ? 1.0 : k % 2 ? 4.0 : 2.0 ) / ( 3 * n );
        integral += weight * std::pow( radius, dimension - 1 ) *
                    ( p.density * p.velocity * p.velocity + p.pressure );
    }
    if ( dimension == 1 )
        integral += profile( 0 ).pressure / ( 3 * n );
    // Behind a strong shock of speed U both energies per volume are
    // 2 rho U^2 / (gamma^2 - 1), and U = 2 r / ((j + 2) t).
    const double rate = 2.0 / ( dimension + 2 );
    const double alpha = surface[dimension - 1] * integral * 2 * rate * rate /
                         ( gamma * gamma - 1 );
    _scale = std::pow( energy / ( alpha * density ), 1.0 / ( dimension + 2 ) );
}

double SedovSolution::shockRadius( double t ) const
{
    return _scale * std::pow( t, 2.0 / ( _dimension + 2 ) );
}

SedovSolution::Profile SedovSolution::profile( double w ) const
{
    const double j = _dimension, g = _gamma;
    const double size = j + 2;
    const double V = ( 1 + w ) * 2 / ( size * g );
    // Exponents, eq. 33 to 38.
    const double down = 2 * ( g - 1 ) + j;
    const double a0 = 2 / size;
    const double a2 = -( g - 1 ) / down;
    const double a1 = size * g / ( 2 + j * ( g - 1 ) ) *
                      ( 2 * j * ( 2 - g ) / ( g * size * size ) - a2 );
    const double a3 = j / down;
    const double a4 = size * a1 / ( 2 - g );
    const double a5 = -2 / ( 2 - g );
    // Bases; each is 1 at the shock.
    const double turn = 2 + j * ( g - 1 );
    const double x1 = 0.25 * size * ( g + 1 ) * V;
    const double x2 = w / _shock_parameter;
    const double x3 = size * ( g + 1 ) / ( size * ( g + 1 ) - 2 * turn ) *
                      ( 1 - 0.5 * turn * V );
    const double x4 = ( g + 1 ) / ( g - 1 ) * ( 1 - 0.5 * size * V );
    const double radius =
        std::pow( x1, -a0 ) * std::pow( x2, -a2 ) * std::pow( x3, -a1 );
    // As one exponential: near gamma = 2 factors overflow whose product is
    // moderate.
    const double log3 = std::log( x3 ), log4 = std::log( x4 );
    return { radius, x1 * radius,
             std::exp( a3 * std::log( x2 ) + a4 * log3 + a5 * log4 ),
             std::exp( a0 * j * std::log( x1 ) + ( a4 - 2 * a1 ) * log3 +
                       ( 1 + a5 ) * log4 ) };
}

//! Inverts radius( w ), which grows like a power of w near the centre, so that
//! the bisection is in its logarithm.
SedovSolution::Profile SedovSolution::profileAt( double radius ) const
{
    double low = -600, high = 0; // of log( w / shock parameter )
    for ( int i = 0; i < 70; ++i )
    {
        const double middle = 0.5 * ( low + high );
        const bool is_beyond =
            profile( _shock_parameter * std::exp( middle ) ).radius > radius;
        ( is_beyond ? high : low ) = middle;
    }
    return profile( _shock_parameter * std::exp( high ) );
}

SedovSolution::Radial SedovSolution::inside( double r, double t ) const
{
    const double shock = shockRadius( t );
    const double speed = 2 * shock / ( ( _dimension + 2 ) * t );
    const Profile p = profileAt( r / shock );
    // Below the least radius that w tells (.14 with gamma 1.01) v is linear.
    const double within = r / shock / p.radius;
    return { _density * ( _gamma + 1 ) / ( _gamma - 1 ) * p.density,
             2 * speed / ( _gamma + 1 ) * p.velocity * within,
             2 * _density * speed * speed / ( _gamma + 1 ) * p.pressure };
}

} // namespace Machpoint
