// Particles, their sidecars, and the modules' registry.
#include "scenes.hpp"

#include <core/large_pages.hpp>
#include <core/particles.hpp>
#include <core/registry.hpp>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <set>
#include <string>

namespace
{

using namespace Machpoint;

//! Numbers n particles, and a sidecar that repeats each one's id.
using Label = Cabana::MemberTypes<std::int64_t>;
void number( Particles<2>& particles, Sidecar<Label>& sidecar, const int n )
{
    particles.resize( n );
    const auto id = particles.slice<Id>();
    const auto mass = particles.slice<Mass>();
    const auto L = particles.slice<VelocityGradient>();
    const auto label = Cabana::slice<0>( sidecar.data() );
    Kokkos::parallel_for(
        "number", Range( 0, n ), KOKKOS_LAMBDA( const int p ) {
            id( p ) = p;
            mass( p ) = 0.5 * p;
            for ( int c = 0; c < 4; ++c )
                L( p, c / 2, c % 2 ) = 4 * p + c;
            label( p ) = p;
        } );
}

//! The ids in order, having checked that masses, velocity gradients and sidecar
//! belong to them.
std::vector<std::int64_t> ids( const Particles<2>& particles,
                               Sidecar<Label>& sidecar )
{
    const auto host = particles.toHost();
    const auto labels = Cabana::create_mirror_view_and_copy(
        Kokkos::HostSpace(), sidecar.data() );
    const auto id = host.slice<Id>();
    const auto mass = host.slice<Mass>();
    const auto L = host.slice<VelocityGradient>();
    const auto label = Cabana::slice<0>( labels );
    std::vector<std::int64_t> list;
    for ( std::size_t p = 0; p < host.size(); ++p )
    {
        list.push_back( id( p ) );
        EXPECT_EQ( mass( p ), 0.5 * static_cast<Real>( id( p ) ) );
        for ( int c = 0; c < 4; ++c )
            EXPECT_EQ( L( p, c / 2, c % 2 ),
                       4 * static_cast<Real>( id( p ) ) + c );
        EXPECT_EQ( label( p ), id( p ) );
    }
    return list;
}

// Kernels stand in free functions: nvcc takes none from a test's body.

//! Writes n numbers to member M of a sidecar.
template <std::size_t M, class Members>
void numberSidecar( Sidecar<Members>& sidecar, const int n )
{
    const auto label = Cabana::slice<M>( sidecar.data() );
    Kokkos::parallel_for(
        "numberSidecar", Range( 0, n ),
        KOKKOS_LAMBDA( const int p ) { label( p ) = p; } );
}

//! A new state that nobody wants.
void spoilNext( Particles<2>& particles, Sidecar<Label>& sidecar )
{
    const auto L = particles.next<VelocityGradient>().slice;
    const auto label = Cabana::slice<0>( sidecar.next() );
    Kokkos::parallel_for(
        "spoilNext", Range( 0, particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            label( p ) = -7;
            for ( int c = 0; c < 4; ++c )
                L( p, c / 2, c % 2 ) = -7;
        } );
}

//! Member M of a sidecar, whole numbers.
template <std::size_t M, class Members>
std::vector<std::int64_t> labels( Sidecar<Members>& sidecar )
{
    const auto host = Cabana::create_mirror_view_and_copy( Kokkos::HostSpace(),
                                                           sidecar.data() );
    const auto label = Cabana::slice<M>( host );
    std::vector<std::int64_t> list;
    for ( std::size_t p = 0; p < host.size(); ++p )
        list.push_back( label( p ) );
    return list;
}

//! Every stride-th of n rows.
IndexList everyRow( const int n, const int stride )
{
    IndexList rows( "rows", ( n + stride - 1 ) / stride );
    Kokkos::parallel_for(
        "everyRow", Range( 0, rows.extent_int( 0 ) ),
        KOKKOS_LAMBDA( const int k ) { rows( k ) = stride * k; } );
    return rows;
}

//! Appends copies with half the mass and new ids, as halving does.
void halve( Particles<2>& particles, const IndexList& rows )
{
    const int n = particles.size();
    particles.duplicate( rows );
    const auto id = particles.slice<Id>();
    const auto mass = particles.slice<Mass>();
    Kokkos::parallel_for(
        "halve", Range( 0, rows.extent_int( 0 ) ),
        KOKKOS_LAMBDA( const int k ) {
            id( n + k ) = 1000 + k;
            mass( n + k ) *= 0.5;
            mass( rows( k ) ) *= 0.5;
        } );
}

//! Keys that fall as the particle's number grows, seven particles to a key.
IndexList fallingKeys( const int n )
{
    IndexList keys( "keys", n );
    Kokkos::parallel_for(
        "keys", Range( 0, n ),
        KOKKOS_LAMBDA( const int p ) { keys( p ) = ( n - 1 - p ) / 7; } );
    return keys;
}

//! Notes every stride-th of n rows, the last first.
void noteRows( const RowList& list, const int n, const int stride )
{
    Kokkos::parallel_for(
        "noteRows", Range( 0, n ), KOKKOS_LAMBDA( const int k ) {
            const int p = n - 1 - k;
            if ( p % stride == 0 )
                list.note( p );
        } );
}

//! Notes the particles lighter than a mass, a pack at a time.
void noteLight( const RowList& list, const Particles<2>& particles,
                const Real most )
{
    const auto mass = particles.slice<Mass>();
    const int n = particles.size();
    forEachPack(
        "noteLight", n, KOKKOS_LAMBDA( const Pack p ) {
            list.note( p, active( p ) && load( mass, p ) < Lanes( most ) );
        } );
}

//! The rows of a list. \param stride of those noted
std::vector<int> rowsOf( const RowList& list, const int n, const int stride )
{
    const auto rows = list.rows(
        n, KOKKOS_LAMBDA( const int p ) { return p % stride == 0; } );
    const auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), rows );
    return { host.data(), host.data() + host.size() };
}

