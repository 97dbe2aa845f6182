/*!
  \file scenes.hpp
  \brief Small inputs for tests.
*/
#ifndef MACHPOINT_UNITTEST_SCENES_HPP
#define MACHPOINT_UNITTEST_SCENES_HPP

#include "tolerance.hpp"

#include <core/module.hpp>
#include <core/simulation.hpp>
#include <drivers/input.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace Test
{

using Machpoint::Json;
using Machpoint::Real;

//! The names of all there are.
inline const std::vector<std::string> bases = { "linear", "quadratic",
                                                "cubic" };
inline const std::vector<std::string> methods = { "paper", "apic",
                                                  "conservative" };

//! [Dim] times the same value.
template <class T>
Json repeat( const int dimension, const T& value )
{
    Json list = Json::array();
    for ( int d = 0; d < dimension; ++d )
        list.push_back( value );
    return list;
}

//! Names of the sides of a box.
inline std::vector<std::string> sides( const int dimension )
{
    std::vector<std::string> list;
    for ( int d = 0; d < dimension; ++d )
        for ( const char* end : { "_lower", "_upper" } )
            list.push_back( std::string( 1, "xyz"[d] ) + end );
    return list;
}

//! A unit box of gas at rest with the same boundary on every side.
inline Json box( const int dimension, const int cells, const int per_axis,
                 const std::string& method, const std::string& basis,
                 const std::string& boundary )
{
    int per_cell = 1;
    for ( int d = 0; d < dimension; ++d )
        per_cell *= per_axis;
    Json input;
    input["scene"] = "test";
    input["dimension"] = dimension;
    input["grid"] = { { "lower", repeat( dimension, 0.0 ) },
                      { "upper", repeat( dimension, 1.0 ) },
                      { "cells", repeat( dimension, cells ) } };
    input["method"] = { { "name", method }, { "basis", basis } };
    input["particles"] = { { "per_cell", per_cell } };
    input["physics"] = Json::array( { Json{ { "type", "ideal_gas" } } } );
    input["initial"] =
        Json::array( { Json{ { "type", "uniform" },
                             { "density", 1.4 },
                             { "velocity", repeat( dimension, 0.0 ) },
                             { "pressure", 1.0 } } } );
    input["boundary"] = Json::array();
    for ( const auto& side : sides( dimension ) )
        input["boundary"].push_back(
            { { "type", boundary }, { "side", side } } );
    input["time"] = { { "end", 1e9 } };
    return input;
}

//! The same box with Sod's two gases in it.
inline Json shockTube( const int dimension, const int cells, const int per_axis,
                       const std::string& method, const std::string& basis )
{
    auto input = box( dimension, cells, per_axis, method, basis, "slip_wall" );
    auto state = [&]( const Real density, const Real pressure )
    {
        return Json{ { "density", density },
                     { "velocity", repeat( dimension, 0.0 ) },
                     { "pressure", pressure } };
    };
    input["initial"] =
        Json::array( { Json{ { "type", "riemann" },
                             { "position", 0.5 },
                             { "left", state( 1, 1 ) },
                             { "right", state( 0.125, 0.1 ) } } } );
    return input;
}

//! An inflow of the box's gas. \param velocity [Dim]
inline Json inflow( const std::string& side, const Json& velocity )
{
    return { { "type", "inflow" },
             { "side", side },
             { "density", 1.4 },
             { "velocity", velocity },
             { "pressure", 1 } };
}

//! Adds obstacles of these shapes, each with a name of its own.
inline void addBodies( Json& input, const std::vector<Json>& shapes )
{
    for ( const auto& shape : shapes )
        input["boundary"].push_back(
            { { "type", "obstacle" },
              { "name", "body " + std::to_string( input["boundary"].size() ) },
              { "shape", shape } } );
}

//! The same box, 2 particles a cell along an axis, with a stream along x, which
//! has the box's gas, past a body.
inline Json streamPast( const Json& shape, const int dimension, const int cells,
                        const Real speed, const std::string& method,
                        const std::string& basis )
{
    auto input = box( dimension, cells, 2, method, basis, "slip_wall" );
    auto velocity = repeat( dimension, 0.0 );
    velocity[0] = speed;
    input["initial"][0]["velocity"] = velocity;
    input["boundary"][0] = inflow( "x_lower", velocity );
    input["boundary"][1] = { { "type", "outflow" }, { "side", "x_upper" } };
    input["boundary"].push_back(
        { { "type", "obstacle" }, { "name", "body" }, { "shape", shape } } );
    return input;
}

//! Adds von Neumann's viscosity.
inline void addViscosity( Json& input )
{
    input["physics"].push_back( { { "type", "artificial_viscosity" } } );
}

//! A run of a test's input.
inline std::unique_ptr<Machpoint::Simulation> simulate( const Json& input )
{
    return Machpoint::makeSimulation(
        Machpoint::resolveInput( input, "test" ) );
}

//! Advances by a number of steps.
inline void advance( Machpoint::Simulation& simulation, const int steps )
{
    for ( int k = 0; k < steps; ++k )
        simulation.step( 1e9 );
}

//! Advances to a time.
inline void advanceTo( Machpoint::Simulation& simulation, const Real time )
{
    while ( simulation.time() < time )
        simulation.step( time );
}

//! Largest magnitude in a list.
inline Real largest( const std::vector<Real>& values )
{
    Real max = 0;
    for ( const Real v : values )
        max = std::max( max, std::abs( v ) );
    return max;
}

} // namespace Test

#endif
