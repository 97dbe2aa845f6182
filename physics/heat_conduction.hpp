/*!
  \file heat_conduction.hpp
  \brief Heat flux along the gradient of the temperature (docs/diffusion.md).
*/
#ifndef MACHPOINT_HEAT_CONDUCTION_HPP
#define MACHPOINT_HEAT_CONDUCTION_HPP

#include <core/for_basis.hpp>
#include <core/module.hpp>
#include <core/pair_exchange.hpp>
#include <physics/diffusion.hpp>

namespace Machpoint
{

namespace Impl
{

//! V q_d d_d w in column d; then m eta w and m eta e w.
template <int Dim>
struct FluxTerms : ValueTerms<Dim + 2>
{
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int axis( const int t )
    {
        return t < Dim ? t : -1;
    }
};

/*!
  \brief eta, the part of its difference from the nodes that a particle
  exchanges in a step: where its e is beyond theirs, the part that conducts away
  over a cell, k dt / rho sum_d h_d^-2; 0 elsewhere (docs/diffusion.md).
*/
struct Straggler
{
    Lanes own; //!< e
    Lanes least{ Kokkos::Experimental::infinity_v<Real> };
    Lanes most{ -Kokkos::Experimental::infinity_v<Real> };

    //! A node of its stencil has this e.
    KOKKOS_FORCEINLINE_FUNCTION void look( const Lanes& heat )
    {
        least = Kokkos::min( least, heat );
        most = Kokkos::max( most, heat );
    }
    //! \param conducted k dt sum_d h_d^-2, mass/volume
    KOKKOS_FORCEINLINE_FUNCTION Lanes share( const Real conducted,
                                             const Lanes& V,
                                             const Lanes& m ) const
    {
        const Lanes margin = round_off * Kokkos::abs( own );
        return choose( own + margin < least || most + margin < own,
                       Kokkos::min( Lanes( conducted * V / m ), Lanes( 1.0 ) ),
                       Lanes( 0.0 ) );
    }
};

//! Adds V q_d d_d w of the particles, q = -k grad e of the nodes, and what
//! stragglers exchange. \param conducted k dt sum_d h_d^-2, mass/volume
//! \param means m and e [nodes][2] \param sums the scatter of a field
//! [nodes][Dim + 2]
template <class Basis, int Dim, class Sums>
void depositHeatFlux( const State<Dim>& state, const Real conductivity,
                      const Real conducted, const NodeView& means,
                      const Sums& sums )
{
    const Real reference = state.reference_pressure;
    const auto V = state.particles.template slice<Volume>();
    const auto m = state.particles.template slice<Mass>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        "Machpoint::heatFlux", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes ) MACHPOINT_INLINE {
            const Lanes volume = load( V, p );
            const Lanes mass = load( m, p );
            Straggler particle{
                heatOf( Lanes( load( e, p ) ), volume, mass, reference ) };
            VectorOf<Dim, Lanes> gradient{};
            forEachNode( s, layout,
                         [&]( const auto& i ) MACHPOINT_INLINE
                         {
                             const Lanes heat = at( means, i.row, 1 );
                             particle.look( heat );
                             for ( int d = 0; d < Dim; ++d )
                                 gradient[d] += heat * i.gradient[d];
                         } );
            Products<FluxTerms<Dim>, Dim, Lanes> terms;
            for ( int d = 0; d < Dim; ++d )
                terms.value[d] = -conductivity * volume * gradient[d];
            terms.value[Dim] = mass * particle.share( conducted, volume, mass );
            terms.value[Dim + 1] = terms.value[Dim] * particle.own;
            return addProductsLater( nodes, p, s, layout, s.dw, terms );
        } );
}

//! Columns 0 to 2 become the rate at which nodes gain heat, energy/(mass time),
//! and the means of eta and eta e.
//! \param[in,out] flux [nodes][>= Dim + 2] \param means m and e [nodes][2]
template <int Dim>
void heatingOfNodes( const State<Dim>& state, const NodeView& flux,
                     const NodeView& means )
{
    forEach(
        "Machpoint::heatingOfNodes", state.layout.total,
        MACHPOINT_LAMBDA( const int i ) {
            Real gained = 0;
            for ( int d = 0; d < Dim; ++d )
                gained += flux( i, d );
            const Real m = means( i, 0 );
            flux( i, 0 ) = perMass( gained, m );
            flux( i, 1 ) = perMass( flux( i, Dim ), m );
            flux( i, 2 ) = perMass( flux( i, Dim + 1 ), m );
        } );
}

