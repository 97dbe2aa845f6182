/*!
  \file decomposition.hpp
  \brief Layer 3: which rank has which cells: a Cartesian product of cuts, one
  list for each axis.
*/
#ifndef MACHPOINT_DECOMPOSITION_HPP
#define MACHPOINT_DECOMPOSITION_HPP

#include <core/archive.hpp>
#include <core/communicator.hpp>
#include <core/grid.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief Number of ranks along each axis for the least area of all cuts.
  \param cells of the domain [Dim] \param size number of ranks
  \return [Dim]; their product is size, even if that is more than all cells
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
            double area = 0;
            for ( int d = 0; d < Dim; ++d )
            {
                double cuts = trial[d] - 1;
                for ( int b = 0; b < Dim; ++b )
                    if ( b != d )
                        cuts *= cells[b];
                area += cuts;
                // A box thinner than a cell is none.
                if ( trial[d] > cells[d] )
                    area += 1e300;
            }
            // Of equals the one that cuts the last axis, whose halo is
            // contiguous in memory.
            if ( least < 0 || area < least )
            {
                least = area;
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

//! Along axis d boxes are bounded by cuts[d][0] = 0 < cuts[d][1] < ... =
//! cells[d].
template <int Dim>
using Cuts = std::array<std::vector<int>, Dim>;

//! Finds the box that has a position's cell; for kernels.
template <int Dim>
struct BoxFinder
{
    //! Cuts of an axis on the device, [boxes + 1].
    using CutView = Kokkos::View<int*, MemorySpace>;

    Grid<Dim> grid;                   //!< the whole domain
    Kokkos::Array<CutView, Dim> cuts; //!< of each axis

    //! \param x [Dim] \return number of the box, x first
    KOKKOS_INLINE_FUNCTION int operator()( const Vector<Dim>& x ) const
    {
        int box = 0;
        for ( int d = Dim - 1; d >= 0; --d )
        {
            const int c = grid.cell( x[d], d );
            const int boxes = static_cast<int>( cuts[d].extent( 0 ) ) - 1;
            int low = 0, high = boxes; // cuts[low] <= c < cuts[high]
            while ( high - low > 1 )
            {
                const int middle = ( low + high ) / 2;
                ( c >= cuts[d]( middle ) ? low : high ) = middle;
            }
            box = box * boxes + low;
        }
        return box;
    }
};

//! The finder of the boxes between cuts.
template <int Dim>
BoxFinder<Dim> findBoxes( const Grid<Dim>& grid, const Cuts<Dim>& cuts )
{
    BoxFinder<Dim> finder{ grid, {} };
    for ( int d = 0; d < Dim; ++d )
    {
        finder.cuts[d] = typename BoxFinder<Dim>::CutView( "Machpoint::cuts",
                                                           cuts[d].size() );
        Kokkos::deep_copy( finder.cuts[d],
                           Kokkos::View<const int*, Kokkos::HostSpace>(
                               cuts[d].data(), cuts[d].size() ) );
    }
    return finder;
}

/*!
  \brief The boxes of all ranks.

  Rank numbers run along x first.
*/
template <int Dim>
class Decomposition
{
  public:
    Decomposition() = default;

    //! Boxes of equal numbers of cells, as far as they divide.
    //! \param ranks along each axis; their product is the number of ranks
    //! \throws std::invalid_argument when it is not, or when boxes are empty
    Decomposition( const Communicator& communicator, const Indices<Dim>& cells,
                   const Indices<Dim>& ranks )
        : _comm( communicator ), _ranks( ranks )
    {
        double product = 1; // as many as anyone may ask for
        for ( int d = 0; d < Dim; ++d )
            product *= ranks[d];
        if ( product != _comm.size() )
            throw std::invalid_argument(
                fmt::format( "a decomposition into {:.15g}", product ) +
                " boxes on " + std::to_string( _comm.size() ) +
                " ranks; start as many ranks as there are boxes" );
        int rest = _comm.rank();
        Cuts<Dim> cuts;
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
            for ( int r = 0; r <= ranks[d]; ++r )
                cuts[d].push_back( static_cast<int>(
                    static_cast<std::int64_t>( cells[d] ) * r / ranks[d] ) );
        }
        setCuts( cuts );
    }

    //! Moves the boxes; their number stays. All ranks give the same cuts.
    //! \param cuts [Dim][ranks + 1]
    void setCuts( const Cuts<Dim>& cuts )
    {
        _cuts = cuts;
        _device_cuts = findBoxes<Dim>( Grid<Dim>{}, cuts ).cuts;
    }

    //! The ranks that share the domain.
    const Communicator& comm() const { return _comm; }
    //! Ranks along each axis [Dim].
    const Indices<Dim>& ranks() const { return _ranks; }
    //! Cuts along an axis, [ranks + 1].
    const std::vector<int>& cuts( const int d ) const { return _cuts[d]; }

    //! Writes the cuts, or takes up those that were written; where there were
    //! other numbers of boxes, its own stay. \throws ArchiveError
    void checkpoint( Archive& archive )
    {
        Cuts<Dim> cuts;
        bool fits = true;
        for ( int d = 0; d < Dim; ++d )
        {
            std::vector<std::int64_t> list( _cuts[d].begin(), _cuts[d].end() );
            archive.table( std::string( "cuts_" ) + "xyz"[d], list, 1 );
            cuts[d].assign( list.begin(), list.end() );
            fits = fits && cuts[d].size() == _cuts[d].size();
        }
        if ( archive.isReading() && fits )
            setCuts( cuts );
    }

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
    //! \param direction -1 or 1 \return its number
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
    BoxFinder<Dim> finder( const Grid<Dim>& grid ) const
    {
        return { grid, _device_cuts };
    }

  private:
    Communicator _comm;
    Indices<Dim> _ranks{};
    Indices<Dim> _place{}; // of this rank among them
    Cuts<Dim> _cuts;
    Kokkos::Array<typename BoxFinder<Dim>::CutView, Dim> _device_cuts;
};

} // namespace Machpoint

#endif
