// Several particles at once: every operation that kernels use gives each
// particle what it gives a single one.
#include "few_turns.hpp"
#include "tolerance.hpp"

#include <core/lane_members.hpp>
#include <core/lane_rows.hpp>
#include <core/node_sum.hpp>
#include <core/particles.hpp>
#include <core/power.hpp>
#include <core/products.hpp>
#include <core/profile.hpp>

#include <Cabana_Core.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

using namespace Machpoint;
using Test::FewTurnsUnshared;
using Test::tolerance;

namespace
{

using Members = Cabana::MemberTypes<Real[2], Real>;
using AoSoA = ParticleArray<Members>;

// Three packs, the last of which is not full (or, on a GPU, three particles).
constexpr int n = 2 * lane_count + ( lane_count + 1 ) / 2;

//! Numbers on both sides of zero and of each other; y's are positive.
AoSoA makeNumbers()
{
    AoSoA numbers( "numbers", n );
    const auto x = Cabana::slice<0>( numbers );
    const auto y = Cabana::slice<1>( numbers );
    Kokkos::parallel_for(
        "fill", Range( 0, n ), KOKKOS_LAMBDA( const int p ) {
            x( p, 0 ) = 0.37 * ( p % 7 ) - 1.1;
            x( p, 1 ) = 0.53 * ( p % 5 ) - 0.9;
            y( p ) = 0.21 + 0.19 * p;
        } );
    return numbers;
}

constexpr int operations = 17;

//! Result `which` of the operations on a, b and c > 0.
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number operate( const int which, const Number& a,
                                            const Number& b, const Number& c )
{
    const Number one( 1.0 ), zero( 0.0 );
    switch ( which )
    {
    case 0:
        return a + b * c;
    case 1:
        return ( a - b ) / c;
    case 2:
        return 1 - 2 * a;
    case 3:
        return choose( a < b, one, zero );
    case 4:
        return choose( a <= b && a <= a, one, zero );
    case 5:
        return choose( b < a && zero < a, one, zero );
    case 6:
        return choose( b < a || zero < a, one, zero );
    case 7:
        return choose( !( a < zero ), one, zero );
    case 8:
        return Kokkos::floor( a );
    case 9:
        return Kokkos::sqrt( c );
    case 10:
        return Kokkos::abs( a );
    case 11:
        return Kokkos::max( a, b );
    case 12:
        return Kokkos::min( a, b );
    case 13:
        return clip( a, Number( -0.5 ), Number( 0.5 ) );
    case 14:
        return clip( Number( zero / ( c - c ) ), Number( -0.5 ), one );
    case 15:
        return exponential( a );
    default:
        return powerNearOne( Number( c - 1 ), -1.4 );
    }
}

//! Results of all particles, one by one or in packs. [operations][n]
template <bool Together>
Kokkos::View<Real**, Kokkos::HostSpace> results()
{
    AoSoA numbers = makeNumbers();
    AoSoA out( "out", n );
    Kokkos::View<Real**, Kokkos::HostSpace> all( "all", operations, n );
    const auto x = Cabana::slice<0>( numbers );
    const auto y = Cabana::slice<1>( numbers );
    const auto result = Cabana::slice<1>( out );
    for ( int which = 0; which < operations; ++which )
    {
        if ( Together )
            forEachPack(
                "together", n, KOKKOS_LAMBDA( const Pack p ) {
                    store( result,
                           operate( which, load( x, p, 0 ), load( x, p, 1 ),
                                    load( y, p ) ),
                           p );
                } );
        else
            Kokkos::parallel_for(
                "alone", Range( 0, n ), KOKKOS_LAMBDA( const int p ) {
                    store( result,
                           operate( which, load( x, p, 0 ), load( x, p, 1 ),
                                    load( y, p ) ),
                           p );
                } );
        const auto host =
            Cabana::create_mirror_view_and_copy( Kokkos::HostSpace(), out );
        for ( int p = 0; p < n; ++p )
            all( which, p ) = Cabana::slice<1>( host )( p );
    }
    return all;
}

TEST( Lanes, operateLikeSingleNumbers )
{
    const auto alone = results<false>();
    const auto together = results<true>();
    for ( int which = 0; which < operations; ++which )
        for ( int p = 0; p < n; ++p )
            EXPECT_REAL_EQ( together( which, p ), alone( which, p ) )
                << "operation " << which << ", particle " << p;
}

//! Particles of several tiles that do not read what packs wrote, or whose
//! neighbours a pack has changed.
int wrongAcrossTiles()
{
    const int many = 2 * AoSoA::vector_length + n;
    const AoSoA numbers( "numbers", many );
    const auto x = Cabana::slice<0>( numbers );
    const auto y = Cabana::slice<1>( numbers );
    Kokkos::parallel_for(
        "alone", Range( 0, many ), KOKKOS_LAMBDA( const int p ) {
            x( p, 0 ) = p;
            x( p, 1 ) = -1;
            y( p ) = -1;
        } );
    forEachPack(
        "together", many, KOKKOS_LAMBDA( const Pack p ) {
            store( x, 2 * load( x, p, 0 ), p, 1 );
        } );
    int wrong = 0;
    Kokkos::parallel_reduce(
        "alone", Range( 0, many ),
        KOKKOS_LAMBDA( const int p, int& sum ) {
            sum += x( p, 0 ) == p && x( p, 1 ) == 2 * p && y( p ) == -1 ? 0 : 1;
        },
        wrong );
    return wrong;
}

// What packs write, particles read, and the other way round.
TEST( Lanes, crossTiles )
{
    EXPECT_EQ( wrongAcrossTiles(), 0 );
}

using FloatMembers = Cabana::MemberTypes<Real, float[3], Real>;

//! Writes y, three floats and -y of every particle, past the cache or not, and
//! reads them again. [n][5]
Kokkos::View<Real**, Kokkos::HostSpace> amongFloats( const bool streams )
{
    const AoSoA numbers = makeNumbers();
    const ParticleArray<FloatMembers> members( "members", n );
    const Kokkos::View<Real**, Kokkos::LayoutRight, MemorySpace> read( "read",
                                                                       n, 5 );
    const auto y = Cabana::slice<1>( numbers );
    const auto front = Cabana::slice<0>( members );
    const auto floats = Cabana::slice<1>( members );
    const auto back = Cabana::slice<2>( members );
    forEachPack(
        "write", n, KOKKOS_LAMBDA( const Pack p ) {
            const Lanes value = load( y, p );
            store( Written<decltype( front )>{ front, streams }, value, p );
            for ( int c = 0; c < 3; ++c )
                store( Written<decltype( floats )>{ floats, streams },
                       Lanes( value + c ), p, c );
            store( Written<decltype( back )>{ back, streams },
                   Lanes( 0.0_rt - value ), p );
        } );
    forEachPack(
        "read", n, KOKKOS_LAMBDA( const Pack p ) {
            auto keep = [&]( const int c, const Lanes& value )
            {
                for ( int l = 0; l < p.count; ++l )
                    read( p.first + l, c ) = lane( value, l );
            };
            keep( 0, load( front, p ) );
            for ( int c = 0; c < 3; ++c )
                keep( 1 + c, load( floats, p, c ) );
            keep( 4, load( back, p ) );
        } );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), read );
    const Kokkos::View<Real**, Kokkos::HostSpace> all( "all", n, 5 );
    Kokkos::deep_copy( all, host );
    return all;
}

