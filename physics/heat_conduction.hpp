/*!
  \file heat_conduction.hpp
  \brief Heat flux along the gradient of the temperature (docs/diffusion.md).
*/
#ifndef MACHPOINT_HEAT_CONDUCTION_HPP
#define MACHPOINT_HEAT_CONDUCTION_HPP

#include <core/for_basis.hpp>
#include <core/module.hpp>
#include <physics/diffusion.hpp>

namespace Machpoint
{

namespace Impl
{

//! V q_d d_d w in column d.
template <int Dim>
struct FluxTerms : ValueTerms<Dim>
{
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int axis( const int t )
    {
        return t;
    }
};

//! Adds m and m e of the particles, e without what a stiffened gas has of its
//! reference pressure. \param sums the scatter of a field [nodes][2]
template <class Basis, int Dim, class Sums>
void depositTemperature( const State<Dim>& state, const Sums& sums )
{
    const Real reference = state.reference_pressure;
    const auto V = state.particles.template slice<Volume>();
    const auto m = state.particles.template slice<Mass>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        "Machpoint::nodeTemperature", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes ) MACHPOINT_INLINE {
            Products<ValueTerms<2>, Dim, Lanes> terms;
            terms.value[0] = load( m, p );
            terms.value[1] =
                terms.value[0] * load( e, p ) - reference * load( V, p );
            return addProductsLater( nodes, p, s, layout, s.w, terms );
        } );
}

//! Adds V q_d d_d w of the particles, q = -k grad e of the nodes.
//! \param means m and e [nodes][2] \param sums the scatter of a field
//! [nodes][Dim]
template <class Basis, int Dim, class Sums>
void depositHeatFlux( const State<Dim>& state, const Real conductivity,
                      const NodeView& means, const Sums& sums )
{
    const auto V = state.particles.template slice<Volume>();
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        "Machpoint::heatFlux", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes ) MACHPOINT_INLINE {
            VectorOf<Dim, Lanes> gradient{};
            forEachNode( s, layout,
                         [&]( const auto& i ) MACHPOINT_INLINE
                         {
                             const Lanes heat = at( means, i.row, 1 );
                             for ( int d = 0; d < Dim; ++d )
                                 gradient[d] += heat * i.gradient[d];
                         } );
            Products<FluxTerms<Dim>, Dim, Lanes> terms;
            for ( int d = 0; d < Dim; ++d )
                terms.value[d] = -conductivity * load( V, p ) * gradient[d];
            return addProductsLater( nodes, p, s, layout, s.dw, terms );
        } );
}

//! Column 0 becomes the rate at which nodes gain heat, energy/(mass time).
//! \param[in,out] flux [nodes][>= Dim] \param means m and e [nodes][2]
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
            flux( i, 0 ) = m > 0 ? gained / m : 0.0_rt;
        } );
}

//! dt sum w of the nodes' heating.
//! \param heating column 0 \param[out] heat energy/mass [particles]
template <class Basis, int Dim, class Slice>
void gatherHeating( const State<Dim>& state, const NodeView& heating,
                    const Slice& heat )
{
    const auto layout = state.layout;
    const Real dt = state.dt;
    forEachStencil<Basis>(
        "Machpoint::conductedHeatOfParticles", state,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s )
            MACHPOINT_INLINE {
                Lanes rate( 0.0 );
                forEachNode( s, layout,
                             [&]( const auto& i ) MACHPOINT_INLINE
                             { rate += i.weight * at( heating, i.row, 0 ); } );
                store( heat, dt * rate, p );
            },
        heating );
}

} // namespace Impl

/*!
  \brief Fourier's law with a constant coefficient, q = -k grad e with k =
  kappa / c_v.

  e_i = sum m w e / sum m w, Q_i = sum V q . grad w, e_p += dt sum w Q_i / m_i:
  the sum of m e stays. Sides and bodies let no heat pass. e is heat, e - p_inf
  / rho, of a stiffened gas.
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
            .unit( "mass/(length*time)" )
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
        _flux = makeNodeSum( "Machpoint::heatFlux", state, Dim );
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
        _means.deposit( [&]( const auto& sums )
                        { Impl::depositTemperature<Basis>( state, sums ); } );
        _means.foldAndFill( state.halo, NodeComponents<2>{} );
        const auto means = _means.field();
        divideByFirst<2>( "Machpoint::divideTemperature", means );
        _flux.deposit(
            [&]( const auto& sums ) {
                Impl::depositHeatFlux<Basis>( state, _conductivity, means,
                                              sums );
            } );
        _flux.foldAndFill( state.halo, NodeComponents<Dim>{} );
        Impl::heatingOfNodes( state, _flux.field(), means );
        Impl::gatherHeating<Basis>( state, _flux.field(), _heat.slice() );
    }

    Real _conductivity;
    NodeSum _means; // m and e [nodes][2]
    NodeSum _flux;  // [nodes][Dim]
    HeatOfStep _heat;
};

} // namespace Machpoint

#endif
