/*!
  \file soundness.hpp
  \brief Layer 3: is the gas sound after a step, and still in the domain? Asked
  while the new state is in registers.
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
    const Number huge( largest_quantity );
    auto sound = Number( least ) < energy && energy < huge &&
                 Number( 0.0 ) < volume && volume < huge;
    for ( int d = 0; d < Dim; ++d )
        sound = sound && Kokkos::abs( moved[d] ) <= Number( spacing[d] ) &&
                Kokkos::abs( v[d] ) < Number( largest_speed );
    return sound;
}

/*!
  \brief What the last kernel of a step notes of the particles that it moves,
  so that they need not be read again: those that may leave the rank's box
  (State::noted), and that one may not be sound (State::suspicion).
*/
template <int Dim, class Positions>
struct Watch
{
    Positions start;
    Bounds<Dim> bounds;
    Vector<Dim> spacing;
    RowList noted;
    Kokkos::View<int, MemorySpace> suspicion;
    Real least_energy;
    bool returns; //!< is there a state to return to?

    //! The pack's new state.
    KOKKOS_FORCEINLINE_FUNCTION void operator()( const Pack p,
                                                 const VectorOf<Dim, Lanes>& x,
                                                 const VectorOf<Dim, Lanes>& v,
                                                 const Lanes& volume,
                                                 const Lanes& energy ) const
    {
        const LaneMask moved = active( p );
        noted.note( p, moved && bounds.excludes( x ) );
        if ( !returns )
            return;
        VectorOf<Dim, Lanes> way{};
        for ( int d = 0; d < Dim; ++d )
            way[d] = x[d] - load( start, p, d );
        if ( any( moved && !isSound<Dim>( way, v, volume, energy, spacing,
                                          least_energy ) ) )
            Kokkos::atomic_store( &suspicion(), 1 );
    }
};

//! The watch of a kernel of this step.
template <int Dim>
auto watch( const State<Dim>& state )
{
    const auto start = state.particles.template start<Position>();
    return Watch<Dim, decltype( start )>{
        start,
        boxBounds( state.grid, state.layout.box ),
        state.grid.spacing,
        state.noted,
        state.suspicion,
        state.least_energy,
        state.particles.keeps() };
}

} // namespace Machpoint

#endif