TEST( Lanes, roundFloatsInMemoryAndNothingBesideThem )
{
    for ( const bool streams : { false, true } )
    {
        const auto read = amongFloats( streams );
        for ( int p = 0; p < n; ++p )
        {
            const Real y = read( p, 0 );
            EXPECT_REAL_EQ( y, 0.21 + 0.19 * p );
            for ( int c = 0; c < 3; ++c )
                EXPECT_EQ( read( p, 1 + c ), static_cast<float>( y + c ) )
                    << "particle " << p << ", float " << c;
            EXPECT_EQ( read( p, 4 ), -y );
        }
    }
}

//! How often a loop of `count` turns takes each, and one beyond the last.
IndexList::HostMirror turnsOf( const int count )
{
    const IndexList taken( "taken", count + 1 );
    forEach(
        "take", count,
        KOKKOS_LAMBDA( const int i ) { Kokkos::atomic_inc( &taken( i ) ); } );
    return Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), taken );
}

// Fewer turns than threads, or as many as one takes, or one more, or a number
// that they cannot share evenly.
TEST( ForEach, takesEveryTurnOnce )
{
    for ( const int count : { 0, 1, 2, 3, 7, few_rows, few_rows + 1, 1001 } )
    {
        const auto taken = turnsOf( count );
        for ( int i = 0; i < count; ++i )
            EXPECT_EQ( taken( i ), 1 ) << "turn " << i << " of " << count;
        EXPECT_EQ( taken( count ), 0 );
    }
}

