/*!
  \file riemann.hpp
  \brief Two gases that meet at a plane.
*/
#ifndef MACHPOINT_RIEMANN_HPP
#define MACHPOINT_RIEMANN_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

//! Riemann problem: left state where n . x < position, right state beyond.
class Riemann : public InitialState
{
  public:
    static constexpr const char* name = "riemann";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "two gases that meet at a plane", dimension );
        p.choice( "axis", axisNames( dimension ), "normal of the plane" )
            .defaultsTo( "x" );
        p.vector( "normal", "normal of the plane, of any length; overrides "
                            "axis" )
            .optional();
        p.number( "position", "of the plane along its unit normal" )
            .unit( "length" );
        p.object( "left",
                  declareGasState( "left", "gas before the plane", dimension ),
                  "gas before the plane" );
        p.object( "right",
                  declareGasState( "right", "gas beyond the plane", dimension ),
                  "gas beyond the plane" );
        return p;
    }

    explicit Riemann( const Json& json )
        : _position( json.at( "position" ) ),
          _left( toGasState( json.at( "left" ) ) ),
          _right( toGasState( json.at( "right" ) ) )
    {
        if ( json.contains( "normal" ) )
        {
            int d = 0;
            for ( const auto& component : json.at( "normal" ) )
                _normal[d++] = component;
            const Real length = Kokkos::sqrt( dot<3>( _normal, _normal ) );
            for ( d = 0; d < 3; ++d )
                _normal[d] /= length;
        }
        else
            _normal[axisNumber( json.at( "axis" ) )] = 1;
    }

    GasState state( const Vector<3>& x ) const override
    {
        return dot<3>( _normal, x ) < _position ? _left : _right;
    }

  private:
    Vector<3> _normal{};
    Real _position;
    GasState _left;
    GasState _right;
};

} // namespace Machpoint

#endif
