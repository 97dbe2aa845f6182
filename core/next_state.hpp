/*!
  \file next_state.hpp
  \brief Layer 3: what a kernel writes to the state after a step.
*/
#ifndef MACHPOINT_NEXT_STATE_HPP
#define MACHPOINT_NEXT_STATE_HPP

#include <core/lanes.hpp>
#include <core/particles.hpp>

namespace Machpoint
{

/*!
  \brief Takes over the members that a step leaves as they are: mass, pressure,
  sound speed and id. For the last kernel of a step that changes particles.
*/
template <class Numbers, class Ids>
struct CarryOver
{
    Numbers old[3], next[3];
    Ids old_id, next_id;
    bool needed; //!< is the new state another place?

    KOKKOS_FORCEINLINE_FUNCTION void operator()( const Pack p ) const
    {
        if ( !needed )
            return;
        for ( int k = 0; k < 3; ++k )
            copy( old[k], next[k], p );
        copy( old_id, next_id, p );
    }
};

template <int Dim>
auto carryOver( const Particles<Dim>& particles )
{
    const auto id = particles.template slice<Id>();
    using Numbers = decltype( particles.template slice<Mass>() );
    return CarryOver<Numbers, decltype( id )>{
        { particles.template slice<Mass>(),
          particles.template slice<Pressure>(),
          particles.template slice<SoundSpeed>() },
        { particles.template next<Mass>(), particles.template next<Pressure>(),
          particles.template next<SoundSpeed>() },
        id,
        particles.template next<Id>(),
        particles.keeps() };
}

} // namespace Machpoint

#endif