//! Notes on the host who was called for which turns.
struct Calls
{
    IndexList first; // of each call, at the place of the call's last turn
    void operator()( const int begin, const int end ) const
    {
        if ( end > begin )
            first( end - 1 ) = begin;
    }
};

// A second thread is called for more turns than `few`, and then for its share;
// a profiler hears of a loop in either case.
TEST( ForEach, leavesFewTurnsToOneThread )
{
    if constexpr ( runs_on_host )
    {
        const FewTurnsUnshared unshared;
        Profile::start();
        constexpr int few = 6;
        for ( const int count : { few, 4 * few } )
        {
            const IndexList first( "first", count );
            Kokkos::deep_copy( first, -1 );
            const auto kernels = Profile::kernels();
            forEachShare( "few", count, few, Calls{ first } );
            EXPECT_EQ( Profile::kernels() - kernels, 1 );
            const int threads = count > few ? loopThreads() : 1;
            const int share = ( count + threads - 1 ) / threads;
            for ( int i = 0; i < count; ++i )
                EXPECT_EQ( first( i ), i == count - 1 || ( i + 1 ) % share == 0
                                           ? i / share * share
                                           : -1 )
                    << "turn " << i << " of " << count;
        }
    }
    else
        GTEST_SKIP() << "a thread of a GPU takes one turn";
}

//! A sum in two parts.
struct TwoSums
{
    int ones = 0, turns = 0;
    KOKKOS_INLINE_FUNCTION TwoSums& operator+=( const TwoSums& other )
    {
        ones += other.ones;
        turns += other.turns;
        return *this;
    }
};

//! What reductions into a struct and into two reducers find in i % 7 - 3 of all
//! turns i; a profiler hears of each once.
void expectReduction( const int count )
{
    TwoSums sums{ 99, 99 };
    int least = 99, most = 99;
    const auto kernels = Profile::kernels();
    reduceEach(
        "sum", count, few_rows,
        KOKKOS_LAMBDA( const int i, TwoSums& sum ) {
            sum += TwoSums{ i % 7 == 4 ? 1 : 0, 1 };
        },
        sums );
    reduceEach(
        "extremes", count, few_rows,
        KOKKOS_LAMBDA( const int i, int& min, int& max ) {
            min = Kokkos::min( min, i % 7 - 3 );
            max = Kokkos::max( max, i % 7 - 3 );
        },
        Kokkos::Min<int>( least ), Kokkos::Max<int>( most ) );
    EXPECT_EQ( Profile::kernels() - kernels, 2 );
    EXPECT_EQ( sums.turns, count );
    EXPECT_EQ( sums.ones, ( count + 2 ) / 7 );
    EXPECT_EQ( least, count > 0 ? -3 : Kokkos::reduction_identity<int>::min() );
    EXPECT_EQ( most, count > 0 ? Kokkos::min( count - 1, 6 ) - 3
                               : Kokkos::reduction_identity<int>::max() );
}

//! Every third turn listed by a scan.
void expectScan( const int count )
{
    const IndexList thirds( "thirds", count + 1 );
    const int found = scanEach(
        "scan", count, few_rows,
        KOKKOS_LAMBDA( const int i, int& k, const bool final ) {
            if ( i % 3 != 0 )
                return;
            if ( final )
                thirds( k ) = i;
            ++k;
        } );
    ASSERT_EQ( found, ( count + 2 ) / 3 );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), thirds );
    for ( int k = 0; k < found; ++k )
        EXPECT_EQ( host( k ), 3 * k );
}

// Short ones, which the host runs, longer ones, and short ones that are shared.
TEST( ForEach, reducesAndScansAsOneThreadDoes )
{
    Profile::start();
    const auto expectAll = []
    {
        for ( const int count : { 0, 1, 2, 20, few_rows, few_rows + 1, 5001 } )
        {
            expectReduction( count );
            expectScan( count );
        }
    };
    expectAll();
    const FewTurnsUnshared unshared;
    expectAll();
}