TEST( RowList, hasWhatWasNotedInOrder )
{
    const int n = 40003;
    RowList list;
    // Few, and more than it has room for.
    for ( const int stride : { 1000, 2, n } )
    {
        list.clear( n );
        noteRows( list, n, stride );
        std::vector<int> expected;
        for ( int p = 0; p < n; p += stride )
            expected.push_back( p );
        EXPECT_EQ( list.count(), expected.size() );
        EXPECT_EQ( rowsOf( list, n, stride ), expected );
    }
}

TEST( RowList, takesLanesOfPacks )
{
    Particles<2> particles;
    auto& sidecar =
        particles.addSidecar<Label>( "labels", DuringStep::changes );
    for ( const int n : { 3, 21 } )
    {
        number( particles, sidecar, n );
        for ( const int below : { 0, 2, 13, 100 } )
        {
            RowList list;
            list.clear( n );
            noteLight( list, particles, 0.5 * below );
            std::vector<int> expected( std::min( n, below ) );
            std::iota( expected.begin(), expected.end(), 0 );
            EXPECT_EQ( rowsOf( list, n, 1 ), expected );
        }
    }
}

TEST( Particles, removalKeepsAllOthersWithTheirSidecars )
{
    Particles<2> particles;
    auto& sidecar =
        particles.addSidecar<Label>( "labels", DuringStep::changes );
    const int n = 1000;
    for ( const int stride : { 3, 1, 999 } )
    {
        number( particles, sidecar, n );
        const auto rows = everyRow( n, stride );
        particles.remove( rows );
        EXPECT_EQ( particles.size(), n - rows.extent_int( 0 ) );
        auto left = ids( particles, sidecar );
        std::sort( left.begin(), left.end() );
        std::vector<std::int64_t> expected;
        for ( int p = 0; p < n; ++p )
            if ( p % stride != 0 )
                expected.push_back( p );
        EXPECT_EQ( left, expected );
    }
}

// One that enters anew has an id and a mass, and no former life.
TEST( Particles, forgettingClearsSidecarsAlone )
{
    Particles<2> particles;
    auto& sidecar =
        particles.addSidecar<Label>( "labels", DuringStep::changes );
    auto& other = particles.addSidecar<Label>( "other", DuringStep::stays );
    const int n = 21;
    number( particles, sidecar, n );
    numberSidecar<0>( other, n );
    auto rows = everyRow( n, 4 );
    Kokkos::deep_copy( Kokkos::subview( rows, 2 ), -1 ); // none
    particles.forget( rows );
    const auto host = particles.toHost();
    const auto a = labels<0>( sidecar ), b = labels<0>( other );
    for ( int p = 0; p < n; ++p )
    {
        EXPECT_EQ( host.slice<Id>()( p ), p );
        EXPECT_EQ( host.slice<Mass>()( p ), 0.5 * p );
        const int kept = p % 4 == 0 && p != 8 ? 0 : p;
        EXPECT_EQ( a[p], kept );
        EXPECT_EQ( b[p], kept );
    }
}

