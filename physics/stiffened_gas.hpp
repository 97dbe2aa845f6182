/*!
  \file stiffened_gas.hpp
  \brief p = (gamma - 1) rho e - gamma p_inf: a liquid-like gas.
*/
#ifndef MACHPOINT_STIFFENED_GAS_HPP
#define MACHPOINT_STIFFENED_GAS_HPP

#include <physics/advance_pressure.hpp>

namespace Machpoint
{

//! Stiffened gas (Harlow and Amsden 1971; Menikoff and Plohr 1989).
template <int Dim>
class StiffenedGas : public EquationOfState<Dim>
{
  public:
    static constexpr const char* name = "stiffened_gas";

    static Parameters declare( const int dimension )
    {
        Parameters p( name,
                      "equation of state p = (gamma - 1) rho e - gamma p_inf",
                      dimension );
        p.number( "gamma", "ratio of specific heats" )
            .above( 1 )
            .defaultsTo( 4.4 )
            .source( "Harlow and Amsden 1971; 4.4 for water" );
        p.number( "reference_pressure", "p_inf, the gas's cohesion" )
            .unit( "pressure" )
            .atLeast( 0 )
            .defaultsTo( 0 )
            .source( "Menikoff and Plohr 1989" );
        return p;
    }

    explicit StiffenedGas( const Json& json )
        : _gamma( json.at( "gamma" ) ),
          _reference( json.at( "reference_pressure" ) )
    {
    }

    Real specificInternalEnergy( const Real density,
                                 const Real pressure ) const override
    {
        return ( pressure + _gamma * _reference ) /
               ( ( _gamma - 1 ) * density );
    }

    void particleState( State<Dim>& state ) override
    {
        const auto m = state.particles.template slice<Mass>();
        const auto V = state.particles.template slice<Volume>();
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const auto pressure = state.particles.template slice<Pressure>();
        const auto sound_speed = state.particles.template slice<SoundSpeed>();
        const Real gamma = _gamma;
        const Real reference = _reference;
        Kokkos::parallel_for(
            "Machpoint::stiffenedGas", Range( 0, state.particles.size() ),
            KOKKOS_LAMBDA( const int p ) {
                const Real density = m( p ) / V( p );
                const Real value =
                    ( gamma - 1 ) * density * e( p ) - gamma * reference;
                pressure( p ) = value;
                // c^2 = gamma (p + p_inf) / rho, none when torn apart.
                sound_speed( p ) = Kokkos::sqrt(
                    gamma * Kokkos::max( value + reference, 0.0 ) / density );
            } );
    }

    void advancePressure( State<Dim>& state, const Real time ) override
    {
        Impl::advancePressure( state, time, _gamma, _reference );
    }

  private:
    Real _gamma;
    Real _reference;
};

} // namespace Machpoint

#endif
