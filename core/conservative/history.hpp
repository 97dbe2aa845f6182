/*!
  \file history.hpp
  \brief What halving and merging remember of particles (docs/conservative.md,
  section 9).
*/
#ifndef MACHPOINT_CONSERVATIVE_HISTORY_HPP
#define MACHPOINT_CONSERVATIVE_HISTORY_HPP

#include <core/conservative/parts.hpp>
#include <core/state.hpp>

namespace Machpoint
{

//! What halving and merging remember of a particle: accumulated stretch along
//! each axis, volume change apart, and the mass it started with, which is zero
//! until a particle was to be halved or might have merged.
template <int Dim>
using HistoryMembers = Cabana::MemberTypes<Real[Dim], Real>;

//! Names of the members of a history.
enum HistoryMember : std::size_t
{
    Stretch,     //!< integral of C_aa - tr C / Dim [Dim]
    OriginalMass //!< mass
};

namespace Impl
{

//! Advances the stretch that particles remember, by a rectangle of
//! parts.track_every steps. In 1D volume is all that changes.
template <int Dim>
void trackStretch( const State<Dim>& state,
                   Sidecar<HistoryMembers<Dim>>& history,
                   const ConservativeParts& parts )
{
    if ( Dim == 1 || state.step % parts.track_every != 0 )
        return;
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto stretch = Cabana::slice<Stretch>( history.data() );
    const Real elapsed = parts.track_every * state.dt;
    forEachPack(
        "Machpoint::trackStretch", state.particles.size(),
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            Lanes mean( 0.0 );
            for ( int a = 0; a < Dim; ++a )
                mean += load( C, p, a, a ) * ( 1.0_rt / Dim );
            for ( int a = 0; a < Dim; ++a )
                store( stretch,
                       load( stretch, p, a ) +
                           elapsed * ( load( C, p, a, a ) - mean ),
                       p, a );
        } );
}

} // namespace Impl
} // namespace Machpoint

#endif
