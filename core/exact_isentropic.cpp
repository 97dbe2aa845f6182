/*!
  \file exact_isentropic.cpp
  \brief Isentropic flows: a simple wave and a vortex.
*/
#include <core/exact.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace Machpoint
{

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

} // namespace Machpoint
