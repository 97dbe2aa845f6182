/*!
  \file hydrostatic.hpp
  \brief A column at rest under gravity.
*/
#ifndef MACHPOINT_HYDROSTATIC_HPP
#define MACHPOINT_HYDROSTATIC_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

//! p = p0 exp( g rho0 (x - x0) / p0 ), rho = rho0 p / p0, no motion: dp/dx =
//! rho g with constant p / rho, which for an ideal gas is isothermal.
class Hydrostatic : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "hydrostatic";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "column of constant p / rho at rest under gravity",
                      dimension );
        p.choice( "axis", axisNames( dimension ), "direction of gravity" )
            .defaultsTo( "x" );
        p.number( "position", "of the base, x0" )
            .unit( "length" )
            .defaultsTo( 0 );
        p.number( "density", "at the base, rho0" )
            .unit( "mass/length^Dim" )
            .above( 0 );
        p.number( "pressure", "at the base, p0" ).unit( "pressure" ).above( 0 );
        p.number( "gravity", "acceleration along the axis, g; give the same "
                             "to the effect gravity" )
            .unit( "length/time^2" );
        return p;
    }

    explicit Hydrostatic( const Json& json )
        : _axis( axisNumber( json.at( "axis" ) ) ),
          _position( json.at( "position" ) ), _density( json.at( "density" ) ),
          _pressure( json.at( "pressure" ) ), _gravity( json.at( "gravity" ) )
    {
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        const double ratio = Kokkos::exp( _gravity * _density / _pressure *
                                          ( x[_axis] - _position ) );
        return { _density * ratio, {}, _pressure * ratio };
    }

  private:
    int _axis;
    double _position, _density, _pressure, _gravity;
};

} // namespace Machpoint

#endif
