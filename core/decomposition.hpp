/*!
  \file decomposition.hpp
  \brief Layer 3: which rank has which cells: a Cartesian product of cuts, one
  list for each axis.
*/
#ifndef MACHPOINT_DECOMPOSITION_HPP
#define MACHPOINT_DECOMPOSITION_HPP

#include <core/communicator.hpp>
#include <core/grid.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief Number of ranks along each axis whose boxes have the least surface.
  \param cells of the domain [Dim] \param size number of ranks
*/
template <int Dim>
Indices<Dim> chooseRanks( const Indices<Dim>& cells, const int size )
{
    Indices<Dim> best{}, trial{};
    double least = -1;
    // All ways to write size as a product, axis by axis.
    auto search = [&]( auto&& self, const int axis, const int left ) -> void
    {
        if ( axis == Dim - 1 )
        {
            trial[axis] = left;
            double surface = 0;
            for ( int d = 0; d < Dim; ++d )
            {
                double face = trial[d] > 1 ? 1 : 0;
                for ( int b = 0; b < Dim; ++b )
                    if ( b != d )
                        face *= static_cast<double>( cells[b] ) / trial[b];
                surface += face;
                // A box thinner than a cell is none.
                if ( trial[d] > cells[d] )
                    surface += 1e300;
            }
            // Of equals the one that cuts the last axis, whose halo is
            // contiguous in memory.
            if ( least < 0 || surface < least )
            {
                least = surface;
                best = trial;
            }
            return;
        }
        for ( int r = 1; r <= left; ++r )
            if ( left % r == 0 )
            {
                trial[axis] = r;
                self( self, axis + 1, left / r );
            }
    };
    search( search, 0, size );
    return best;
}

/*!
  \brief The boxes of all ranks.

  Rank numbers run along x first. Along axis d the boxes are bounded by
  cuts[d][0] = 0 < cuts[d][1] < ... = cells[d].
*/
template <int Dim>
class Decomposition
{
  public:
    //! Cuts of an axis on the device, [ranks + 1].
    using CutView = Kokkos::View<int*, MemorySpace>;

    Decomposition() = default;

    //! Boxes of equal numbers of cells, as far as they divide.
    //! \param ranks along each axis; their product is the number of ranks
    //! \throws std::invalid_argument when it is not, or when boxes are empty
    Decomposition( const Communicator& communicator, const Indices<Dim>& cells,
                   const Indices<Dim>& ranks )
        : _comm( communicator ), _ranks( ranks )
    {
        int product = 1;
        for ( int d = 0; d < Dim; ++d )
            product *= ranks[d];
        if ( product != _comm.size() )
            throw std::invalid_argument(
                "a decomposition into " + std::to_string( product ) +
                " boxes on " + std::to_string( _comm.size() ) +
                " ranks; start as many ranks as there are boxes" );
        int rest = _comm.rank();
        for ( int d = 0; d < Dim; ++d )
        {
            if ( ranks[d] > cells[d] )
                throw std::invalid_argument(
                    "axis " + std::to_string( d ) + " has " +
                    std::to_string( cells[d] ) + " cells for " +
                    std::to_string( ranks[d] ) +
                    " ranks; start fewer ranks, or take more cells" );
            _place[d] = rest % ranks[d];
            rest /= ranks[d];
            std::vector<int> cuts( ranks[d] + 1 );
            for ( int r = 0; r <= ranks[d]; ++r )
                cuts[r] = static_cast<int>(
                    static_cast<std::int64_t>( cells[d] ) * r / ranks[d] );
            setCuts( d, cuts );
        }
    }

    const Communicator& comm() const { return _comm; }
    //! Ranks along each axis [Dim].
    const Indices<Dim>& ranks() const { return _ranks; }
    //! Cuts along an axis, [ranks + 1].
    const std::vector<int>& cuts( const int d ) const { return _cuts[d]; }

    //! This rank's cells.
    CellBox<Dim> box() const
    {
        CellBox<Dim> box{};
        for ( int d = 0; d < Dim; ++d )
        {
            box.begin[d] = _cuts[d][_place[d]];
            box.end[d] = _cuts[d][_place[d] + 1];
        }
        return box;
    }

    //! The fewest cells that a box has along an axis.
    int fewestCells( const int d ) const
    {
        int fewest = _cuts[d][1] - _cuts[d][0];
        for ( int r = 1; r < _ranks[d]; ++r )
            fewest = std::min( fewest, _cuts[d][r + 1] - _cuts[d][r] );
        return fewest;
    }

    //! The rank beside this one, around the domain's ends.
    //! \param direction -1 or 1
    int neighbour( const int axis, const int direction ) const
    {
        auto place = _place;
        place[axis] = ( place[axis] + direction + _ranks[axis] ) % _ranks[axis];
        int rank = 0;
        for ( int d = Dim - 1; d >= 0; --d )
            rank = rank * _ranks[d] + place[d];
        return rank;
    }

    //! Finds the rank that has a position's cell; for kernels.
    struct Finder
    {
        Grid<Dim> grid;
        Indices<Dim> ranks;
        Kokkos::Array<CutView, Dim> cuts;

        //! \param x [Dim]
        KOKKOS_INLINE_FUNCTION int operator()( const Vector<Dim>& x ) const
        {
            int rank = 0;
            for ( int d = Dim - 1; d >= 0; --d )
            {
                const int c = grid.cell( x[d], d );
                int low = 0, high = ranks[d]; // cuts[low] <= c < cuts[high]
                while ( high - low > 1 )
                {
                    const int middle = ( low + high ) / 2;
                    ( c >= cuts[d]( middle ) ? low : high ) = middle;
                }
                rank = rank * ranks[d] + low;
            }
            return rank;
        }
    };
    Finder finder( const Grid<Dim>& grid ) const
    {
        return { grid, _ranks, _device_cuts };
    }

  private:
    void setCuts( const int d, const std::vector<int>& cuts )
    {
        _cuts[d] = cuts;
        _device_cuts[d] = CutView( "Machpoint::cuts", cuts.size() );
        const Kokkos::View<const int*, Kokkos::HostSpace> host( cuts.data(),
                                                                cuts.size() );
        Kokkos::deep_copy( _device_cuts[d], host );
    }

    Communicator _comm;
    Indices<Dim> _ranks{};
    Indices<Dim> _place{}; // of this rank among them
    std::vector<int> _cuts[Dim];
    Kokkos::Array<CutView, Dim> _device_cuts;
};

} // namespace Machpoint

#endif
