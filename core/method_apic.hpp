/*!
  \file method_apic.hpp
  \brief `apic`: affine transfer (Jiang et al. 2015) with the centred energy
  update and the return of transfer losses as heat.
*/
#ifndef MACHPOINT_METHOD_APIC_HPP
#define MACHPOINT_METHOD_APIC_HPP

#include <core/method_defaults.hpp>
#include <core/power.hpp>

namespace Machpoint
{

namespace Impl
{
//! Largest volume of a particle, in cells. Where particles lose sight of each
//! other (strong rarefactions, wakes) the grid's divergence no longer tells
//! their distance and V would grow for ever; the pressure force of an ideal
//! gas is untouched, as it has V p = (gamma - 1) m e. Measured on Toro 2, 100
//! cells, L1(rho): 5.2e-2 with 2 cells, 2.9e-2 with 4, 3.9e-2 without a limit.
constexpr Real widest_volume = 4;

/*!
  \brief G2P of `apic` (docs/method.md, section 5).

  v' = sum w v'_i, C' = sum w v'_i (x_i - x)^T / (moment),
  V' = V exp(dt D), e' = e - dt p V D / m + loss, x' = x + dt v',
  D = sum grad w . (v_i + v'_i) / 2.

  The loss is the kinetic energy that the two transfers would destroy:
  sum w |u_p(x_i) - v_i|^2 / 2 on the way to the grid and the residual of the
  affine fit on the way back. Both are non-negative; returned as heat they make
  sum m (e + |v|^2/2 + moment |C|^2/2) exact.

  exp(dt D) is the volume of a cell that expands at the rate D
  for dt. The explicit 1 + dt D loses (dt D)^2 / 2 per step, which at a fixed
  Courant number adds up to a density 2.3 % too high behind a Mach 2 piston's
  shock on any grid (0.2 % with exp; examples/piston).
*/
template <class Basis, int Dim>
void gridToParticlesApic( const State<Dim>& state )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto next_x = state.particles.template next<Position>();
    const auto next_v = state.particles.template next<Velocity>();
    const auto next_C = state.particles.template next<VelocityGradient>();
    const auto next_V = state.particles.template next<Volume>();
    const auto next_e = state.particles.template next<SpecificInternalEnergy>();
    const auto note = watch( state );
    const auto velocities = state.nodes.velocities;
    const auto grid = state.grid;
    const auto layout = state.layout;
    const Real dt = state.dt;
    const Real widest = widest_volume * grid.cellVolume();
    forEachStencil<Basis>(
        "Machpoint::gridToParticles", state,
        MACHPOINT_LAMBDA(
            const Pack p,
            const Stencil<Basis, Dim, Lanes>& s ) MACHPOINT_INLINE {
            const auto old_x = loadVector<Dim>( x, p );
            const auto old_v = loadVector<Dim>( v, p );
            VectorOf<Dim, Lanes> old_C[Dim];
            loadMatrix<Dim>( C, p, old_C );
            // Sums relative to the old velocity: a uniform flow then has
            // zeros to add, not large numbers that cancel.
            VectorOf<Dim, Lanes> change{};   // sum w (v'_i - v)
            VectorOf<Dim, Lanes> fit[Dim]{}; // sum w (v'_i - v) (x_i - x)^T, or
                                             // sum (v'_i - v) grad w for hats
            // sum w (|v'_i - v|^2 + |v_i - u(x_i)|^2)
            Lanes squares( 0.0 );
            // sum grad w . (v_i - u(x_i) + v'_i - v): 2 D without what the
            // affine field u has of it, tr C
            Lanes diverging( 0.0 );
            forEachLine<Dim == 2>(
                s, layout,
                [&]( const auto& line ) MACHPOINT_INLINE
                {
                    auto u = old_v; // v + C (x_i - x), the first axis apart
                    for ( int a = 0; a < Dim; ++a )
                        for ( int b = 1; b < Dim; ++b )
                            u[a] += old_C[a][b] * line.dx[b];
                    // Sums along the line, its own weight still to come.
                    VectorOf<Dim, Lanes> steps{}, fits{}, lags{};
                    Lanes diverging_along( 0.0 );
                    Lanes all_squares( 0.0 );
                    for ( int i = 0; i < Basis::nodes; ++i )
                    {
                        Lanes both[2 * Dim]; // v and v'
                        loadRow( velocities, rowAt( s.base, line.shift + i ),
                                 both );
                        const Lanes& w = s.w[0][i];
                        const Lanes w_fit = fitWeight( s, 0, i );
                        Lanes squared( 0.0 );
                        for ( int a = 0; a < Dim; ++a )
                        {
                            const Lanes step = both[Dim + a] - old_v[a];
                            const Lanes lag =
                                both[a] - u[a] - old_C[a][0] * s.dx[0][i];
                            steps[a] += w * step;
                            fits[a] += w_fit * step;
                            if ( a == 0 )
                                diverging_along += s.dw[0][i] * ( lag + step );
                            else
                                lags[a] += w * lag;
                            squared += step * step + lag * lag;
                        }
                        all_squares += w * squared;
                    }
                    squares += line.weight * all_squares;
                    diverging += line.weight * diverging_along;
                    for ( int a = 0; a < Dim; ++a )
                    {
                        change[a] += line.weight * steps[a];
                        if ( a > 0 )
                            diverging +=
                                line.gradient[a] * ( lags[a] + steps[a] );
                        for ( int b = 0; b < Dim; ++b )
                            fit[a][b] +=
                                line.fit[b] * ( b == 0 ? fits[a] : steps[a] );
                    }
                } );
            Lanes D = 0.5_rt * diverging;
            for ( int a = 0; a < Dim; ++a )
                D += 0.5_rt * old_C[a][a];
            VectorOf<Dim, Lanes> new_x{}, new_v{};
            for ( int a = 0; a < Dim; ++a )
            {
                squares -= change[a] * change[a];
                new_v[a] = old_v[a] + change[a];
                new_x[a] = old_x[a] + dt * new_v[a];
                store( next_v, new_v[a], p, a );
                store( next_x, new_x[a], p, a );
            }
            const auto landed = landFit<Basis, Dim>( grid, s, fit, new_x );
            for ( int b = 0; b < Dim; ++b )
                for ( int a = 0; a < Dim; ++a )
                    store( next_C, landed.C[a][b], p, a, b );
            const Lanes lost =
                Kokkos::max( squares - landed.fitted, Lanes( 0.0 ) );
            const Lanes loss =
                0.5_rt * ( lost + landed.fitted - landed.carried );
            const Lanes old_V = load( V, p );
            const Lanes old_e = load( e, p );
            const Lanes work = load( pressure, p ) * old_V / load( m, p ) * D;
            const Lanes new_e = old_e + loss - dt * work;
            const Lanes new_V =
                Kokkos::min( Lanes( old_V * exponential( Lanes( dt * D ) ) ),
                             Lanes( widest ) );
            store( next_e, new_e, p );
            store( next_V, new_V, p );
            note( p, old_x, new_x, new_v, new_V, new_e, load( m, p ) );
        },
        velocities );
}
} // namespace Impl

