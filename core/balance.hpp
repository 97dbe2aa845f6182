/*!
  \file balance.hpp
  \brief Layer 3: cuts between the ranks that move with the particles.

  The load of a box is counted, not timed, so that a run takes the same cuts
  whenever it is repeated or restarted.
*/
#ifndef MACHPOINT_BALANCE_HPP
#define MACHPOINT_BALANCE_HPP

#include <core/archive.hpp>
#include <core/decomposition.hpp>
#include <core/parameters.hpp>
#include <core/particles.hpp>

#include <algorithm>
#include <utility>
#include <vector>

namespace Machpoint
{

//! What a run reports: the largest load of a rank over the mean one.
struct Imbalance
{
    double start = 0;            //!< of equal boxes; 0: not yet looked at
    double largest = 0;          //!< of all looks
    double end = 0;              //!< of the last look
    std::int64_t cuts_moved = 0; //!< how often
};

//! Loads of the cells along one axis, for each slab that the cuts of the other
//! axes leave: [slabs][cells], in particles.
using SlabLoads = std::vector<std::vector<double>>;

//! Cuts of one axis, and the load of the heaviest box between them.
struct AxisCuts
{
    std::vector<int> cuts; //!< [parts + 1]
    double heaviest;       //!< in particles
};

/*!
  \brief The cuts along one axis whose heaviest box is lightest, those of the
  other axes being given: exact to one part in a million.

  Of cuts that are equally good, those nearest to equal loads of whole layers.
  \param loads [slabs][cells], none negative
  \param parts boxes along the axis
  \param fewest cells of a box
  \throws std::invalid_argument when there are too few cells for that
*/
AxisCuts cutAxis( const SlabLoads& loads, int parts, int fewest );

//! All cuts, and the load of the heaviest box between them.
template <int Dim>
struct BoxCuts
{
    Cuts<Dim> cuts;      //!< [Dim][ranks + 1]
    double heaviest = 0; //!< in particles; 0 where no axis is cut
};

/*!
  \brief Cuts of all axes whose heaviest box is light.

  Axis after axis, each exactly for the cuts of the others, until that gains
  nothing: the best for one axis, and as good as cuts through the whole domain
  can be where the load is a product of the axes' own. A load on a diagonal is
  neither: no such cuts even it out.
  \param cells of the domain [Dim] \param ranks along each axis [Dim]
  \param fewest cells of a box along each axis that is cut [Dim]
  \param loads callable with an axis and the cuts of all, gives SlabLoads
  \throws std::invalid_argument when an axis has too few cells for that
*/
template <int Dim, class Loads>
BoxCuts<Dim> chooseCuts( const Indices<Dim>& cells, const Indices<Dim>& ranks,
                         const Indices<Dim>& fewest, const Loads& loads )
{
    // Gains below this are not worth another round, of which few are needed.
    constexpr double least_gain = 1e-3;
    constexpr int most_rounds = 5;
    BoxCuts<Dim> chosen;
    for ( int d = 0; d < Dim; ++d )
        chosen.cuts[d] = { 0, cells[d] };
    double before = 0;
    for ( int round = 0; round < most_rounds; ++round )
    {
        for ( int d = 0; d < Dim; ++d )
            if ( ranks[d] > 1 )
            {
                auto found =
                    cutAxis( loads( d, chosen.cuts ), ranks[d], fewest[d] );
                chosen.cuts[d] = std::move( found.cuts );
                chosen.heaviest = found.heaviest;
            }
        if ( round > 0 && chosen.heaviest > before * ( 1 - least_gain ) )
            break;
        before = chosen.heaviest;
    }
    return chosen;
}

/*!
  \brief Loads of all ranks' particles and cells along an axis, for the slabs
  between the cuts of the other axes. Collective.
  \param cuts of all axes; those of `axis` do not count
  \param cell_cost load of a cell, in particles
*/
template <int Dim>
SlabLoads countLoads( const Communicator& comm, const Grid<Dim>& grid,
                      const Particles<Dim>& particles, const int axis,
                      Cuts<Dim> cuts, const double cell_cost )
{
    const auto x = particles.template slice<Position>();
    const int cells = grid.cells[axis];
    cuts[axis] = { 0, cells };
    std::size_t slabs = 1;
    for ( int d = 0; d < Dim; ++d )
        slabs *= cuts[d].size() - 1;
    const auto slab_of = findBoxes<Dim>( grid, cuts );
    Kokkos::View<int**, Kokkos::LayoutRight, MemorySpace> counts(
        "Machpoint::loads", slabs, cells );
    forEach(
        "Machpoint::countLoads", particles.size(),
        MACHPOINT_LAMBDA( const int p ) {
            const auto y = loadVector<Dim>( x, p );
            Kokkos::atomic_inc(
                &counts( slab_of( y ), grid.cell( y[axis], axis ) ) );
        } );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), counts );
    const auto sums = comm.sumCounts(
        std::vector<std::int64_t>( host.data(), host.data() + host.size() ) );

    SlabLoads loads( slabs, std::vector<double>( cells ) );
    for ( std::size_t s = 0; s < slabs; ++s )
    {
        double layer = cell_cost; // of the slab's cells in one layer
        std::size_t rest = s;
        for ( int d = 0; d < Dim; ++d )
        {
            const auto place = rest % ( cuts[d].size() - 1 );
            rest /= cuts[d].size() - 1;
            if ( d != axis )
                layer *= cuts[d][place + 1] - cuts[d][place];
        }
        for ( int c = 0; c < cells; ++c )
            loads[s][c] = layer + static_cast<double>( sums[s * cells + c] );
    }
    return loads;
}

