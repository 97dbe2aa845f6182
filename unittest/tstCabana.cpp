/*!
  \file tstCabana.cpp
  \brief What Machpoint relies on in Cabana, bundled or installed: the layout
  of an AoSoA, slices, copies, sorting and the loop over structs.
*/
#include <core/types.hpp>

#include <Cabana_Core.hpp>

#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

namespace
{

using namespace Machpoint;

// Two structs of 8 and a rest, so that every index rule matters.
constexpr int vector_length = 8;
constexpr int num_particle = 21;

using Members = Cabana::MemberTypes<Real[2][2], Real[3], Real, int>;
using AoSoA = Cabana::AoSoA<Members, MemorySpace, vector_length>;
using HostAoSoA = Cabana::AoSoA<Members, Kokkos::HostSpace, vector_length>;

// Values that tell particle, row and column apart.
KOKKOS_INLINE_FUNCTION Real value( const int p, const int i = 0,
                                   const int j = 0 )
{
    return 100 * p + 10 * i + j;
}

AoSoA makeParticles( const int n )
{
    AoSoA particles( "particles", n );
    auto matrix = Cabana::slice<0>( particles );
    auto vector = Cabana::slice<1>( particles );
    auto scalar = Cabana::slice<2>( particles );
    auto id = Cabana::slice<3>( particles );
    Kokkos::parallel_for(
        "fill", Range( 0, n ), KOKKOS_LAMBDA( const int p ) {
            for ( int i = 0; i < 2; ++i )
                for ( int j = 0; j < 2; ++j )
                    matrix( p, i, j ) = value( p, i, j );
            for ( int i = 0; i < 3; ++i )
                vector( p, i ) = value( p, i );
            scalar( p ) = value( p );
            id( p ) = p;
        } );
    return particles;
}

HostAoSoA toHost( const AoSoA& particles )
{
    HostAoSoA host( "host", particles.size() );
    Cabana::deep_copy( host, particles );
    return host;
}

// Place p must hold the values that particle `source` was made with.
void expectParticle( const HostAoSoA& host, const int p, const int source )
{
    const auto matrix = Cabana::slice<0>( host );
    const auto vector = Cabana::slice<1>( host );
    for ( int i = 0; i < 2; ++i )
        for ( int j = 0; j < 2; ++j )
            EXPECT_EQ( matrix( p, i, j ), value( source, i, j ) );
    for ( int i = 0; i < 3; ++i )
        EXPECT_EQ( vector( p, i ), value( source, i ) );
    EXPECT_EQ( Cabana::slice<2>( host )( p ), value( source ) );
    EXPECT_EQ( Cabana::slice<3>( host )( p ), source );
}

// A view of n keys key( p ).
template <class Key, class Function>
Kokkos::View<Key*, MemorySpace> makeKeys( const int n, const Function& key )
{
    Kokkos::View<Key*, MemorySpace> keys( "keys", n );
    const auto host = Kokkos::create_mirror_view( keys );
    for ( int p = 0; p < n; ++p )
        host( p ) = key( p );
    Kokkos::deep_copy( keys, host );
    return keys;
}

// The kernels stand in functions of their own: nvcc takes none in a TEST.

// Size and offset of every bin.
template <class Binning>
std::vector<std::pair<int, int>> binsOf( const Binning& binning )
{
    const int n = binning.numBin();
    const Kokkos::View<int* [2], MemorySpace> bins( "bins", n );
    Kokkos::parallel_for(
        "bins", Range( 0, n ), KOKKOS_LAMBDA( const int b ) {
            bins( b, 0 ) = binning.binSize( b );
            bins( b, 1 ) = binning.binOffset( b );
        } );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace{}, bins );
    std::vector<std::pair<int, int>> result;
    for ( int b = 0; b < n; ++b )
        result.emplace_back( host( b, 0 ), host( b, 1 ) );
    return result;
}

// Which particle comes to each place of the range.
template <class Binning>
std::vector<int> orderOf( const Binning& binning )
{
    const int n = binning.rangeEnd() - binning.rangeBegin();
    const Kokkos::View<int*, MemorySpace> order( "order", n );
    Kokkos::parallel_for(
        "order", Range( 0, n ), KOKKOS_LAMBDA( const int q ) {
            order( q ) = binning.permutation( q );
        } );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace{}, order );
    return { host.data(), host.data() + n };
}

