/*!
  \file scene_parts.hpp
  \brief Layer 5: parts of building a scene that have a file of their own; for
  the sources of core/scene alone.
*/
#ifndef MACHPOINT_SCENE_PARTS_HPP
#define MACHPOINT_SCENE_PARTS_HPP

#include <core/scene.hpp>

#include <vector>

namespace Machpoint
{

//! checkSides of an input of this dimension. \throws InputError as that does
template <int Dim>
void checkSides( const Json& input );

/*!
  \brief What each node of each side of the whole domain is; the modules claim
  them. All ranks find the same, and the same errors.
  \param[in,out] scene with its grid and modules; learns where walls are
  \param whole nodes of the domain without halo
  \return for each side the kinds of its nodes without halo, x first
  \throws InputError where a node is claimed by nobody, or more than once
*/
template <int Dim>
std::vector<std::vector<SideKind>> claimSides( Scene<Dim>& scene,
                                               const NodeLayout<Dim>& whole );

//! Lays the particles into this rank's cells. Collective.
//! \param scene all but its particles \throws InputError where no particle
//! finds room, or the gas is none; on all ranks alike
template <int Dim>
void placeParticles( const Json& input, Scene<Dim>& scene );

} // namespace Machpoint

#endif
