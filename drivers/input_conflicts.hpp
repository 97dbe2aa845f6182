/*!
  \file input_conflicts.hpp
  \brief Layer 7: conflicts between the keys of an input.
*/
#ifndef MACHPOINT_INPUT_CONFLICTS_HPP
#define MACHPOINT_INPUT_CONFLICTS_HPP

#include <drivers/sound_keys.hpp>

#include <core/input_hooks.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

//! What a resolved input says of its method.
MethodFacts methodFacts( const Json& input );

//! Why a file or a directory cannot have a name; empty: it can.
std::string fileNameFault( const std::string& name );

/*!
  \brief What no single key can tell: conflicts between keys. What needs a key
  that is wrong itself is left out.
  \param input resolved \param dimension 0 where it is not known
  \return one line for each conflict
*/
std::vector<std::string> findConflicts( const Json& input,
                                        const SoundKeys& sound, int dimension );

} // namespace Machpoint

#endif