//! Largest and smallest y of all packs, and how many particles they have.
Kokkos::Array<Real, 3> extremes()
{
    AoSoA numbers = makeNumbers();
    const auto y = Cabana::slice<1>( numbers );
    Real most = 0, least = 0, count = 0;
    Kokkos::parallel_reduce(
        "extremes", Range( 0, countPacks( n ) ),
        KOKKOS_LAMBDA( const int k, Real& max, Real& min, Real& sum ) {
            const Pack p = Pack::of( k, n );
            const auto inside = active( p );
            max = Kokkos::max(
                max, largest( choose( inside, load( y, p ), Lanes( -1e9 ) ) ) );
            min = Kokkos::min(
                min, smallest( choose( inside, load( y, p ), Lanes( 1e9 ) ) ) );
            sum += Machpoint::any( inside ) ? p.count : 0;
        },
        Kokkos::Max<Real>( most ), Kokkos::Min<Real>( least ),
        Kokkos::Sum<Real>( count ) );
    return { most, least, count };
}

TEST( Lanes, countNoParticleBeyondTheLast )
{
    const auto found = extremes();
    EXPECT_REAL_EQ( found[0], 0.21 + 0.19 * ( n - 1 ) );
    EXPECT_REAL_EQ( found[1], 0.21 );
    EXPECT_EQ( found[2], n );
}

//! Adds K columns to nodes that neighbours share, and reads them back; from
//! column 1 on.
template <int K, bool Together>
Kokkos::View<Real**, Kokkos::LayoutRight, Kokkos::HostSpace> sumOfColumns()
{
    constexpr int nodes = 5;
    AoSoA numbers = makeNumbers();
    const auto y = Cabana::slice<1>( numbers );
    const NodeView field( "field", nodes + 1, paddedColumns( K ) + 1 );
    const NodeScatter scatter( field );
    scatter.clear();
    if ( Together )
        forEachPack(
            "together", n, KOKKOS_LAMBDA( const Pack p ) {
                const Lanes first = Kokkos::floor( load( y, p ) * 0.9_rt );
                Bases<Lanes> base{};
                advance( base, clip( first, Lanes( 0.0 ), Lanes( 4.0 ) ), 1 );
                Lanes values[K];
                for ( int c = 0; c < K; ++c )
                    values[c] = load( y, p ) + c;
                addColumns( scatter.thread().access(
                                p, base, StencilRows<1>{ 2, { 1 } } ),
                            p, rowAt( base, 1 ), 1, values );
            } );
    else
        Kokkos::parallel_for(
            "alone", Range( 0, n ), KOKKOS_LAMBDA( const int p ) {
                const Real first = Kokkos::floor( y( p ) * 0.9_rt );
                int base = 0;
                advance( base, clip( first, 0.0_rt, 4.0_rt ), 1 );
                Real values[K];
                for ( int c = 0; c < K; ++c )
                    values[c] = y( p ) + c;
                addColumns( scatter.thread().access(
                                p, base, StencilRows<1>{ 2, { 1 } } ),
                            p, rowAt( base, 1 ), 1, values );
            } );
    scatter.contribute();
    return Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), field );
}

template <int K>
void checkColumns()
{
    const auto alone = sumOfColumns<K, false>();
    const auto together = sumOfColumns<K, true>();
    Real total = 0;
    for ( std::size_t i = 0; i < alone.extent( 0 ); ++i )
        for ( std::size_t c = 0; c < alone.extent( 1 ); ++c )
        {
            EXPECT_NEAR( together( i, c ), alone( i, c ), tolerance( 1e-12 ) )
                << K << " columns, node " << i << ", column " << c;
            total += alone( i, c );
        }
    EXPECT_GT( total, 1 );
}

TEST( Lanes, addColumnsToNodes )
{
    checkColumns<1>();
    checkColumns<2>();
    checkColumns<3>();
    checkColumns<4>();
    checkColumns<5>();
    checkColumns<7>();
    checkColumns<8>();
    checkColumns<9>();
}

