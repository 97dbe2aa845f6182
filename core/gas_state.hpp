/*!
  \file gas_state.hpp
  \brief Vectors and the state of a gas at a place, as inputs give them; host
  only.
*/
#ifndef MACHPOINT_GAS_STATE_HPP
#define MACHPOINT_GAS_STATE_HPP

#include <core/parameters.hpp>
#include <core/types.hpp>

namespace Machpoint
{

//! Primitive state of a gas.
struct GasState
{
    double density; //!< mass/length^Dim; 0: no gas
    //! [3], length/time; components beyond the dimension are 0.
    Vector3 velocity;
    double pressure;
};

//! Vector from a resolved input array. \param json [Dim] numbers
template <int Dim>
Vector<Dim> toVector( const Json& json )
{
    Vector<Dim> x{};
    for ( int d = 0; d < Dim; ++d )
        x[d] = json.at( d ).get<Real>();
    return x;
}

//! Up to three numbers of an input as a vector, zeros behind them; zeros if
//! null.
inline Vector3 toVector3( const Json& json )
{
    Vector3 result{};
    for ( std::size_t d = 0; d < json.size(); ++d )
        result[d] = json[d];
    return result;
}

//! The keys `density`, `velocity` and `pressure` of an entry of an input.
//! \param json resolved
inline GasState toGasState( const Json& json )
{
    return { json.at( "density" ), toVector3( json.at( "velocity" ) ),
             json.at( "pressure" ) };
}

} // namespace Machpoint

#endif
