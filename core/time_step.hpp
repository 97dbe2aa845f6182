/*!
  \file time_step.hpp
  \brief Layer 5: the CFL condition, and the check that the gas is still sound.
*/
#ifndef MACHPOINT_TIME_STEP_HPP
#define MACHPOINT_TIME_STEP_HPP

#include <core/simulation.hpp>

#include <fmt/format.h>

namespace Machpoint
{

//! What one pass over the particles finds out before a step.
struct ParticleSurvey
{
    Real fastest = 0; //!< max of c + |v|
    Extrema extrema;
    int broken = -1; //!< a particle with a non-finite value or no volume

    KOKKOS_INLINE_FUNCTION ParticleSurvey& operator+=( const ParticleSurvey& s )
    {
        fastest = Kokkos::max( fastest, s.fastest );
        extrema.min_density =
            Kokkos::min( extrema.min_density, s.extrema.min_density );
        extrema.min_specific_internal_energy =
            Kokkos::min( extrema.min_specific_internal_energy,
                         s.extrema.min_specific_internal_energy );
        extrema.max_mach = Kokkos::max( extrema.max_mach, s.extrema.max_mach );
        // The largest number, so that the answer is the same on any backend.
        broken = Kokkos::max( broken, s.broken );
        return *this;
    }
};

//! Surveys all particles. Needs sound speeds (particleState).
template <int Dim>
ParticleSurvey surveyParticles( const State<Dim>& state )
{
    const auto v = state.particles.template slice<Velocity>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto c = state.particles.template slice<SoundSpeed>();
    ParticleSurvey survey;
    Kokkos::parallel_reduce(
        "Machpoint::survey", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p, ParticleSurvey& sum ) {
            const auto u = get<Dim>( v, p );
            const Real speed = Kokkos::sqrt( dot<Dim>( u, u ) );
            ParticleSurvey own;
            own.fastest = c( p ) + speed;
            own.extrema.min_density = m( p ) / V( p );
            own.extrema.min_specific_internal_energy = e( p );
            own.extrema.max_mach = c( p ) > 0 ? speed / c( p ) : 0.0;
            // Written so that a NaN is caught too.
            const bool sound = own.fastest < 1e300 && V( p ) > 0 &&
                               Kokkos::abs( e( p ) ) < 1e300;
            own.broken = sound ? -1 : p;
            sum += own;
        },
        survey );
    return survey;
}

//! Says which particle broke, where and when. \param p its number
template <int Dim>
NumericalFailure describeFailure( const State<Dim>& state, const int p )
{
    using tuple_type = typename Particles<Dim>::aosoa_type::tuple_type;
    Kokkos::View<tuple_type, MemorySpace> tuple( "Machpoint::brokenParticle" );
    const auto aosoa = state.particles.data();
    Kokkos::parallel_for(
        "Machpoint::describeFailure", Range( 0, 1 ),
        KOKKOS_LAMBDA( const int ) { tuple() = aosoa.getTuple( p ); } );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), tuple );
    std::string place, velocity;
    for ( int d = 0; d < Dim; ++d )
    {
        place += fmt::format( "{}{:.6g}", d ? ", " : "",
                              Cabana::get<Position>( host(), d ) );
        velocity += fmt::format( "{}{:.6g}", d ? ", " : "",
                                 Cabana::get<Velocity>( host(), d ) );
    }
    return NumericalFailure( fmt::format(
        "the gas broke down at step {}, t = {:.8g}: particle {} at ({}) has "
        "volume {:.6g}, specific internal energy {:.6g}, velocity ({}), sound "
        "speed {:.6g}; try a smaller time.cfl, artificial_viscosity, or "
        "method.name = apic",
        state.step, state.time, Cabana::get<Id>( host() ), place,
        Cabana::get<Volume>( host() ),
        Cabana::get<SpecificInternalEnergy>( host() ), velocity,
        Cabana::get<SoundSpeed>( host() ) ) );
}

} // namespace Machpoint

#endif
