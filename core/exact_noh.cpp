/*!
  \file exact_noh.cpp
  \brief Noh's problem: cold gas that falls onto a plane, a line or a point.
*/
#include <core/exact.hpp>

#include <cmath>

namespace Machpoint
{

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

} // namespace Machpoint
