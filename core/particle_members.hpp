/*!
  \file particle_members.hpp
  \brief Layer 2: what a particle has, member by member; particles on the host.
*/
#ifndef MACHPOINT_PARTICLE_MEMBERS_HPP
#define MACHPOINT_PARTICLE_MEMBERS_HPP

#include <core/particle_array.hpp>

#include <cstddef>
#include <cstdint>

namespace Machpoint
{

//! What a step advances: a particle has an old value and a new one, so that a
//! step can be repeated.
template <int Dim>
using AdvancedMembers =
    Cabana::MemberTypes<Real[Dim], Real[Dim], Deviation[Dim][Dim], Real, Real>;

//! What a step leaves as it is, or makes anew of the advanced members.
using LastingMembers = Cabana::MemberTypes<Real, Real, Real, std::int64_t>;

//! Names of the members of a particle, in the order of the types above.
enum Member : std::size_t
{
    Position,               //!< x_p [Dim], length
    Velocity,               //!< v_p [Dim], length/time
    VelocityGradient,       //!< `paper`: L_p, else the affine matrix C_p
                            //!< [Dim][Dim], 1/time
    Volume,                 //!< V_p, length^Dim; density is m_p / V_p
    SpecificInternalEnergy, //!< e_p, energy/mass
    Mass,                   //!< m_p, mass; the first that lasts
    Pressure,               //!< p_p, and q_p where a viscosity adds it
    SoundSpeed,             //!< c_p, length/time
    Id                      //!< unique for ever; negative: to be removed
};

//! Does a step advance this member?
constexpr bool isAdvanced( const std::size_t member )
{
    return member < Mass;
}

//! What a checkpoint calls them.
constexpr const char* member_names[] = { "position",
                                         "velocity",
                                         "velocity_gradient",
                                         "volume",
                                         "specific_internal_energy",
                                         "mass",
                                         "pressure",
                                         "sound_speed",
                                         "id" };

//! Bytes of all members of one particle.
template <int Dim>
constexpr std::size_t
    particle_bytes = sizeof( Cabana::Tuple<AdvancedMembers<Dim>> ) +
                     sizeof( Cabana::Tuple<LastingMembers> );

//! Slice of a member. \param advanced, lasting AoSoAs
template <std::size_t M, class Advanced, class Lasting>
auto sliceOf( const Advanced& advanced, const Lasting& lasting )
{
    if constexpr ( isAdvanced( M ) )
        return Cabana::slice<M>( advanced );
    else
        return Cabana::slice<M - Mass>( lasting );
}

//! Particles in host memory, to be looked at or made one by one.
template <int Dim>
struct HostParticles
{
    ParticleArray<AdvancedMembers<Dim>, Kokkos::HostSpace> advanced; //!< [n]
    ParticleArray<LastingMembers, Kokkos::HostSpace> lasting;        //!< [n]

    std::size_t size() const { return advanced.size(); }
    //! Those that stay keep their data; new ones are not set.
    void resize( const std::size_t n )
    {
        advanced.resize( n );
        lasting.resize( n );
    }
    //! A member of every particle.
    template <std::size_t M>
    auto slice() const
    {
        return sliceOf<M>( advanced, lasting );
    }
};

} // namespace Machpoint

#endif
