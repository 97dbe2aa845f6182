/*!
  \file grid_fields.hpp
  \brief Layer 7: node fields of a whole run, to be compared with those of a run
  on another grid.
*/
#ifndef MACHPOINT_GRID_FIELDS_HPP
#define MACHPOINT_GRID_FIELDS_HPP

#include <core/report.hpp>
#include <core/simulation.hpp>

#include <array>
#include <cstddef>
#include <vector>

namespace Machpoint
{

//! The blocks of all ranks as one, on the root; empty elsewhere. Collective.
//! \throws std::runtime_error where a field is more than 2 GiB
GridData wholeGrid( const Communicator& ranks, const GridData& own );

//! Node fields, to be asked at any place.
class GridFields
{
  public:
    //! \param whole a block that is the whole
    explicit GridFields( const GridData& whole );

    //! Density, pressure, energy, velocity [3 + Dim], linearly interpolated;
    //! empty where a node beside the place has no gas. \param x [Dim]
    std::vector<double> at( const std::array<double, 3>& x ) const;

  private:
    std::vector<double> _lower, _spacing;
    std::vector<std::size_t> _shape;          // x first
    std::vector<std::vector<double>> _fields; // [fields][nodes]
};

//! How far one run's field is from another's, and how large that is.
struct FieldDifference
{
    FieldError error; //!< norms of the difference
    double size = 0;  //!< |field| of the other run, integrated over the domain
};

/*!
  \brief Differences of density, velocity, pressure and specific internal
  energy, in this order.

  Both are interpolated linearly to the centres of the cells of an input, and
  integrated over the domain; cells in which one of them has no gas are left
  out.
  \param coarse, fine of one scene
  \param input resolved, of the coarse run
*/
std::vector<FieldDifference> fieldDifferences( const GridFields& coarse,
                                               const GridFields& fine,
                                               const Json& input );

} // namespace Machpoint

#endif
