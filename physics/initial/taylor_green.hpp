/*!
  \file taylor_green.hpp
  \brief Vortices that break up.
*/
#ifndef MACHPOINT_TAYLOR_GREEN_HPP
#define MACHPOINT_TAYLOR_GREEN_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

/*!
  \brief Taylor's and Green's vortices at constant density.

  With k = 2 pi / wavelength: 2D: v = V ( sin kx cos ky, -cos kx sin ky ),
  p = p0 + rho V^2 / 4 ( cos 2kx + cos 2ky ), which stands still in
  incompressible flow; 3D: v times cos kz, and p = p0 + rho V^2 / 16
  ( cos 2kx + cos 2ky ) ( cos 2kz + 2 ).

  Source: G. I. Taylor and A. E. Green, Proc. R. Soc. A 158 (1937) 499; the
  defaults are at Mach 0.1 as is usual for compressible codes (J. R. DeBonis,
  AIAA paper 2013-0382).
*/
class TaylorGreen : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "taylor_green";
    static constexpr int least_dimension = 2;

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "array of vortices", dimension );
        p.number( "density", "of the gas" )
            .unit( "mass/length^Dim" )
            .above( 0 )
            .defaultsTo( 1 );
        p.number( "speed", "V, largest velocity" )
            .unit( "length/time" )
            .defaultsTo( 1 )
            .source( "Taylor and Green 1937" );
        p.number( "pressure", "p0, mean; the default is Mach 0.1 for gamma "
                              "1.4" )
            .unit( "pressure" )
            .above( 0 )
            .defaultsTo( 100 / 1.4 )
            .source( "DeBonis 2013" );
        p.number( "wavelength", "of the velocity along each axis" )
            .unit( "length" )
            .above( 0 )
            .defaultsTo( 1 );
        return p;
    }

    TaylorGreen( const Json& json, const SceneFacts& scene )
        : _dimension( scene.dimension ), _density( json.at( "density" ) ),
          _speed( json.at( "speed" ) ), _pressure( json.at( "pressure" ) ),
          _k( 2 * Kokkos::numbers::pi_v<double> /
              json.at( "wavelength" ).get<double>() )
    {
    }
    //! @}

    GasState state( const Vector3& y ) const override
    {
        using Kokkos::cos, Kokkos::sin;
        const double x[] = { _k * y[0], _k * y[1], _k * y[2] };
        const double u = _speed * cos( x[2] );
        const double depth =
            _dimension == 2 ? 0.25 : ( cos( 2 * x[2] ) + 2 ) / 16;
        return { _density,
                 { u * sin( x[0] ) * cos( x[1] ),
                   -u * cos( x[0] ) * sin( x[1] ), 0 },
                 _pressure + _density * _speed * _speed * depth *
                                 ( cos( 2 * x[0] ) + cos( 2 * x[1] ) ) };
    }

    Gradient velocityGradient( const Vector3& y ) const override
    {
        using Kokkos::cos, Kokkos::sin;
        const double x[] = { _k * y[0], _k * y[1], _k * y[2] };
        const double u = _k * _speed;
        const double cc = cos( x[0] ) * cos( x[1] ),
                     ss = sin( x[0] ) * sin( x[1] );
        Gradient gradient{};
        gradient[0] = { u * cc * cos( x[2] ), -u * ss * cos( x[2] ),
                        -u * sin( x[0] ) * cos( x[1] ) * sin( x[2] ) };
        gradient[1] = { u * ss * cos( x[2] ), -u * cc * cos( x[2] ),
                        u * cos( x[0] ) * sin( x[1] ) * sin( x[2] ) };
        return gradient;
    }

  private:
    int _dimension;
    double _density, _speed, _pressure, _k;
};

} // namespace Machpoint

#endif
