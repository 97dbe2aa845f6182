/*!
  \file acoustic_wave.hpp
  \brief A sine wave of finite amplitude that runs along a line.
*/
#ifndef MACHPOINT_ACOUSTIC_WAVE_HPP
#define MACHPOINT_ACOUSTIC_WAVE_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

//! \see AcousticWave
class AcousticWaveState : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "acoustic_wave";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "sine wave of finite amplitude", dimension );
        declareDirection( p, "along which it runs" );
        p.number( "position", "where a node of the sine stands, along the "
                              "unit direction" )
            .unit( "length" )
            .defaultsTo( 0 );
        p.number( "amplitude", "of the velocity, in sound speeds" )
            .atLeast( 0 )
            .defaultsTo( 0.05 );
        p.number( "wavelength", "of the sine" )
            .unit( "length" )
            .above( 0 )
            .defaultsTo( 1 );
        p.number( "density", "of the undisturbed gas" )
            .unit( "mass/length^Dim" )
            .above( 0 )
            .defaultsTo( 1.4 );
        p.vector( "velocity", "of the undisturbed gas" )
            .unit( "length/time" )
            .defaultsTo( zeros( dimension ) );
        p.number( "pressure", "of the undisturbed gas" )
            .unit( "pressure" )
            .above( 0 )
            .defaultsTo( 1 )
            .source( "Landau and Lifshitz 1987, sections 101 and 102" );
        return p;
    }

    //! \throws std::invalid_argument without a known gas law, or for an
    //! amplitude that no such wave has
    AcousticWaveState( const Json& json, const SceneFacts& scene )
        : _wave( makeAcousticWave( json, scene.gas() ) )
    {
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        return _wave.state( x, 0 );
    }

    Gradient velocityGradient( const Vector3& x ) const override
    {
        return gradientAlong( _wave.direction(), _wave.initialSlope( x ) );
    }

  private:
    AcousticWave _wave;
};

} // namespace Machpoint

#endif
