/*!
  \file ideal_gas.hpp
  \brief p = (gamma - 1) rho e.
*/
#ifndef MACHPOINT_IDEAL_GAS_HPP
#define MACHPOINT_IDEAL_GAS_HPP

#include <physics/advance_pressure.hpp>

namespace Machpoint
{

//! Calorically perfect gas (Toro 2009, eq. 1.20).
template <int Dim>
class IdealGas : public EquationOfState<Dim>
{
  public:
    static constexpr const char* name = "ideal_gas";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "equation of state p = (gamma - 1) rho e",
                      dimension );
        p.number( "gamma", "ratio of specific heats" )
            .above( 1 )
            .defaultsTo( 1.4 )
            .source( "Toro 2009, section 1.2" );
        return p;
    }

    explicit IdealGas( const Json& json ) : _gamma( json.at( "gamma" ) ) {}

    Real specificInternalEnergy( const Real density,
                                 const Real pressure ) const override
    {
        return pressure / ( ( _gamma - 1 ) * density );
    }

    void particleState( State<Dim>& state ) override
    {
        const auto m = state.particles.template slice<Mass>();
        const auto V = state.particles.template slice<Volume>();
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const auto pressure = state.particles.template slice<Pressure>();
        const auto sound_speed = state.particles.template slice<SoundSpeed>();
        const Real gamma = _gamma;
        Kokkos::parallel_for(
            "Machpoint::idealGas", Range( 0, state.particles.size() ),
            KOKKOS_LAMBDA( const int p ) {
                // The paper's energy update can lose all of a cold gas's
                // energy; its sound speed is then taken as 0.
                pressure( p ) = ( gamma - 1 ) * m( p ) / V( p ) * e( p );
                sound_speed( p ) = Kokkos::sqrt( gamma * ( gamma - 1 ) *
                                                 Kokkos::max( e( p ), 0.0 ) );
            } );
    }

    void advancePressure( State<Dim>& state, const Real time ) override
    {
        Impl::advancePressure( state, time, _gamma, 0 );
    }

  private:
    Real _gamma;
};

} // namespace Machpoint

#endif