// Add 1 to component 1 of particle p, n times at once.
template <class Slice>
void addOnes( const Slice& slice, const int p, const int n )
{
    const typename Slice::atomic_access_slice atomic = slice;
    Kokkos::parallel_for(
        "add", Range( 0, n ),
        KOKKOS_LAMBDA( const int ) { atomic( p, 1 ) += 1.; } );
}

// Add 1 to particles [begin, end).
template <class Slice>
void visit( const Slice& slice, const int begin, const int end )
{
    const typename Slice::atomic_access_slice visits = slice;
    Cabana::simd_parallel_for(
        Cabana::SimdPolicy<vector_length, ExecutionSpace>( begin, end ),
        KOKKOS_LAMBDA( const int s, const int a ) {
            visits.access( s, a ) += 1;
        },
        "visit" );
}

TEST( Cabana, LayoutIsStructsOfArrays )
{
    const HostAoSoA host = toHost( makeParticles( num_particle ) );
    ASSERT_EQ( int( host.numSoA() ), 3 );
    EXPECT_EQ( int( host.arraySize( 1 ) ), vector_length );
    EXPECT_EQ( int( host.arraySize( 2 ) ), 5 );
    EXPECT_GE( int( host.capacity() ), 24 );

    // 4 + 3 + 1 numbers and an id, each an array of 8: no padding, but for what
    // the bundled one has behind the last to start with a line of memory.
    constexpr auto bytes =
        vector_length * ( 8 * sizeof( Real ) + sizeof( int ) );
    static_assert( sizeof( HostAoSoA::soa_type ) >= bytes &&
                   sizeof( HostAoSoA::soa_type ) < bytes + 64 );
    const auto matrix = Cabana::slice<0>( host );
    EXPECT_EQ( &matrix( 9, 0, 0 ) - &matrix( 8, 0, 0 ), 1 );
    EXPECT_EQ( &matrix( 8, 0, 1 ) - &matrix( 8, 0, 0 ), vector_length );
    EXPECT_EQ( &matrix( 8, 1, 0 ) - &matrix( 8, 0, 0 ), 2 * vector_length );
    EXPECT_EQ( reinterpret_cast<const char*>( &matrix( 8, 0, 0 ) ) -
                   reinterpret_cast<const char*>( &matrix( 0, 0, 0 ) ),
               std::ptrdiff_t( sizeof( HostAoSoA::soa_type ) ) );
}

TEST( Cabana, SliceTupleAndStructSeeTheSameValues )
{
    const HostAoSoA host = toHost( makeParticles( num_particle ) );
    const auto matrix = Cabana::slice<0>( host, "matrix" );
    EXPECT_EQ( matrix.label(), "matrix" );
    EXPECT_EQ( int( matrix.size() ), num_particle );
    for ( int p = 0; p < num_particle; ++p )
    {
        const int s = p / vector_length;
        const int a = p % vector_length;
        const auto tuple = host.getTuple( p );
        for ( int i = 0; i < 2; ++i )
            for ( int j = 0; j < 2; ++j )
            {
                EXPECT_EQ( matrix( p, i, j ), value( p, i, j ) );
                EXPECT_EQ( matrix.access( s, a, i, j ), value( p, i, j ) );
                EXPECT_EQ( Cabana::get<0>( tuple, i, j ), value( p, i, j ) );
                EXPECT_EQ( Cabana::get<0>( host.access( s ), a, i, j ),
                           value( p, i, j ) );
            }
    }
}

TEST( Cabana, SetTupleChangesOneParticle )
{
    const HostAoSoA host = toHost( makeParticles( num_particle ) );
    host.setTuple( 17, host.getTuple( 3 ) );
    for ( int p = 0; p < num_particle; ++p )
        expectParticle( host, p, p == 17 ? 3 : p );
}

TEST( Cabana, ResizeKeepsValues )
{
    AoSoA particles = makeParticles( num_particle );
    particles.resize( 100 );
    EXPECT_EQ( int( particles.size() ), 100 );
    particles.resize( 13 );
    EXPECT_GE( int( particles.capacity() ), 100 );
    particles.shrinkToFit();
    EXPECT_EQ( int( particles.capacity() ), 16 );
    particles.reserve( 1000 );
    ASSERT_EQ( int( particles.size() ), 13 );

    const HostAoSoA host = toHost( particles );
    for ( int p = 0; p < 13; ++p )
        expectParticle( host, p, p );
}

