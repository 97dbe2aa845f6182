/*!
  \file mixing.hpp
  \brief Parts of `conservative` that exchange volume or heat between the
  particles of a cell (docs/conservative.md, section 8).
*/
#ifndef MACHPOINT_CONSERVATIVE_MIXING_HPP
#define MACHPOINT_CONSERVATIVE_MIXING_HPP

#include <core/conservative/faces.hpp>

namespace Machpoint
{
namespace Impl
{

//! A field on cells: staggered along every axis.
template <int Dim, std::size_t N>
NodeComponents<N> cellComponents()
{
    NodeComponents<N> list{};
    for ( auto& component : list )
        component.staggered = ( 1 << Dim ) - 1;
    return list;
}

//! Pressure and its gradient as the cells around a particle see them.
template <class Basis, int Dim>
struct CellPressure
{
    Real stiffness = 0;     //!< rho c^2, mean of the cells
    Vector<Dim> gradient{}; //!< limited, pressure/length
    Real trust = 1;         //!< 1, less where the limit cuts steep slopes

    KOKKOS_FORCEINLINE_FUNCTION
    CellPressure( const Grid<Dim>& grid, const NodeLayout<Dim>& layout,
                  const Stencil<Basis, Dim>& s,
                  const HalfwayWeights<Basis, Dim>& halfway,
                  const NodeView& means, const Real own )
    {
        Real least = own;
        constexpr int places = Basis::nodes - 1;
        forEachCell( grid, s, halfway, layout,
                     [&]( const auto& cell )
                     {
                         const Real p = means( cell.row, 1 );
                         stiffness += cell.weight * means( cell.row, 2 );
                         least = Kokkos::min( least, p );
                     } );
        // Derivative of the cells' interpolant, axis by axis.
        for ( int k = 0; k < ( Dim > 2 ? places : 1 ); ++k )
            for ( int j = 0; j < ( Dim > 1 ? places : 1 ); ++j )
                for ( int i = 0; i < places; ++i )
                {
                    const int at[3] = { i, j, k };
                    int row = s.base;
                    for ( int d = 0; d < Dim; ++d )
                        row += at[d] * layout.stride[d];
                    for ( int a = 0; a < Dim; ++a )
                    {
                        Real slope = halfway.dc[a][at[a]] / grid.spacing[a];
                        for ( int d = 0; d < Dim; ++d )
                            if ( d != a )
                                slope *= halfway.c[d][at[d]];
                        gradient[a] += slope * means( row, 1 );
                    }
                }
        // Without the limit, steep pressures run away.
        least = Kokkos::max( least, 0.0 ) / ( 2 * Dim );
        for ( int a = 0; a < Dim; ++a )
        {
            const Real limit = least / grid.spacing[a];
            const Real steep = Kokkos::abs( gradient[a] );
            if ( steep > 3 * limit )
                trust = Kokkos::min( trust, 3 * limit / steep );
            gradient[a] = Kokkos::clamp( gradient[a], -limit, limit );
        }
    }
};

//! Adds V, V p and m c^2 of the particles to their cells.
//! \param sums the scatter of a field on cells [nodes][3]
template <class Basis, int Dim, class Sums>
void depositCellPressure( const State<Dim>& state, const Sums& sums )
{
    const auto x = state.particles.template slice<Position>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    Kokkos::parallel_for(
        "Machpoint::cellPressure", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            const auto cells = sums.access();
            const Stencil<Basis, Dim> s( grid, layout, get<Dim>( x, p ) );
            const HalfwayWeights<Basis, Dim> halfway( grid, s );
            forEachCell( grid, s, halfway, layout,
                         [&]( const auto& cell )
                         {
                             const Real w = cell.weight;
                             cells( cell.row, 0 ) += w * V( p );
                             cells( cell.row, 1 ) += w * V( p ) * pressure( p );
                             cells( cell.row, 2 ) +=
                                 w * m( p ) * c( p ) * c( p );
                         } );
        } );
}

//! Adds K and K (p + g dx) of the particles to their cells.
//! \param means of the cells \param sums the scatter of a field [nodes][2]
template <class Basis, int Dim, class Sums>
void depositTargetPressure( const State<Dim>& state, const NodeView& means,
                            const Real eta, const Sums& sums )
{
    const auto x = state.particles.template slice<Position>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    Kokkos::parallel_for(
        "Machpoint::targetPressure", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            const auto cells = sums.access();
            const Stencil<Basis, Dim> s( grid, layout, get<Dim>( x, p ) );
            const HalfwayWeights<Basis, Dim> halfway( grid, s );
            const CellPressure<Basis, Dim> around( grid, layout, s, halfway,
                                                   means, pressure( p ) );
            const Real stiffness =
                m( p ) / V( p ) * c( p ) * c( p ) + around.stiffness;
            const Real rate = eta * around.trust * around.trust;
            const Real K = stiffness > 0 ? rate * V( p ) / stiffness : 0.0;
            forEachCell( grid, s, halfway, layout,
                         [&]( const auto& cell )
                         {
                             const Real target =
                                 pressure( p ) +
                                 dot<Dim>( around.gradient, cell.dx );
                             cells( cell.row, 0 ) += K * cell.weight;
                             cells( cell.row, 1 ) += K * cell.weight * target;
                         } );
        } );
}