TEST( Particles, sortingCarriesSidecarsAlong )
{
    Particles<2> particles;
    auto& sidecar =
        particles.addSidecar<Label>( "labels", DuringStep::changes );
    // Fits into the memory of an old state; does not; need not come along.
    auto& small = particles.addSidecar<Label>( "small", DuringStep::stays );
    auto& large =
        particles.addSidecar<Cabana::MemberTypes<Real[20], std::int64_t>>(
            "large", DuringStep::stays );
    auto& rates = particles.addSidecar<Label>( "rates", DuringStep::renews );
    const int n = 500;
    for ( const bool has_old : { false, true } )
    {
        number( particles, sidecar, n );
        particles.beginStep( has_old );
        particles.endStep();
        number( particles, sidecar, n );
        numberSidecar<0>( small, n );
        numberSidecar<1>( large, n );
        numberSidecar<0>( rates, n );
        particles.permute(
            Cabana::binByKey( fallingKeys( n ), ( n - 1 ) / 7 + 1 ) );
        const auto order = ids( particles, sidecar );
        for ( int p = 1; p < n; ++p )
            EXPECT_LE( ( n - 1 - order[p - 1] ) / 7, ( n - 1 - order[p] ) / 7 );
        EXPECT_EQ( labels<0>( small ), order );
        EXPECT_EQ( labels<1>( large ), order );
        for ( int p = 0; p < n; ++p )
            EXPECT_EQ( labels<0>( rates )[p], p );
    }
}

// Whatever has been halved, removed and added since the step, masses and ids
// return to theirs.
TEST( Particles, restoringGivesBackMassesAndIds )
{
    Particles<2> particles;
    auto& sidecar =
        particles.addSidecar<Label>( "labels", DuringStep::changes );
    const int n = 100;
    number( particles, sidecar, n );
    for ( const bool changes : { true, false, true } )
    {
        particles.beginStep( true );
        particles.endStep();
        if ( changes )
        {
            const auto large = everyRow( n, 10 );
            particles.keepIdentities( large );
            halve( particles, large );
            for ( const int stride : { 3, 2 } )
                particles.remove( everyRow( particles.size(), stride ) );
            EXPECT_LT( particles.size(), n / 2 );
            const int rest = particles.size();
            particles.duplicate( everyRow( rest, 1 ) ); // as if they arrived
            EXPECT_EQ( particles.size(), 2 * rest );
        }
        particles.restore();
        const auto list = ids( particles, sidecar );
        ASSERT_EQ( list.size(), 100u );
        for ( int p = 0; p < n; ++p )
            EXPECT_EQ( list[p], p );
    }
}

// A checkpoint tells sidecars by their labels.
TEST( Particles, noTwoSidecarsHaveOneLabel )
{
    Particles<1> particles;
    particles.addSidecar<Label>( "one", DuringStep::stays );
    particles.addSidecar<Label>( "two", DuringStep::stays );
    EXPECT_THROW( particles.addSidecar<Label>( "one", DuringStep::renews ),
                  std::logic_error );
}

// Rows are ints: more would be negative ones.
TEST( Particles, noRankHasMoreThanItCanCount )
{
    Particles<1> particles;
    particles.resize( 2 );
    try
    {
        particles.resize( std::size_t{ 1 } << 31 );
        FAIL() << "took 2^31 particles";
    }
    catch ( const std::length_error& error )
    {
        const std::string message = error.what();
        EXPECT_NE( message.find( "2147483648 particles on one rank" ),
                   std::string::npos )
            << message;
        EXPECT_NE( message.find( "take more ranks" ), std::string::npos );
    }
    EXPECT_EQ( particles.size(), 2 );
}

// So do what kernels have written beside the old state, whether the step that
// is taken back has ended or not, and what it was to change with it.
TEST( Particles, restoringGivesBackTheOldState )
{
    for ( const bool has_ended : { false, true } )
    {
        Particles<2> particles;
        auto& sidecar =
            particles.addSidecar<Label>( "labels", DuringStep::changes );
        const int n = 100;
        number( particles, sidecar, n );
        particles.beginStep( true );
        spoilNext( particles, sidecar );
        if ( has_ended )
            particles.endStep();
        particles.restore();
        const auto list = ids( particles, sidecar ); // of labels and gradients
        ASSERT_EQ( list.size(), 100u );
        for ( int p = 0; p < n; ++p )
            EXPECT_EQ( list[p], p ) << has_ended;
    }
}

