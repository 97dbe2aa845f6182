/*!
  \file member_rows.hpp
  \brief Layer 2: members of particles as tables on the host, and in
  checkpoints.
*/
#ifndef MACHPOINT_MEMBER_ROWS_HPP
#define MACHPOINT_MEMBER_ROWS_HPP

#include <core/archive.hpp>
#include <core/particle_array.hpp>

#include <string>
#include <utility>
#include <vector>

namespace Machpoint
{

namespace Impl
{
//! Rows of a table on the host, [rows][columns].
template <class Value>
using HostRows = Kokkos::View<Value**, Kokkos::LayoutRight, Kokkos::HostSpace,
                              Kokkos::MemoryTraits<Kokkos::Unmanaged>>;

//! Copies member M of the particles from `first` on to the rows of a table.
template <std::size_t M, class AoSoA, class Value>
void fetchMember( const AoSoA& aosoa, const std::size_t first,
                  const HostRows<Value>& rows )
{
    using Type =
        typename Cabana::MemberTypeAtIndex<M,
                                           typename AoSoA::member_types>::type;
    const auto slice = Cabana::slice<M>( aosoa );
    // The same memory, unless the particles are a device's.
    const auto block = Kokkos::create_mirror_view( MemorySpace(), rows );
    forEach(
        "Machpoint::fetchMember", rows.extent_int( 0 ),
        MACHPOINT_LAMBDA( const int k ) {
            for ( std::size_t c = 0; c < block.extent( 1 ); ++c )
                block( k, c ) = component<Type>( slice, first + k, c );
        } );
    Kokkos::deep_copy( rows, block );
}

//! A member of all particles. \return [n][components], row by row
template <std::size_t M, class AoSoA>
auto copyMember( const AoSoA& aosoa )
{
    using Type =
        typename Cabana::MemberTypeAtIndex<M,
                                           typename AoSoA::member_types>::type;
    using Value = std::remove_all_extents_t<Type>;
    constexpr std::size_t columns = sizeof( Type ) / sizeof( Value );
    std::vector<Value> values( aosoa.size() * columns );
    fetchMember<M>( aosoa, 0,
                    HostRows<Value>( values.data(), aosoa.size(), columns ) );
    return values;
}

//! Overwrites member M from row `first` on.
template <std::size_t M, class AoSoA, class Value>
void storeMember( const AoSoA& aosoa, const std::size_t first,
                  const HostRows<Value>& rows )
{
    using Type =
        typename Cabana::MemberTypeAtIndex<M,
                                           typename AoSoA::member_types>::type;
    const auto slice = Cabana::slice<M>( aosoa );
    const auto block =
        Kokkos::create_mirror_view_and_copy( MemorySpace(), rows );
    forEach(
        "Machpoint::storeMember", rows.extent_int( 0 ),
        MACHPOINT_LAMBDA( const int k ) {
            for ( std::size_t c = 0; c < block.extent( 1 ); ++c )
                component<Type>( slice, first + k, c ) = block( k, c );
        } );
    Kokkos::fence( "Machpoint::storeMember" ); // before the rows change
}

//! Writes member M of all particles, or reads it; the first makes room.
template <std::size_t M, class Members>
void checkpointMember( Archive& archive, const std::string& name,
                       ParticleArray<Members>& aosoa )
{
    using Type = typename Cabana::MemberTypeAtIndex<M, Members>::type;
    using Value = std::remove_all_extents_t<Type>;
    constexpr std::size_t columns = sizeof( Type ) / sizeof( Value );
    Rows<Value> rows{
        aosoa.size(), columns,
        [aosoa]( const std::size_t first, const std::size_t count,
                 Value* values ) {
            fetchMember<M>( aosoa, first,
                            HostRows<Value>( values, count, columns ) );
        } };
    archive.rows( name, rows );
    if ( !archive.isReading() )
        return;
    if ( M == 0 )
        resizeWithSlack( aosoa, rows.count );
    if ( rows.count != aosoa.size() )
        throw ArchiveError( name + " has another length" );
    rows.forEachBlock(
        [&]( const std::size_t first, const std::size_t count, Value* values )
        {
            storeMember<M>( aosoa, first,
                            HostRows<Value>( values, count, columns ) );
        } );
}

template <class Members, std::size_t... M>
void checkpointMembers( Archive& archive, const char* const* names,
                        ParticleArray<Members>& aosoa,
                        std::index_sequence<M...> )
{
    ( checkpointMember<M>( archive, names ? names[M] : std::to_string( M ),
                           aosoa ),
      ... );
}

//! Writes all members, or reads them with their number.
//! \param names of the members; null: they are numbered
template <class Members>
void checkpointMembers( Archive& archive, const char* const* names,
                        ParticleArray<Members>& aosoa )
{
    checkpointMembers( archive, names, aosoa,
                       std::make_index_sequence<Members::size>{} );
}
} // namespace Impl

} // namespace Machpoint

#endif
