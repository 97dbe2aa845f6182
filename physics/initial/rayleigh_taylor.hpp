/*!
  \file rayleigh_taylor.hpp
  \brief Heavy gas on light gas.
*/
#ifndef MACHPOINT_RAYLEIGH_TAYLOR_HPP
#define MACHPOINT_RAYLEIGH_TAYLOR_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

/*!
  \brief Two layers of constant density in hydrostatic balance, the heavier one
  on top: p = p0 + rho g ( s - s0 ), s along the axis.

  The velocity along the axis is a times the product over all axes of
  ( 1 + cos ) / 2, with the wavelength across, and the height, centred at s0,
  along the axis.

  Source: R. Liska and B. Wendroff, SIAM J. Sci. Comput. 25 (2003) 995, section
  4.6, in the form and with the values of J. M. Stone et al., Astrophys. J.
  Suppl. 178 (2008) 137.
*/
class RayleighTaylor : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "rayleigh_taylor";
    static constexpr int least_dimension = 2;

    static Parameters declare( const int dimension )
    {
        const char* source = "Liska and Wendroff 2003";
        Parameters p( name, "heavy gas on light gas, single mode", dimension );
        p.choice( "axis", axisNames( dimension ), "upwards" ).defaultsTo( "y" );
        const auto number = [&]( const char* key, const char* text,
                                 const char* unit,
                                 const double value ) -> Parameter&
        {
            return p.number( key, text )
                .unit( unit )
                .defaultsTo( value )
                .source( source );
        };
        number( "position", "s0, of the interface along the axis", "length",
                0 );
        number( "lower_density", "below", "mass/length^Dim", 1 ).above( 0 );
        number( "upper_density", "above", "mass/length^Dim", 2 ).above( 0 );
        number( "pressure", "p0, at the interface", "pressure", 2.5 )
            .above( 0 );
        number( "gravity",
                "g along the axis; give the same to the effect "
                "gravity",
                "length/time^2", -0.1 );
        number( "amplitude", "a, largest velocity", "length/time", 0.01 );
        number( "wavelength", "across the axis; a crest stands at 0", "length",
                0.5 )
            .above( 0 );
        number( "height",
                "within which the velocity falls to 0, half on each "
                "side of the interface",
                "length", 1.5 )
            .above( 0 );
        return p;
    }

    explicit RayleighTaylor( const Json& json )
        : _axis( axisNumber( json.at( "axis" ) ) ),
          _position( json.at( "position" ) ),
          _lower_density( json.at( "lower_density" ) ),
          _upper_density( json.at( "upper_density" ) ),
          _pressure( json.at( "pressure" ) ), _gravity( json.at( "gravity" ) ),
          _amplitude( json.at( "amplitude" ) )
    {
        const double turn = 2 * Kokkos::numbers::pi_v<double>;
        for ( int d = 0; d < 3; ++d )
            _k[d] =
                turn /
                json.at( d == _axis ? "height" : "wavelength" ).get<double>();
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        const double s = x[_axis] - _position;
        const double density = s < 0 ? _lower_density : _upper_density;
        GasState gas{ density, {}, _pressure + density * _gravity * s };
        gas.velocity[_axis] =
            _amplitude * wave( x, 0 ) * wave( x, 1 ) * wave( x, 2 );
        return gas;
    }

    Gradient velocityGradient( const Vector3& x ) const override
    {
        Gradient gradient{};
        for ( int b = 0; b < 3; ++b )
            gradient[_axis][b] =
                -_amplitude * 0.5 * _k[b] * Kokkos::sin( phase( x, b ) ) *
                wave( x, ( b + 1 ) % 3 ) * wave( x, ( b + 2 ) % 3 );
        return gradient;
    }

  private:
    int _axis;
    double _position;
    double _lower_density, _upper_density;
    double _pressure, _gravity, _amplitude;
    Vector3 _k{};

    double phase( const Vector3& x, const int d ) const
    {
        return _k[d] * ( x[d] - ( d == _axis ? _position : 0 ) );
    }
    double wave( const Vector3& x, const int d ) const
    {
        return 0.5 * ( 1 + Kokkos::cos( phase( x, d ) ) );
    }
};

} // namespace Machpoint

#endif
