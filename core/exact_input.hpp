/*!
  \file exact_input.hpp
  \brief Layer 2: directions that an input gives exact solutions; for the
  sources of core/exact alone.
*/
#ifndef MACHPOINT_EXACT_INPUT_HPP
#define MACHPOINT_EXACT_INPUT_HPP

#include <core/gas_state.hpp>

namespace Machpoint
{

//! Unit vector along an axis: "x", "y" or "z".
Vector3 axisVector( const Json& axis );

//! Unit vector of the keys `normal`, or else `axis`, of an entry of `initial`.
//! \throws std::invalid_argument where the normal is zero
Vector3 unitNormal( const Json& initial );

} // namespace Machpoint

#endif
