/*!
  \file placement.hpp
  \brief Layer 2: where the particles of a cell stand: on a lattice, on a
  jittered lattice, or at random. A place depends on the cell, the particle's
  number and the seed alone.
*/
#ifndef MACHPOINT_PLACEMENT_HPP
#define MACHPOINT_PLACEMENT_HPP

#include <core/random.hpp>
#include <core/types.hpp>

#include <cmath>

namespace Machpoint
{

//! How particles are laid into cells.
enum class Placement
{
    lattice,  //!< q^Dim equal sub-cells, one particle at the centre of each
    jittered, //!< anywhere within its sub-cell
    random    //!< anywhere within the cell
};

//! Particles along one axis of a lattice, or 0 if n is no Dim-th power.
inline int latticeSize( const int n, const int dimension )
{
    const int q = static_cast<int>(
        std::lround( std::pow( static_cast<double>( n ), 1.0 / dimension ) ) );
    int power = 1;
    for ( int d = 0; d < dimension; ++d )
        power *= q;
    return power == n ? q : 0;
}

/*!
  \brief Place of particle k of a cell, each coordinate in [0, 1).
  \param q particles along one axis of the lattice (unused at random)
  \param cell unique number of the cell, the counter of the random draws
*/
template <int Dim>
KOKKOS_INLINE_FUNCTION Vector<Dim>
placeInCell( const Placement placement, const int q, const std::uint64_t seed,
             const std::uint64_t cell, int k )
{
    Vector<Dim> f{};
    const int number = k;
    for ( int d = 0; d < Dim; ++d )
    {
        const Real draw =
            placement == Placement::lattice
                ? 0.5_rt
                : uniformRandom( seed, cell,
                                 static_cast<std::uint64_t>( number ) * Dim +
                                     d );
        if ( placement == Placement::random )
            f[d] = draw;
        else
        {
            f[d] = ( k % q + draw ) / q;
            k /= q;
        }
    }
    return f;
}

} // namespace Machpoint

#endif
