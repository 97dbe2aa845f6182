/*!
  \file scene.hpp
  \brief Layer 5: what an input describes, built: grid, particles, modules.
*/
#ifndef MACHPOINT_SCENE_HPP
#define MACHPOINT_SCENE_HPP

#include <core/registry.hpp>

namespace Machpoint
{

//! A module of the scene and its name in the report.
template <int Dim>
struct ActiveModule
{
    std::string name;
    std::unique_ptr<Module<Dim>> module;
};

//! State and modules of a run.
template <int Dim>
struct Scene
{
    State<Dim> state;
    std::vector<ActiveModule<Dim>> modules; //!< physics, then boundaries
    EquationOfState<Dim>* gas = nullptr;    //!< one of the modules
    bool is_open = false;                   //!< gas enters or leaves
    Indices<Dim> has_wall{}; //!< does a wall take momentum along this axis?
};

/*!
  \brief Builds the scene of a resolved input.
  \param layout the nodes of the basis
  \throws InputError where places of a side are taken twice or by nobody, or
  where no particle finds room
*/
template <int Dim>
Scene<Dim> makeScene( const Json& input, const Grid<Dim>& grid,
                      const NodeLayout<Dim>& layout );

//! The grid of a resolved input.
template <int Dim>
Grid<Dim> makeGrid( const Json& input )
{
    const auto& json = input.at( "grid" );
    Indices<Dim> cells{};
    for ( int d = 0; d < Dim; ++d )
        cells[d] = json.at( "cells" ).at( d ).template get<int>();
    return Grid<Dim>( toVector<Dim>( json.at( "lower" ) ),
                      toVector<Dim>( json.at( "upper" ) ), cells );
}

} // namespace Machpoint

#endif