//! Column 1 of the node at the floor of y, read by packs. [n]
Kokkos::View<Real*, Kokkos::HostSpace> readNodes()
{
    AoSoA numbers = makeNumbers();
    const auto y = Cabana::slice<1>( numbers );
    const NodeView field( "field", n, 3 );
    Kokkos::parallel_for(
        "nodes", Range( 0, n ),
        KOKKOS_LAMBDA( const int i ) { field( i, 1 ) = 10 + i; } );
    forEachPack(
        "read", n, KOKKOS_LAMBDA( const Pack p ) {
            Bases<Lanes> base{};
            advance( base,
                     Kokkos::floor(
                         clip( load( y, p ), Lanes( 0.0 ), Lanes( n - 2.0 ) ) ),
                     1 );
            store( y, at( field, rowAt( base, 1 ), 1 ), p );
        } );
    const auto host =
        Cabana::create_mirror_view_and_copy( Kokkos::HostSpace(), numbers );
    Kokkos::View<Real*, Kokkos::HostSpace> read( "read", n );
    for ( int p = 0; p < n; ++p )
        read( p ) = Cabana::slice<1>( host )( p );
    return read;
}

TEST( Lanes, readNodes )
{
    const auto read = readNodes();
    for ( int p = 0; p < n; ++p )
    {
        const Real y = std::min<Real>( 0.21 + 0.19 * p, n - 2.0 );
        EXPECT_EQ( read( p ), 11 + std::floor( y ) ) << p;
    }
}

//! y of the particles, stored by packs. \param streams past the cache
AoSoA storeNumbers( const bool streams )
{
    AoSoA numbers = makeNumbers();
    AoSoA stored( "stored", n );
    const auto x = Cabana::slice<0>( numbers );
    const auto y = Cabana::slice<1>( numbers );
    const Written new_x{ Cabana::slice<0>( stored ), streams };
    const Written new_y{ Cabana::slice<1>( stored ), streams };
    forEachPack(
        "store", n, KOKKOS_LAMBDA( const Pack p ) {
            for ( int d = 0; d < 2; ++d )
                store( new_x, load( x, p, d ), p, d );
            store( new_y, load( y, p ), p );
        } );
    return stored;
}

TEST( Lanes, storePacksThroughTheCacheOrPastIt )
{
    const auto host = []( const AoSoA& aosoa ) {
        return Cabana::create_mirror_view_and_copy( Kokkos::HostSpace(),
                                                    aosoa );
    };
    const auto numbers = host( makeNumbers() );
    for ( const bool streams : { false, true } )
    {
        const auto stored = host( storeNumbers( streams ) );
        for ( int p = 0; p < n; ++p )
        {
            for ( int d = 0; d < 2; ++d )
                EXPECT_EQ( Cabana::slice<0>( stored )( p, d ),
                           Cabana::slice<0>( numbers )( p, d ) )
                    << p << streams;
            EXPECT_EQ( Cabana::slice<1>( stored )( p ),
                       Cabana::slice<1>( numbers )( p ) )
                << p << streams;
        }
    }
}

//! K columns of the node at the floor of y from the first on, by packs: of
//! particle p the number of wrong ones. [n]
template <std::size_t K>
Kokkos::View<int*, Kokkos::HostSpace> wrongColumns( const int first )
{
    AoSoA numbers = makeNumbers();
    const auto y = Cabana::slice<1>( numbers );
    // An even number, as single lanes read two at once.
    const std::size_t columns = ( first + K ) / 2 * 2 + 2;
    const NodeView field( "field", n, columns );
    Kokkos::parallel_for(
        "nodes", Range( 0, n ), KOKKOS_LAMBDA( const int i ) {
            for ( std::size_t c = 0; c < columns; ++c )
                field( i, c ) = 100 * i + static_cast<Real>( c );
        } );
    const IndexList wrong( "wrong", n );
    forEachPack(
        "read", n, KOKKOS_LAMBDA( const Pack p ) {
            const Lanes node = Kokkos::floor(
                clip( load( y, p ), Lanes( 0.0 ), Lanes( n - 2.0 ) ) );
            Bases<Lanes> base{};
            advance( base, node, 1 );
            Lanes values[K];
            loadRow( field, rowAt( base, 1 ), values, first );
            for ( std::size_t c = 0; c < K; ++c )
                for ( int l = 0; l < p.count; ++l )
                    wrong( p.first + l ) +=
                        lane( values[c], l ) !=
                                100 * ( lane( node, l ) + 1 ) +
                                    static_cast<Real>( first + c )
                            ? 1
                            : 0;
        } );
    return Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), wrong );
}

