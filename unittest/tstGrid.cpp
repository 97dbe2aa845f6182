// Grid, node layout, bases, placement and random numbers.
#include "tolerance.hpp"

#include <core/basis.hpp>
#include <core/bounds.hpp>
#include <core/halo.hpp>
#include <core/placement.hpp>
#include <core/stencil.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <vector>

namespace
{

using namespace Machpoint;
using Test::tolerance;

TEST( Grid, cellsAndVolumes )
{
    const Grid<2> grid( { -1, 0 }, { 1, 3 }, { 4, 6 } );
    EXPECT_REAL_EQ( grid.spacing[0], 0.5 );
    EXPECT_REAL_EQ( grid.spacing[1], 0.5 );
    EXPECT_EQ( wholeDomain( grid ).totalCells(), 24 );
    EXPECT_REAL_EQ( grid.cellVolume(), 0.25 );
    EXPECT_EQ( grid.cell( -1.0, 0 ), 0 );
    EXPECT_EQ( grid.cell( 0.49, 0 ), 2 );
    // On the upper side, and beyond either: the nearest cell.
    EXPECT_EQ( grid.cell( 1.0, 0 ), 3 );
    EXPECT_EQ( grid.cell( 7.0, 0 ), 3 );
    EXPECT_EQ( grid.cell( -7.0, 0 ), 0 );
    EXPECT_EQ( wholeDomain( grid ).flatCell( grid, { 0.2, 1.2 } ), 2 * 4 + 2 );
}

// Below the lower side, or not just inside the upper one, along any axis.
TEST( Grid, whatLeaves )
{
    const Grid<2> grid( { -1, 0 }, { 1, 3 }, { 4, 6 } );
    auto out = [&]( const Vector<2>& x )
    { return domainBounds( grid ).excludes( x ); };
    EXPECT_FALSE( out( { -1, 0 } ) );
    EXPECT_FALSE( out( { 0.5, 2.9 } ) );
    EXPECT_FALSE( out( { justInside( -1, 1 ), justInside( 0, 3 ) } ) );
    EXPECT_TRUE( out( { std::nextafter( Real( -1 ), Real( -2 ) ), 1 } ) );
    EXPECT_TRUE( out( { 0, -std::numeric_limits<Real>::min() } ) );
    EXPECT_TRUE( out( { 1, 1 } ) );
    EXPECT_TRUE( out( { 0, 3 } ) );
    EXPECT_TRUE( out( { -5, 7 } ) );
}

// A box numbers its own cells, but knows them by their place in the domain.
TEST( Grid, boxOfARank )
{
    const Grid<2> grid( { -1, 0 }, { 1, 3 }, { 4, 6 } );
    const CellBox<2> box{ { 1, 2 }, { 3, 6 } };
    EXPECT_EQ( box.totalCells(), 8 );
    EXPECT_EQ( box.flatCell( grid, { 0.2, 1.2 } ), 1 );
    EXPECT_EQ( box.flatCell( grid, { 9, 9 } ), 7 ); // the nearest
    EXPECT_TRUE( box.contains( grid, { 0.2, 1.2 } ) );
    EXPECT_TRUE( box.contains( grid, { 0.2, 3 } ) ); // the upper side
    EXPECT_FALSE( box.contains( grid, { 0.2, 0.9 } ) );
    EXPECT_FALSE( box.contains( grid, { 0.5, 1.2 } ) );
    const NodeLayout<2> layout( grid, box, false, 1, { 2, 0 } );
    EXPECT_EQ( layout.owned[0], 2 );
    EXPECT_EQ( layout.owned[1], 5 ); // the domain's last vertex, too
    EXPECT_EQ( layout.lowest( 0 ), 1 - 3 );
    EXPECT_EQ( layout( { -2, 1 } ), 0 );
    EXPECT_REAL_EQ( layout.position( { 1, 2 } )[0], -0.5 );
    for ( int row = 0; row < layout.total; ++row )
        EXPECT_EQ( layout( layout.indices( row ) ), row );
    EXPECT_TRUE( layout.isOwned( { 2, 6 } ) );
    EXPECT_FALSE( layout.isOwned( { 3, 6 } ) );
    EXPECT_FALSE( layout.isOwned( { 0, 6 } ) );
}

// A domain may have more nodes than an int counts: its sides are known.
TEST( Grid, layoutOfADomainForManyRanks )
{
    const Grid<3> grid( { 0, 0, 0 }, { 1, 1, 1 }, { 2000, 2000, 1500 } );
    const NodeLayout<3> whole( grid, false, 0 );
    EXPECT_EQ( whole.extent[2], 1501 );
    EXPECT_EQ( Halo<3>::sideSize( whole, 0 ), 2001 * 1501 );
    EXPECT_EQ( Halo<3>::sideSize( whole, 2 ), 2001 * 2001 );
    EXPECT_EQ( Halo<3>::sideNode( whole, 2, 2001 * 2001 - 1 )[1], 2000 );
}

// A layer more along an axis; nodes beyond a periodic end are at home inside.
TEST( Grid, layoutOfACutPeriodicAxis )
{
    const Grid<2> grid( { 0, 0 }, { 4, 6 }, { 4, 6 } );
    for ( const bool centred : { true, false } )
    {
        NodeLayout<2> layout( grid, { { 0, 3 }, { 4, 6 } }, centred, 1,
                              { 1, 1 }, { 0, 1 } );
        layout.period[1] = 6;
        EXPECT_EQ( layout.halo[0], 2 );
        EXPECT_EQ( layout.halo[1], 3 );
        EXPECT_EQ( layout.lowest( 1 ), 0 );
        EXPECT_EQ( layout.extent[1], 3 + ( centred ? 0 : 1 ) + 2 * 3 );
        const auto above = layout.home( { -1, 8 } );
        EXPECT_EQ( above[0], -1 ); // that axis has walls
        EXPECT_EQ( above[1], 2 );
        EXPECT_EQ( layout.home( { 3, -2 } )[1], 4 );
        EXPECT_EQ( layout.home( { 3, 6 } )[1], 0 );
        EXPECT_EQ( layout.home( { 3, 5 } )[1], 5 );
    }
}

TEST( Grid, layoutIsABijection )
{
    const Grid<3> grid( { 0, 0, 0 }, { 3, 2, 1 }, { 3, 2, 4 } );
    const auto layout = nodeLayout<Cubic>( grid );
    EXPECT_EQ( layout.owned[2], 5 );
    EXPECT_EQ( layout.total, 6 * 5 * 7 );
    for ( int row = 0; row < layout.total; ++row )
        EXPECT_EQ( layout( layout.indices( row ) ), row );
    EXPECT_TRUE( layout.isOwned( { 0, 0, 4 } ) );
    EXPECT_FALSE( layout.isOwned( { 0, -1, 4 } ) );
    const auto x = layout.position( { 1, 1, 1 } );
    EXPECT_REAL_EQ( x[0], 1 );
    EXPECT_REAL_EQ( x[2], 0.25 );
    const auto centred = nodeLayout<Quadratic>( grid );
    EXPECT_EQ( centred.owned[0], 3 );
    EXPECT_REAL_EQ( centred.position( { 0, 0, 0 } )[0], 0.5 );
}

template <class T>
class BasisTest : public testing::Test
{
};
using Bases = testing::Types<Linear, Quadratic, Cubic>;
TYPED_TEST_SUITE( BasisTest, Bases );

// Partition of unity, exactness on linear fields, the moment, and the
// derivative against a central difference, anywhere in a cell.
TYPED_TEST( BasisTest, reproducesLinearFields )
{
    constexpr int n = TypeParam::nodes;
    for ( int k = 0; k <= 20; ++k )
    {
        const Real f = k / 20.0;
        Real w[n], dw[n];
        TypeParam::weights( f, w );
        TypeParam::gradients( f, dw );
        Real one = 0, zero = 0, first = 0, slope = 0, second = 0;
        for ( int i = 0; i < n; ++i )
        {
            const Real dx = TypeParam::offset( f, i );
            EXPECT_GE( w[i], 0 );
            one += w[i];
            zero += dw[i];
            first += w[i] * dx;
            slope += dw[i] * dx;
            second += w[i] * dx * dx;
        }
        EXPECT_NEAR( one, 1, tolerance( 1e-15 ) );
        EXPECT_NEAR( zero, 0, tolerance( 1e-15 ) );
        EXPECT_NEAR( first, 0, tolerance( 1e-15 ) );
        EXPECT_NEAR( slope, 1, tolerance( 1e-14 ) );
        EXPECT_NEAR( second, TypeParam::moment( f ), tolerance( 1e-14 ) );
        if ( k == 0 || k == 20 )
            continue;
        const Real d = is_single ? 1e-3 : 1e-6;
        Real before[n], after[n];
        TypeParam::weights( f - d, before );
        TypeParam::weights( f + d, after );
        for ( int i = 0; i < n; ++i )
            EXPECT_NEAR( ( after[i] - before[i] ) / ( 2 * d ), dw[i],
                         is_single ? 1e-3 : 1e-9 );
    }
}

// Knots are cell boundaries: from one cell to the next the weights continue.
TYPED_TEST( BasisTest, isContinuousAcrossCells )
{
    constexpr int n = TypeParam::nodes;
    Real left[n], right[n];
    TypeParam::weights( 1.0_rt, left );
    TypeParam::weights( 0.0_rt, right );
    EXPECT_NEAR( left[0], 0, tolerance( 1e-15 ) );
    EXPECT_NEAR( right[n - 1], 0, tolerance( 1e-15 ) );
    for ( int i = 1; i < n; ++i )
        EXPECT_NEAR( left[i], right[i - 1], tolerance( 1e-15 ) );
}

//! Keeps the nodes that it is shown. (nvcc would warn of a lambda of the host.)
template <int Dim>
struct Collect
{
    StencilNode<Dim>* nodes;
    int* count;

