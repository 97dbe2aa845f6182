// Where cuts between ranks go, against all the cuts that there are.
#include <core/balance.hpp>
#include <core/random.hpp>

#include <gtest/gtest.h>

#include <numeric>

namespace
{

using namespace Machpoint;

//! Load of the heaviest box along an axis, over all slabs.
double heaviest( const SlabLoads& loads, const std::vector<int>& cuts )
{
    double most = 0;
    for ( const auto& slab : loads )
        for ( std::size_t k = 1; k < cuts.size(); ++k )
            most = std::max( most,
                             std::accumulate( slab.begin() + cuts[k - 1],
                                              slab.begin() + cuts[k], 0.0 ) );
    return most;
}

//! Calls visit( cuts ) for all cuts whose boxes have enough cells.
template <class Visit>
void forAllCuts( const int cells, const int parts, const int fewest,
                 const Visit& visit, std::vector<int> cuts = { 0 } )
{
    if ( parts == 1 )
    {
        cuts.push_back( cells );
        if ( cells - cuts[cuts.size() - 2] >= fewest )
            visit( cuts );
        return;
    }
    for ( int c = cuts.back() + fewest; c <= cells; ++c )
    {
        auto longer = cuts;
        longer.push_back( c );
        forAllCuts( cells, parts - 1, fewest, visit, longer );
    }
}

// The lightest heaviest box of all cuts, and no box thinner than its halo.
TEST( CutAxis, isTheBestOfAll )
{
    int tried = 0;
    for ( int cells : { 7, 12 } )
        for ( int parts : { 2, 3, 4 } )
            for ( int fewest : { 1, 2, 3 } )
                for ( int slabs : { 1, 3 } )
                    for ( int draw = 0; draw < 5; ++draw )
                    {
                        if ( parts * fewest > cells )
                            continue;
                        // Steep, so that single cells matter, and with gaps.
                        SlabLoads loads( slabs, std::vector<double>( cells ) );
                        for ( int s = 0; s < slabs; ++s )
                            for ( int c = 0; c < cells; ++c )
                            {
                                const double u =
                                    uniformRandom( 11 + draw, s, c );
                                loads[s][c] = u < 0.3 ? 0 : std::pow( u, 4 );
                            }
                        double best = 1e300;
                        forAllCuts( cells, parts, fewest,
                                    [&]( const auto& cuts ) {
                                        best = std::min(
                                            best, heaviest( loads, cuts ) );
                                    } );
                        const auto found = cutAxis( loads, parts, fewest );
                        ASSERT_EQ( static_cast<int>( found.cuts.size() ),
                                   parts + 1 );
                        EXPECT_EQ( found.cuts.front(), 0 );
                        EXPECT_EQ( found.cuts.back(), cells );
                        for ( int k = 0; k < parts; ++k )
                            EXPECT_GE( found.cuts[k + 1] - found.cuts[k],
                                       fewest );
                        EXPECT_NEAR( found.heaviest,
                                     heaviest( loads, found.cuts ), 1e-14 );
                        EXPECT_LE( found.heaviest, best * ( 1 + 1e-6 ) );
                        ++tried;
                    }
    EXPECT_GT( tried, 100 );
}

TEST( CutAxis, equalLoadsGiveEqualBoxes )
{
    const SlabLoads loads( 2, std::vector<double>( 12, 3.0 ) );
    EXPECT_EQ( cutAxis( loads, 4, 2 ).cuts,
               ( std::vector<int>{ 0, 3, 6, 9, 12 } ) );
    EXPECT_EQ( cutAxis( loads, 1, 2 ).cuts, ( std::vector<int>{ 0, 12 } ) );
}

// Of equally good cuts those nearest to equal loads: where one cell holds most,
// the others are close to it, as nothing is won by moving them.
TEST( CutAxis, equallyGoodCutsAreEven )
{
    std::vector<double> load( 16, 1.0 );
    load[0] = 100;
    EXPECT_EQ( cutAxis( { load }, 3, 1 ).cuts,
               ( std::vector<int>{ 0, 1, 2, 16 } ) );
    EXPECT_EQ( cutAxis( { std::vector<double>( 9, 0.0 ) }, 3, 3 ).cuts,
               ( std::vector<int>{ 0, 3, 6, 9 } ) );
}

TEST( CutAxis, tooFewCells )
{
    EXPECT_THROW( cutAxis( { std::vector<double>( 11, 1.0 ) }, 4, 3 ),
                  std::invalid_argument );
}

//! Loads of a plane along an axis. \param load [y][x]
SlabLoads loadsOf( const std::vector<std::vector<double>>& load, const int axis,
                   const Cuts<2>& cuts )
{
    const auto& across = cuts[1 - axis];
    const int cells = cuts[axis].back();
    SlabLoads loads( across.size() - 1, std::vector<double>( cells ) );
    for ( std::size_t s = 0; s + 1 < across.size(); ++s )
        for ( int t = across[s]; t < across[s + 1]; ++t )
            for ( int c = 0; c < cells; ++c )
                loads[s][c] += axis == 0 ? load[t][c] : load[c][t];
    return loads;
}

//! Cuts into 2 x 2 boxes of a plane of n x n cells.
template <class Load>
BoxCuts<2> cutPlane( const int n, const int fewest, const Load& load )
{
    std::vector<std::vector<double>> plane( n, std::vector<double>( n ) );
    for ( int y = 0; y < n; ++y )
        for ( int x = 0; x < n; ++x )
            plane[y][x] = load( x, y );
    const auto chosen =
        chooseCuts<2>( { n, n }, { 2, 2 }, { fewest, fewest },
                       [&]( const int axis, const Cuts<2>& cuts )
                       { return loadsOf( plane, axis, cuts ); } );
    // What it says of the heaviest box holds along either axis.
    for ( int axis : { 0, 1 } )
        EXPECT_NEAR(
            chosen.heaviest,
            heaviest( loadsOf( plane, axis, chosen.cuts ), chosen.cuts[axis] ),
            1e-12 );
    return chosen;
}

TEST( ChooseCuts, gasInACornerIsShared )
{
    const auto gas = []( const int x, const int y )
    { return x < 16 && y < 12 ? 4.0 : 0.0; };
    const auto chosen = cutPlane( 32, 3, gas );
    EXPECT_EQ( chosen.cuts[0][1], 8 );
    EXPECT_EQ( chosen.cuts[1][1], 6 );
    EXPECT_EQ( chosen.heaviest, 4 * 8 * 6 );
    // Boxes wider than the gas is cannot share it.
    EXPECT_EQ( cutPlane( 32, 16, gas ).heaviest, 4 * 16 * 12 );
}

// Equal loads of whole layers leave 280 of 550 in one box: what lies in a layer
// lies on one side of the other axis' cut. 195 is the best that there is.
TEST( ChooseCuts, looksAtBoxesNotAtLayers )
{
    const auto chosen =
        cutPlane( 20, 1,
                  []( const int x, const int y )
                  { return ( x < 15 ? y < 4 : y >= 10 ) ? 5.0 : 0.0; } );
    EXPECT_LE( chosen.heaviest, 200 );
    EXPECT_GE( chosen.heaviest, 195 );
}

// The limit: a third of a diagonal would be the best, and half is found.
TEST( ChooseCuts, aDiagonalIsNoWorseThanInEqualBoxes )
{
    const auto chosen = cutPlane(
        24, 2, []( const int x, const int y ) { return x == y ? 1.0 : 0; } );
    EXPECT_LE( chosen.heaviest, 12 );
    EXPECT_GE( chosen.heaviest, 8 );
}

// Counts of particles, and the share of the cells, by slab.
TEST( CountLoads, particlesAndCells )
{
    const Grid<2> grid( { 0, -1 }, { 6, 3 }, { 6, 4 } );
    const std::vector<Vector<2>> places = {
        { 0.5, -0.5 }, { 0.5, 2.5 }, { 0.6, 2.9 }, { 5.9, 0.1 }, { 6, 3 } };
    Particles<2> particles;
    particles.resize( places.size() );
    auto host = particles.toHost();
    for ( std::size_t p = 0; p < places.size(); ++p )
        for ( int d = 0; d < 2; ++d )
            host.slice<Position>()( p, d ) = places[p][d];
    particles.fromHost( host );
    const Communicator comm;
    const Cuts<2> cuts = { std::vector{ 0, 2, 6 }, std::vector{ 0, 3, 4 } };
    // Along x: 3 cells of a layer below y = 2, 1 above.
    const auto along_x = countLoads<2>( comm, grid, particles, 0, cuts, 0.5 );
    EXPECT_EQ( along_x, ( SlabLoads{ { 2.5, 1.5, 1.5, 1.5, 1.5, 2.5 },
                                     { 2.5, 0.5, 0.5, 0.5, 0.5, 1.5 } } ) );
    const auto along_y = countLoads<2>( comm, grid, particles, 1, cuts, 0 );
    EXPECT_EQ( along_y, ( SlabLoads{ { 1, 0, 0, 2 }, { 0, 1, 0, 1 } } ) );
}

} // namespace
