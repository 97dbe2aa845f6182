/*!
  \file mixing.hpp
  \brief Parts of `conservative` that exchange volume or heat between the
  particles of a cell (docs/conservative.md, section 8).
*/
#ifndef MACHPOINT_CONSERVATIVE_MIXING_HPP
#define MACHPOINT_CONSERVATIVE_MIXING_HPP

#include <core/conservative/faces.hpp>
#include <core/soundness.hpp>

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

//! Pressure and its gradient as the cells around particles see them.
template <class Basis, int Dim>
struct CellPressure
{
    Lanes pressure{ 0.0 };           //!< mean of the cells
    VectorOf<Dim, Lanes> gradient{}; //!< limited, pressure/length
    Lanes trust{ 1.0 };              //!< 1, less where the limit cuts steep
                                     //!< slopes

    //! \param own pressure of the particles \param reference p_inf of a
    //! stiffened gas
    KOKKOS_FORCEINLINE_FUNCTION
    CellPressure( const Grid<Dim>& grid, const NodeLayout<Dim>& layout,
                  const Stencil<Basis, Dim, Lanes>& s,
                  const HalfwayWeights<Basis, Dim, Lanes>& halfway,
                  const NodeView& means, const Lanes& own,
                  const Real reference )
    {
        Lanes least = own;
        constexpr int places = Basis::nodes - 1;
        for ( int k = 0; k < ( Dim > 2 ? places : 1 ); ++k )
            for ( int j = 0; j < ( Dim > 1 ? places : 1 ); ++j )
                for ( int i = 0; i < places; ++i )
                {
                    const int place[3] = { i, j, k };
                    int row = 0;
                    Lanes weight( 1.0 );
                    for ( int d = 0; d < Dim; ++d )
                    {
                        row += place[d] * layout.stride[d];
                        weight *= halfway.c[d][place[d]];
                    }
                    Lanes mean[2]; // of volume and pressure
                    loadRow( means, rowAt( s.base, row ), mean );
                    const Lanes& p = mean[1];
                    pressure += weight * p;
                    least = Kokkos::min( least, p );
                    // Derivative of the cells' interpolant, axis by axis.
                    for ( int a = 0; a < Dim; ++a )
                    {
                        Lanes slope = halfway.dc[a][place[a]] * grid.inverse[a];
                        for ( int d = 0; d < Dim; ++d )
                            if ( d != a )
                                slope *= halfway.c[d][place[d]];
                        gradient[a] += slope * p;
                    }
                }
        // Without the limit, steep pressures run away.
        least =
            Kokkos::max( least + reference, Lanes( 0.0 ) ) * ( 0.5_rt / Dim );
        for ( int a = 0; a < Dim; ++a )
        {
            const Lanes limit = least * grid.inverse[a];
            const Lanes steep = Kokkos::abs( gradient[a] );
            const auto is_cut = 3 * limit < steep;
            if ( any( is_cut ) ) // seldom
                trust = choose(
                    is_cut,
                    Lanes( Kokkos::min( trust, Lanes( 3 * limit / steep ) ) ),
                    trust );
            gradient[a] = clip( gradient[a], Lanes( -limit ), limit );
        }
    }
};

//! What particles bring to the exchange of volume.
template <class Basis, int Dim>
struct VolumeExchange
{
    HalfwayWeights<Basis, Dim, Lanes> halfway;
    CellPressure<Basis, Dim> around;
    Lanes pressure;
    Lanes K; //!< eta trust^2 V / (rho c^2 + that of the cells)

    //! \param particles slices \param response of their gas
    //! \param means of the cells
    template <class Slices>
    KOKKOS_FORCEINLINE_FUNCTION
    VolumeExchange( const Slices& particles, const PressureResponse& response,
                    const Grid<Dim>& grid, const NodeLayout<Dim>& layout,
                    const Stencil<Basis, Dim, Lanes>& stencil,
                    const NodeView& means, const Real eta, const Pack p )
        : halfway( grid, stencil ),
          around( grid, layout, stencil, halfway, means,
                  load( particles.pressure, p ), response.reference ),
          pressure( load( particles.pressure, p ) )
    {
        const Lanes V = load( particles.V, p );
        const Lanes zero( 0.0 );
        const Lanes stiffness =
            response.exponent *
            ( Kokkos::max( pressure + response.reference, zero ) +
              Kokkos::max( around.pressure + response.reference, zero ) );
        const Lanes rate = eta * around.trust * around.trust;
        K = choose( zero < stiffness, Lanes( rate * ( V / stiffness ) ), zero );
    }
};

//! The slices that the exchange of volume reads.
template <class Positions, class Volumes, class Scalars>
struct ExchangeSlices
{
    Positions x;
    Volumes V;
    Scalars pressure;
};
template <int Dim>
auto exchangeSlices( const State<Dim>& state )
{
    const auto& particles = state.particles;
    return ExchangeSlices{ particles.template slice<Position>(),
                           particles.template slice<Volume>(),
                           particles.template slice<Pressure>() };
}

