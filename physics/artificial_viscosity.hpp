/*!
  \file artificial_viscosity.hpp
  \brief Pressure that resists compression and gives shocks a width.
*/
#ifndef MACHPOINT_ARTIFICIAL_VISCOSITY_HPP
#define MACHPOINT_ARTIFICIAL_VISCOSITY_HPP

#include <core/flow_facts.hpp>
#include <core/module.hpp>

#include <fmt/format.h>

namespace Machpoint
{

/*!
  \brief q = rho h |D| (c1 c + c2 h |D|) where D = div v < 0.

  Von Neumann and Richtmyer 1950 (quadratic part), Landshoff 1955 (linear
  part). D is the trace of the particle's velocity gradient, so the effect
  needs no state of its own; a method that has rates (State::rates) takes the
  trace of its affine fit of the grid's new velocity instead, with a limiter
  that multiplies q. h is the smallest spacing.
*/
template <int Dim>
class ArtificialViscosity : public Module<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "artificial_viscosity";

    static Parameters declare( const int dimension )
    {
        Parameters p( name,
                      "pressure q = rho h |D| (c1 c + c2 h |D|) in compression",
                      dimension );
        p.number( "linear", "c1, in sound speeds" )
            .atLeast( 0 )
            .defaultsTo( 0.5 )
            .source( "Landshoff 1955" );
        p.number( "quadratic", "c2, in velocity jumps per cell" )
            .atLeast( 0 )
            .defaultsTo( 1.0 )
            .source( "von Neumann and Richtmyer 1950" );
        return p;
    }

    //! It acts where gas is compressed, and nothing else gives shocks a width.
    static std::string remark( const Json* entry, const FlowFacts& flow )
    {
        constexpr auto remedy = "add { \"type\": \"artificial_viscosity\" }";
        if ( entry )
            return flow.is_undisturbed && flow.effects == 1
                       ? "the gas is uniform and nothing disturbs it, so "
                         "artificial_viscosity will not be felt; leave it out"
                       : "";
        if ( flow.shocks_need_viscosity && !flow.shock.empty() )
            return fmt::format(
                "{}, and nothing but artificial_viscosity gives a shock its "
                "width; {}",
                flow.shock, remedy );
        if ( flow.waves_grow && !( flow.is_undisturbed && flow.effects == 0 ) )
            return fmt::format( "without artificial_viscosity the integrator "
                                "symplectic lets waves grow; {}, or take "
                                "\"time\": \"midpoint\"",
                                remedy );
        return "";
    }

    explicit ArtificialViscosity( const Json& json )
        : _linear( json.at( "linear" ) ), _quadratic( json.at( "quadratic" ) )
    {
    }
    //! @}

    void initialize( State<Dim>& state ) override
    {
        if ( state.rates )
            state.viscosity = { true, _linear, _quadratic };
    }

    //! With the gradient that the particle carries, where the method offers
    //! nothing better.
    void particleState( State<Dim>& state ) override
    {
        if ( state.rates )
            return;
        const auto m = state.particles.template slice<Mass>();
        const auto V = state.particles.template slice<Volume>();
        const auto L = state.particles.template slice<VelocityGradient>();
        const auto pressure = state.particles.template slice<Pressure>();
        const auto c = state.particles.template slice<SoundSpeed>();
        const Real c1 = _linear;
        const Real c2 = _quadratic;
        const Real h = state.grid.minSpacing();
        forEach(
            "Machpoint::artificialViscosity", state.particles.size(),
            MACHPOINT_LAMBDA( const int p ) {
                Real D = 0;
                for ( int d = 0; d < Dim; ++d )
                    D += L( p, d, d );
                if ( D < 0 )
                    pressure( p ) -=
                        m( p ) / V( p ) * h * D * ( c1 * c( p ) - c2 * h * D );
            } );
    }

    //! Viscosity diffuses: its wave speed is twice c1 c + c2 h |D| on top of c,
    //! in the frame of the gas (docs/method.md, section 6).
    Real limitTimeStep( State<Dim>& state ) override
    {
        const Real fastest = state.rates ? state.survey.fastest_viscous
                                         : fastestCarried( state );
        return fastest > 0 ? state.cfl * state.grid.minSpacing() / fastest
                           : Kokkos::Experimental::infinity_v<Real>;
    }

    //! max of c + 2 (c1 c + c2 h |D|) where D < 0, length/time; 0 without any
    //! such gas. Public only because nvcc wants the parent function of a device
    //! lambda to be accessible.
    Real fastestCarried( const State<Dim>& state ) const
    {
        const auto L = state.particles.template slice<VelocityGradient>();
        const auto c = state.particles.template slice<SoundSpeed>();
        const Real c1 = _linear;
        const Real c2 = _quadratic;
        const Real h = state.grid.minSpacing();
        Real fastest = 0;
        reduceEach(
            "Machpoint::limitViscosity", state.particles.size(), few_rows,
            MACHPOINT_LAMBDA( const int p, Real& max ) {
                Real D = 0;
                for ( int d = 0; d < Dim; ++d )
                    D += L( p, d, d );
                if ( D >= 0 )
                    return;
                max = Kokkos::max( max,
                                   c( p ) + 2 * ( c1 * c( p ) - c2 * h * D ) );
            },
            Kokkos::Max<Real>( fastest ) );
        return fastest;
    }

  private:
    Real _linear;
    Real _quadratic;
};

} // namespace Machpoint

#endif