    KOKKOS_FUNCTION void operator()( const StencilNode<Dim>& node ) const
    {
        nodes[( *count )++] = node;
    }
};

//! Keeps the lines that it is shown.
template <int Dim>
struct CollectLines
{
    StencilLine<Dim>* lines;
    int* count;

    KOKKOS_FUNCTION void operator()( const StencilLine<Dim>& line ) const
    {
        lines[( *count )++] = line;
    }
};

//! Are the lines of a stencil its nodes, in their order?
template <bool WrittenOut, class Basis, int Dim>
void checkLines( const Stencil<Basis, Dim>& s, const NodeLayout<Dim>& layout,
                 const std::vector<StencilNode<Dim>>& nodes )
{
    std::vector<StencilLine<Dim>> lines( nodes.size() );
    int visited = 0;
    forEachLine<WrittenOut>( s, layout,
                             CollectLines<Dim>{ lines.data(), &visited } );
    ASSERT_EQ( static_cast<std::size_t>( visited * Basis::nodes ),
               nodes.size() );
    for ( std::size_t n = 0; n < nodes.size(); ++n )
    {
        const auto& node = nodes[n];
        const auto& line = lines[n / Basis::nodes];
        const int i = static_cast<int>( n % Basis::nodes );
        const Real w = s.w[0][i];
        EXPECT_EQ( rowAt( s.base, line.shift + i ), node.row );
        EXPECT_NEAR( line.weight * w, node.weight, tolerance( 1e-15 ) );
        for ( int b = 0; b < Dim; ++b )
        {
            if ( b > 0 )
            {
                EXPECT_EQ( line.dx[b], node.dx[b] );
            }
            EXPECT_NEAR( line.gradient[b] * ( b == 0 ? s.dw[0][i] : w ),
                         node.gradient[b], tolerance( 1e-14 ) );
            EXPECT_NEAR( line.fit[b] * ( b == 0 ? fitWeight( s, 0, i ) : w ),
                         Basis::constant_moment ? node.weight * node.dx[b]
                                                : node.gradient[b],
                         tolerance( 1e-14 ) );
        }
    }
}

template <class Basis, int Dim>
void checkStencil()
{
    Vector<Dim> lower{}, upper{}, x{}, slope{};
    Indices<Dim> cells{};
    for ( int d = 0; d < Dim; ++d )
    {
        lower[d] = -1 - d;
        upper[d] = 2 + d;
        cells[d] = 5 + d; // another spacing along each axis
        x[d] = 0.377 + 0.1 * d;
        slope[d] = 2 - 3.3 * d;
    }
    const Grid<Dim> grid( lower, upper, cells );
    const auto layout = nodeLayout<Basis>( grid );
    const Stencil<Basis, Dim> s( grid, layout, x );
    Real unity = 0, value = 0;
    Vector<Dim> gradient{};
    int visited = 0;
    std::vector<StencilNode<Dim>> nodes( 64 ); // of the largest stencil
    forEachNode( s, layout, Collect<Dim>{ nodes.data(), &visited } );
    nodes.resize( visited );
    for ( const auto& node : nodes )
    {
        const auto y = layout.position( layout.indices( node.row ) );
        for ( int d = 0; d < Dim; ++d )
            EXPECT_NEAR( node.dx[d], y[d] - x[d], tolerance( 1e-14 ) );
        unity += node.weight;
        const Real field = 1 + dot<Dim>( slope, y );
        value += node.weight * field;
        for ( int d = 0; d < Dim; ++d )
            gradient[d] += node.gradient[d] * field;
    }
    int expected = 1;
    for ( int d = 0; d < Dim; ++d )
        expected *= Basis::nodes;
    EXPECT_EQ( visited, expected );
    checkLines<false>( s, layout, nodes );
    checkLines<true>( s, layout, nodes );
    EXPECT_NEAR( unity, 1, tolerance( 1e-14 ) );
    EXPECT_NEAR( value, 1 + dot<Dim>( slope, x ), tolerance( 1e-13 ) );
    for ( int d = 0; d < Dim; ++d )
        EXPECT_NEAR( gradient[d], slope[d], tolerance( 1e-12 ) );
}

TYPED_TEST( BasisTest, stencilReproducesLinearFields )
{
    checkStencil<TypeParam, 1>();
    checkStencil<TypeParam, 2>();
    checkStencil<TypeParam, 3>();
}

// A particle that the division by h has in a rank's box, and the product with
// 1/h just before it: its moment, by which an affine field is scaled, is not
// negative.
TEST( Stencil, momentOfHatsIsNotNegative )
{
    const Grid<1> grid( { 0 }, { 1 }, { 96 } );
    const NodeLayout<1> layout( grid, { { 24 }, { 48 } }, Linear::centred,
                                Linear::halo, {} );
    for ( const Real side : { 0.25_rt, 0.5_rt } )
        for ( const Real toward : { 0.0_rt, 1.0_rt } )
        {
            Real x = side;
            for ( int k = 0; k < 4; ++k )
            {
                const Stencil<Linear, 1> s( grid, layout, { x } );
                EXPECT_GE( s.moment( 0, grid.spacing[0] ), 0 ) << x;
                x = std::nextafter( x, toward );
            }
        }
}

TEST( Placement, latticeSizes )
{
    EXPECT_EQ( latticeSize( 3, 1 ), 3 );
    EXPECT_EQ( latticeSize( 9, 2 ), 3 );
    EXPECT_EQ( latticeSize( 8, 3 ), 2 );
    EXPECT_EQ( latticeSize( 125, 3 ), 5 );
    EXPECT_EQ( latticeSize( 8, 2 ), 0 );
}

TEST( Placement, latticeIsCentredAndJitterStaysInItsSubCell )
{
    Real widest = 0;
    std::set<Real> draws;
    for ( int k = 0; k < 9; ++k )
    {
        const auto f = placeInCell<2>( Placement::lattice, 3, 1, 7, k );
        EXPECT_REAL_EQ( f[0], ( k % 3 + 0.5 ) / 3 );
        EXPECT_REAL_EQ( f[1], ( k / 3 + 0.5 ) / 3 );
        const auto g = placeInCell<2>( Placement::jittered, 3, 1, 7, k );
        for ( int d = 0; d < 2; ++d )
        {
            const Real jitter = std::abs( g[d] - f[d] );
            EXPECT_LE( jitter, 0.5 / 3 );
            widest = std::max( widest, jitter );
            draws.insert( g[d] - f[d] );
        }
    }
    EXPECT_GT( widest, 0.3 / 3 );
    EXPECT_EQ( draws.size(), 18u );
}

// Mean 1/2 and variance 1/12 within five standard errors, every draw
// different, and the same on every call.
TEST( Random, isUniformAndReproducible )
{
    const int n = 100000;
    Real mean = 0, square = 0;
    std::set<Real> seen;
    for ( int k = 0; k < n; ++k )
    {
        const Real r = uniformRandom( 3, k, 5 );
        ASSERT_GE( r, 0 );
        ASSERT_LT( r, 1 );
        EXPECT_EQ( r, uniformRandom( 3, k, 5 ) );
        seen.insert( r );
        mean += r / n;
        square += ( r - 0.5 ) * ( r - 0.5 ) / n;
    }
    // Of 2^24 floats some are drawn twice: n^2 / 2^25 of them.
    EXPECT_GE( seen.size(),
               static_cast<std::size_t>( is_single ? n - 400 : n ) );
    EXPECT_NEAR( mean, 0.5, 5 * std::sqrt( 1.0 / 12 / n ) );
    EXPECT_NEAR( square, 1.0 / 12, 5 * std::sqrt( 1.0 / 180 / n ) );
    EXPECT_NE( uniformRandom( 3, 1, 5 ), uniformRandom( 4, 1, 5 ) );
    EXPECT_NE( uniformRandom( 3, 1, 5 ), uniformRandom( 3, 1, 6 ) );
}

} // namespace
