/*!
  \file diffusion.hpp
  \brief What viscosity and heat conduction share.
*/
#ifndef MACHPOINT_DIFFUSION_HPP
#define MACHPOINT_DIFFUSION_HPP

#include <core/flow_facts.hpp>
#include <core/soundness.hpp>
#include <core/transfer.hpp>

#include <fmt/format.h>

#include <string>

namespace Machpoint
{

//! Heat that an effect finds before G2P, where particles read the step's nodes,
//! and gives them after it. energy/mass
class HeatOfStep
{
    using Members = Cabana::MemberTypes<Real>;

  public:
    //! Makes room beside the particles. \param label of the memory
    template <int Dim>
    void make( State<Dim>& state, const char* label )
    {
        _heat = &state.particles.template addSidecar<Members>(
            label, DuringStep::renews );
    }
    //! [particles], energy/mass
    auto slice() const { return Cabana::slice<0>( _heat->data() ); }

    //! Adds it to the particles' energy, in particleSource; a step that it
    //! breaks is repeated.
    template <int Dim>
    void give( const State<Dim>& state ) const
    {
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const auto V = state.particles.template slice<Volume>();
        const auto m = state.particles.template slice<Mass>();
        const auto heat = slice();
        const auto note = watch( state );
        forEachPack(
            "Machpoint::giveHeat", state.particles.size(),
            MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
                const Lanes energy = load( e, p ) + load( heat, p );
                store( e, energy, p );
                note.lookAtEnergy( p, energy, V, m );
            } );
    }

  private:
    Sidecar<Members>* _heat = nullptr;
};

/*!
  \brief Time step for which diffusion by explicit steps is stable, Courant
  number included: CFL / (2 D sum_d h_d^-2), D = coefficient / least density
  (docs/diffusion.md). \param coefficient mass length^(2-Dim)/time
*/
template <int Dim>
Real diffusiveTimeStep( const State<Dim>& state, const Real coefficient )
{
    const Real density = state.survey.extrema.min_density;
    Real rate = 0;
    for ( int d = 0; d < Dim; ++d )
        rate += 2 * coefficient / density * state.grid.inverse[d] *
                state.grid.inverse[d];
    return rate > 0 ? static_cast<Real>( state.cfl ) / rate
                    : Kokkos::Experimental::infinity_v<Real>;
}

//! Gas in one state everywhere has nothing to diffuse: InputHooks::remark.
//! \param name of the effect
inline std::string diffusionRemark( const char* name, const Json* entry,
                                    const FlowFacts& flow )
{
    return entry && flow.is_undisturbed && flow.effects == 1
               ? fmt::format( "the gas is uniform and nothing disturbs it, so "
                              "{} will not be felt; leave it out",
                              name )
               : "";
}

} // namespace Machpoint

#endif