//! A stencil's cells: halfway between its nodes, and none behind the last.
template <class Basis, int Dim>
KOKKOS_FORCEINLINE_FUNCTION Stencil<Basis, Dim, Lanes>
onCells( const Grid<Dim>& grid, const Stencil<Basis, Dim, Lanes>& s )
{
    Stencil<Basis, Dim, Lanes> cells = s;
    const FaceWeights<Basis, Dim, Lanes> halfway( grid, s );
    for ( int d = 0; d < Dim; ++d )
        for ( int i = 0; i < Basis::nodes; ++i )
        {
            cells.w[d][i] = halfway.w[d][i];
            cells.dx[d][i] += 0.5_rt * grid.spacing[d];
        }
    return cells;
}

//! Adds V and V p of the particles to their cells.
//! \param sums the scatter of a field on cells [nodes][2]
template <class Basis, int Dim, class Sums>
void depositCellPressure( const State<Dim>& state, const Sums& sums )
{
    const auto of = exchangeSlices( state );
    const auto grid = state.grid;
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        "Machpoint::cellPressure", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& cells ) MACHPOINT_INLINE {
            Products<ValueTerms<2>, Dim, Lanes> terms;
            terms.value[0] = load( of.V, p );
            terms.value[1] = terms.value[0] * load( of.pressure, p );
            return addProductsLater( cells, p, onCells( grid, s ), layout, s.w,
                                     terms );
        } );
}

//! K, and K (p + g dx).
struct TargetTerms : ValueTerms<2>
{
    KOKKOS_FORCEINLINE_FUNCTION static constexpr bool isAffine( const int t )
    {
        return t == 1;
    }
};

//! Adds K and K (p + g dx) of the particles to their cells.
//! \param response of the gas \param means of the cells
//! \param sums the scatter of a field [nodes][2]
template <class Basis, int Dim, class Sums>
void depositTargetPressure( const State<Dim>& state,
                            const PressureResponse& response,
                            const NodeView& means, const Real eta,
                            const Sums& sums )
{
    const auto of = exchangeSlices( state );
    const auto grid = state.grid;
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        "Machpoint::targetPressure", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& cells ) MACHPOINT_INLINE {
            const VolumeExchange<Basis, Dim> own( of, response, grid, layout, s,
                                                  means, eta, p );
            Products<TargetTerms, Dim, Lanes> terms;
            terms.value[0] = own.K;
            terms.value[1] = own.K * own.pressure;
            for ( int d = 0; d < Dim; ++d )
                terms.slope[1][d] = own.K * own.around.gradient[d];
            return addProductsLater( cells, p, onCells( grid, s ), layout, s.w,
                                     terms );
        } );
}

/*!
  \brief Sub-cell pressure relaxation (after Tipton, in Shashkov 2008).

  Particles of a cell exchange volume until their pressures agree, at the rate
  eta: K = eta trust^2 V / (g (p + p_inf) + g (p + p_inf) of the cells),
  phat_c = sum K w (p + g dx) / sum K w, s = K w (p + g dx - phat_c),
  V += sum s, e -= sum phat_c s / m. Conserves volume and energy, and removes
  the pressures that the faces cannot see.
  \param response of the gas: g and p_inf, where g (p + p_inf) is rho c^2
  \param cell_means [nodes][2] scratch
  \param cell_sums [nodes][>= 2] scratch
*/
template <class Basis, int Dim>
void relaxPressure( const State<Dim>& state, const PressureResponse& response,
                    NodeSum& cell_means, NodeSum& cell_sums, const Real eta )
{
    const auto of = exchangeSlices( state );
    const auto m = state.particles.template slice<Mass>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto means = cell_means.field();
    const auto sums = cell_sums.field();
    const auto note = watch( state );

    cell_means.deposit( [&]( const auto& cells )
                        { depositCellPressure<Basis>( state, cells ); } );
    cell_means.foldAndFill( state.halo, cellComponents<Dim, 2>() );
    divideByFirst<2>( "Machpoint::meanCellPressure", means );

    cell_sums.deposit(
        [&]( const auto& cells ) {
            depositTargetPressure<Basis>( state, response, means, eta, cells );
        } );
    cell_sums.foldAndFill( state.halo, cellComponents<Dim, 2>() );
    divideByFirst<2>( "Machpoint::cellTargetPressure", sums );

    forEachStencil<Basis>(
        "Machpoint::exchangeVolume", state,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s )
            MACHPOINT_INLINE {
                const VolumeExchange<Basis, Dim> own(
                    of, response, grid, layout, s, means, eta, p );
                const Lanes zero( 0.0 );
                Lanes volume = zero;
                Lanes work = zero;
                forEachCell(
                    grid, s, own.halfway, layout,
                    [&]( const auto& cell ) MACHPOINT_INLINE
                    {
                        const Lanes target = at( sums, cell.row, 1 );
                        const Lanes given =
                            own.K * cell.weight *
                            ( own.pressure +
                              dot<Dim>( own.around.gradient, cell.dx ) -
                              target );
                        volume += given;
                        work += target * given;
                    } );
                volume += load( of.V, p );
                store( of.V, volume, p );
                note.lookAtVolume( p, volume );
                store( e, load( e, p ) - work / load( m, p ), p );
            } );
}

