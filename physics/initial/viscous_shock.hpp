/*!
  \file viscous_shock.hpp
  \brief A shock of viscous, heat-conducting gas, within its width.
*/
#ifndef MACHPOINT_VISCOUS_SHOCK_STATE_HPP
#define MACHPOINT_VISCOUS_SHOCK_STATE_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

//! \see ViscousShock
class ViscousShockState : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "viscous_shock";

    static Parameters declare( const int dimension )
    {
        auto p = declareGasState( name,
                                  "shock as wide as viscosity and heat "
                                  "conduction make it",
                                  dimension );
        declareDirection( p, "in which it runs, into the gas given here" );
        p.number( "position", "of the steepest velocity, along the unit "
                              "direction" )
            .unit( "length" );
        p.number( "mach", "speed through the gas ahead, in its sound speeds" )
            .above( 1 )
            .defaultsTo( 2 )
            .source( "Becker 1922" );
        return p;
    }

    //! \throws std::invalid_argument without a known gas law, or where
    //! `physics` has not the viscosity and conduction that it is of
    ViscousShockState( const Json& json, const SceneFacts& scene )
        : _shock( makeViscousShock( json, scene.input ) )
    {
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        return _shock.state( x, 0 );
    }

    Gradient velocityGradient( const Vector3& x ) const override
    {
        return gradientAlong( _shock.direction(), _shock.initialSlope( x ) );
    }

  private:
    ViscousShock _shock;
};

} // namespace Machpoint

#endif
