/*!
  \file survey.hpp
  \brief Layer 3: what a pass over the gas finds out before a step.
*/
#ifndef MACHPOINT_SURVEY_HPP
#define MACHPOINT_SURVEY_HPP

#include <core/lanes.hpp>

namespace Machpoint
{

//! Extremes over particles, and over steps.
struct Extrema
{
    //! mass/length^Dim
    Real min_density = Kokkos::Experimental::infinity_v<Real>;
    //! energy/mass
    Real min_specific_internal_energy = Kokkos::Experimental::infinity_v<Real>;
    Real max_mach = 0; //!< |v| / c

    //! Takes in the extremes of others.
    KOKKOS_INLINE_FUNCTION Extrema& operator+=( const Extrema& other )
    {
        min_density = Kokkos::min( min_density, other.min_density );
        min_specific_internal_energy = Kokkos::min(
            min_specific_internal_energy, other.min_specific_internal_energy );
        max_mach = Kokkos::max( max_mach, other.max_mach );
        return *this;
    }
};

//! How fast the gas of a rank is, what its extremes are, and is it sound?
struct GasSurvey
{
    Real fastest = 0; //!< max of c + |v|, length/time
    //! max of c + 2 Viscosity::speed, length/time; 0 where that does not act.
    Real fastest_viscous = 0;
    Extrema extrema; //!< of this pass
    //! Row of a particle with a non-finite value, or without mass, volume or
    //! heat; -1: none.
    int broken = -1;

    //! Takes in what another part of the pass has seen.
    KOKKOS_INLINE_FUNCTION GasSurvey& operator+=( const GasSurvey& other )
    {
        fastest = Kokkos::max( fastest, other.fastest );
        fastest_viscous = Kokkos::max( fastest_viscous, other.fastest_viscous );
        extrema += other.extrema;
        // The largest number, so that the answer is the same on any backend.
        broken = Kokkos::max( broken, other.broken );
        return *this;
    }
};

//! The survey of some packs, lane by lane.
class LaneSurvey
{
  public:
    //! Takes in a pack. \param speed |v| \param sound c \param heat of the
    //! energy \param least heat
    KOKKOS_FORCEINLINE_FUNCTION void
    look( const Pack p, const Lanes& speed, const Lanes& sound,
          const Lanes& volume, const Lanes& density, const Lanes& energy,
          const Lanes& heat, const Real least )
    {
        const LaneMask counts = active( p );
        const Lanes zero( 0.0 );
        const Lanes huge( largest_quantity );
        const Lanes sum = sound + speed;
        _fastest = Kokkos::max( _fastest, choose( counts, sum, zero ) );
        // The quotient itself: products of two that tie may round either way,
        // and then the answer would be that of whoever comes first.
        _mach = Kokkos::max(
            _mach, choose( counts && zero < sound, speed / sound, zero ) );
        _density = Kokkos::min( _density, choose( counts, density, huge ) );
        _energy = Kokkos::min( _energy, choose( counts, energy, huge ) );
        // Written so that a NaN is caught too. Cold gas has heat of round-off.
        const Lanes size = Kokkos::abs( energy );
        const LaneMask is_sound = sum < huge && zero < volume &&
                                  zero < density && size < huge &&
                                  Lanes( least ) <= heat + round_off * size;
        if ( any( counts && !is_sound ) )
            for ( int l = 0; l < p.count; ++l )
                if ( !lane( is_sound, l ) )
                    _broken = p.first + l;
    }

    //! \param speed c + 2 Viscosity::speed of a pack
    KOKKOS_FORCEINLINE_FUNCTION void lookAtViscosity( const Pack p,
                                                      const Lanes& speed )
    {
        _fastest_viscous = Kokkos::max(
            _fastest_viscous, choose( active( p ), speed, Lanes( 0.0 ) ) );
    }

    //! Of all lanes.
    KOKKOS_FORCEINLINE_FUNCTION GasSurvey result() const
    {
        GasSurvey all;
        all.fastest = largest( _fastest );
        all.fastest_viscous = largest( _fastest_viscous );
        all.extrema = { smallest( _density ), smallest( _energy ),
                        largest( _mach ) };
        all.broken = _broken;
        return all;
    }

  private:
    Lanes _fastest{ 0.0 }, _fastest_viscous{ 0.0 };
    Lanes _mach{ 0.0 };
    Lanes _density{ largest_quantity }, _energy{ largest_quantity };
    int _broken = -1; // of those seen last
};

} // namespace Machpoint

#endif
