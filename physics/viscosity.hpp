/*!
  \file viscosity.hpp
  \brief The viscous stress of a Newtonian gas (docs/diffusion.md).
*/
#ifndef MACHPOINT_VISCOSITY_HPP
#define MACHPOINT_VISCOSITY_HPP

#include <core/for_basis.hpp>
#include <core/module.hpp>
#include <physics/diffusion.hpp>

namespace Machpoint
{

/*!
  \brief tau = mu (L + L^T - 2/3 tr L I) + zeta tr L I, of the velocity gradient
  L_ab = d v_a / d x_b (Landau and Lifshitz 1987, eq. 15.3).
*/
struct NewtonianStress
{
    Real shear; //!< mu, mass length^(2-Dim)/time
    Real bulk;  //!< zeta, mass length^(2-Dim)/time

    //! tau_ab, pressure. \param L gradient [Dim][Dim], 1/time
    template <int Dim, class Number>
    KOKKOS_FORCEINLINE_FUNCTION Number
    component( const VectorOf<Dim, Number> ( &L )[Dim], const int a,
               const int b ) const
    {
        Number tau = shear * ( L[a][b] + L[b][a] );
        if ( a == b )
            for ( int d = 0; d < Dim; ++d )
                tau += ( bulk - 2 * shear / 3 ) * L[d][d];
        return tau;
    }

    //! tau : M, power/volume. \param L as above \param M another gradient
    template <int Dim, class Number>
    KOKKOS_FORCEINLINE_FUNCTION Number
    power( const VectorOf<Dim, Number> ( &L )[Dim],
           const VectorOf<Dim, Number> ( &M )[Dim] ) const
    {
        Number sum( 0.0 );
        for ( int a = 0; a < Dim; ++a )
            for ( int b = 0; b < Dim; ++b )
                sum += component<Dim>( L, a, b ) * M[a][b];
        return sum;
    }
};

namespace Impl
{

//! -V tau_ab d_b w in column Dim a + b.
template <int Dim>
struct StressTerms : ValueTerms<Dim * Dim>
{
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int axis( const int t )
    {
        return t % Dim;
    }
};

//! Gradients of v and of (v + v') / 2, 1/time.
template <int Dim, class Number>
struct VelocityGradients
{
    VectorOf<Dim, Number> start[Dim]{}; //!< L_ab = sum v_a d_b w
    VectorOf<Dim, Number> mean[Dim]{};  //!< the same of (v + v') / 2

    template <class Basis>
    KOKKOS_FORCEINLINE_FUNCTION
    VelocityGradients( const Stencil<Basis, Dim, Number>& s,
                       const NodeLayout<Dim>& layout,
                       const NodeView& velocities )
    {
        forEachNode( s, layout,
                     [&]( const auto& i ) MACHPOINT_INLINE
                     {
                         Number both[2 * Dim]; // v and v'
                         loadRow( velocities, i.row, both );
                         for ( int a = 0; a < Dim; ++a )
                             for ( int b = 0; b < Dim; ++b )
                             {
                                 start[a][b] += both[a] * i.gradient[b];
                                 mean[a][b] += 0.5_rt *
                                               ( both[a] + both[Dim + a] ) *
                                               i.gradient[b];
                             }
                     } );
    }
};

//! The terms of a particle. \param L of v
template <int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION Products<StressTerms<Dim>, Dim, Number>
stressTerms( const NewtonianStress& law, const Number& volume,
             const VectorOf<Dim, Number> ( &L )[Dim] )
{
    Products<StressTerms<Dim>, Dim, Number> terms;
    for ( int a = 0; a < Dim; ++a )
        for ( int b = 0; b < Dim; ++b )
            terms.value[Dim * a + b] = -volume * law.component<Dim>( L, a, b );
    return terms;
}

//! Adds -V tau_ab d_b w of the particles. \param sums the scatter of a field
//! [nodes][Dim Dim]
template <class Basis, int Dim, class Sums>
void depositStress( const State<Dim>& state, const NewtonianStress& law,
                    const Sums& sums )
{
    const auto V = state.particles.template slice<Volume>();
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        "Machpoint::viscousStress", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes ) MACHPOINT_INLINE {
            const VelocityGradients<Dim, Lanes> L( s, layout, velocities );
            return addProductsLater(
                nodes, p, s, layout, s.dw,
                stressTerms<Dim>( law, load( V, p ), L.start ) );
        } );
}

