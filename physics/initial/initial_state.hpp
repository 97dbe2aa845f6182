/*!
  \file initial_state.hpp
  \brief What fills the domain at the start.
*/
#ifndef MACHPOINT_INITIAL_STATE_HPP
#define MACHPOINT_INITIAL_STATE_HPP

#include <core/exact.hpp>
#include <core/module.hpp>

namespace Machpoint
{

//! What an initial state may ask about the scene that it is part of.
struct SceneFacts
{
    int dimension;     //!< 1 to 3
    const Json& input; //!< resolved

    //! For a state that follows from it. \throws std::invalid_argument where
    //! it is not known
    GasLaw gas() const { return gasLaw( input ); }
};

//! d v_a / d x_b [3][3], 1/time; rows and columns beyond Dim are 0.
using Gradient = Kokkos::Array<Vector3, 3>;

/*!
  \brief A gas state for every place. Host only: it is asked once per particle.

  It is made from its resolved JSON, and from SceneFacts if it wants them. Its
  type has a `name`, the "type" of its entries in `initial`, their keys,
  `declare( dimension )` (1 to 3, or 0 for any), and, if it needs a plane, a
  `least_dimension`.
*/
class InitialState
{
  public:
    virtual ~InitialState() = default;

    //! \param x position [3], length; components beyond Dim are 0
    virtual GasState state( const Vector3& x ) const = 0;

    //! Gradient of the velocity where it is smooth, 1/time. A jump has none: it
    //! is left to the grid, so that states that are uniform but for jumps need
    //! not override this.
    virtual Gradient velocityGradient( const Vector3& ) const { return {}; }

    /*!
      \brief Lays this state over that of the entries before it.

      Replaces it, unless the state is one that adds to what there is.
      \param[in,out] gas of zero density where nothing is yet
      \param[in,out] gradient of its velocity, 1/time
    */
    virtual void apply( const Vector3& x, GasState& gas,
                        Gradient& gradient ) const
    {
        gas = state( x );
        gradient = velocityGradient( x );
    }
};

//! Number of an axis, 0 to 2, from its validated name.
inline int axisNumber( const Json& name )
{
    return name.get<std::string>()[0] - 'x';
}

//! Names of the axes of a dimension (0: all).
inline std::vector<std::string> axisNames( const int dimension )
{
    const std::vector<std::string> all = { "x", "y", "z" };
    return { all.begin(), all.begin() + ( dimension ? dimension : 3 ) };
}

//! A vector of zeros, for defaults. \param dimension 0: of all axes
inline Json zeros( const int dimension )
{
    return std::vector<double>( dimension ? dimension : 3, 0 );
}

//! That of a velocity along a line which changes along it alone: slope n n^T.
//! \param n unit vector of the line \param slope d (n . v) / ds, 1/time
inline Gradient gradientAlong( const Vector3& n, const double slope )
{
    Gradient gradient{};
    for ( int a = 0; a < 3; ++a )
        for ( int b = 0; b < 3; ++b )
            gradient[a][b] = slope * n[a] * n[b];
    return gradient;
}

//! Declares the keys of a GasState.
inline Parameters declareGasState( const std::string& name,
                                   const std::string& summary,
                                   const int dimension )
{
    Parameters p( name, summary, dimension );
    p.number( "density", "mass per volume" )
        .unit( "mass/length^Dim" )
        .above( 0 );
    p.vector( "velocity", "of the gas" ).unit( "length/time" );
    p.number( "pressure", "of the gas" ).unit( "pressure" ).above( 0 );
    return p;
}

//! Declares the keys `axis` and `normal` of a state that varies along a line.
inline void declareDirection( Parameters& p, const std::string& what )
{
    p.choice( "axis", axisNames( p.dimension() ), what ).defaultsTo( "x" );
    p.vector( "normal", what + ", of any length; overrides axis" ).optional();
}

//! Reads what declareDirection declares. \return a unit vector
inline Vector3 toDirection( const Json& json )
{
    Vector3 n{};
    if ( !json.contains( "normal" ) )
    {
        n[axisNumber( json.at( "axis" ) )] = 1;
        return n;
    }
    n = toVector3( json.at( "normal" ) );
    const double length = Kokkos::sqrt( dot<3>( n, n ) );
    for ( int d = 0; d < 3; ++d )
        n[d] /= length;
    return n;
}

} // namespace Machpoint

#endif