TEST( Cabana, CopiesReachOtherLayouts )
{
    const AoSoA particles = makeParticles( num_particle );
    const auto mirror =
        Cabana::create_mirror_view_and_copy( Kokkos::HostSpace{}, particles );
    Cabana::AoSoA<Members, MemorySpace, 4> narrow( "narrow", num_particle );
    Cabana::deep_copy( narrow, mirror );
    AoSoA back( "back", num_particle );
    Cabana::deep_copy( back, narrow );
    const HostAoSoA host = toHost( back );
    for ( int p = 0; p < num_particle; ++p )
        expectParticle( host, p, p );

    AoSoA other_size( "other_size", num_particle + 1 );
    EXPECT_THROW( Cabana::deep_copy( other_size, particles ),
                  std::runtime_error );
}

TEST( Cabana, SlicesAreCopiedAndFilled )
{
    AoSoA particles = makeParticles( num_particle );
    auto vector = Cabana::slice<1>( particles );
    Cabana::deep_copy( vector, 7. );
    // Its neighbours in the struct must be left alone.
    HostAoSoA host = toHost( particles );
    for ( int p = 0; p < num_particle; ++p )
    {
        for ( int i = 0; i < 3; ++i )
            EXPECT_EQ( Cabana::slice<1>( host )( p, i ), 7. );
        EXPECT_EQ( Cabana::slice<0>( host )( p, 1, 1 ), value( p, 1, 1 ) );
        EXPECT_EQ( Cabana::slice<2>( host )( p ), value( p ) );
    }

    const AoSoA original = makeParticles( num_particle );
    auto host_vector = Cabana::slice<1>( host );
    Cabana::deep_copy( host_vector, Cabana::slice<1>( original ) );
    for ( int p = 0; p < num_particle; ++p )
        expectParticle( host, p, p );
}

TEST( Cabana, AtomicSliceLosesNoUpdate )
{
    const AoSoA particles = makeParticles( num_particle );
    const int additions = 10000;
    addOnes( Cabana::slice<1>( particles ), 20, additions );
    EXPECT_EQ( Cabana::slice<1>( toHost( particles ) )( 20, 1 ),
               value( 20, 1 ) + additions );
}

// Structs whose arrays fill pages of memory.
TEST( Cabana, LongArraysKeepTheirValues )
{
    constexpr int length = 1024;
    const int n = length + num_particle;
    using LongAoSoA = Cabana::AoSoA<Members, MemorySpace, length>;
    const AoSoA particles = makeParticles( n );
    LongAoSoA wide( "wide", n );
    Cabana::deep_copy( wide, particles );
    ASSERT_EQ( int( wide.numSoA() ), 2 );

    // One after the other, and each as far from the next as the slice says.
    const auto matrix = Cabana::slice<0>( wide );
    const std::ptrdiff_t distance = matrix.stride( 3 );
    EXPECT_GE( distance, length );
    EXPECT_EQ( &matrix( 8, 0, 1 ) - &matrix( 8, 0, 0 ), distance );
    EXPECT_EQ( &matrix( 8, 1, 0 ) - &matrix( 8, 0, 0 ), 2 * distance );

    // Member by member: a copy, a number for all, and reversed.
    const auto keys = makeKeys<int>( n, []( const int p ) { return -p; } );
    auto vector = Cabana::slice<1>( wide );
    Cabana::deep_copy( vector, 7. );
    Cabana::deep_copy( vector, Cabana::slice<1>( particles ) );
    Cabana::permute( Cabana::sortByKey( keys, 0, n ), vector );
    AoSoA back( "back", n );
    Cabana::deep_copy( back, wide );
    const HostAoSoA host = toHost( back );
    for ( int p = 0; p < n; ++p )
    {
        EXPECT_EQ( Cabana::slice<0>( host )( p, 1, 1 ), value( p, 1, 1 ) );
        EXPECT_EQ( Cabana::slice<1>( host )( p, 2 ), value( n - 1 - p, 2 ) );
        EXPECT_EQ( Cabana::slice<2>( host )( p ), value( p ) );
    }
}