//! The same of mirror images, whose stress is R tau R.
template <class Basis, int Dim, class Sums>
void depositImageStress( const State<Dim>& state, const NewtonianStress& law,
                         const Sums& sums )
{
    const auto images = state.images;
    if ( images.count == 0 )
        return;
    const auto x = state.particles.template slice<Position>();
    const auto V = state.particles.template slice<Volume>();
    const auto velocities = state.nodes.velocities;
    const auto grid = state.grid;
    const auto layout = state.layout;
    forEach(
        "Machpoint::viscousStressOfImages", images.count,
        MACHPOINT_LAMBDA( const int k ) {
            const int p = images.particle( k );
            const auto mirror = images.mirror( k );
            const auto place = loadVector<Dim>( x, p );
            const Stencil<Basis, Dim> own( grid, layout, place );
            VelocityGradients<Dim, Real> L( own, layout, velocities );
            mirrorAffine<Dim>( mirror, L.start );
            const Stencil<Basis, Dim> s( grid, layout, mirror.point( place ) );
            addProducts( accessTo( sums.thread(), p, s, layout ), p, s, layout,
                         s.dw, stressTerms<Dim>( law, load( V, p ), L.start ) );
        },
        few_particles );
}

//! Adds dt f / m to v', f_a the sum of the columns of axis a.
//! \param stress [nodes][Dim Dim], folded
template <int Dim>
void pushByStress( const State<Dim>& state, const NodeView& stress )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const Real dt = state.dt;
    forEach(
        "Machpoint::viscousForce", state.layout.total,
        MACHPOINT_LAMBDA( const int i ) {
            const Real m = moments( i, 0 );
            for ( int a = 0; a < Dim; ++a )
            {
                Real force = 0;
                for ( int b = 0; b < Dim; ++b )
                    force += stress( i, Dim * a + b );
                velocities( i, Dim + a ) += perMass( dt * force, m );
            }
        } );
}

//! dt V tau : (L + L') / 2 over m, which is what the force takes from the
//! nodes' kinetic energy. \param[out] heat energy/mass [particles]
template <class Basis, int Dim, class Slice>
void findFrictionHeat( const State<Dim>& state, const NewtonianStress& law,
                       const Slice& heat )
{
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const Real dt = state.dt;
    forEachStencil<Basis>(
        "Machpoint::viscousHeat", state,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s )
            MACHPOINT_INLINE {
                const VelocityGradients<Dim, Lanes> L( s, layout, velocities );
                store( heat,
                       dt * law.power<Dim>( L.start, L.mean ) *
                           ( load( V, p ) / load( m, p ) ),
                       p );
            },
        velocities );
}

//! What the images' stress gives to the nodes of this rank, energy.
template <class Basis, int Dim>
ReproducibleSum workOfImageStress( const State<Dim>& state,
                                   const NewtonianStress& law )
{
    const auto images = state.images;
    const auto x = state.particles.template slice<Position>();
    const auto V = state.particles.template slice<Volume>();
    const auto velocities = state.nodes.velocities;
    const auto grid = state.grid;
    const auto layout = state.layout;
    const Real dt = state.dt;
    ReproducibleSum given;
    reduceEach(
        "Machpoint::workOfImageStress", images.count, few_stencils<Dim>,
        MACHPOINT_LAMBDA( const int k, ReproducibleSum& sum ) {
            const int p = images.particle( k );
            const auto mirror = images.mirror( k );
            const auto place = loadVector<Dim>( x, p );
            VelocityGradients<Dim, Real> L(
                Stencil<Basis, Dim>( grid, layout, place ), layout,
                velocities );
            mirrorAffine<Dim>( mirror, L.start );
            const VelocityGradients<Dim, Real> there(
                Stencil<Basis, Dim>( grid, layout, mirror.point( place ) ),
                layout, velocities );
            sum += -dt * load( V, p ) * law.power<Dim>( L.start, there.mean );
        },
        given );
    return given;
}

} // namespace Impl

