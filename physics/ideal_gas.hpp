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
        const int n = state.particles.size();
        Kokkos::parallel_for(
            "Machpoint::idealGas", packs( n ), KOKKOS_LAMBDA( const int k ) {
                const Pack p = Pack::of( k, n );
                const Lanes heat = ( gamma - 1 ) * load( e, p );
                store( pressure, heat * load( m, p ) / load( V, p ), p );
                // The paper's energy update can lose all of a cold gas's
                // energy; its sound speed is then taken as 0.
                store(
                    sound_speed,
                    Kokkos::sqrt( Kokkos::max( gamma * heat, Lanes( 0.0 ) ) ),
                    p );
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