//! dt sum w of the nodes' heating, and what stragglers exchange.
//! \param heating columns 0 to 2 \param conducted, means as above
//! \param[out] heat energy/mass [particles]
template <class Basis, int Dim, class Slice>
void gatherHeating( const State<Dim>& state, const NodeView& heating,
                    const Real conducted, const NodeView& means,
                    const Slice& heat )
{
    const Real reference = state.reference_pressure;
    const auto V = state.particles.template slice<Volume>();
    const auto m = state.particles.template slice<Mass>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto layout = state.layout;
    const Real dt = state.dt;
    forEachStencil<Basis>(
        "Machpoint::conductedHeatOfParticles", state,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s )
            MACHPOINT_INLINE {
                const Lanes volume = load( V, p );
                const Lanes mass = load( m, p );
                Straggler particle{
                    heatOf( Lanes( load( e, p ) ), volume, mass, reference ) };
                Lanes gained( 0.0 );
                PairExchange pairs;
                forEachNode( s, layout,
                             [&]( const auto& i ) MACHPOINT_INLINE
                             {
                                 const Lanes mean = at( means, i.row, 1 );
                                 particle.look( mean );
                                 gained += i.weight * at( heating, i.row, 0 );
                                 pairs.add( i.weight, mean,
                                            at( heating, i.row, 1 ),
                                            at( heating, i.row, 2 ) );
                             } );
                const Lanes share = particle.share( conducted, volume, mass );
                store( heat, dt * gained + pairs.gained( particle.own, share ),
                       p );
            },
        heating, means );
}

} // namespace Impl

/*!
  \brief Fourier's law with a constant coefficient, q = -k grad e with k =
  kappa / c_v.

  e_i = sum m w e / sum m w, Q_i = sum V q . grad w, e_p += dt sum w Q_i / m_i.
  Particles whose e is beyond that of their nodes, which Q_i cannot see,
  exchange heat with the others as well (Straggler). The sum of m e stays. Sides
  and bodies let no heat pass. e is heat, e - p_inf / rho, of a stiffened gas.
*/
template <int Dim>
class HeatConduction : public Module<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "heat_conduction";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "heat flux k grad e along the temperature",
                      dimension );
        p.number( "conductivity",
                  "k = kappa / c_v, for e stands for the temperature; gamma mu "
                  "/ Pr of a Prandtl number Pr" )
            .unit( "mass*length^(2-Dim)/time" )
            .atLeast( 0 )
            .source( "Fourier 1822; Landau and Lifshitz 1987, section 50" );
        return p;
    }

    static std::string remark( const Json* entry, const FlowFacts& flow )
    {
        return diffusionRemark( name, entry, flow );
    }

    explicit HeatConduction( const Json& json )
        : _conductivity( json.at( "conductivity" ) )
    {
    }
    //! @}

    void layOut( State<Dim>& state ) override
    {
        _means = makeNodeSum( "Machpoint::nodeTemperature", state, 2 );
        _flux = makeNodeSum( "Machpoint::heatFlux", state, Dim + 2 );
    }
    void initialize( State<Dim>& state ) override
    {
        _heat.make( state, "Machpoint::conductedHeat" );
    }

    Real limitTimeStep( State<Dim>& state ) override
    {
        return diffusiveTimeStep( state, _conductivity );
    }

    void gridForce( State<Dim>& state ) override
    {
        forBasis( state,
                  [&]( const auto basis )
                  {
                      using Basis = std::remove_cvref_t<decltype( basis )>;
                      conduct<Basis>( state );
                  } );
    }

    bool particleSource( State<Dim>& state ) override
    {
        _heat.give( state );
        return false; // it has looked at what it changed
    }

  private:
    template <class Basis>
    void conduct( State<Dim>& state )
    {
        _means.deposit(
            [&]( const auto& sums ) {
                depositShares<Basis, false>( "Machpoint::nodeTemperature",
                                             state, sums );
            } );
        _means.foldAndFill( state.halo, NodeComponents<2>{} );
        const auto means = _means.field();
        divideByFirst<2>( "Machpoint::divideTemperature", means );
        Real conducted = 0; // over a cell, mass/volume
        for ( int d = 0; d < Dim; ++d )
            conducted += _conductivity * static_cast<Real>( state.dt ) *
                         state.grid.inverse[d] * state.grid.inverse[d];
        _flux.deposit(
            [&]( const auto& sums )
            {
                Impl::depositHeatFlux<Basis>( state, _conductivity, conducted,
                                              means, sums );
            } );
        _flux.foldAndFill( state.halo, NodeComponents<Dim + 2>{} );
        Impl::heatingOfNodes( state, _flux.field(), means );
        Impl::gatherHeating<Basis>( state, _flux.field(), conducted, means,
                                    _heat.slice() );
    }

    Real _conductivity;
    NodeSum _means; // m and e [nodes][2]
    NodeSum _flux;  // [nodes][Dim + 2]
    HeatOfStep _heat;
};

} // namespace Machpoint

#endif
