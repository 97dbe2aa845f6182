/*!
  \file method_paper.hpp
  \brief `paper`: Algorithm 1 of Baioni, Benacchio, Capone and de Falco (2023),
  line by line: FLIP velocity update, second momentum P2G (MUSL), energy 9b,
  density 9c, move last.
*/
#ifndef MACHPOINT_METHOD_PAPER_HPP
#define MACHPOINT_METHOD_PAPER_HPP

#include <core/method_defaults.hpp>

namespace Machpoint
{

namespace Impl
{
//! Largest change of a volume in one step: V' = V max(1 + dt div v, this). A
//! particle cannot be turned inside out by one bad step.
constexpr Real min_volume_ratio = 0.1;

//! Line 6: v_p += sum w (v'_i - v_i), the FLIP update.
template <class Basis, int Dim>
void updateParticleVelocity( State<Dim>& state )
{
    const auto v = state.particles.template slice<Velocity>();
    const auto next_v = state.particles.template next<Velocity>();
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    forEachStencil<Basis>(
        "Machpoint::updateParticleVelocity", state,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s )
            MACHPOINT_INLINE {
                VectorOf<Dim, Lanes> change{};
                forEachNode( s, layout,
                             [&]( const auto& i ) MACHPOINT_INLINE
                             {
                                 for ( int d = 0; d < Dim; ++d )
                                     change[d] +=
                                         i.weight *
                                         ( at( velocities, i.row, Dim + d ) -
                                           at( velocities, i.row, d ) );
                             } );
                for ( int d = 0; d < Dim; ++d )
                    store( next_v, load( v, p, d ) + change[d], p, d );
            },
        velocities );
    state.particles.template reached<Velocity>();
}

//! Line 7: the momentum of the updated particles, (mv)_i = sum m w v.
//! \param sums the scatter of a field [nodes][Dim]
template <class Basis, int Dim, class Sums>
void momentumToGrid( const State<Dim>& state, const Sums& sums )
{
    const auto v = state.particles.template slice<Velocity>();
    const auto m = state.particles.template slice<Mass>();
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        "Machpoint::momentumToGrid", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes ) MACHPOINT_INLINE {
            const Lanes mass = load( m, p );
            Products<ValueTerms<Dim>, Dim, Lanes> momentum;
            for ( int d = 0; d < Dim; ++d )
                momentum.value[d] = mass * load( v, p, d );
            return addProductsLater( nodes, p, s, layout, s.w, momentum );
        } );
}

//! Line 8: momentum becomes velocity, in place. \param velocity [nodes][Dim]
template <int Dim>
void divideByMass( const State<Dim>& state, const NodeView& velocity )
{
    const auto moments = state.nodes.moments;
    forEach(
        "Machpoint::divideByMass", state.layout.total,
        MACHPOINT_LAMBDA( const int i ) {
            const Real m = moments( i, 0 );
            for ( int d = 0; d < Dim; ++d )
                velocity( i, d ) = perMass( velocity( i, d ), m );
        } );
}

//! Lines 9a (velocity gradient), 9b (energy), 9c (density) and 10 (move).
//! \param velocity the second grid velocity [nodes][Dim]
template <class Basis, int Dim>
void updateParticles( const State<Dim>& state, const NodeView& velocity )
{
    const auto x = state.particles.template slice<Position>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto new_v = state.particles.template slice<Velocity>();
    const auto next_x = state.particles.template next<Position>();
    const auto next_L = state.particles.template next<VelocityGradient>();
    const auto next_V = state.particles.template next<Volume>();
    const auto next_e = state.particles.template next<SpecificInternalEnergy>();
    const auto note = watch( state );
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const Real dt = state.dt;
    const Real least = min_volume_ratio;
    forEachStencil<Basis>(
        "Machpoint::updateParticles", state,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s )
            MACHPOINT_INLINE {
                const auto old_x = loadVector<Dim>( x, p );
                VectorOf<Dim, Lanes> gradient[Dim]{};
                VectorOf<Dim, Lanes> move{};
                forEachNode( s, layout,
                             [&]( const auto& i ) MACHPOINT_INLINE
                             {
                                 for ( int a = 0; a < Dim; ++a )
                                 {
                                     move[a] += i.weight * at( velocities,
                                                               i.row, Dim + a );
                                     const Lanes u = at( velocity, i.row, a );
                                     for ( int b = 0; b < Dim; ++b )
                                         gradient[a][b] += u * i.gradient[b];
                                 }
                             } );
                Lanes D( 0.0 );
                VectorOf<Dim, Lanes> new_x{};
                for ( int a = 0; a < Dim; ++a )
                {
                    D += gradient[a][a];
                    for ( int b = 0; b < Dim; ++b )
                        store( next_L, gradient[a][b], p, a, b ); // 9a
                    new_x[a] = old_x[a] + dt * move[a];           // 10
                    store( next_x, new_x[a], p, a );
                }
                const Lanes volume = load( V, p );
                const Lanes work =
                    load( pressure, p ) * volume / load( m, p ) * D;
                const Lanes new_e = load( e, p ) - dt * work; // 9b
                const Lanes new_V =
                    volume * Kokkos::max( 1 + dt * D, Lanes( least ) ); // 9c
                store( next_e, new_e, p );
                store( next_V, new_V, p );
                note( p, old_x, new_x, loadVector<Dim>( new_v, p ), new_V,
                      new_e, load( m, p ) );
            },
        velocities, velocity );
}
} // namespace Impl

//! The `paper` method: what differs between methods within a step.
struct Paper : MethodDefaults
{
    //! \name What method_defaults.hpp asks of every method
    //! @{
    static constexpr const char* name = "paper";
    static constexpr const char* summary =
        "Algorithm 1 of Baioni et al. (2023): FLIP, MUSL, energy 9b, "
        "density 9c";
    static constexpr const char* default_basis = "linear";
    static constexpr bool affine = false;
    //! @}
    //! 9b can take more energy than there is.
    static constexpr bool positive_energy = false;
    //! The paper has none, at Mach 3 either.
    static constexpr bool shocks_need_viscosity = false;

    //! The second grid velocity.
    template <int Dim>
    struct Storage
    {
        NodeSum velocity; //!< momentum, then velocity [nodes][Dim]
        Storage( const State<Dim>& state, const Json& ) { layOut( state ); }
        //! Allocates it for the nodes that there are now.
        void layOut( const State<Dim>& state )
        {
            velocity = makeNodeSum( "Machpoint::secondVelocity", state, Dim );
        }
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

    //! Lines 6 to 10. \param constrain applies boundaries (eq. 7) to a node
    //! velocity
    template <class Basis, int Dim, class Constrain>
    static void gridToParticles( State<Dim>& state, Storage<Dim>& second,
                                 const Constrain& constrain )
    {
        const auto components = vectorComponents<Dim, 1>( Parity::velocity );
        state.halo.fillSides( state.nodes.velocities,
                              velocityComponents<Dim>() );
        Impl::updateParticleVelocity<Basis, Dim>( state ); // 6
        second.velocity.deposit(
            [&]( const auto& sums )
            { Impl::momentumToGrid<Basis>( state, sums ); } ); // 7
        second.velocity.fold( state.halo, components );
        const auto& velocity = second.velocity.field();
        Impl::divideByMass<Dim>( state, velocity );      // 8
        constrain( GridVelocity{ velocity, 0, false } ); // eq. 7
        state.halo.fillSides( velocity, components );
        Impl::updateParticles<Basis, Dim>( state, velocity ); // 9, 10
    }
};

} // namespace Machpoint

#endif