//! The `apic` method: what differs between methods within a step.
struct Apic : MethodDefaults
{
    //! \name What method_defaults.hpp asks of every method
    //! @{
    static constexpr const char* name = "apic";
    static constexpr const char* summary =
        "affine particle-in-cell with centred, conservative energy update";
    static constexpr const char* default_basis = "quadratic";
    static constexpr bool affine = true;
    //! @}

    //! Node fields beyond those of State; none.
    template <int Dim>
    struct Storage
    {
        Storage( const State<Dim>&, const Json& ) {}
        void layOut( const State<Dim>& ) {}
    };

    //! Lines 2 to 4.
    template <class Basis, int Dim, class MakeImages>
    static void particlesToGrid( State<Dim>& state, Storage<Dim>&,
                                 const EquationOfState<Dim>&,
                                 const MakeImages& )
    {
        state.nodes.moment_sum.deposit(
            [&]( const auto& sums )
            { Machpoint::particlesToGrid<Basis, affine>( state, sums ); } );
    }

    //! Lines 6 to 10: everything from the new node velocities to the new
    //! particles, positions included. What applies boundaries to a node
    //! velocity is not asked, as `apic` has no second grid velocity.
    template <class Basis, int Dim, class Constrain>
    static void gridToParticles( State<Dim>& state, Storage<Dim>&,
                                 const Constrain& )
    {
        state.halo.fillSides( state.nodes.velocities,
                              velocityComponents<Dim>() );
        Impl::gridToParticlesApic<Basis, Dim>( state );
    }
};

} // namespace Machpoint

#endif
