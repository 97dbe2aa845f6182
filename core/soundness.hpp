/*!
  \file soundness.hpp
  \brief Layer 3: is the gas sound after a step, and still in the domain? Asked
  while the new state is in registers.
*/
#ifndef MACHPOINT_SOUNDNESS_HPP
#define MACHPOINT_SOUNDNESS_HPP

#include <core/bounds.hpp>
#include <core/collect.hpp>
#include <core/state.hpp>

namespace Machpoint
{

//! What of the specific internal energy makes pressure and sound: e of an ideal
//! gas, and less the cohesion p_inf V / m of a stiffened one. energy/mass
//! \param reference p_inf, 0 of an ideal gas
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number heatOf( const Number& energy,
                                           const Number& volume,
                                           const Number& mass,
                                           const Real reference )
{
    return reference > 0 ? Number( energy - reference * volume / mass )
                         : energy;
}

/*!
  \brief Is a particle, or each of a pack, sound after a step: finite, positive
  volume and heat, and moved by no more than a cell?
  \param moved since the step began [Dim] \param v velocity [Dim]
  \param heat see heatOf \param least heat
*/
template <int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION auto
isSound( const VectorOf<Dim, Number>& moved, const VectorOf<Dim, Number>& v,
         const Number& volume, const Number& heat, const Vector<Dim>& spacing,
         const Real least )
{
    // Written so that a NaN is caught too.
    const Number huge( largest_quantity );
    auto sound = Number( least ) < heat && heat < huge &&
                 Number( 0.0 ) < volume && volume < huge;
    for ( int d = 0; d < Dim; ++d )
        sound = sound && Kokkos::abs( moved[d] ) <= Number( spacing[d] ) &&
                Kokkos::abs( v[d] ) < Number( largest_speed );
    return sound;
}

/*!
  \brief What the last kernel of a step notes of the particles that it moves,
  so that they need not be read again: those that may leave the rank's box
  (State::noted), and that one may not be sound (State::suspicions). A kernel
  that moves them for a part of the step ahead of it asks lookAtMove, one that
  changes their volume lookAtVolume, and one that gives them heat behind it
  lookAtEnergy.
*/
template <int Dim>
struct Watch
{
    Bounds<Dim> bounds;   //!< of what surely stays on this rank
    Vector<Dim> farthest; //!< that a particle may move in this kernel
    RowList noted;        //!< State::noted
    //! State::suspicions
    Kokkos::View<int[suspicion_count], MemorySpace> suspicions;
    Real least_heat;   //!< energy/mass
    Real reference;    //!< p_inf of a stiffened gas
    Real large_volume; //!< length^Dim; see Large
    bool returns;      //!< is there a state to return to?

    //! The pack's new state. \param old_x where the kernel found it
    KOKKOS_FORCEINLINE_FUNCTION void
    operator()( const Pack p, const VectorOf<Dim, Lanes>& old_x,
                const VectorOf<Dim, Lanes>& x, const VectorOf<Dim, Lanes>& v,
                const Lanes& volume, const Lanes& energy,
                const Lanes& mass ) const
    {
        const LaneMask counts = active( p );
        noted.note( p, counts && bounds.excludes( x ) );
        if ( !returns )
            return;
        VectorOf<Dim, Lanes> way{};
        for ( int d = 0; d < Dim; ++d )
            way[d] = x[d] - old_x[d];
        const Lanes heat = heatOf( energy, volume, mass, reference );
        if ( any( counts && !isSound<Dim>( way, v, volume, heat, farthest,
                                           least_heat ) ) )
            tell( Unsound );
    }

    //! Of a kernel that moves particles ahead of it. \param way [Dim], length
    KOKKOS_FORCEINLINE_FUNCTION void
    lookAtMove( const Pack p, const VectorOf<Dim, Lanes>& way ) const
    {
        if ( !returns )
            return;
        LaneMask near = Kokkos::abs( way[0] ) <= Lanes( farthest[0] );
        for ( int d = 1; d < Dim; ++d )
            near = near && Kokkos::abs( way[d] ) <= Lanes( farthest[d] );
        if ( any( active( p ) && !near ) )
            tell( Unsound );
    }

    //! Of a kernel that changes volumes.
    KOKKOS_FORCEINLINE_FUNCTION void lookAtVolume( const Pack p,
                                                   const Lanes& volume ) const
    {
        if ( any( active( p ) && Lanes( large_volume ) < volume ) )
            tell( Large );
    }

    //! Of a kernel that changes energies once G2P is done, when `returns` is
    //! not known any more. \param V volumes \param m masses
    template <class Volumes, class Masses>
    KOKKOS_FORCEINLINE_FUNCTION void
    lookAtEnergy( const Pack p, const Lanes& energy, const Volumes& V,
                  const Masses& m ) const
    {
        const Lanes heat = reference > 0 ? heatOf( energy, load( V, p ),
                                                   load( m, p ), reference )
                                         : energy;
        if ( any( active( p ) && !( Lanes( least_heat ) < heat &&
                                    heat < Lanes( largest_quantity ) ) ) )
            tell( Unsound );
    }

    //! Of any thread; isSuspected asks.
    KOKKOS_FORCEINLINE_FUNCTION void tell( const Suspicion suspicion ) const
    {
        Kokkos::atomic_store( &suspicions( suspicion ), 1 );
    }
};

//! The watch of a kernel of this step.
//! \param part of the step's motion that is the kernel's, of a cell at most
template <int Dim>
Watch<Dim> watch( const State<Dim>& state, const Real part = 1 )
{
    auto farthest = state.grid.spacing;
    for ( int d = 0; d < Dim; ++d )
        farthest[d] *= part;
    return { boxBounds( state.grid, state.layout.box ),
             farthest,
             state.noted,
             state.suspicions,
             state.least_heat,
             state.reference_pressure,
             state.large_volume,
             state.particles.keeps() };
}

//! Not 0 once a kernel has told of it.
template <int Dim>
SharedNumber suspicionOf( const State<Dim>& state, const Suspicion suspicion )
{
    return Kokkos::subview( state.suspicions, static_cast<int>( suspicion ) );
}

//! Has a kernel told of it on this rank since this was last asked?
template <int Dim>
bool isSuspected( const State<Dim>& state, const Suspicion suspicion )
{
    const auto told = suspicionOf( state, suspicion );
    if ( fetch( told ) == 0 )
        return false;
    put( told, 0 );
    return true;
}

} // namespace Machpoint

#endif
