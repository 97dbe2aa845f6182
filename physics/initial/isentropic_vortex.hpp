/*!
  \file isentropic_vortex.hpp
  \brief A vortex of constant entropy in a uniform stream.
*/
#ifndef MACHPOINT_ISENTROPIC_VORTEX_HPP
#define MACHPOINT_ISENTROPIC_VORTEX_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

//! \see IsentropicVortex
class IsentropicVortexState : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "isentropic_vortex";
    static constexpr int least_dimension = 2;

    static Parameters declare( const int dimension )
    {
        const char* source = "Yee, Sandham and Djomehri 1999";
        Parameters p( name, "vortex of constant entropy in a stream",
                      dimension );
        p.vector( "center", "of the vortex, which turns about z" )
            .unit( "length" );
        p.number( "density", "of the stream" )
            .unit( "mass/length^Dim" )
            .above( 0 )
            .defaultsTo( 1 )
            .source( source );
        p.vector( "velocity", "of the stream" ).unit( "length/time" );
        p.number( "pressure", "of the stream" )
            .unit( "pressure" )
            .above( 0 )
            .defaultsTo( 1 )
            .source( source );
        p.number( "strength", "2 pi times the velocity at the radius; > 0 "
                              "turns counter-clockwise" )
            .unit( "length/time" )
            .defaultsTo( 5 )
            .source( source );
        p.number( "radius", "where it turns fastest" )
            .unit( "length" )
            .above( 0 )
            .defaultsTo( 1 )
            .source( source );
        return p;
    }

    //! \throws std::invalid_argument without a known gas law, or for a strength
    //! that would leave it hollow
    IsentropicVortexState( const Json& json, const SceneFacts& scene )
        : _vortex( makeIsentropicVortex( json, scene.gas() ) ),
          _periods( periodsOf( scene.input ) )
    {
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        return _vortex.stateAt( fromCenter( x ) );
    }

    Gradient velocityGradient( const Vector3& x ) const override
    {
        const auto plane = _vortex.gradientAt( fromCenter( x ) );
        Gradient gradient{};
        for ( int a = 0; a < 2; ++a )
            for ( int b = 0; b < 2; ++b )
                gradient[a][b] = plane[a][b];
        return gradient;
    }

  private:
    IsentropicVortex _vortex;
    Vector3 _periods;

    //! Of the nearest image of the vortex.
    Vector3 fromCenter( Vector3 x ) const
    {
        for ( int d = 0; d < 3; ++d )
            x[d] -= _vortex.center()[d];
        return toNearestImage( x, _periods );
    }
};

} // namespace Machpoint

#endif
