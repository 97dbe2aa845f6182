/*!
  \file stability.hpp
  \brief `conservative`: the time step that the particles' arrangement allows
  (docs/conservative.md, section 10).
*/
#ifndef MACHPOINT_CONSERVATIVE_STABILITY_HPP
#define MACHPOINT_CONSERVATIVE_STABILITY_HPP

#include <core/conservative/faces.hpp>

#include <cmath>
#include <limits>

namespace Machpoint
{
namespace Impl
{

/*!
  \brief Largest time step for which the motion that the pressure drives is
  stable: dt^2 = most_stiffness / s, with

  s = max_i kappa h^Dim / m_i sum_a sum_f rho c^2_f / (h_a^2 theta_f)

  over this rank's own nodes i and the faces f next to them. Particles press
  with all of their pressure on faces that they fill in part, and the nodes
  there are light: in a hole the grid's sound is faster than the gas's. kappa is
  the mean square of a face's weight. Nodes with a face below least_filling, at
  the edge of a vacuum, do not count.

  \param response of the gas
  \return infinity without gas
*/
template <class Basis, int Dim>
double stableTimeStep( const State<Dim>& state,
                       const PressureResponse& response,
                       const Real least_filling )
{
    // 4 (1 + T) / (3 - T), where P2G keeps the part T = 1/2 of a mode. On
    // hats it keeps nothing where particles cross nodes, and the fastest
    // mode has 2 s.
    constexpr double most_stiffness = Basis::constant_moment ? 2.4 : 2.0 / 3;
    const auto moments = state.nodes.moments;
    const auto layout = state.layout;
    const auto inverse = state.grid.inverse;
    Real factor = response.exponent * state.grid.cellVolume() *
                  Basis::halfway_mean_square;
    for ( int a = 1; a < Dim; ++a )
        factor *= Basis::mean_square;
    Real stiffness = 0;
    reduceEach(
        "Machpoint::stableTimeStep", layout.total, few_rows,
        MACHPOINT_LAMBDA( const int i, Real& most ) {
            Real sum = 0;
            for ( int a = 0; a < Dim; ++a )
                for ( const int f : { i - layout.stride[a], i } )
                {
                    // The outermost nodes, which are nobody's, have no
                    // face on one side.
                    const int row = Kokkos::max( f, 0 );
                    const Real theta = moments( row, theta_column<Dim> + a );
                    if ( theta < least_filling )
                        return;
                    const Real pressed =
                        moments( row, pressure_column<Dim> + a );
                    sum += ( pressed + response.reference * theta ) *
                           inverse[a] * inverse[a] / ( theta * theta );
                }
            // Few nodes are the stiffest so far; only then it matters
            // whose they are.
            const Real m = moments( i, 0 );
            if ( most * m < factor * sum &&
                 layout.isOwned( layout.indices( i ) ) )
                most = factor * sum / m;
        },
        Kokkos::Max<Real>( stiffness ) );
    if ( stiffness > 0 )
        return std::sqrt( most_stiffness / stiffness );
    return std::numeric_limits<double>::infinity();
}

} // namespace Impl
} // namespace Machpoint

#endif
