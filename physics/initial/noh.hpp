/*!
  \file noh.hpp
  \brief Cold gas that falls onto a plane, a line or a point.
*/
#ifndef MACHPOINT_NOH_HPP
#define MACHPOINT_NOH_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

//! \see NohSolution
class Noh : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "noh";

    static Parameters declare( const int dimension )
    {
        const char* source = "Noh 1987";
        Parameters p( name, "cold gas that falls towards a centre", dimension );
        p.vector( "center", "where it falls to: a plane in 1D, a line in 2D, "
                            "a point in 3D" )
            .unit( "length" )
            .defaultsTo( zeros( dimension ) );
        p.number( "density", "of the gas" )
            .unit( "mass/length^Dim" )
            .above( 0 )
            .defaultsTo( 1 )
            .source( source );
        p.number( "speed", "towards the centre" )
            .unit( "length/time" )
            .above( 0 )
            .defaultsTo( 1 )
            .source( source );
        p.number( "pressure", "of the gas; the exact solution has 0" )
            .unit( "pressure" )
            .above( 0 )
            .defaultsTo( 1e-6 );
        return p;
    }

    //! \throws std::invalid_argument without a known gas law
    Noh( const Json& json, const SceneFacts& scene )
        : _solution( makeNoh( json, scene.gas() ) ),
          _dimension( scene.dimension ), _speed( json.at( "speed" ) )
    {
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        return _solution.state( x, 0 );
    }

    //! -u ( delta_ab - n_a n_b ) / r; the jump at the centre has none.
    Gradient velocityGradient( const Vector3& x ) const override
    {
        const auto [n, r] = _solution.radial( x );
        Gradient gradient{};
        if ( r > 0 )
            for ( int a = 0; a < _dimension; ++a )
                for ( int b = 0; b < _dimension; ++b )
                    gradient[a][b] =
                        -_speed / r * ( ( a == b ? 1 : 0 ) - n[a] * n[b] );
        return gradient;
    }

  private:
    NohSolution _solution;
    int _dimension;
    double _speed;
};

} // namespace Machpoint

#endif
