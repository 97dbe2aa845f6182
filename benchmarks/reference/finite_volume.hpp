/*!
  \file finite_volume.hpp
  \brief The scheme: MUSCL reconstruction of primitive values, HLLC fluxes,
  Heun's two stages, all axes at once.
*/
#ifndef MACHPOINT_REFERENCE_FINITE_VOLUME_HPP
#define MACHPOINT_REFERENCE_FINITE_VOLUME_HPP

#include "ghost_cells.hpp"

#include <core/report.hpp>
#include <core/scene.hpp>
#include <physics/modules.hpp>

#include <tuple>
#include <type_traits>

namespace Machpoint::Reference
{

//! Courant number, of the sum over the axes, whatever the scene's particles
//! take. Stable up to 1.
inline constexpr Real usual_courant_number = 0.4;

//! The initial state of a resolved entry of `initial`.
template <class... States>
std::unique_ptr<InitialState>
makeInitialState( const Json& json, const SceneFacts& facts,
                  std::type_identity<std::tuple<States...>> )
{
    std::unique_ptr<InitialState> state;
    const auto make = [&]<class State>( std::type_identity<State> )
    {
        if ( json.at( "type" ) != State::name )
            return;
        if constexpr ( std::is_constructible_v<State, const Json&,
                                               const SceneFacts&> )
            state = std::make_unique<State>( json, facts );
        else
            state = std::make_unique<State>( json );
    };
    ( make( std::type_identity<States>() ), ... );
    return state;
}

/*!
  \brief Does a shock pass by a cell's faces along an axis, rather than through
  them? That is, does the pressure of a neighbour along another axis differ by
  more than half?

  At such faces HLLC, like every scheme that resolves contacts, lets a strong
  shock along the grid grow dents ("carbuncles"); HLL does not (Quirk 1994).
*/
template <int Dim>
KOKKOS_INLINE_FUNCTION bool isShocked( const NodeView& w,
                                       const NodeLayout<Dim>& cells,
                                       const int row, const int axis )
{
    const auto i = cells.indices( row );
    if ( !cells.isOwned( i ) )
        return false;
    const Real p = w( row, Dim + 1 );
    for ( int d = 0; d < Dim; ++d )
        for ( int step = -1; step < 2; step += 2 )
        {
            auto neighbour = i;
            neighbour[d] += step;
            if ( d == axis || !cells.isOwned( neighbour ) )
                continue;
            const Real q = w( cells( neighbour ), Dim + 1 );
            if ( Kokkos::max( p, q ) > 1.5 * Kokkos::min( p, q ) )
                return true;
        }
    return false;
}

/*!
  \brief A scene on a grid of cells, in time.

  Cell means advance by d(U)/dt = -sum_a d(F_a)/dx_a + S with a cell's primitive
  values extrapolated to its faces by van Leer's limited slopes (van Leer 1979;
  Toro 2009, section 13.4 and, for the limiter, 13.8), HLLC fluxes (HLL
  beside shocks, see isShocked()), and Heun's method, the two-stage Runge-Kutta
  method that keeps a scheme's total variation (Shu and Osher 1988). Gravity is
  the source S = (0, rho g, rho u . g). The step is the Courant number over
  max sum_a (|u_a| + c) / h_a, the first five a fifth of that (Toro 2009,
  section 6.3.2).
*/
template <int Dim>
class FiniteVolume
{
  public:
    //! \param input resolved \param number_of_cells instead of the input's own
    //! \param courant_number in (0, 1]
    //! \throws InputError where a cell has no initial state
    FiniteVolume( const Json& input, const Indices<Dim>& number_of_cells,
                  const Real courant_number = usual_courant_number )
        : _courant_number( courant_number ),
          _grid( toVector<Dim>( input.at( "grid" ).at( "lower" ) ),
                 toVector<Dim>( input.at( "grid" ).at( "upper" ) ),
                 number_of_cells ),
          _cells( _grid, true, ghost_layers ), _solid( input, _cells ),
          _u( "Machpoint::referenceConserved", _cells.total, Dim + 2 ),
          _u_start( "Machpoint::referenceStart", _cells.total, Dim + 2 ),
          _w( "Machpoint::referencePrimitive", _cells.total, Dim + 2 ),
          _flux( "Machpoint::referenceFlux", _cells.total, Dim * ( Dim + 2 ) )
    {
        for ( const auto& entry : input.at( "physics" ) )
        {
            if ( entry.at( "type" ) == "ideal_gas" )
                _gamma = entry.at( "gamma" );
            if ( entry.at( "type" ) == "gravity" )
                _gravity = toVector<Dim>( entry.at( "acceleration" ) );
        }
        for ( int side = 0; side < 2 * Dim; ++side )
            _sides.push_back( makeSide<Dim>( input, _grid, _cells, side ) );
        setInitialState( input );
        updatePrimitive();
    }

