// Many ranks: the halo between them against that of the whole domain, particles
// that change ranks, the boxes that ranks have and how these follow the
// particles, and sums over ranks. Runs under mpirun; every rank checks its
// part.
#include "halos.hpp"
#include "tolerance.hpp"

#include <core/balance.hpp>
#include <core/halo.hpp>
#include <core/particles.hpp>
#include <core/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace
{

using namespace Machpoint;
using Test::makeHalo;
using Test::tolerance;

//! All ways to cut a domain of Dim axes into boxes for the ranks of the run.
template <int Dim>
std::vector<Indices<Dim>> allCuts( const int size )
{
    std::vector<Indices<Dim>> list;
    Indices<Dim> ranks{};
    auto add = [&]( auto&& self, const int axis, const int left ) -> void
    {
        if ( axis == Dim - 1 )
        {
            ranks[axis] = left;
            list.push_back( ranks );
            return;
        }
        for ( int r = 1; r <= left; ++r )
            if ( left % r == 0 )
            {
                ranks[axis] = r;
                self( self, axis + 1, left / r );
            }
    };
    add( add, 0, size );
    return list;
}

//! Boxes as thin as they may be, but for the last along each axis.
template <int Dim>
Cuts<Dim> unevenCuts( const Indices<Dim>& cells, const Indices<Dim>& ranks,
                      const int fewest )
{
    Cuts<Dim> cuts;
    for ( int d = 0; d < Dim; ++d )
    {
        for ( int r = 0; r < ranks[d]; ++r )
            cuts[d].push_back( r * fewest );
        cuts[d].push_back( cells[d] );
    }
    return cuts;
}

//! A scalar, two components of a velocity, one of a force, two on faces.
template <int Dim>
NodeComponents<6> components()
{
    const int last = Dim - 1;
    return { NodeComponent{},
             { Parity::velocity, 0 },
             { Parity::velocity, last },
             { Parity::force, 0 },
             { Parity::scalar, 0, 1 },
             { Parity::scalar, last, 1 << last } };
}

Real draw( const int seed, const int row, const int column )
{
    return uniformRandom( seed, row, column ) - 0.5;
}

//! A field, and what is in the rows below along each axis.
//! \param[out] read [nodes][1 + Dim]
template <int Dim>
void readBelow( const NodeLayout<Dim>& layout, const NodeRows& rows,
                const NodeView& field, const NodeView& read )
{
    rows.forEach(
        "readBelow", KOKKOS_LAMBDA( const int row ) {
            read( row, 0 ) = field( row, 0 );
            for ( int d = 0; d < Dim; ++d )
            {
                const int below = row - layout.stride[d];
                read( row, 1 + d ) = below < 0 ? 0.0 : field( below, 1 + d );
            }
        } );
}

/*!
  \brief Both halos, side by side: what all ranks deposit into their nodes and
  halos, added up, is deposited into the whole domain; fold and fill then agree
  on every node that a rank stores.
*/
template <int Dim>
void expectSameAsWhole( const std::array<SideKind, 3>& kind, const bool centred,
                        const int width, const int reach )
{
    const Communicator comm;
    Indices<Dim> cells{}, far{};
    Vector<Dim> corner{};
    for ( int d = 0; d < Dim; ++d )
    {
        far[d] = reach + ( d == 0 ? 1 : 0 ); // as images in high cells do
        cells[d] = 4 * ( width + reach + 2 ) + d;
        corner[d] = 1 + d;
    }
    const Grid<Dim> grid( Vector<Dim>{}, corner, cells );
    const NodeLayout<Dim> whole( grid, wholeDomain( grid ), centred, width,
                                 far );
    const auto whole_halo = makeHalo<Dim>( whole, kind, {} );
    for ( const auto& ranks : allCuts<Dim>( comm.size() ) )
        for ( const bool even : { true, false } )
        {
            Decomposition<Dim> decomposition( comm, cells, ranks );
            if ( !even )
                decomposition.setCuts(
                    unevenCuts<Dim>( cells, ranks, width + reach + 2 ) );
            const NodeLayout<Dim> layout( grid, decomposition.box(), centred,
                                          width, far );
            const auto halo = makeHalo<Dim>( layout, kind, decomposition );
            NodeView own( "own", layout.total, 6 ),
                all( "all", whole.total, 6 );
            const auto own_host = Kokkos::create_mirror_view( own );
            const auto all_host = Kokkos::create_mirror_view( all );
            std::vector<double> deposits( 6 * whole.total, 0 );
            for ( int row = 0; row < layout.total; ++row )
                for ( int c = 0; c < 6; ++c )
                {
                    own_host( row, c ) = draw( 1 + comm.rank(), row, c );
                    deposits[6 * whole( layout.indices( row ) ) + c] =
                        own_host( row, c );
                }
            deposits = comm.sum( deposits );
            std::copy( deposits.begin(), deposits.end(), all_host.data() );
            Kokkos::deep_copy( own, own_host );
            Kokkos::deep_copy( all, all_host );

            // What reads a row and those below it may do so while messages are
            // under way.
            NodeView both( "both", layout.total, 6 );
            NodeView read( "read", layout.total, 1 + Dim );
            Kokkos::deep_copy( both, own );
            halo.foldAndFill( both, components<Dim>(),
                              [&]( const NodeRows& rows )
                              { readBelow( layout, rows, both, read ); } );
            const auto expected = Kokkos::create_mirror_view_and_copy(
                Kokkos::HostSpace(), read );
            readBelow( layout, NodeRows( layout.total ), both, read );
            const auto found = Kokkos::create_mirror_view_and_copy(
                Kokkos::HostSpace(), read );
            int wrong = 0;
            for ( int row = 0; row < layout.total; ++row )
                for ( int c = 0; c <= Dim; ++c )
                    wrong += found( row, c ) != expected( row, c ) ? 1 : 0;
            EXPECT_EQ( wrong, 0 );

            halo.fold( own, components<Dim>() );
            whole_halo.fold( all, components<Dim>() );
            halo.fillSides( own, components<Dim>() );
            whole_halo.fill( all, components<Dim>() );

            Kokkos::deep_copy( all_host, all );
            for ( const auto& field : { own, both } )
            {
                Kokkos::deep_copy( own_host, field );
                Real worst = 0;
                for ( int row = 0; row < layout.total; ++row )
                    for ( int c = 0; c < 6; ++c )
                    {
                        const int same = whole( layout.indices( row ) );
                        worst =
                            std::max( worst, std::abs( own_host( row, c ) -
                                                       all_host( same, c ) ) );
                    }
                EXPECT_LT( worst, tolerance( 1e-13 ) )
                    << field.label() << ", " << Dim << "D, kinds "
                    << static_cast<int>( kind[0] )
                    << static_cast<int>( kind[1] ) << ", centred " << centred
                    << ", width " << width << "+" << reach << ", ranks along x "
                    << ranks[0] << " of " << comm.size() << ", even " << even;
            }
        }
}

template <int Dim>
void expectSameAsWhole( const bool centred, const int width )
{
    using enum SideKind;
    for ( const auto& kind : { std::array{ periodic, periodic, periodic },
                               std::array{ slip, periodic, open },
                               std::array{ no_slip, slip, periodic },
                               std::array{ open, slip, slip } } )
        for ( const int reach : { 0, 1 } )
            expectSameAsWhole<Dim>( kind, centred, width, reach );
}

TEST( RankHalo, linear )
{
    expectSameAsWhole<1>( false, 0 );
    expectSameAsWhole<2>( false, 0 );
    expectSameAsWhole<3>( false, 0 );
}

TEST( RankHalo, quadratic )
{
    expectSameAsWhole<1>( true, 1 );
    expectSameAsWhole<2>( true, 1 );
    expectSameAsWhole<3>( true, 1 );
}

TEST( RankHalo, cubic )
{
    expectSameAsWhole<1>( false, 1 );
    expectSameAsWhole<2>( false, 1 );
    expectSameAsWhole<3>( false, 1 );
}

// A box thinner than its halo would lose mass: an error on every rank.
TEST( RankHalo, boxThinnerThanTheHalo )
{
    const Communicator comm;
    if ( comm.size() == 1 )
        GTEST_SKIP() << "tstHalo tests whole domains";
    const int cells = 2 * comm.size(); // two each
    const Grid<1> grid( { 0 }, { 1 }, { cells } );
    const Decomposition<1> decomposition( comm, { cells }, { comm.size() } );
    const NodeLayout<1> layout( grid, decomposition.box(), true, 1, { 1 } );
    EXPECT_THROW( makeHalo<1>( layout, { SideKind::slip }, decomposition ),
                  std::invalid_argument );
}

//! Rank of the cell of a position, by another way than Decomposition's.
int rankOf( const Decomposition<2>& decomposition, const Grid<2>& grid,
            const Vector<2>& x )
{
    int place[2];
    for ( int d = 0; d < 2; ++d )
    {
        const auto& cuts = decomposition.cuts( d );
        place[d] = static_cast<int>(
            std::upper_bound( cuts.begin(), cuts.end(), grid.cell( x[d], d ) ) -
            cuts.begin() - 1 );
    }
    return place[1] * decomposition.ranks()[0] + place[0];
}

//! Particles anywhere go home with all they carry, and none is lost.
void expectAllHome( const bool even )
{
    const Communicator comm;
    const Grid<2> grid( { -1, 0 }, { 2, 1 }, { 13, 11 } );
    Decomposition<2> decomposition( comm, grid.cells,
                                    chooseRanks<2>( grid.cells, comm.size() ) );
    if ( !even )
        decomposition.setCuts(
            unevenCuts<2>( grid.cells, decomposition.ranks(), 1 ) );
    const int n = 100 + 17 * comm.rank();
    Particles<2> particles;
    auto& flags = particles.addSidecar<Cabana::MemberTypes<std::int64_t>>(
        "flags", DuringStep::stays );
    auto& sidecar =
        particles.addSidecar<Cabana::MemberTypes<Real[3], std::int64_t>>(
            "sidecar", DuringStep::changes );
    particles.resize( n );
    const auto first = comm.sumBefore( std::int64_t( n ) );
    auto place = []( const std::int64_t id )
    {
        return Vector<2>{ -1 + 3 * uniformRandom( 7, id, 0 ),
                          uniformRandom( 7, id, 1 ) };
    };
    auto host = particles.toHost();
    auto side = Cabana::create_mirror_view_and_copy( Kokkos::HostSpace(),
                                                     sidecar.data() );
    auto flag = Cabana::create_mirror_view_and_copy( Kokkos::HostSpace(),
                                                     flags.data() );
    for ( int p = 0; p < n; ++p )
    {
        const auto x = place( first + p );
        Cabana::slice<0>( flag )( p ) = -( first + p );
        host.slice<Id>()( p ) = first + p;
        host.slice<Mass>()( p ) = 3.0 * ( first + p );
        host.slice<Position>()( p, 0 ) = x[0];
        host.slice<Position>()( p, 1 ) = x[1];
        Cabana::slice<0>( side )( p, 2 ) = 5.0 * ( first + p );
        Cabana::slice<1>( side )( p ) = first + p;
    }
    particles.fromHost( host );
    Cabana::deep_copy( sidecar.data(), side );
    Cabana::deep_copy( flags.data(), flag );

    particles.migrate( comm, decomposition.finder( grid ) );

    const int found = particles.size();
    const auto after = particles.toHost();
    const auto side_after = Cabana::create_mirror_view_and_copy(
        Kokkos::HostSpace(), sidecar.data() );
    const auto flag_after = Cabana::create_mirror_view_and_copy(
        Kokkos::HostSpace(), flags.data() );
    // All ranks return or none, which the others would wait for below.
    ASSERT_FALSE(
        comm.any( static_cast<int>( sidecar.data().size() ) != found ) );
    std::vector<std::int64_t> ids;
    for ( int p = 0; p < found; ++p )
    {
        const auto id = after.slice<Id>()( p );
        ids.push_back( id );
        const auto x = place( id );
        EXPECT_EQ( after.slice<Position>()( p, 0 ), x[0] );
        EXPECT_EQ( after.slice<Position>()( p, 1 ), x[1] );
        EXPECT_EQ( after.slice<Mass>()( p ), 3.0 * id );
        EXPECT_EQ( Cabana::slice<0>( side_after )( p, 2 ), 5.0 * id );
        EXPECT_EQ( Cabana::slice<1>( side_after )( p ), id );
        EXPECT_EQ( Cabana::slice<0>( flag_after )( p ), -id );
        EXPECT_EQ( rankOf( decomposition, grid, x ), comm.rank() );
        EXPECT_TRUE( decomposition.box().contains( grid, x ) );
    }
    ids = comm.gatherAll( ids );
    const auto all = comm.sum( std::int64_t( n ) );
    EXPECT_EQ( static_cast<std::int64_t>( ids.size() ), all );
    EXPECT_EQ( static_cast<std::int64_t>(
                   std::set<std::int64_t>( ids.begin(), ids.end() ).size() ),
               all );
}

TEST( Migration, everyParticleGoesHome )
{
    expectAllHome( true );
}
TEST( Migration, everyParticleGoesHomeToAnyBox )
{
    expectAllHome( false );
}

// Nothing moves: nothing changes, and a rank may have no particle at all.
TEST( Migration, emptyRanks )
{
    const Communicator comm;
    const Grid<1> grid( { 0 }, { 1 }, { 8 } );
    const Decomposition<1> decomposition( comm, { 8 }, { comm.size() } );
    std::vector<std::int64_t> ids, found;
    if ( comm.isRoot() )
        ids = { 2, 0, 1 };
    const int n = static_cast<int>( ids.size() );
    HostParticles<1> host;
    host.resize( n );
    for ( int p = 0; p < n; ++p )
    {
        host.slice<Position>()( p, 0 ) = 0;
        host.slice<Id>()( p ) = ids[p];
    }
    Particles<1> particles;
    particles.fromHost( host );
    particles.migrate( comm, decomposition.finder( grid ) );
    const auto after = particles.toHost();
    for ( int p = 0; p < particles.size(); ++p )
        found.push_back( after.slice<Id>()( p ) );
    EXPECT_EQ( found, ids );
}

//! Notes every row twice.
void noteAll( const RowList& list, const int n )
{
    Kokkos::parallel_for(
        "noteAll", Range( 0, 2 * n ),
        KOKKOS_LAMBDA( const int k ) { list.note( k / 2 ); } );
}

// Of the particles noted those go that are marked or another rank's. When a
// fault is found after that, each rank has its own again, with their masses and
// ids.
TEST( Migration, ofTheNotedAndBack )
{
    const Communicator comm;
    const Grid<1> grid( { 0 }, { 1 }, { 8 * comm.size() } );
    const Decomposition<1> decomposition( comm, grid.cells, { comm.size() } );
    // The notes of few fit into the list.
    for ( const int n : { 40, 4000 } )
    {
        HostParticles<1> host;
        host.resize( n );
        for ( int p = 0; p < n; ++p )
        {
            const int k = comm.rank() * n + p;
            host.slice<Position>()( p, 0 ) = ( k + 0.5 ) / ( n * comm.size() );
            host.slice<Id>()( p ) = k;
            host.slice<Mass>()( p ) = 3.0 * k;
        }
        Particles<1> particles;
        particles.fromHost( host );
        particles.beginStep( true );
        particles.endStep();
        particles.keepIdentities( IndexList( "firstRow", 1 ) );
        auto moved = particles.toHost();
        moved.slice<Id>()( 0 ) = -1;
        for ( int p = 0; p < n; ++p )
            moved.slice<Position>()( p, 0 ) =
                std::fmod( host.slice<Position>()( p, 0 ) + 0.1 * p / n, 1 );
        particles.fromHost( moved );
        RowList noted;
        noted.clear( n );
        noteAll( noted, n );
        EXPECT_EQ(
            particles.migrate( comm, decomposition.finder( grid ), noted ),
            ( n - 1 ) * comm.size() );
        EXPECT_EQ( comm.sum( std::int64_t( particles.size() ) ),
                   ( n - 1 ) * comm.size() );
        const auto there = particles.toHost();
        const auto box = decomposition.box();
        int foreign = 0;
        for ( int p = 0; p < particles.size(); ++p )
        {
            foreign += there.slice<Id>()( p ) / n != comm.rank() ? 1 : 0;
            EXPECT_GE( there.slice<Id>()( p ), 0 );
            EXPECT_TRUE( box.contains(
                grid, loadVector<1>( there.slice<Position>(), p ) ) );
        }
        EXPECT_EQ( foreign > 0, comm.size() > 1 );

        particles.restore();
        ASSERT_FALSE( comm.any( particles.size() != n ) );
        const auto back = particles.toHost();
        for ( int p = 0; p < n; ++p )
        {
            EXPECT_EQ( back.slice<Position>()( p, 0 ),
                       host.slice<Position>()( p, 0 ) );
            EXPECT_EQ( back.slice<Id>()( p ), host.slice<Id>()( p ) );
            EXPECT_EQ( back.slice<Mass>()( p ), host.slice<Mass>()( p ) );
        }
    }
}

TEST( Decomposition, boxesOfLeastCutArea )
{
    EXPECT_EQ( ( chooseRanks<2>( { 400, 200 }, 2 )[0] ), 2 );
    EXPECT_EQ( ( chooseRanks<2>( { 200, 400 }, 2 )[1] ), 2 );
    EXPECT_EQ( ( chooseRanks<2>( { 400, 200 }, 7 )[0] ), 7 );
    EXPECT_EQ( ( chooseRanks<3>( { 64, 64, 64 }, 8 )[1] ), 2 );
    EXPECT_EQ( ( chooseRanks<3>( { 64, 64, 64 }, 4 )[2] ), 2 );
    EXPECT_EQ( ( chooseRanks<2>( { 300, 2 }, 6 )[1] ), 1 );
}

// Every cell belongs to one box, whatever the number of ranks.
TEST( Decomposition, boxesCoverTheDomain )
{
    const Communicator comm;
    const Indices<3> cells{ 9, 13, 11 };
    for ( const auto& ranks : allCuts<3>( comm.size() ) )
    {
        const Decomposition<3> decomposition( comm, cells, ranks );
        const auto own = decomposition.box().totalCells();
        EXPECT_GT( own, 0 );
        EXPECT_EQ( comm.sum( std::int64_t( own ) ), 9 * 13 * 11 );
    }
    EXPECT_THROW( Decomposition<3>( comm, cells, { comm.size() + 1, 1, 1 } ),
                  std::invalid_argument );
    EXPECT_THROW( Decomposition<3>( comm, { 1, 1, comm.size() - 1 },
                                    { 1, 1, comm.size() } ),
                  std::invalid_argument );
}

// Cuts come back from a checkpoint of as many boxes, and only from that.
TEST( Decomposition, cutsInACheckpoint )
{
    const Communicator comm;
    const Indices<2> cells{ 4, 3 * comm.size() };
    const Indices<2> ranks{ 1, comm.size() };
    const auto cuts = unevenCuts<2>( cells, ranks, 2 );
    Decomposition<2> decomposition( comm, cells, ranks );
    decomposition.setCuts( cuts );
    Archive written;
    decomposition.checkpoint( written );
    Decomposition<2> again( comm, cells, ranks );
    Archive read( written.entries() );
    again.checkpoint( read );
    EXPECT_EQ( again.cuts( 1 ), cuts[1] );

    Archive foreign;
    std::vector<std::int64_t> x = { 0, 4 }, y = { 0, 1, 2, 3, 4, 5 };
    foreign.table( "cuts_x", x, 1 );
    foreign.table( "cuts_y", y, 1 );
    Archive foreign_read( foreign.entries() );
    again.checkpoint( foreign_read );
    EXPECT_EQ( again.cuts( 1 ), cuts[1] );
    EXPECT_TRUE( foreign_read.entries().empty() );
}

//! Makes n particles at positions( p ) on a line.
template <class Positions>
void place( Particles<1>& particles, const int n, const Positions& positions )
{
    particles.resize( n );
    auto host = particles.toHost();
    for ( int p = 0; p < n; ++p )
    {
        host.slice<Position>()( p, 0 ) = positions( p );
        host.slice<Id>()( p ) = p; // a negative one marks a hole
    }
    particles.fromHost( host );
}

// Every rank counts the particles of all.
TEST( Balance, loadsOfAllRanks )
{
    const Communicator comm;
    const Grid<1> grid( { 0 }, { 1 }, { 4 } );
    Particles<1> particles;
    place( particles, 1 + comm.rank(), []( int ) { return 0.1; } );
    const int n = comm.size() * ( comm.size() + 1 ) / 2;
    EXPECT_EQ( countLoads<1>( comm, grid, particles, 0, {}, 0.5 ),
               ( SlabLoads{ { n + 0.5, 0.5, 0.5, 0.5 } } ) );
}

// Boxes follow the particles where that gains something, and stay elsewhere.
TEST( Balance, boxesFollowTheParticles )
{
    const Communicator comm;
    if ( comm.size() == 1 )
        GTEST_SKIP() << "one rank has all";
    const int cells = 8 * comm.size();
    const Grid<1> grid( { 0 }, { 1 }, { cells } );
    Decomposition<1> decomposition( comm, grid.cells, { comm.size() } );
    const auto equal = decomposition.cuts( 0 );
    Particles<1> particles;
    place( particles, comm.isRoot() ? 8 * comm.size() : 0,
           [&]( const int p ) { return ( p / comm.size() + 0.5 ) / cells; } );
    auto balancer = []( const Real threshold )
    {
        return Balancer<1>( Json{
            { "every", 5 }, { "threshold", threshold }, { "cell_cost", 0 } } );
    };
    auto patient = balancer( comm.size() );
    EXPECT_FALSE( patient.moveCuts( decomposition, grid, particles, { 1 } ) );
    EXPECT_EQ( decomposition.cuts( 0 ), equal );
    EXPECT_EQ( patient.seen().start, comm.size() );

    auto quick = balancer( 1.1 );
    EXPECT_TRUE( quick.isDue( comm, 10 ) );
    EXPECT_FALSE( quick.isDue( comm, 11 ) );
    EXPECT_TRUE( quick.moveCuts( decomposition, grid, particles, { 1 } ) );
    particles.migrate( comm, decomposition.finder( grid ) );
    EXPECT_EQ( particles.size(), 8 );
    EXPECT_FALSE( quick.moveCuts( decomposition, grid, particles, { 1 } ) );
    EXPECT_EQ( quick.seen().largest, comm.size() );
    EXPECT_EQ( quick.seen().end, 1 );
    EXPECT_EQ( quick.seen().cuts_moved, 1 );
    // No thinner than asked for.
    auto other = balancer( 1 );
    decomposition.setCuts( { equal } );
    particles.migrate( comm, decomposition.finder( grid ) );
    EXPECT_FALSE( other.moveCuts( decomposition, grid, particles, { 8 } ) );
}

// A rank that fails alone must not wait for ever.
TEST( Communicator, noticesWhoDoesNotArrive )
{
    const Communicator comm;
    EXPECT_TRUE( comm.allArrive( 60 ) );
    EXPECT_TRUE( comm.allArrive( 60 ) );
    if ( comm.isRoot() )
    {
        EXPECT_EQ( comm.allArrive( 0.2 ), comm.size() == 1 );
    }
    comm.sum( 1.0 );
    // They find it there, late as they are.
    if ( !comm.isRoot() )
    {
        EXPECT_TRUE( comm.allArrive( 60 ) );
    }
}

// Sums are the same on all ranks and in the order of the ranks.
TEST( Communicator, reductions )
{
    const Communicator comm;
    const int n = comm.size();
    const auto sums = comm.sum( std::vector{ 1.0 * comm.rank(), 1e-20 } );
    EXPECT_EQ( sums[0], n * ( n - 1 ) / 2 );
    EXPECT_DOUBLE_EQ( sums[1], n * 1e-20 );
    EXPECT_EQ( comm.max( comm.rank() ), n - 1 );
    EXPECT_EQ( comm.min( comm.rank() ), 0 );
    EXPECT_TRUE( comm.any( comm.rank() == n - 1 ) );
    EXPECT_FALSE( comm.any( false ) );
    EXPECT_EQ( comm.sumBefore( std::int64_t( 1 ) ), comm.rank() );
    const auto counts = comm.sumCounts( { 1, comm.rank() } );
    EXPECT_EQ( counts[0], n );
    EXPECT_EQ( counts[1], n * ( n - 1 ) / 2 );
    EXPECT_EQ( comm.from( n - 1, std::to_string( comm.rank() ) ),
               std::to_string( n - 1 ) );
    const auto all = comm.gatherAll( std::vector<int>( comm.rank(), 1 ) );
    EXPECT_EQ( static_cast<int>( all.size() ), n * ( n - 1 ) / 2 );
}

} // namespace