template <std::size_t K>
void checkRows()
{
    for ( const int first : { 0, 4, 7 } )
    {
        if ( lane_count == 1 && K % 2 == 0 && first % 2 == 1 )
            continue; // two at once begin with an even one
        const auto wrong = wrongColumns<K>( first );
        for ( int p = 0; p < n; ++p )
            EXPECT_EQ( wrong( p ), 0 )
                << K << " columns from " << first << ", particle " << p;
    }
}

TEST( Lanes, readRowsOfNodes )
{
    checkRows<1>();
    checkRows<2>();
    checkRows<3>();
    checkRows<4>();
    checkRows<5>();
    checkRows<7>();
    checkRows<8>();
}

//! Row p of a pack moves from p by 2 floor(y - 2) and by 50 more; which of
//! these packs are within [first, end).
std::vector<int> packsWithin( const int first, const int end )
{
    AoSoA numbers = makeNumbers();
    const auto y = Cabana::slice<1>( numbers );
    const int packs = countPacks( n );
    const IndexList within( "within", packs );
    forEachPack(
        "within", n, KOKKOS_LAMBDA( const Pack p ) {
            Bases<Lanes> base{};
            advance( base, Kokkos::floor( load( y, p ) - 2 ), 2 );
            advance( base, Lanes( 1.0 ), 50 );
            within( p.first / lane_count ) = areWithin( p, base, first, end );
        } );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), within );
    return { host.data(), host.data() + packs };
}

TEST( Lanes, moveRowsAndCompareThoseOfParticles )
{
    std::vector<int> rows( n );
    for ( int p = 0; p < n; ++p )
        rows[p] = 50 + 2 * static_cast<int>( std::floor(
                               Real( 0.21 ) + Real( 0.19 ) * p - 2 ) );
    for ( const int first : { 0, 46, 47, 48, 49, 60 } )
        for ( const int end : { 0, 47, 48, 52, 53, 54, 1000 } )
        {
            const auto found = packsWithin( first, end );
            for ( int k = 0; k < static_cast<int>( found.size() ); ++k )
            {
                const Pack p = Pack::of( k, n );
                bool expected = true;
                for ( int q = p.first; q < p.first + p.count; ++q )
                    expected = expected && first <= rows[q] && rows[q] < end;
                EXPECT_EQ( found[k], expected )
                    << "pack " << k << ", " << first << " to " << end;
            }
        }
}

TEST( Power, isAccurateWhereKernelsNeedIt )
{
    // To fifth order, and of the right size far from 1.
    for ( const Real y : { -7.0, -4.4, -1.67, -1.4, -1.01, 2.0 } )
    {
        for ( const Real a : { -0.2, -0.1, -0.01, 0.05, 0.15, 0.2 } )
        {
            const Real leading =
                y * ( y * y - 4 ) * ( y * y - 16 ) / 11520 * std::pow( a, 5 );
            EXPECT_NEAR( powerNearOne( a, y ) / std::pow( 1 + a, y ), 1,
                         2 * std::abs( leading ) + tolerance( 1e-14 ) );
        }
        Real last = powerNearOne( -0.6, y );
        for ( Real a = -0.5; a < 1.05; a += 0.1 )
        {
            const Real next = powerNearOne( a, y );
            EXPECT_EQ( next < last, y < 0 ) << a << " " << y;
            EXPECT_GT( next, 0 );
            last = next;
        }
    }
    for ( const Real x : { -1.0, -0.3, -1e-9, 0.0, 1e-3, 1.0 } )
        EXPECT_NEAR( exponential( x ) / std::exp( x ), 1, tolerance( 1e-13 ) );
    EXPECT_NEAR( exponential( -5.0 ) / std::exp( -5.0 ), 1, 1e-8 );
    // Uniform gas stays as it is, to the last bit.
    EXPECT_EQ( exponential( 0.0 ), 1.0 );
    EXPECT_EQ( powerNearOne( 0.0, -1.4 ), 1.0 );
    // A step far too long still leaves a volume.
    EXPECT_EQ( exponential( -300.0 ), exponential( -5.0 ) );
}

} // namespace