    //! One time step, not beyond `until`. \throws NumericalFailure
    void step( const Real until )
    {
        const Real rate = fastestRate();
        if ( !( rate > 0 && std::isfinite( rate ) ) )
            throw NumericalFailure( fmt::format(
                "machpoint_reference: no time step at t = {:.6g}, step {}: the "
                "gas broke down",
                _time, _steps ) );
        const Real dt = _courant_number / rate * ( _steps < 5 ? 0.2 : 1.0 );
        const bool last = _time + dt >= until;
        Kokkos::deep_copy( _u_start, _u );
        for ( const Real share : { 0.0, 0.5 } )
        {
            updateFluxes();
            advance( last ? until - _time : dt, share );
            updatePrimitive();
        }
        _time = last ? until : _time + dt;
        ++_steps;
    }

    Real time() const { return _time; }
    std::int64_t steps() const { return _steps; }
    int cells() const { return wholeDomain( _grid ).totalCells(); }

    //! Fields at the cells' centres; all 0 in solids.
    GridData fields() const
    {
        const auto w =
            Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), _w );
        const auto is_gas = Kokkos::create_mirror_view_and_copy(
            Kokkos::HostSpace(), _solid.is_gas );
        GridData data;
        for ( int d = 0; d < Dim; ++d )
        {
            data.shape.insert( data.shape.begin(), _grid.cells[d] );
            data.lower.push_back( _cells.first[d] );
            data.spacing.push_back( _cells.spacing[d] );
        }
        for ( int row = 0; row < _cells.total; ++row )
        {
            if ( !_cells.isOwned( _cells.indices( row ) ) )
                continue;
            const Real gas = is_gas( row );
            const Real p = w( row, Dim + 1 );
            data.density.push_back( gas * w( row, 0 ) );
            data.pressure.push_back( gas * p );
            data.specific_internal_energy.push_back(
                gas * p / ( ( _gamma - 1 ) * w( row, 0 ) ) );
            for ( int d = 0; d < Dim; ++d )
                data.velocity.push_back( gas * w( row, 1 + d ) );
        }
        return data;
    }

    //! \name Kernels, public for nvcc's sake
    //! @{

    //! Primitive values of the gas and of all ghost cells.
    void updatePrimitive()
    {
        const auto u = _u;
        const auto w = _w;
        const auto is_gas = _solid.is_gas;
        const Real gamma = _gamma;
        Kokkos::parallel_for(
            "Machpoint::referencePrimitive", Range( 0, _cells.total ),
            KOKKOS_LAMBDA( const int row ) {
                if ( is_gas( row ) )
                    store<Dim>( w, row,
                                primitive<Dim>( load<Dim>( u, row ), gamma ) );
            } );
        _solid.fill( w );
        for ( int side = 0; side < 2 * Dim; ++side )
            fillSide<Dim>( _sides[side], _cells, side, w );
    }

    //! The largest sum_a (|u_a| + c) / h_a of all gas, 1/time.
    Real fastestRate() const
    {
        const auto w = _w;
        const auto is_gas = _solid.is_gas;
        const auto h = _grid.spacing;
        const Real gamma = _gamma;
        Real fastest = 0;
        Kokkos::parallel_reduce(
            "Machpoint::referenceTimeStep", Range( 0, _cells.total ),
            KOKKOS_LAMBDA( const int row, Real& max ) {
                if ( !is_gas( row ) )
                    return;
                const auto q = load<Dim>( w, row );
                const Real c = soundSpeed<Dim>( q, gamma );
                Real rate = 0;
                for ( int d = 0; d < Dim; ++d )
                    rate += ( Kokkos::abs( q[1 + d] ) + c ) / h[d];
                // A maximum passes NaN by, so let it be infinite.
                max = rate <= max  ? max
                      : rate > max ? rate
                                   : Kokkos::Experimental::infinity_v<Real>;
            },
            Kokkos::Max<Real>( fastest ) );
        return fastest;
    }

    //! The flux through the lower face of every cell, along every axis.
    void updateFluxes()
    {
        const auto w = _w;
        const auto flux = _flux;
        const auto cells = _cells;
        const Real gamma = _gamma;
        Kokkos::parallel_for(
            "Machpoint::referenceFlux", Range( 0, _cells.total ),
            KOKKOS_LAMBDA( const int row ) {
                const auto i = cells.indices( row );
                for ( int a = 0; a < Dim; ++a )
                {
                    // The upper side's faces are those of the next layer.
                    bool needed = true;
                    for ( int d = 0; d < Dim; ++d )
                        needed = needed && i[d] >= 0 &&
                                 i[d] < cells.owned[d] + ( d == a );
                    if ( !needed )
                        continue;
                    const int next = cells.stride[a];
                    const auto q0 = load<Dim>( w, row - 2 * next );
                    const auto q1 = load<Dim>( w, row - next );
                    const auto q2 = load<Dim>( w, row );
                    const auto q3 = load<Dim>( w, row + next );
                    const auto l = faceValues<Dim>( q0, q1, q2, 1 );
                    const auto r = faceValues<Dim>( q1, q2, q3, -1 );
                    const bool in_shock =
                        isShocked<Dim>( w, cells, row, a ) ||
                        isShocked<Dim>( w, cells, row - next, a );
                    store<Dim>( flux, row,
                                hllFlux<Dim>( l, r, a, gamma, !in_shock ),
                                a * ( Dim + 2 ) );
                }
            } );
    }

    //! One stage: U = share U_start + (1 - share) (U + dt dU/dt).
    void advance( const Real dt, const Real share )
    {
        const auto u = _u;
        const auto u_start = _u_start;
        const auto w = _w;
        const auto flux = _flux;
        const auto cells = _cells;
        const auto is_gas = _solid.is_gas;
        const auto g = _gravity;
        Kokkos::parallel_for(
            "Machpoint::referenceAdvance", Range( 0, _cells.total ),
            KOKKOS_LAMBDA( const int row ) {
                if ( !is_gas( row ) )
                    return;
                Values<Dim> rate{};
                for ( int a = 0; a < Dim; ++a )
                {
                    const int next = row + cells.stride[a];
                    for ( int k = 0; k < Dim + 2; ++k )
                    {
                        const int column = a * ( Dim + 2 ) + k;
                        rate[k] -=
                            ( flux( next, column ) - flux( row, column ) ) /
                            cells.spacing[a];
                    }
                    const Real force = w( row, 0 ) * g[a];
                    rate[1 + a] += force;
                    rate[Dim + 1] += force * w( row, 1 + a );
                }
                for ( int k = 0; k < Dim + 2; ++k )
                    u( row, k ) =
                        share * u_start( row, k ) +
                        ( 1 - share ) * ( u( row, k ) + dt * rate[k] );
            } );
    }

    //! @}

  private:
    //! The state at the cells' centres; later entries overwrite earlier ones.
    void setInitialState( const Json& input )
    {
        const auto u = Kokkos::create_mirror_view( _u );
        const auto w = Kokkos::create_mirror_view( _w );
        std::vector<GasState> gas( _cells.total, GasState{} );
        const SceneFacts facts{ Dim, input };
        for ( const auto& entry : input.at( "initial" ) )
        {
            const auto state = makeInitialState(
                entry, facts, std::type_identity<InitialStates>() );
            const bool everywhere = !entry.contains( "region" );
            Shape<Dim, Kokkos::HostSpace> region;
            if ( !everywhere )
                region =
                    makeShape<Dim, Kokkos::HostSpace>( entry.at( "region" ) );
            for ( int row = 0; row < _cells.total; ++row )
            {
                const auto x = _cells.position( _cells.indices( row ) );
                if ( !everywhere && region.distance( x ) >= 0 )
                    continue;
                Vector<3> place{};
                for ( int d = 0; d < Dim; ++d )
                    place[d] = x[d];
                Gradient gradient{};
                state->apply( place, gas[row], gradient );
            }
        }
        for ( int row = 0; row < _cells.total; ++row )
        {
            if ( gas[row].density > 0 )
            {
                const auto q = primitive<Dim>( gas[row] );
                store<Dim>( w, row, q );
                store<Dim>( u, row, conserved<Dim>( q, _gamma ) );
            }
            else if ( _cells.isOwned( _cells.indices( row ) ) )
                throw InputError( { "/initial: some cells lie in no region; "
                                    "this program knows no vacuum, so begin "
                                    "with an entry without region" } );
        }
        Kokkos::deep_copy( _u, u );
        Kokkos::deep_copy( _w, w );
    }

    Real _courant_number;
    Grid<Dim> _grid;
    NodeLayout<Dim> _cells; // rows of cells, ghost layers included
    Solid<Dim> _solid;
    std::vector<Side<Dim>> _sides;
    Real _gamma = 0;
    Vector<Dim> _gravity{};
    NodeView _u;       // conserved [rows][Dim + 2]
    NodeView _u_start; // at the start of the step
    NodeView _w;       // primitive
    NodeView _flux;    // through lower faces [rows][Dim * (Dim + 2)]
    Real _time = 0;
    std::int64_t _steps = 0;
};

} // namespace Machpoint::Reference

#endif
