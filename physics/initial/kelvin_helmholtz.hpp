/*!
  \file kelvin_helmholtz.hpp
  \brief A stream within a counter-stream, with smooth shear layers.
*/
#ifndef MACHPOINT_KELVIN_HELMHOLTZ_HPP
#define MACHPOINT_KELVIN_HELMHOLTZ_HPP

#include <physics/initial/initial_state.hpp>

#include <stdexcept>

namespace Machpoint
{

/*!
  \brief A stream along x between two shear layers at constant pressure.

  With s the distance from the nearest layer, positive in the inner stream, the
  share of the inner stream is exp( s / thickness ) / 2 outside and
  1 - exp( -s / thickness ) / 2 inside; density and velocity follow it. A
  transverse velocity a sin( 2 pi x / wavelength ) grows.

  Source: C. P. McNally, W. Lyra and J.-C. Passy, Astrophys. J. Suppl. 201
  (2012) 18, whose values are the defaults (gamma 5/3, unit periodic square).
*/
class KelvinHelmholtz : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "kelvin_helmholtz";
    static constexpr int least_dimension = 2;

    static Parameters declare( const int dimension )
    {
        const char* source = "McNally, Lyra and Passy 2012";
        Parameters p( name, "shear layers with a single mode", dimension );
        const auto number = [&]( const char* key, const char* text,
                                 const char* unit,
                                 const double value ) -> Parameter&
        {
            return p.number( key, text )
                .unit( unit )
                .defaultsTo( value )
                .source( source );
        };
        number( "lower", "y of the lower layer", "length", 0.25 );
        number( "upper", "y of the upper layer", "length", 0.75 );
        number( "outer_density", "far outside", "mass/length^Dim", 1 )
            .above( 0 );
        number( "inner_density", "between the layers", "mass/length^Dim", 2 )
            .above( 0 );
        number( "outer_velocity", "along x, far outside", "length/time", 0.5 );
        number( "inner_velocity", "along x, between the layers", "length/time",
                -0.5 );
        number( "pressure", "everywhere", "pressure", 2.5 ).above( 0 );
        number( "thickness", "of the layers", "length", 0.025 ).above( 0 );
        number( "amplitude", "of the velocity along y", "length/time", 0.01 );
        number( "wavelength", "of that velocity along x", "length", 0.5 )
            .above( 0 );
        return p;
    }

    //! \throws std::invalid_argument where the layers are in the other order
    explicit KelvinHelmholtz( const Json& json )
        : _lower( json.at( "lower" ) ), _upper( json.at( "upper" ) ),
          _outer_density( json.at( "outer_density" ) ),
          _inner_density( json.at( "inner_density" ) ),
          _outer_velocity( json.at( "outer_velocity" ) ),
          _inner_velocity( json.at( "inner_velocity" ) ),
          _pressure( json.at( "pressure" ) ),
          _thickness( json.at( "thickness" ) ),
          _amplitude( json.at( "amplitude" ) ),
          _k( 2 * Kokkos::numbers::pi_v<double> /
              json.at( "wavelength" ).get<double>() )
    {
        if ( !( _lower < _upper ) )
            throw std::invalid_argument( "upper must be greater than lower" );
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        const double s = depth( x ) / _thickness;
        const double half = 0.5 * Kokkos::exp( -Kokkos::abs( s ) );
        const double inner = s < 0 ? half : 1 - half;
        return {
            _outer_density + inner * ( _inner_density - _outer_density ),
            { _outer_velocity + inner * ( _inner_velocity - _outer_velocity ),
              _amplitude * Kokkos::sin( _k * x[0] ), 0 },
            _pressure };
    }

    Gradient velocityGradient( const Vector3& x ) const override
    {
        const double slope =
            0.5 * Kokkos::exp( -Kokkos::abs( depth( x ) ) / _thickness ) /
            _thickness;
        const double sign = isNearLower( x ) ? 1 : -1;
        Gradient gradient{};
        gradient[0][1] = sign * slope * ( _inner_velocity - _outer_velocity );
        gradient[1][0] = _amplitude * _k * Kokkos::cos( _k * x[0] );
        return gradient;
    }

  private:
    double _lower, _upper;
    double _outer_density, _inner_density;
    double _outer_velocity, _inner_velocity;
    double _pressure, _thickness, _amplitude, _k;

    bool isNearLower( const Vector3& x ) const
    {
        return x[1] - _lower < _upper - x[1];
    }
    //! Distance from the nearest layer, positive in the inner stream.
    double depth( const Vector3& x ) const
    {
        return Kokkos::min( x[1] - _lower, _upper - x[1] );
    }
};

} // namespace Machpoint

#endif
