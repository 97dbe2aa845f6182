/*!
  \file exact_doubts.hpp
  \brief Layer 7: does a scene stay what its exact solution is of?
*/
#ifndef MACHPOINT_EXACT_DOUBTS_HPP
#define MACHPOINT_EXACT_DOUBTS_HPP

#include <core/parameters.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief Why the `exact` of an input is of another flow than the scene's, as
  "/exact: ..." with a remedy; empty where it names none.

  Exact solutions know nothing of later entries of `initial`, of sides and of
  bodies. Told are the first place at which the gas does not start as they say,
  and the first, of eight times, at which they go through a side or a body that
  would not let them. Looked at are the centres of at most 250000 cells, and
  those of the sides; a hundredth of what the gas has makes a difference.
  \param input resolved \throws InputError where there is no such gas
*/
std::vector<std::string> findExactDoubts( const Json& input );

} // namespace Machpoint

#endif
