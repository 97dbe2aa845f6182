/*!
  \file soundness.hpp
  \brief Layer 3: is the gas sound after a step? Asked while the new state is
  still in registers.
*/
#ifndef MACHPOINT_SOUNDNESS_HPP
#define MACHPOINT_SOUNDNESS_HPP

#include <core/module.hpp>

namespace Machpoint
{

/*!
  \brief Is a particle, or each of a pack, sound after a step: finite, positive
  volume and energy, and moved by no more than a cell?
  \param moved since the step began [Dim] \param v velocity [Dim]
  \param least energy
*/
template <int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION auto
isSound( const VectorOf<Dim, Number>& moved, const VectorOf<Dim, Number>& v,
         const Number& volume, const Number& energy, const Vector<Dim>& spacing,
         const Real least )
{
    // Written so that a NaN is caught too.
    const Number huge( 1e300 );
    auto sound = Number( least ) < energy && energy < huge &&
                 Number( 0.0 ) < volume && volume < huge;
    for ( int d = 0; d < Dim; ++d )
        sound = sound && Kokkos::abs( moved[d] ) <= Number( spacing[d] ) &&
                Kokkos::abs( v[d] ) < Number( 1e150 );
    return sound;
}

/*!
  \brief Raises State::suspicion where a step leaves a particle that is not
  sound, so that the particles need not be read again to know that all are.
  For the last kernel of a step that changes particles.
*/
template <int Dim, class Positions>
struct Suspect
{
    Positions start;
    Kokkos::View<int, MemorySpace> suspicion;
    Vector<Dim> spacing;
    Real least_energy;
    bool needed; //!< is there a state to return to?

    //! The pack's new state. \param mine its particles that the kernel serves
    KOKKOS_FORCEINLINE_FUNCTION void
    operator()( const Pack p, const LaneMask& mine,
                const VectorOf<Dim, Lanes>& x, const VectorOf<Dim, Lanes>& v,
                const Lanes& volume, const Lanes& energy ) const
    {
        if ( !needed )
            return;
        VectorOf<Dim, Lanes> moved{};
        for ( int d = 0; d < Dim; ++d )
            moved[d] = x[d] - load( start, p, d );
        if ( any( mine && active( p ) &&
                  !isSound<Dim>( moved, v, volume, energy, spacing,
                                 least_energy ) ) )
            Kokkos::atomic_store( &suspicion(), 1 );
    }
};

//! The check for a kernel of this step.
template <int Dim>
auto suspect( const State<Dim>& state )
{
    const auto start = state.particles.template start<Position>();
    return Suspect<Dim, decltype( start )>{
        start, state.suspicion, state.grid.spacing, state.least_energy,
        state.particles.keeps() };
}

} // namespace Machpoint

#endif