// There is none to return to where it was not kept, is taken back already, or
// has become scratch of a sort.
TEST( Particles, restoringNeedsAnOldState )
{
    Particles<2> particles;
    auto& sidecar =
        particles.addSidecar<Label>( "labels", DuringStep::changes );
    number( particles, sidecar, 10 );
    EXPECT_THROW( particles.restore(), std::logic_error );
    particles.beginStep( false );
    particles.endStep();
    EXPECT_THROW( particles.restore(), std::logic_error );
    particles.beginStep( true );
    particles.endStep();
    particles.restore();
    EXPECT_THROW( particles.restore(), std::logic_error );
    particles.beginStep( true );
    particles.endStep();
    particles.permute( Cabana::binByKey( fallingKeys( 10 ), 10 ) );
    EXPECT_THROW( particles.restore(), std::logic_error );
}

TEST( Particles, newSidecarEntriesAreZero )
{
    Particles<2> particles;
    auto& sidecar =
        particles.addSidecar<Label>( "labels", DuringStep::changes );
    number( particles, sidecar, 100 );
    particles.resize( 250 );
    const auto host = Cabana::create_mirror_view_and_copy( Kokkos::HostSpace(),
                                                           sidecar.data() );
    const auto label = Cabana::slice<0>( host );
    for ( int p = 0; p < 250; ++p )
        EXPECT_EQ( label( p ), p < 100 ? p : 0 );
    EXPECT_GE( particles.bytes(), 250 * ( sizeof( Real ) * ( 2 + 2 + 5 ) +
                                          sizeof( Deviation ) * 4 + 2 * 8 ) );
}

//! The flags of the mapping of an address, as Linux tells them.
std::string mappingFlags( const void* const address )
{
    std::ifstream maps( "/proc/self/smaps" );
    const auto place = reinterpret_cast<std::uintptr_t>( address );
    bool is_here = false;
    for ( std::string line; std::getline( maps, line ); )
    {
        std::uintptr_t begin = 0, end = 0;
        if ( std::sscanf( line.c_str(), "%" SCNxPTR "-%" SCNxPTR " ", &begin,
                          &end ) == 2 )
            is_here = begin <= place && place < end;
        else if ( is_here && line.starts_with( "VmFlags:" ) )
            return line + " ";
    }
    return "";
}

TEST( LargePages, areAskedForForWhatIsLargeAndKept )
{
    if ( !runs_on_host ||
         !std::filesystem::exists( "/sys/kernel/mm/transparent_hugepage" ) )
        GTEST_SKIP() << "no large pages here";
    askForLargePages();
    askForLargePages(); // once more changes nothing
    constexpr std::size_t size = std::size_t( 16 ) << 20; // bytes
    const Kokkos::View<char*, MemorySpace> ours( "Machpoint::large", size );
    const Kokkos::View<char*, MemorySpace> others( "Cabana::large", size );
    EXPECT_NE( mappingFlags( ours.data() + size / 2 ).find( " hg " ),
               std::string::npos );
    EXPECT_EQ( mappingFlags( others.data() + size / 2 ).find( " hg " ),
               std::string::npos );
}

#ifdef MACHPOINT_BACKEND_SERIAL
// Kokkos that knows threads, too, would keep some that spin beside the run: the
// tests ask for two (OMP_NUM_THREADS).
TEST( KokkosSession, runsOnOneThread )
{
    EXPECT_EQ( Kokkos::DefaultHostExecutionSpace().concurrency(), 1 );
}
#endif

// Everything in the lists can be found by name, once.
TEST( Registry, namesAreUniqueAndDeclared )
{
    for ( const auto& family :
          { physicsFamily(), boundaryFamily(), initialFamily() } )
        for ( const int dimension : { 0, 1, 2, 3 } )
        {
            std::set<std::string> names;
            for ( const auto& member : family.members( dimension ) )
            {
                EXPECT_TRUE( names.insert( member.name() ).second );
                EXPECT_FALSE( member.summary().empty() );
                for ( const auto& key : member.keys() )
                    EXPECT_FALSE( key.description.empty() )
                        << member.name() << " " << key.name;
            }
            EXPECT_GE( names.size(), 3u );
        }
}

} // namespace
