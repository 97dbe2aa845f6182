/*!
  \file particle_array.hpp
  \brief Layer 2: particles in tiles, and what is done to whole ones.
*/
#ifndef MACHPOINT_PARTICLE_ARRAY_HPP
#define MACHPOINT_PARTICLE_ARRAY_HPP

#include <Cabana_Core.hpp>
#include <core/collect.hpp>
#include <core/types.hpp>

#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace Machpoint
{

/*!
  \brief Particles of a tile. On a CPU a member of a tile fills eight pages of
  memory: the processor fetches ahead by itself what is read in a row, and a
  kernel that takes some of the members would else have half of the bandwidth.
  A register's where a particle has more than 12 numbers, as in 3D, where more
  take 2 % longer, and on Zens, where longer ones gain nothing; on a GPU
  Cabana's.
*/
template <class Members, class Space>
inline constexpr int tile_length =
    runs_on_host && !is_zen &&
            sizeof( Cabana::Tuple<Members> ) <= 12 * sizeof( Real )
        ? 4096
        : std::max<int>( lane_count,
                         Cabana::AoSoA<Members, Space>::vector_length );

//! Particles in tiles.
template <class Members, class Space = MemorySpace>
using ParticleArray =
    Cabana::AoSoA<Members, Space, tile_length<Members, Space>>;

//! An order of particles: the k-th is row permutation( k ). Of each bin also
//! its size and where it begins.
using ParticleBins = Cabana::BinningData<MemorySpace>;

//! Memory where particles are that is not in use meanwhile: for every particle
//! at least one number.
struct Scratch
{
    static constexpr std::size_t least_bytes = 8; //!< of a particle

    void* data;        //!< on the device
    std::size_t bytes; //!< of all of it
};

//! Particles that a rank can hold: rows are ints, and the last tile may be
//! longer than what is in it.
inline constexpr std::size_t most_particles =
    std::numeric_limits<int>::max() - 4096;

namespace Impl
{
//! Copies whole particles within an AoSoA. \param from, to [>= count] rows
template <class AoSoA>
void moveTuples( const AoSoA& aosoa, const IndexList& from, const IndexList& to,
                 const int count )
{
    forEach(
        "Machpoint::moveParticles", count,
        MACHPOINT_LAMBDA( const int k ) {
            aosoa.setTuple( to( k ), aosoa.getTuple( from( k ) ) );
        },
        few_particles );
}

//! Rows first to first + count - 1. \param memory of the list
inline IndexList rowsFrom( Reused<int>& memory, const int first,
                           const int count )
{
    const auto rows = memory.take( count );
    forEach(
        "Machpoint::rowsFrom", count,
        MACHPOINT_LAMBDA( const int k ) { rows( k ) = first + k; } );
    return rows;
}

//! Particle p alone. \return [1]
template <class AoSoA>
AoSoA singleTuple( const AoSoA& aosoa, const int p )
{
    const AoSoA single( aosoa.label(), 1 );
    forEach(
        "Machpoint::singleParticle", 1, MACHPOINT_LAMBDA( const int ) {
            single.setTuple( 0, aosoa.getTuple( p ) );
        } );
    return single;
}

//! Overwrites particles from row `first` on. \param from on the host
template <class AoSoA, class HostAoSoA>
void putTuples( const AoSoA& aosoa, const std::size_t first,
                const HostAoSoA& from )
{
    const auto block =
        Cabana::create_mirror_view_and_copy( MemorySpace(), from );
    forEach(
        "Machpoint::putParticles", static_cast<int>( from.size() ),
        MACHPOINT_LAMBDA( const int k ) {
            aosoa.setTuple( first + k, block.getTuple( k ) );
        },
        few_particles );
    Kokkos::fence( "Machpoint::putParticles" ); // before the host's change
}

//! Resizes with spare room, so that an open scene does not reallocate every
//! time a few particles enter.
//! \throws std::length_error beyond most_particles
template <class AoSoA>
void resizeWithSlack( AoSoA& aosoa, const std::size_t n )
{
    if ( n > most_particles )
        throw std::length_error(
            aosoa.label() + ": " + std::to_string( n ) +
            " particles on one rank are more than the " +
            std::to_string( most_particles ) +
            " that it can hold; take more ranks, or fewer cells or particles "
            "per cell" );
    if ( n > aosoa.capacity() && aosoa.size() > 0 )
        aosoa.reserve( n + n / 4 );
    aosoa.resize( n );
}

//! Copies particles in another order. \param to another AoSoA, as long
template <class From, class To>
void copyInOrder( const ParticleBins& bins, const From& from, const To& to )
{
    forEach(
        "Machpoint::permute", static_cast<int>( from.size() ),
        MACHPOINT_LAMBDA( const int k ) {
            to.setTuple( k, from.getTuple( bins.permutation( k ) ) );
        },
        few_particles );
}

//! Reorders particles. \param spare takes the old order
template <class AoSoA>
void permute( const ParticleBins& bins, AoSoA& aosoa, AoSoA& spare )
{
    resizeWithSlack( spare, aosoa.size() );
    copyInOrder( bins, aosoa, spare );
    std::swap( aosoa, spare );
}

//! Component c of a member, row by row. \tparam Type e.g. Real[2][2]
template <class Type, class SliceType>
KOKKOS_INLINE_FUNCTION auto&
component( const SliceType& slice, const std::size_t p, const std::size_t c )
{
    constexpr auto rank = std::rank_v<Type>;
    static_assert( rank <= 2 );
    if constexpr ( rank == 0 )
        return slice( p );
    else if constexpr ( rank == 1 )
        return slice( p, c );
    else
        return slice( p, c / std::extent_v<Type, 1>,
                      c % std::extent_v<Type, 1> );
}

//! Reorders a member, one component after the other. \param ordered [n], 8
//! bytes each
template <std::size_t M, class AoSoA>
void permuteMember( const ParticleBins& bins, const AoSoA& aosoa,
                    void* const ordered )
{
    using Type =
        typename Cabana::MemberTypeAtIndex<M,
                                           typename AoSoA::member_types>::type;
    using Value = std::remove_all_extents_t<Type>;
    static_assert( sizeof( Value ) <= Scratch::least_bytes );
    const auto slice = Cabana::slice<M>( aosoa );
    auto* const values = static_cast<Value*>( ordered );
    const Range all( 0, static_cast<int>( aosoa.size() ) );
    for ( std::size_t c = 0; c < sizeof( Type ) / sizeof( Value ); ++c )
    {
        Kokkos::parallel_for(
            "Machpoint::permuteComponent", all,
            MACHPOINT_LAMBDA( const int k ) {
                values[k] = component<Type>( slice, bins.permutation( k ), c );
            } );
        Kokkos::parallel_for(
            "Machpoint::storeComponent", all, MACHPOINT_LAMBDA( const int k ) {
                component<Type>( slice, k, c ) = values[k];
            } );
    }
}

template <class AoSoA, std::size_t... M>
void permuteMembers( const ParticleBins& bins, const AoSoA& aosoa,
                     void* const ordered, std::index_sequence<M...> )
{
    ( permuteMember<M>( bins, aosoa, ordered ), ... );
}

//! Reorders particles by way of scratch memory: at once if it holds them all,
//! else number by number, which takes twice as long.
template <class Members>
void permute( const ParticleBins& bins, const ParticleArray<Members>& aosoa,
              const Scratch& scratch )
{
    using aosoa_type = ParticleArray<Members>;
    using soa_type = typename aosoa_type::soa_type;
    using Ordered =
        Cabana::AoSoA<Members, MemorySpace, aosoa_type::vector_length,
                      Kokkos::MemoryTraits<Kokkos::Unmanaged>>;
    const std::size_t tiles = aosoa.numSoA();
    if ( scratch.bytes < tiles * sizeof( soa_type ) )
        permuteMembers( bins, aosoa, scratch.data,
                        std::make_index_sequence<Members::size>{} );
    else
    {
        const Ordered ordered( static_cast<soa_type*>( scratch.data ), tiles,
                               aosoa.size() );
        copyInOrder( bins, aosoa, ordered );
        using Bytes = Kokkos::View<std::byte*, MemorySpace,
                                   Kokkos::MemoryTraits<Kokkos::Unmanaged>>;
        const std::size_t bytes = tiles * sizeof( soa_type );
        Kokkos::deep_copy(
            ExecutionSpace(),
            Bytes( reinterpret_cast<std::byte*>( aosoa.data() ), bytes ),
            Bytes( static_cast<std::byte*>( scratch.data ), bytes ) );
    }
    Kokkos::fence( "Machpoint::permute" ); // before others take the scratch
}

//! Copies particles, their number included.
template <class AoSoA>
void copyParticles( AoSoA& to, const AoSoA& from )
{
    resizeWithSlack( to, from.size() );
    Cabana::deep_copy( to, from );
}
} // namespace Impl

} // namespace Machpoint

#endif