/*!
  \brief Shear and bulk viscosity with constant coefficients.

  f_i = -sum V tau grad w on the nodes, tau of the gradient of v_i, and what it
  takes from the nodes' kinetic energy is the particles' heat, exactly. A
  no-slip side holds the gas by it; bodies and slip sides have no friction.
*/
template <int Dim>
class NewtonianViscosity : public Module<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "viscosity";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "shear and bulk viscosity of a Newtonian gas",
                      dimension );
        p.number( "shear", "mu, dynamic viscosity" )
            .unit( "mass*length^(2-Dim)/time" )
            .atLeast( 0 )
            .source( "Landau and Lifshitz 1987, eq. 15.3" );
        p.number( "bulk", "zeta, of expansion" )
            .unit( "mass*length^(2-Dim)/time" )
            .atLeast( 0 )
            .defaultsTo( 0 )
            .source( "Landau and Lifshitz 1987, eq. 15.3; 0: Stokes 1845" );
        return p;
    }

    static std::string remark( const Json* entry, const FlowFacts& flow )
    {
        return diffusionRemark( name, entry, flow );
    }

    explicit NewtonianViscosity( const Json& json )
        : _law{ json.at( "shear" ), json.at( "bulk" ) }
    {
    }
    //! @}

    void layOut( State<Dim>& state ) override
    {
        _stress = makeNodeSum( "Machpoint::viscousStress", state, Dim * Dim );
    }
    void initialize( State<Dim>& state ) override
    {
        _heat.make( state, "Machpoint::frictionHeat" );
    }

    Real limitTimeStep( State<Dim>& state ) override
    {
        return diffusiveTimeStep( state, 4 * _law.shear / 3 + _law.bulk );
    }

    void gridForce( State<Dim>& state ) override
    {
        fillVelocities( state );
        forBasis( state,
                  [&]( const auto basis )
                  {
                      using Basis = std::remove_cvref_t<decltype( basis )>;
                      _stress.deposit(
                          [&]( const auto& sums )
                          {
                              Impl::depositStress<Basis>( state, _law, sums );
                              Impl::depositImageStress<Basis>( state, _law,
                                                               sums );
                          } );
                  } );
        NodeComponents<Dim * Dim> components{};
        for ( int c = 0; c < Dim * Dim; ++c )
            components[c] = { Parity::velocity, c / Dim };
        _stress.fold( state.halo, components );
        Impl::pushByStress( state, _stress.field() );
    }

    void gridWork( State<Dim>& state ) override
    {
        fillVelocities( state );
        forBasis( state,
                  [&]( const auto basis )
                  {
                      using Basis = std::remove_cvref_t<decltype( basis )>;
                      Impl::findFrictionHeat<Basis>( state, _law,
                                                     _heat.slice() );
                      if ( state.images.count > 0 )
                          state.ledger.energy_in +=
                              Impl::workOfImageStress<Basis>( state, _law );
                  } );
    }

    bool particleSource( State<Dim>& state ) override
    {
        _heat.give( state );
        return false; // it has looked at what it changed
    }

  private:
    //! What particles read beyond sides.
    static void fillVelocities( const State<Dim>& state )
    {
        state.halo.fillSides( state.nodes.velocities,
                              vectorComponents<Dim, 2>( Parity::velocity ) );
    }

    NewtonianStress _law;
    NodeSum _stress; // [nodes][Dim Dim]
    HeatOfStep _heat;
};

} // namespace Machpoint

#endif