// Bin n particles by key 5 + (7 p + 3) mod 10 and compare with the definition
// of binning: what is in each bin, and where the bin starts.
TEST( Cabana, BinByKeyThenPermuteSorts )
{
    const int n = 1000;
    const int num_key = 10;
    const auto key = []( const int p ) { return 5 + ( 7 * p + 3 ) % num_key; };
    AoSoA particles = makeParticles( n );
    const auto keys = makeKeys<int>( n, key );
    const auto binning = Cabana::binByKey( keys, num_key );
    Cabana::permute( binning, particles );

    // One bin per key from the smallest key on; the last bin is empty.
    const auto bins = binsOf( binning );
    ASSERT_EQ( int( bins.size() ), num_key + 1 );
    EXPECT_EQ( bins.back(), std::make_pair( 0, n ) );

    const HostAoSoA host = toHost( particles );
    const auto id = Cabana::slice<3>( host );
    std::set<int> seen;
    for ( int b = 0; b < num_key; ++b )
    {
        // 7 has an inverse modulo 10: every key occurs equally often.
        const auto [size, offset] = bins[b];
        ASSERT_EQ( size, n / num_key );
        ASSERT_EQ( offset, b * n / num_key );
        for ( int p = offset; p < offset + size; ++p )
        {
            EXPECT_EQ( key( id( p ) ), 5 + b );
            // All members move together.
            expectParticle( host, p, id( p ) );
            seen.insert( id( p ) );
        }
    }
    EXPECT_EQ( seen.size(), std::size_t( n ) );
}

// Of whole numbers so large that some are the same as doubles each has one of
// the bins, whichever.
TEST( Cabana, BinByKeyKeepsLargeKeysWithinItsBins )
{
    const int n = 101;
    const int nbin = 300;
    const auto key = []( const int p )
    { return ( std::int64_t( 1 ) << 62 ) + 5 * p; };
    const auto bins =
        binsOf( Cabana::binByKey( makeKeys<std::int64_t>( n, key ), nbin ) );
    ASSERT_EQ( bins.size(), std::size_t( nbin + 1 ) );
    int before = 0;
    for ( const auto& [size, offset] : bins )
    {
        EXPECT_EQ( offset, before );
        before += size;
    }
    EXPECT_EQ( before, n );
}

TEST( Cabana, PermuteLeavesParticlesOutsideTheRange )
{
    AoSoA particles = makeParticles( num_particle );
    const auto keys =
        makeKeys<int>( num_particle, []( const int p ) { return -p; } );
    // The range starts and ends inside a struct.
    const int begin = 3;
    const int end = 18;
    const auto order = Cabana::sortByKey( keys, begin, end );
    Cabana::permute( order, particles );
    HostAoSoA host = toHost( particles );
    for ( int p = 0; p < num_particle; ++p )
        expectParticle( host, p,
                        p < begin || p >= end ? p : begin + end - 1 - p );

    // The same order once more, on one member only: it is its own inverse.
    auto vector = Cabana::slice<1>( particles );
    Cabana::permute( order, vector );
    host = toHost( particles );
    for ( int p = 0; p < num_particle; ++p )
    {
        EXPECT_EQ( Cabana::slice<1>( host )( p, 2 ), value( p, 2 ) );
        EXPECT_EQ( Cabana::slice<2>( host )( p ),
                   value( p < begin || p >= end ? p : begin + end - 1 - p ) );
    }
}

TEST( Cabana, SortByKeyOrdersNumbersOfEitherSign )
{
    // A permutation of -500.5 ... 499.5, since 617 and 1000 share no divisor.
    const int n = 1000;
    const auto key = []( const int p ) { return ( 617 * p ) % n - 500.5; };
    const auto order = orderOf( Cabana::sortByKey( makeKeys<Real>( n, key ) ) );
    ASSERT_EQ( int( order.size() ), n );
    for ( int q = 0; q < n; ++q )
        EXPECT_EQ( key( order[q] ), q - 500.5 );
}

TEST( Cabana, SimdParallelForCoversEachParticleOnce )
{
    // Ranges that start or end at, before and inside a struct's last place.
    const std::vector<std::pair<int, int>> ranges = {
        { 0, num_particle }, { 0, 16 }, { 5, 19 }, { 9, 12 }, { 8, 9 } };
    for ( const auto& [begin, end] : ranges )
    {
        AoSoA particles( "particles", num_particle );
        auto count = Cabana::slice<3>( particles );
        Cabana::deep_copy( count, 0 );
        visit( count, begin, end );
        const HostAoSoA host = toHost( particles );
        for ( int p = 0; p < num_particle; ++p )
            EXPECT_EQ( Cabana::slice<3>( host )( p ), begin <= p && p < end )
                << "particle " << p << " of " << begin << " to " << end;
    }
}

} // namespace
