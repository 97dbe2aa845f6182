/*!
  \file error_estimate.hpp
  \brief Layer 7: the discretisation error of a run, estimated from companion
  runs on coarser grids.
*/
#ifndef MACHPOINT_ERROR_ESTIMATE_HPP
#define MACHPOINT_ERROR_ESTIMATE_HPP

#include <drivers/companion.hpp>
#include <drivers/grid_fields.hpp>

#include <optional>

namespace Machpoint
{

//! The error of the finest of two or three grids.
struct Extrapolation
{
    double error = 0;               //!< of the unit of `near`
    double order = 1;               //!< that the error was computed with
    std::optional<double> observed; //!< order, of three grids
};

/*!
  \brief Richardson's extrapolation: error = near / (ratio^p - 1).

  Three grids show the order: far / near = ratio^p (far_ratio^p - 1) /
  (ratio^p - 1), that is ratio^p where both ratios are the same. It is
  believed between lowest_order and highest_order (as Eca and Hoekstra 2014 do,
  J. Comput. Phys. 262); with two it is taken to be 1, as at shocks and
  contacts.
  \param near how far the next coarser grid is from the finest
  \param far how far the coarsest is from that one; none without it
  \param ratio of the spacings of the finer two grids, > 1
  \param far_ratio of those of the coarser two, > 1
*/
Extrapolation extrapolate( double near, std::optional<double> far, double ratio,
                           double far_ratio );

/*!
  \brief Can companion runs be made of this input? Collective.
  \param input resolved \throws InputError that says why not
*/
void requireCompanions( const Json& input );

/*!
  \brief Runs the scene on half and on a quarter of the cells along each axis,
  and compares. Collective.

  A quarter is left out where its longest axis would have fewer than 8 cells,
  and where the gas breaks down on it.
  \param input resolved \param fine the run's grid data, own blocks
  \param time of the data \param stop ends a companion, and the estimate
  \return `error_estimate` of the summary; on all ranks but the root without
  what the fields tell
*/
Json estimateError( const Json& input, const GridData& fine, double time,
                    const IsStopped& stop );

} // namespace Machpoint

#endif
