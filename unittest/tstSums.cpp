// Sums whose bits do not depend on order: scalars and node fields.
#include <core/basis.hpp>
#include <core/node_sum.hpp>
#include <core/products.hpp>
#include <core/random.hpp>
#include <core/reproducible_sum.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

namespace
{

using namespace Machpoint;

//! Terms of both signs over 2 `decades` decades. \return [n]
std::vector<double> mixedTerms( const int n, const double decades )
{
    std::mt19937_64 random( 7 );
    std::uniform_real_distribution<double> uniform( -1, 1 );
    std::vector<double> terms( n );
    for ( auto& term : terms )
    {
        const double sign = uniform( random );
        term = sign * std::pow( 10.0, decades * uniform( random ) );
    }
    return terms;
}

//! Neumaier's compensated sum (1974).
double compensated( const std::vector<double>& terms )
{
    double sum = 0, lost = 0;
    for ( const double term : terms )
    {
        const double total = sum + term;
        lost += std::abs( sum ) >= std::abs( term ) ? ( sum - total ) + term
                                                    : ( term - total ) + sum;
        sum = total;
    }
    return sum + lost;
}

template <class Sum>
Sum add( const std::vector<double>& terms )
{
    Sum sum = 0;
    for ( const double term : terms )
        sum += term;
    return sum;
}

TEST( ReproducibleSum, hasTheSameBitsInAnyOrderAndAnySplit )
{
    // The largest decades lie far beyond what one sum can hold: what is cut
    // off must not depend on order either.
    for ( const double decades : { 1.0, 8.0, 150.0 } )
    {
        auto terms = mixedTerms( 3000, decades );
        const double expected = add<ReproducibleSum>( terms ).value();
        int plain_differs = 0;
        std::mt19937_64 random( 3 );
        for ( int shuffle = 0; shuffle < 30; ++shuffle )
        {
            const double plain = add<double>( terms );
            std::shuffle( terms.begin(), terms.end(), random );
            plain_differs += add<double>( terms ) != plain;
            EXPECT_EQ( add<ReproducibleSum>( terms ).value(), expected );
            // As threads or ranks would, one of them with nothing to add.
            ReproducibleSum parts[4];
            for ( std::size_t k = 0; k < terms.size(); ++k )
                parts[random() % 3] += terms[k];
            ReproducibleSum all;
            for ( const int part : { 2, 3, 0, 1 } )
                all += parts[part];
            EXPECT_EQ( all.value(), expected );
        }
        EXPECT_GT( plain_differs, 0 ) << decades;
    }
    std::vector<double> rising( 100 ), falling;
    for ( int k = 0; k < 100; ++k )
        rising[k] = std::ldexp( 1.1, k );
    falling.assign( rising.rbegin(), rising.rend() );
    EXPECT_EQ( add<ReproducibleSum>( rising ).value(),
               add<ReproducibleSum>( falling ).value() );
}

// A few units in the last place, and no worse than compensation where terms
// cancel: a long double has 11 bits more than a double.
TEST( ReproducibleSum, isAccurate )
{
    const double epsilon = std::numeric_limits<double>::epsilon();
    for ( const double decades : { 1.0, 8.0 } )
    {
        auto terms = mixedTerms( 3000, decades );
        const auto exact = add<long double>( terms );
        const double scale = std::abs( static_cast<double>( exact ) );
        const auto sum = add<ReproducibleSum>( terms ).value();
        EXPECT_LE( std::abs( static_cast<double>( sum - exact ) ),
                   2 * epsilon * scale );
        EXPECT_LE( std::abs( sum - compensated( terms ) ),
                   4 * epsilon * scale );
    }
    // What is equal and small adds up on top of what is large.
    ReproducibleSum sum = 1e6;
    for ( int k = 0; k < 1000000; ++k )
        sum += 1e-11;
    EXPECT_EQ( sum.value() - 1e6, ( 1e6 + 1e-5 ) - 1e6 );
    sum -= 1e6;
    EXPECT_NEAR( sum.value(), 1e-5, 1e-5 * epsilon );
}

TEST( ReproducibleSum, knowsSignsLimitsAndMultiples )
{
    const double tiny = std::numeric_limits<double>::denorm_min();
    const double huge = std::numeric_limits<double>::max();
    const double infinite = std::numeric_limits<double>::infinity();
    EXPECT_EQ( ReproducibleSum().value(), 0 );
    for ( const double term : { tiny, -tiny, 3e-310, 1.0, -0.1, 1e300, huge } )
        EXPECT_EQ( ReproducibleSum( term ).value(), term );
    ReproducibleSum zero = 0.3;
    zero -= 0.3;
    EXPECT_EQ( zero.value(), 0 );
    // A small negative sum of large terms: digits carry through zero.
    ReproducibleSum small = 1e10;
    small -= 1e10;
    small -= 1e-9;
    EXPECT_EQ( small.value(), -1e-9 );
    ReproducibleSum many, one_by_one;
    many.add( 0.1, 1000 );
    for ( int k = 0; k < 1000; ++k )
        one_by_one += 0.1;
    EXPECT_EQ( many.value(), one_by_one.value() );
    EXPECT_EQ( many.value(), 100 ); // 0.1 is 1/10 (1 + 5.6e-17)
    ReproducibleSum broken = 1;
    broken += infinite;
    EXPECT_EQ( broken.value(), infinite );
    broken -= infinite;
    EXPECT_TRUE( std::isnan( broken.value() ) );
}

#ifndef MACHPOINT_PRECISION_SINGLE // whose builds have no such sums
using TermView = Kokkos::View<Real* [2], MemorySpace>;

//! Terms for the nodes of a line, in a given order: term k adds to node
//! k % nodes. \return [n][2]
TermView nodeTerms( const std::vector<int>& order, const Real small )
{
    const int n = static_cast<int>( order.size() );
    TermView terms( "terms", n );
    const auto host = Kokkos::create_mirror_view( terms );
    for ( int k = 0; k < n; ++k )
        for ( int c = 0; c < 2; ++c )
        {
            const Real term = uniformRandom( 1, order[k], c );
            // Even nodes are in thin gas; momentum has both signs.
            host( k, c ) =
                ( order[k] % 2 == 0 ? small : 1.0 ) * ( c ? term - 0.5 : term );
        }
    Kokkos::deep_copy( terms, host );
    return terms;
}

//! Adds the terms to the nodes of a line. Stands in a free function, as nvcc
//! takes no kernel from a test's body.
template <class Sums>
void addTerms( const Sums& sums, const TermView& terms, const IndexList& rows )
{
    Kokkos::parallel_for(
        "addTerms", Range( 0, static_cast<int>( rows.extent( 0 ) ) ),
        KOKKOS_LAMBDA( const int k ) {
            const auto nodes = sums.thread().access(
                0, rows( k ), StencilRows<1>{ 1, { 1 } } );
            for ( int c = 0; c < 2; ++c )
                nodes( rows( k ), c ) += terms( k, c );
        } );
}

//! A periodic line of nodes at cell centres without a halo.
struct Line
{
    static constexpr int nodes = 8;
    NodeLayout<1> layout;
    Halo<1> halo;

