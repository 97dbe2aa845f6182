/*!
  \file fault.hpp
  \brief Layer 5: what is wrong with a particle that a step broke, in words.
*/
#ifndef MACHPOINT_FAULT_HPP
#define MACHPOINT_FAULT_HPP

#include <core/soundness.hpp>

#include <fmt/format.h>

namespace Machpoint
{

//! What can be wrong with a particle after a step, the worst last.
enum class FaultKind : int
{
    none,            //!< the particle is sound
    moved_too_far,   //!< more than a cell
    negative_energy, //!< specific internal energy, or what is heat of it
    no_volume,       //!< so density is not positive
    no_mass,         //!< none that is positive and finite
    not_finite       //!< place, velocity, volume or heat
};

//! A particle that a step broke; none when particle is negative.
struct Fault
{
    int particle = -1; //!< its row
    FaultKind kind = FaultKind::none;

    //! Keeps the worst fault, of equal ones that of the largest number, so
    //! that the answer is the same on any backend.
    KOKKOS_INLINE_FUNCTION Fault& operator+=( const Fault& other )
    {
        if ( other.kind > kind ||
             ( other.kind == kind && other.particle > particle ) )
            *this = other;
        return *this;
    }
};

//! What is wrong with a particle that is not sound.
//! \param moved since the step began [Dim] \param least heat
template <int Dim>
KOKKOS_INLINE_FUNCTION FaultKind kindOfFault( const Vector<Dim>& moved,
                                              const Vector<Dim>& v,
                                              const Real volume,
                                              const Real heat,
                                              const Real least )
{
    bool finite =
        Kokkos::abs( heat ) < largest_quantity && volume < largest_quantity;
    for ( int d = 0; d < Dim; ++d )
        finite = finite && Kokkos::abs( moved[d] ) < largest_quantity &&
                 Kokkos::abs( v[d] ) < largest_speed;
    if ( !finite )
        return FaultKind::not_finite;
    if ( !( volume > 0 ) )
        return FaultKind::no_volume;
    return heat > least ? FaultKind::moved_too_far : FaultKind::negative_energy;
}

//! The worst fault of all particles after a step.
template <int Dim>
Fault findFault( const State<Dim>& state )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto m = state.particles.template slice<Mass>();
    const auto start = Cabana::slice<Position>( state.particles.old() );
    const auto spacing = state.grid.spacing;
    const Real least = state.least_heat;
    const Real reference = state.reference_pressure;
    Fault fault;
    reduceEach(
        "Machpoint::findFault", state.particles.size(), few_particles,
        MACHPOINT_LAMBDA( const int p, Fault& worst ) {
            Vector<Dim> moved{};
            for ( int d = 0; d < Dim; ++d )
                moved[d] = x( p, d ) - start( p, d );
            const auto u = loadVector<Dim>( v, p );
            const Real heat = heatOf<Real>( e( p ), V( p ), m( p ), reference );
            if ( !( 0 < m( p ) && m( p ) < largest_quantity ) )
                worst += Fault{ p, FaultKind::no_mass };
            else if ( !isSound<Dim>( moved, u, V( p ), heat, spacing, least ) )
                worst += Fault{
                    p, kindOfFault<Dim>( moved, u, V( p ), heat, least ) };
        },
        fault );
    return fault;
}

//! What is wrong with a particle that a survey found broken.
template <int Dim>
FaultKind kindOfBroken( const State<Dim>& state, const int particle )
{
    const auto broken = state.particles.toHost( particle );
    const Real mass = broken.template slice<Mass>()( 0 );
    const Real volume = broken.template slice<Volume>()( 0 );
    if ( !( 0 < mass && mass < largest_quantity ) )
        return FaultKind::no_mass;
    const FaultKind kind = kindOfFault<Dim>(
        {}, loadVector<Dim>( broken.template slice<Velocity>(), 0 ), volume,
        heatOf<Real>( broken.template slice<SpecificInternalEnergy>()( 0 ),
                      volume, mass, state.reference_pressure ),
        state.least_heat );
    // What is left is its pressure, or its speed of sound.
    return kind == FaultKind::moved_too_far ? FaultKind::not_finite : kind;
}

//! Says what is wrong with which particle, where and when, and what to try.
template <int Dim>
std::string describeFault( const State<Dim>& state, const Fault& fault )
{
    const auto broken = state.particles.toHost( fault.particle );
    std::string place, velocity;
    for ( int d = 0; d < Dim; ++d )
    {
        place += fmt::format( "{}{:.6g}", d ? ", " : "",
                              broken.template slice<Position>()( 0, d ) );
        velocity += fmt::format( "{}{:.6g}", d ? ", " : "",
                                 broken.template slice<Velocity>()( 0, d ) );
    }
    const char* what =
        fault.kind == FaultKind::not_finite  ? "a value that is not finite"
        : fault.kind == FaultKind::no_mass   ? "no positive, finite mass"
        : fault.kind == FaultKind::no_volume ? "no positive volume"
        : fault.kind == FaultKind::negative_energy
            ? state.reference_pressure > 0
                  ? "no specific internal energy beyond its cohesion, "
                    "reference_pressure times volume over mass"
                  : "no positive specific internal energy"
            : "moved by more than a cell";
    return fmt::format(
        "the gas broke down at step {}, t = {:.8g}, dt = {:.3g}: particle {} "
        "at ({}) has {}: volume {:.6g}, specific internal energy {:.6g}, "
        "velocity ({}), sound speed {:.6g}; try a smaller time.cfl, more cells "
        "where the gas thins out, artificial_viscosity, or another method.name",
        state.step, state.time, state.dt, broken.template slice<Id>()( 0 ),
        place, what, broken.template slice<Volume>()( 0 ),
        broken.template slice<SpecificInternalEnergy>()( 0 ), velocity,
        broken.template slice<SoundSpeed>()( 0 ) );
}

//! The same of the rank whose fault is the worst, the first of them if several
//! are; empty without faults. Collective.
template <int Dim>
std::string describeWorst( const State<Dim>& state, const Fault& fault )
{
    const auto& comm = state.decomposition.comm();
    const double kind = static_cast<int>( fault.kind );
    const double worst = comm.max( kind );
    if ( worst == 0 )
        return {};
    const int own = comm.rank();
    const int first =
        static_cast<int>( comm.min( kind == worst ? own : comm.size() ) );
    return comm.from( first, first == own ? describeFault( state, fault )
                                          : std::string() );
}

} // namespace Machpoint

#endif
