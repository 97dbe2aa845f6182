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
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "riemann";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "two gases that meet at a plane", dimension );
        declareDirection( p, "normal of the plane" );
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
        : _normal( toDirection( json ) ), _position( json.at( "position" ) ),
          _left( toGasState( json.at( "left" ) ) ),
          _right( toGasState( json.at( "right" ) ) )
    {
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        return dot<3>( _normal, x ) < _position ? _left : _right;
    }

  private:
    Vector3 _normal;
    double _position;
    GasState _left;
    GasState _right;
};

} // namespace Machpoint

#endif
