/*!
  \file sorting.hpp
  \brief Layer 3: the order of particles by cell.
*/
#ifndef MACHPOINT_SORTING_HPP
#define MACHPOINT_SORTING_HPP

#include <core/decomposition.hpp>
#include <core/particles.hpp>

namespace Machpoint
{

//! Cell of every particle, within the rank's box. \param x slice of positions
//! \return [n]
template <int Dim, class PositionSlice>
IndexList cellsOf( const PositionSlice& x, const Grid<Dim>& grid,
                   const CellBox<Dim>& box )
{
    const int n = static_cast<int>( x.size() );
    const IndexList cells(
        Kokkos::view_alloc( "Machpoint::cells", Kokkos::WithoutInitializing ),
        n );
    forEachPack(
        "Machpoint::cellOfParticle", n,
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            const auto cell = box.flatCell( grid, loadVector<Dim>( x, p ) );
            for ( int l = 0; l < p.count; ++l )
                cells( p.first + l ) = lane( cell, l );
        } );
    return cells;
}

//! Is only one in a hundred cells below the one before it, or fewer? Then
//! sorting would take longer than it saves: gas in 1D, and gas at rest. Not
//! where the last is no more behind the first: what has come round a
//! periodic side would be far from its thread's rows.
inline bool areNearlySorted( const IndexList& cells )
{
    const int n = cells.extent_int( 0 );
    int descents = 0;
    reduceEach(
        "Machpoint::descents", n, few_rows,
        MACHPOINT_LAMBDA( const int k, int& sum ) {
            if ( k + 1 < n )
                sum += cells( k + 1 ) < cells( k ) ? 1 : 0;
            else
                sum += cells( k ) <= cells( 0 ) ? n : 0;
        },
        descents );
    return descents <= n / 100;
}

//! Most particles of a cell.
inline int mostInCell( const ParticleBins& bins )
{
    int most = 0;
    reduceEach(
        "Machpoint::mostInCell", bins.numBin(), few_rows,
        MACHPOINT_LAMBDA( const int c, int& max ) {
            max = Kokkos::max( max, bins.binSize( c ) );
        },
        Kokkos::Max<int>( most ) );
    return most;
}

} // namespace Machpoint

#endif