    Line()
        : layout( Grid<1>( { 0.0 }, { 1.0 }, { nodes } ), true, 0 ),
          halo( layout, kinds() )
    {
    }
    static Kokkos::Array<KindView, 2> kinds()
    {
        // Views start at 0: periodic.
        return { KindView( "lower", 1 ), KindView( "upper", 1 ) };
    }

    //! Sums of the terms in an order. \return [node][2]
    NodeView::HostMirror sum( const std::vector<int>& order, const Real small,
                              const bool reproducible ) const
    {
        NodeSum sum( NodeView( "field", layout.total, 2 ), Communicator(),
                     reproducible );
        const auto terms = nodeTerms( order, small );
        IndexList rows( "rows", order.size() );
        const auto host = Kokkos::create_mirror_view( rows );
        for ( std::size_t k = 0; k < order.size(); ++k )
            host( k ) = layout( { order[k] % nodes } );
        Kokkos::deep_copy( rows, host );
        sum.deposit( [&]( const auto& sums )
                     { addTerms( sums, terms, rows ); } );
        sum.fold( halo, NodeComponents<2>{} );
        auto field = Kokkos::create_mirror( sum.field() );
        Kokkos::deep_copy( field, sum.field() );
        return field;
    }
};

TEST( NodeSum, hasTheSameBitsInAnyOrder )
{
    const Line line;
    std::vector<int> order( 5000 );
    std::iota( order.begin(), order.end(), 0 );
    std::mt19937_64 random( 3 );
    const auto expected = line.sum( order, 1e-6, true );
    const auto plain = line.sum( order, 1e-6, false );
    int plain_differs = 0;
    for ( int shuffle = 0; shuffle < 10; ++shuffle )
    {
        std::shuffle( order.begin(), order.end(), random );
        const auto again = line.sum( order, 1e-6, true );
        const auto plain_again = line.sum( order, 1e-6, false );
        for ( int row = 0; row < line.layout.total; ++row )
            for ( int c = 0; c < 2; ++c )
            {
                EXPECT_EQ( again( row, c ), expected( row, c ) );
                plain_differs += plain( row, c ) != plain_again( row, c );
            }
    }
    EXPECT_GT( plain_differs, 0 );
}

//! A field that particles add to: particle p its number to column 0 of a node,
//! in a line 1 to column 1 of the node behind it, too. A node below 0: the
//! particle adds nothing. \param first node of each [n]
NodeView addNumbers( const IndexList& first, const int nodes,
                     const bool in_lines )
{
    const NodeView field( "field", nodes, 2 );
    const NodeScatter scatter( field );
    scatter.clear();
    Kokkos::parallel_for(
        "add", Range( 0, first.extent_int( 0 ) ), KOKKOS_LAMBDA( const int p ) {
            const int base = first( p );
            if ( base < 0 )
                return;
            const auto access =
                scatter.thread().access( p, base, StencilRows<1>{ 2, { 1 } } );
            const Real own = static_cast<Real>( p );
            const Real line[2][2] = { { own, 0 }, { 0, 1 } };
            if ( in_lines )
                addLine( access, p, base, 0, 0, line );
            else
                addColumns( access, p, base, 0, line[0] );
        } );
    scatter.contribute();
    return field;
}

// On a GPU the neighbours in a warp that have the same nodes are summed first,
// however many there are, and whoever between them adds nothing.
TEST( NodeSum, neighboursWithTheSameNodesAddAllThatIsTheirs )
{
    constexpr int n = 1003; // the last warp is not full
    constexpr int nodes = 40;
    std::mt19937 random( 5 );
    for ( const int longest : { 1, 4, 9, 70 } )
        for ( const int idle : { 0, 5 } ) // of 10
        {
            const IndexList first( "first", n );
            const auto host = Kokkos::create_mirror_view( first );
            std::vector<double> numbers( nodes ), counts( nodes );
            for ( int p = 0, left = 0, node = 0; p < n; ++p, --left )
            {
                if ( left == 0 )
                {
                    left = 1 + static_cast<int>( random() % longest );
                    node = static_cast<int>( random() % ( nodes - 1 ) );
                }
                host( p ) =
                    static_cast<int>( random() % 10 ) < idle ? -1 : node;
                if ( host( p ) < 0 )
                    continue;
                numbers[node] += p;
                counts[node + 1] += 1;
            }
            Kokkos::deep_copy( first, host );
            for ( const bool in_lines : { false, true } )
            {
                const auto sums = Kokkos::create_mirror_view_and_copy(
                    Kokkos::HostSpace(), addNumbers( first, nodes, in_lines ) );
                for ( int i = 0; i < nodes; ++i )
                {
                    EXPECT_EQ( sums( i, 0 ), numbers[i] )
                        << "runs of up to " << longest << ", node " << i;
                    EXPECT_EQ( sums( i, 1 ), in_lines ? counts[i] : 0 )
                        << "runs of up to " << longest << ", node " << i;
                }
            }
        }
}

// 2^-74 of the largest term is lost of each, so gas 1e-6 as dense still has
// every digit, and gas 1e-12 as dense ten.
TEST( NodeSum, losesNoDigitOfThinGas )
{
    const Line line;
    std::vector<int> order( 5000 );
    std::iota( order.begin(), order.end(), 0 );
    for ( const Real small : { 1.0, 1e-6, 1e-12 } )
    {
        const auto sum = line.sum( order, small, true );
        const auto terms = Kokkos::create_mirror_view_and_copy(
            Kokkos::HostSpace(), nodeTerms( order, small ) );
        const Real cut = std::ldexp( 1.0, -74 );
        for ( int node = 0; node < line.nodes; ++node )
            for ( int c = 0; c < 2; ++c )
            {
                long double exact = 0;
                for ( int k = node; k < 5000; k += line.nodes )
                    exact += terms( k, c );
                const Real value = sum( line.layout( { node } ), c );
                EXPECT_NEAR( static_cast<Real>( value - exact ), 0,
                             std::numeric_limits<Real>::epsilon() *
                                     std::abs( value ) +
                                 5000 / line.nodes * cut );
                EXPECT_NE( value, 0 );
            }
    }
}

TEST( NodeSum, passesOnWhatIsNotFinite )
{
    const Line line;
    for ( const Real bad : { std::numeric_limits<Real>::quiet_NaN(),
                             std::numeric_limits<Real>::infinity() } )
    {
        const auto sum = line.sum( { 0, 1, 2, 3 }, bad, true );
        EXPECT_FALSE( std::isfinite( sum( line.layout( { 2 } ), 0 ) ) );
    }
}

#endif

} // namespace
