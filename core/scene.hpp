/*!
  \file scene.hpp
  \brief Layer 5: what an input describes, built: grid, particles, modules.
*/
#ifndef MACHPOINT_SCENE_HPP
#define MACHPOINT_SCENE_HPP

#include <core/registry.hpp>

#include <memory>
#include <string>
#include <vector>

namespace Machpoint
{

//! A module of the scene and its name in the report.
template <int Dim>
struct ActiveModule
{
    std::string name; //!< reportName
    std::unique_ptr<Module<Dim>> module;
    Hooks hooks;                  //!< that its type overrides
    std::vector<SideClaim> sides; //!< of a boundary; else none
    Json solid;                   //!< shape of a body; else null
};

//! What a scene needs to know of a basis and a method to lay out its nodes.
struct NodeNeeds
{
    bool centred; //!< nodes at cell centres rather than vertices
    int halo;     //!< layers of nodes that a particle in the box sees beyond it
    int reach;    //!< cells beyond the box from which particles scatter
    int margin;   //!< layers more where axes are cut, so that a rank makes what
                  //!< it needs of neighbours' nodes itself
};

//! State and modules of a run.
template <int Dim>
struct Scene
{
    NodeNeeds needs; //!< of basis and method
    State<Dim> state;
    std::vector<ActiveModule<Dim>> modules; //!< physics, then boundaries
    EquationOfState<Dim>* gas = nullptr;    //!< one of the modules
    bool is_open = false;                   //!< gas enters or leaves
    Indices<Dim> has_wall{}; //!< does a wall take momentum along this axis?
    //! For each side of the domain the kinds of its nodes, x first.
    std::vector<std::vector<SideKind>> side_kinds;
};

/*!
  \brief Builds this rank's part of the scene of a resolved input.
  \throws InputError where places of a side are taken twice or by nobody, where
  no particle finds room, or where the ranks do not fit the cells; on all ranks
  alike
*/
template <int Dim>
Scene<Dim> makeScene( const Json& input, const NodeNeeds& needs );

//! Does each place of a side belong to one entry of `boundary`, where these
//! have regions, and does a body that reaches through a periodic side go on at
//! the opposite one? \param input resolved \throws InputError where not
void checkSides( const Json& input );

//! Lays out this rank's nodes and their halo for the box that it has now.
//! \throws InputError where a rank's box is thinner than the halo
template <int Dim>
void layOut( Scene<Dim>& scene );

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