/*!
  \brief Part of its heat that a particle exchanges: phi min(1, ck dt
  max(-D, 0)) of the flow as the last step left it. A part that no sum would
  feel is none, as it could underflow.
*/
template <class Slice>
struct MixedHeat
{
    Real strength; //!< ck dt of the last step
    Slice divergence, limiter;

    KOKKOS_FORCEINLINE_FUNCTION Lanes of( const Pack p ) const
    {
        const Lanes zero( 0.0 );
        const Lanes closing =
            strength * Kokkos::max( Lanes( -load( divergence, p ) ), zero );
        const Lanes part =
            load( limiter, p ) * Kokkos::min( closing, Lanes( 1.0 ) );
        return choose( active( p ) && Lanes( 1e-12 ) < part, part, zero );
    }
};

//! Adds m eta and m eta e of the particles, e without what a stiffened gas has
//! of its reference pressure.
//! \param sums the scatter of a field [nodes][2]
template <class Basis, int Dim, class Share, class Sums>
void depositHeat( const State<Dim>& state, const Share& share,
                  const Sums& sums )
{
    const Real reference = state.reference_pressure;
    const auto x = state.particles.template slice<Position>();
    const auto V = state.particles.template slice<Volume>();
    const auto m = state.particles.template slice<Mass>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    const int n = state.particles.size();
    forEachPack(
        "Machpoint::sharedHeat", n,
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            const Lanes zero( 0.0 );
            const Lanes part = share.of( p );
            if ( !any( zero < part ) )
                return;
            const Stencil<Basis, Dim, Lanes> s( grid, layout,
                                                loadVector<Dim>( x, p ) );
            Products<ValueTerms<2>, Dim, Lanes> terms;
            const Lanes mass = load( m, p );
            terms.value[0] = mass * part;
            terms.value[1] =
                terms.value[0] *
                heatOf( load( e, p ), load( V, p ), mass, reference );
            addProducts( accessTo( sums.thread(), p, s, layout ), p, s, layout,
                         s.w, terms );
        },
        few_stencils<Dim> );
}

/*!
  \brief Exchange of heat: e += eta (sum w e_i - e) with e_i = sum m eta w e /
  sum m eta w and eta the particles' MixedHeat. Conserves energy; spreads the
  heat that a shock or a wall leaves in too few particles (after the heat flux
  of Noh 1987). e is heat, e - p_inf / rho, of a stiffened gas.
  \param strength ck \param heat [nodes][>= 2] scratch
*/
template <class Basis, int Dim>
void mixHeat( const State<Dim>& state, const Real strength, NodeSum& heat )
{
    const Real reference = state.reference_pressure;
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto divergence = sliceOfFlow<Divergence>( state );
    const MixedHeat<decltype( divergence )> share{
        strength * static_cast<Real>( state.dt ), divergence,
        sliceOfFlow<Limiter>( state ) };
    const auto x = state.particles.template slice<Position>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto sums = heat.field();
    const NodeComponents<2> components{};

    heat.deposit( [&]( const auto& nodes )
                  { depositHeat<Basis>( state, share, nodes ); } );
    heat.foldAndFill( state.halo, components );
    const int n = state.particles.size();
    forEachPack(
        "Machpoint::mixHeat", n,
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            const Lanes zero( 0.0 );
            const Lanes part = share.of( p );
            if ( !any( zero < part ) )
                return;
            const Stencil<Basis, Dim, Lanes> s( grid, layout,
                                                loadVector<Dim>( x, p ) );
            const Lanes energy = load( e, p );
            const Lanes own =
                heatOf( energy, load( V, p ), load( m, p ), reference );
            Lanes change = zero;
            forEachNode( s, layout,
                         [&]( const auto& i ) MACHPOINT_INLINE
                         {
                             const Lanes mass = at( sums, i.row, 0 );
                             const Lanes mean = at( sums, i.row, 1 ) / mass;
                             change += choose(
                                 zero < mass,
                                 Lanes( i.weight * ( mean - own ) ), zero );
                         } );
            store( e, choose( zero < part, energy + part * change, energy ),
                   p );
        },
        few_stencils<Dim> );
}

} // namespace Impl
} // namespace Machpoint

#endif
