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

//! A gas state for every place. Host only: it is asked once per particle.
class InitialState
{
  public:
    virtual ~InitialState() = default;
    //! \param x position, components beyond Dim are 0
    virtual GasState state( const Vector<3>& x ) const = 0;
};

//! Number of an axis from its validated name.
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

//! Reads what declareGasState declares.
inline GasState toGasState( const Json& json )
{
    GasState state{ json.at( "density" ), {}, json.at( "pressure" ) };
    int d = 0;
    for ( const auto& component : json.at( "velocity" ) )
        state.velocity[d++] = component;
    return state;
}

} // namespace Machpoint

#endif
