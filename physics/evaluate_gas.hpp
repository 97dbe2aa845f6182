/*!
  \file evaluate_gas.hpp
  \brief Pressure and sound speed of all particles by a formula.
*/
#ifndef MACHPOINT_EVALUATE_GAS_HPP
#define MACHPOINT_EVALUATE_GAS_HPP

#include <core/module.hpp>
#include <core/soundness.hpp>

namespace Machpoint
{

//! What an equation of state makes of density and specific internal energy.
struct ThermodynamicState
{
    Lanes pressure;
    Lanes sound_squared; //!< c^2, (length/time)^2; below 0 it counts as 0
};

/*!
  \brief Sets pressure and sound speed of all particles.
  \param surveys does it look at what a step has to know of the gas, too?
  \param formula on the device: formula( density, specific internal energy ),
  both Lanes, is a ThermodynamicState
  \return what it saw
*/
template <int Dim, class Formula>
GasSurvey evaluateGas( const State<Dim>& state, const bool surveys,
                       const Formula& formula )
{
    const auto v = state.particles.template slice<Velocity>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto pressure =
        state.particles.written( state.particles.template slice<Pressure>() );
    const auto sound_speed =
        state.particles.written( state.particles.template slice<SoundSpeed>() );
    const auto divergence = sliceOfFlow<Divergence>( state );
    const auto limiter = sliceOfFlow<Limiter>( state );
    const auto viscosity = state.viscosity;
    const Real h = state.grid.minSpacing();
    const Real least = state.least_heat;
    const Real reference = state.reference_pressure;
    const int n = state.particles.size();
    const int count = countPacks( n );
    // Lanes are joined after some packs, as that takes longer than a pack.
    constexpr int block = lane_count > 1 ? 32 : 1;
    GasSurvey survey;
    reduceEach(
        "Machpoint::evaluateGas", ( count + block - 1 ) / block,
        few_particles / block,
        MACHPOINT_LAMBDA( const int b, GasSurvey& sum ) {
            LaneSurvey seen;
            const int end = Kokkos::min( ( b + 1 ) * block, count );
            for ( int k = b * block; k < end; ++k )
            {
                const Pack p = Pack::of( k, n );
                const Lanes volume = load( V, p );
                const Lanes energy = load( e, p );
                const Lanes mass = load( m, p );
                const Lanes density = mass / volume;
                const ThermodynamicState gas = formula( density, energy );
                const Lanes sound = Kokkos::sqrt(
                    Kokkos::max( gas.sound_squared, Lanes( 0.0 ) ) );
                store( pressure, gas.pressure, p );
                store( sound_speed, sound, p );
                if ( !surveys )
                    continue;
                const auto u = loadVector<Dim>( v, p );
                const Lanes speed = Kokkos::sqrt( dot<Dim>( u, u ) );
                seen.look( p, speed, sound, volume, density, energy,
                           heatOf( energy, volume, mass, reference ), least );
                if ( viscosity.acts )
                    seen.lookAtViscosity(
                        p, sound + 2 * viscosity.speed( load( divergence, p ),
                                                        load( limiter, p ),
                                                        sound, h ) );
            }
            sum += seen.result();
        },
        survey );
    return survey;
}

} // namespace Machpoint

#endif