//! Watches the loads of the ranks, and moves the cuts between them.
template <int Dim>
class Balancer
{
  public:
    //! \param balance resolved `decomposition.balance`
    explicit Balancer( const Json& balance )
        : _every( balance.at( "every" ) ),
          _threshold( balance.at( "threshold" ) ),
          _cell_cost( balance.at( "cell_cost" ) )
    {
    }

    //! Is it time to look at the loads?
    bool isDue( const Communicator& comm, const std::int64_t step ) const
    {
        return comm.size() > 1 && _every > 0 && step % _every == 0;
    }

    //! Of the ranks' boxes, in particles.
    struct Loads
    {
        double largest, mean;
    };

    //! Compares the loads of the ranks, and remembers. Collective.
    Loads look( const Decomposition<Dim>& decomposition,
                const Particles<Dim>& particles )
    {
        const auto& comm = decomposition.comm();
        const double own =
            particles.size() + _cell_cost * decomposition.box().totalCells();
        const Loads loads{ comm.max( own ), comm.sum( own ) / comm.size() };
        // The mean of equal loads may round to a larger number.
        _seen.end = loads.mean > 0
                        ? std::max( loads.largest / loads.mean, double( 1 ) )
                        : 1;
        _seen.largest = std::max( _seen.largest, _seen.end );
        if ( _seen.start == 0 )
            _seen.start = _seen.end;
        return loads;
    }

    /*!
      \brief Moves the cuts where the imbalance exceeds the threshold and other
      cuts would lessen it by enough to pay for the move. Collective.
      \param fewest cells of a box along each axis that is cut [Dim]
      \return did they move? What hangs on the boxes must then follow
    */
    bool moveCuts( Decomposition<Dim>& decomposition, const Grid<Dim>& grid,
                   const Particles<Dim>& particles, const Indices<Dim>& fewest )
    {
        const auto loads = look( decomposition, particles );
        if ( loads.largest <= _threshold * loads.mean )
            return false;
        const auto chosen = chooseCuts<Dim>(
            grid.cells, decomposition.ranks(), fewest,
            [&]( const int axis, const Cuts<Dim>& cuts )
            {
                return countLoads<Dim>( decomposition.comm(), grid, particles,
                                        axis, cuts, _cell_cost );
            } );
        if ( chosen.heaviest > ( 1 - least_gain ) * loads.largest )
            return false;
        decomposition.setCuts( chosen.cuts );
        ++_seen.cuts_moved;
        return true;
    }

    //! What the looks have seen.
    const Imbalance& seen() const { return _seen; }

    //! Writes what was seen, or reads it.
    void checkpoint( Archive& archive )
    {
        const Archive::Group group( archive, "imbalance" );
        archive( "start", _seen.start );
        archive( "largest", _seen.largest );
        archive( "cuts_moved", _seen.cuts_moved );
    }

  private:
    //! A move takes about as long as a step: less gain would not pay for it.
    static constexpr double least_gain = 0.05;

    int _every;
    double _threshold;
    double _cell_cost;
    Imbalance _seen;
};

} // namespace Machpoint

#endif