/*!
  \brief Sub-cell pressure relaxation (after Tipton, in Shashkov 2008).

  Particles of a cell exchange volume until their pressures agree, at the rate
  eta: K = eta trust^2 V / (rho c^2 + rho c^2 of the cells),
  phat_c = sum K w (p + g dx) / sum K w, s = K w (p + g dx - phat_c),
  V += sum s, e -= sum phat_c s / m. Conserves volume and energy, and removes
  the pressures that the faces cannot see.
  \param cell_means [nodes][3] scratch
  \param cell_sums [nodes][2] scratch
*/
template <class Basis, int Dim>
void relaxPressure( const State<Dim>& state, NodeSum& cell_means,
                    NodeSum& cell_sums, const Real eta )
{
    const auto x = state.particles.template slice<Position>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto means = cell_means.field();
    const auto sums = cell_sums.field();

    cell_means.deposit( [&]( const auto& cells )
                        { depositCellPressure<Basis>( state, cells ); } );
    cell_means.fold( state.halo, cellComponents<Dim, 3>() );
    Kokkos::parallel_for(
        "Machpoint::meanCellPressure", Range( 0, layout.total ),
        KOKKOS_LAMBDA( const int i ) {
            const Real volume = means( i, 0 );
            for ( int k = 1; k < 3; ++k )
                means( i, k ) = volume > 0 ? means( i, k ) / volume : 0.0;
        } );
    state.halo.fill( means, cellComponents<Dim, 3>() );

    cell_sums.deposit(
        [&]( const auto& cells )
        { depositTargetPressure<Basis>( state, means, eta, cells ); } );
    cell_sums.fold( state.halo, cellComponents<Dim, 2>() );
    state.halo.fill( sums, cellComponents<Dim, 2>() );

    Kokkos::parallel_for(
        "Machpoint::exchangeVolume", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            const Stencil<Basis, Dim> s( grid, layout, get<Dim>( x, p ) );
            const HalfwayWeights<Basis, Dim> halfway( grid, s );
            const CellPressure<Basis, Dim> around( grid, layout, s, halfway,
                                                   means, pressure( p ) );
            const Real stiffness =
                m( p ) / V( p ) * c( p ) * c( p ) + around.stiffness;
            const Real rate = eta * around.trust * around.trust;
            const Real K = stiffness > 0 ? rate * V( p ) / stiffness : 0.0;
            Real volume = 0;
            Real work = 0;
            forEachCell( grid, s, halfway, layout,
                         [&]( const auto& cell )
                         {
                             const Real weight = sums( cell.row, 0 );
                             if ( weight <= 0 )
                                 return;
                             const Real target = sums( cell.row, 1 ) / weight;
                             const Real given =
                                 K * cell.weight *
                                 ( pressure( p ) +
                                   dot<Dim>( around.gradient, cell.dx ) -
                                   target );
                             volume += given;
                             work += target * given;
                         } );
            V( p ) += volume;
            e( p ) -= work / m( p );
        } );
}

//! Part of its heat that particle p exchanges. Parts that no sum would feel are
//! none: they could underflow.
template <class Rate>
struct HeatShare
{
    Rate divergence, limiter;
    Real rate; //!< ck dt

    KOKKOS_INLINE_FUNCTION Real operator()( const int p ) const
    {
        const Real part =
            limiter( p ) *
            Kokkos::min( 1.0, rate * Kokkos::max( -divergence( p ), 0.0 ) );
        return part > 1e-12 ? part : 0.0;
    }
};

//! Adds m eta and m eta e of the particles.
//! \param share eta \param sums the scatter of a field [nodes][2]
template <class Basis, int Dim, class Share, class Sums>
void depositHeat( const State<Dim>& state, const Share& share,
                  const Sums& sums )
{
    const auto x = state.particles.template slice<Position>();
    const auto m = state.particles.template slice<Mass>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    Kokkos::parallel_for(
        "Machpoint::sharedHeat", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            const Real mass = m( p ) * share( p );
            if ( mass <= 0 )
                return;
            const auto nodes = sums.access();
            const Stencil<Basis, Dim> s( grid, layout, get<Dim>( x, p ) );
            forEachNode( s, layout,
                         [&]( const auto& i )
                         {
                             const Real mw = mass * i.weight;
                             nodes( i.row, 0 ) += mw;
                             nodes( i.row, 1 ) += mw * e( p );
                         } );
        } );
}

/*!
  \brief Shock heat mixing: e += eta (sum w e_i - e) with eta =
  min(1, ck dt max(-D, 0)) phi and e_i = sum m eta w e / sum m eta w.
  Conserves energy; spreads the heat that a shock or a wall leaves in too few
  particles (after the heat flux of Noh 1987).
  \param heat [nodes][2] scratch
*/
template <class Basis, int Dim>
void mixHeat( const State<Dim>& state, NodeSum& heat, const Real ck )
{
    const auto x = state.particles.template slice<Position>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto divergence = Cabana::slice<Divergence>( state.rates->data() );
    const auto limiter = Cabana::slice<Limiter>( state.rates->data() );
    const auto grid = state.grid;
    const auto layout = state.layout;
    const Real rate = ck * state.dt;
    const auto sums = heat.field();
    const NodeComponents<2> components{};

    const HeatShare share{ divergence, limiter, rate };
    heat.deposit( [&]( const auto& nodes )
                  { depositHeat<Basis>( state, share, nodes ); } );
    heat.fold( state.halo, components );
    state.halo.fill( sums, components );
    Kokkos::parallel_for(
        "Machpoint::mixHeat", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            const Real part = share( p );
            if ( part <= 0 )
                return;
            const Stencil<Basis, Dim> s( grid, layout, get<Dim>( x, p ) );
            Real change = 0;
            forEachNode( s, layout,
                         [&]( const auto& i )
                         {
                             const Real mass = sums( i.row, 0 );
                             if ( mass > 0 )
                                 change += i.weight *
                                           ( sums( i.row, 1 ) / mass - e( p ) );
                         } );
            e( p ) += part * change;
        } );
}

} // namespace Impl
} // namespace Machpoint

#endif
