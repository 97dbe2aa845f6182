/*!
  \file warnings.hpp
  \brief Layer 7: what is right in an input, and yet seems not to be meant.
*/
#ifndef MACHPOINT_WARNINGS_HPP
#define MACHPOINT_WARNINGS_HPP

#include <core/parameters.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief What the physics modules say of an input, as "/physics/1: ...", and
  what is odd about its gas and its bodies, whatever the modules.

  The gas is asked for at the centres of the cells, of larger ones where there
  are many (SampleGrid). A shock is a wave, from two gases that meet or from one
  that meets a wall or a body, behind which the pressure is a tenth higher.
  \param input resolved \throws InputError where there is no such gas
*/
std::vector<std::string> findWarnings( const Json& input );

} // namespace Machpoint

#endif
