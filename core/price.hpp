/*!
  \file price.hpp
  \brief Layer 6: what a run's accuracy cost, and what more of it would.
*/
#ifndef MACHPOINT_PRICE_HPP
#define MACHPOINT_PRICE_HPP

#include <core/parameters.hpp>
#include <core/types.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace Machpoint
{

//! \name Orders that are believed
//! What falls more slowly than discontinuities do is not resolved; what falls
//! faster than the best method here does in smooth flow is a flow that coarser
//! grids do not show yet.
//! @{
constexpr double lowest_order = 0.5, highest_order = 2;
//! @}

//! Below this part of the field an error is round-off, which no grid halves.
constexpr double least_error = round_off;

/*!
  \brief `price` of a summary: the time, the error of the density that it
  bought, and the time that half the error would take.

  The error is the one against the exact solution or, without one, the estimated
  one. Half of it takes a spacing of 2^(-1/p) h; that is 2^(Dim/p) times the
  cells and 2^(1/p) times the steps. The order p is the observed one where there
  is an estimate, up to highest_order, else 1: all that a discontinuity allows.
  Below lowest_order half the error has no price. Outputs stay as many,
  and take the part of the time that they took since the last restart.
  \param summary with all other keys
  \param process_seconds of its wall seconds, those since the last restart
  \return `price`; null for what is not known (docs/output.md)
*/
Json makePrice( const Json& summary, double process_seconds );

//! `error_estimate` and `price` for the end table.
std::string formatPrice( const Json& summary );

//! 0.0123 s, 12.3 s, 3.4 min, 5.6 h, 7.8 days
std::string formatSeconds( double seconds );

//! 400 x 200
std::string formatCells( const std::vector<std::int64_t>& cells );

} // namespace Machpoint

#endif
