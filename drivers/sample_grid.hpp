/*!
  \file sample_grid.hpp
  \brief Layer 7: where `check` looks at the gas of a scene.
*/
#ifndef MACHPOINT_SAMPLE_GRID_HPP
#define MACHPOINT_SAMPLE_GRID_HPP

#include <core/exact.hpp>
#include <core/registry.hpp>
#include <core/scene.hpp>
#include <core/shape_input.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace Machpoint
{

//! The grid of an input, or a coarser one with at most 250000 cells.
template <int Dim>
class SampleGrid
{
  public:
    //! \param input resolved
    explicit SampleGrid( const Json& input )
        : _grid( coarse( makeGrid<Dim>( input ) ) )
    {
    }

    //! Its cells, with a sample at the centre of each.
    const Grid<Dim>& grid() const { return _grid; }

    //! Number of samples.
    int count() const
    {
        int count = 1;
        for ( int d = 0; d < Dim; ++d )
            count *= _grid.cells[d];
        return count;
    }

    //! The centre of a cell [Dim], length.
    Vector<Dim> center( const Indices<Dim>& i ) const
    {
        Vector<Dim> x{};
        for ( int d = 0; d < Dim; ++d )
            x[d] = _grid.lower[d] + ( i[d] + 0.5 ) * _grid.spacing[d];
        return x;
    }

    //! Calls f( indices, flat index ) for each sample, x fastest.
    template <class Function>
    void forEach( const Function& f ) const
    {
        for ( int flat = 0; flat < count(); ++flat )
        {
            Indices<Dim> i{};
            int rest = flat;
            for ( int d = 0; d < Dim; ++d )
            {
                i[d] = rest % _grid.cells[d];
                rest /= _grid.cells[d];
            }
            f( i, flat );
        }
    }

  private:
    static Grid<Dim> coarse( const Grid<Dim>& grid )
    {
        auto cells = grid.cells;
        const int most = static_cast<int>( std::pow( 250000, 1.0 / Dim ) );
        for ( int d = 0; d < Dim; ++d )
            cells[d] = std::min( cells[d], most );
        return Grid<Dim>( grid.lower, grid.upper, cells );
    }

    Grid<Dim> _grid;
};

//! A place, as messages tell it.
template <int Dim>
std::string placeText( const Vector<Dim>& x )
{
    std::vector<std::string> numbers;
    for ( int d = 0; d < Dim; ++d )
        numbers.push_back( fmt::format( "{:.3g}", x[d] ) );
    return fmt::format( "({})", fmt::join( numbers, ", " ) );
}

//! That of sound in a gas of this law, length/time.
inline double soundSpeed( const GasState& gas, const GasLaw& law )
{
    return std::sqrt( law.gamma * ( gas.pressure + law.pressure_offset ) /
                      gas.density );
}

//! What gas a boundary shows to the gas at a side of its own; that gas itself
//! where nobody knows, and where it leaves an open side faster than sound and
//! meets no cells that the boundary keeps in a state.
inline GasState gasBeyond( const Json& entry, const InputHooks& hooks,
                           const SideClaim& claim, const GasState& gas,
                           const GasLaw& law )
{
    const int axis = claim.side / 2;
    const double out = ( claim.side % 2 ? 1 : -1 ) * gas.velocity[axis];
    const bool is_felt = claim.kind != SideKind::open || hooks.imposedCells ||
                         !( out >= soundSpeed( gas, law ) );
    return hooks.beyond && is_felt ? hooks.beyond( entry, claim.side, gas )
                                   : gas;
}

//! The same of whatever boundary is at a place. \param input resolved
//! \param x on the side [Dim]
template <int Dim>
GasState gasBeyond( const Json& input, const int side, const Vector<Dim>& x,
                    const GasState& gas, const GasLaw& law )
{
    for ( const auto& entry : input.at( "boundary" ) )
    {
        const auto sides = sidesOf( entry, Dim );
        const auto claim = std::find_if( sides.begin(), sides.end(),
                                         [side]( const SideClaim& any )
                                         { return any.side == side; } );
        const bool is_here =
            claim != sides.end() &&
            ( !entry.contains( "region" ) ||
              makeShape<Dim, Kokkos::HostSpace>( entry.at( "region" ) )
                      .distance( x ) < 0 );
        if ( is_here )
            return gasBeyond( entry, boundaryHooks( entry, Dim ), *claim, gas,
                              law );
    }
    return gas;
}

} // namespace Machpoint

#endif
