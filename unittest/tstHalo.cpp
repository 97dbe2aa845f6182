// Fold and fill: images beyond the sides of the domain.
#include "halos.hpp"
#include "tolerance.hpp"

#include <core/basis.hpp>
#include <core/halo.hpp>
#include <core/random.hpp>

#include <gtest/gtest.h>

namespace
{

using namespace Machpoint;
using Test::makeHalo;
using Test::tolerance;

//! Fills a field from a function of (row, column) on the host.
template <class Function>
void set( const NodeView& field, const Function& value )
{
    auto host = Kokkos::create_mirror_view( field );
    for ( std::size_t i = 0; i < field.extent( 0 ); ++i )
        for ( std::size_t c = 0; c < field.extent( 1 ); ++c )
            host( i, c ) =
                value( static_cast<int>( i ), static_cast<int>( c ) );
    Kokkos::deep_copy( field, host );
}

template <class T>
class HaloTest : public testing::Test
{
};
using Bases = testing::Types<Linear, Quadratic, Cubic>;
TYPED_TEST_SUITE( HaloTest, Bases );

// A periodic side's image is shifted by the period: a function of the node's
// position with that period is its own fill.
TYPED_TEST( HaloTest, fillContinuesAPeriodicField )
{
    const Grid<2> grid( { 0, 0 }, { 1, 1 }, { 5, 4 } );
    const auto layout = nodeLayout<TypeParam>( grid );
    const auto halo =
        makeHalo<2>( layout, { SideKind::periodic, SideKind::periodic } );
    NodeView field( "field", layout.total, 1 );
    const Real turn = 2 * M_PI;
    auto value = [&]( const int row, int )
    {
        const auto x = layout.position( layout.indices( row ) );
        return std::sin( turn * x[0] ) + std::cos( turn * x[1] );
    };
    set( field,
         [&]( const int row, const int c ) {
             return layout.isOwned( layout.indices( row ) ) ? value( row, c )
                                                            : 1e9;
         } );
    halo.fill( field, NodeComponents<1>{} );
    auto host =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), field );
    for ( int row = 0; row < layout.total; ++row )
        EXPECT_NEAR( host( row, 0 ), value( row, 0 ), tolerance( 1e-14 ) );
}

// A slip wall mirrors scalars evenly and the normal velocity oddly; an open
// side mirrors velocities evenly; a no-slip wall negates all of them.
TYPED_TEST( HaloTest, fillMirrorsAtWalls )
{
    const Grid<2> grid( { 0, 0 }, { 1, 1 }, { 6, 5 } );
    const auto layout = nodeLayout<TypeParam>( grid );
    struct Case
    {
        SideKind kind;
        Real normal, tangential;
    };
    for ( const auto& c :
          { Case{ SideKind::slip, -1, 1 }, Case{ SideKind::no_slip, -1, -1 },
            Case{ SideKind::open, 1, 1 } } )
    {
        const auto halo = makeHalo<2>( layout, { c.kind, SideKind::periodic } );
        NodeView field( "field", layout.total, 3 );
        set( field, [&]( const int row, const int column )
             { return 1 + row + 1000 * column; } );
        NodeComponents<3> components{};
        components[1] = { Parity::velocity, 0 };
        components[2] = { Parity::velocity, 1 };
        halo.fill( field, components );
        auto host =
            Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), field );
        const int vertex = layout.centred ? 0 : 1;
        for ( int k = 1; k <= layout.halo[0]; ++k )
            for ( const bool upper : { false, true } )
            {
                const int last = layout.owned[0] - 1;
                const int node = upper ? last + k : -k;
                const int image =
                    upper ? last + 1 - k - vertex : k - 1 + vertex;
                const int a = layout( { node, 2 } );
                const int b = layout( { image, 2 } );
                EXPECT_EQ( host( a, 0 ), host( b, 0 ) );
                EXPECT_EQ( host( a, 1 ), c.normal * host( b, 1 ) );
                EXPECT_EQ( host( a, 2 ), c.tangential * host( b, 2 ) );
            }
    }
}

// Fold is the adjoint of fill: sum over all stored nodes of a . fill(b) equals
// the weighted sum over owned nodes of fold(a) . b, for any a and b.
template <class Basis, int Dim>
void checkAdjoint( const std::array<SideKind, 3>& kind )
{
    Vector<Dim> lower{}, upper{};
    Indices<Dim> cells{};
    for ( int d = 0; d < Dim; ++d )
    {
        upper[d] = 1;
        cells[d] = 4 + d;
    }
    const Grid<Dim> grid( lower, upper, cells );
    const auto layout = nodeLayout<Basis>( grid );
    const auto halo = makeHalo<Dim>( layout, kind );
    constexpr int columns = 1 + Dim;
    NodeComponents<columns> components{};
    for ( int d = 0; d < Dim; ++d )
        components[1 + d] = { Parity::velocity, d };
    NodeView a( "a", layout.total, columns ), b( "b", layout.total, columns );
    set( a, []( const int row, const int c )
         { return uniformRandom( 1, row, c ) - 0.5; } );
    set( b, []( const int row, const int c )
         { return uniformRandom( 2, row, c ) - 0.5; } );
    // b must be a field that fill leaves alone on owned nodes: at a wall
    // vertex a component that the wall negates is zero.
    halo.fill( b, components );
    NodeView twice( "twice", layout.total, columns );
    auto hb = Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), b );
    if ( !layout.centred )
        for ( int row = 0; row < layout.total; ++row )
        {
            const auto i = layout.indices( row );
            for ( int d = 0; d < Dim; ++d )
                if ( i[d] == 0 || i[d] == layout.owned[d] - 1 )
                    for ( int c = 1; c < columns; ++c )
                        if ( imageSign( kind[d], components[c], d ) < 0 )
                            hb( row, c ) = 0;
        }
    Kokkos::deep_copy( b, hb );
    halo.fill( b, components );
    Kokkos::deep_copy( hb, b );
    auto ha = Kokkos::create_mirror_view( a );
    Kokkos::deep_copy( ha, a );
    Real everywhere = 0, owned = 0, scale = 0;
    for ( int row = 0; row < layout.total; ++row )
        for ( int c = 0; c < columns; ++c )
        {
            everywhere += ha( row, c ) * hb( row, c );
            scale += std::abs( ha( row, c ) * hb( row, c ) );
        }
    halo.fold( a, components );
    Kokkos::deep_copy( ha, a );
    // A weight reads device memory.
    const auto weight = halo.weights();
    Kokkos::View<Real*, MemorySpace> weights( "weights", layout.total );
    Kokkos::parallel_for(
        "weights", Range( 0, layout.total ), KOKKOS_LAMBDA( const int row ) {
            weights( row ) = weight( layout.indices( row ) );
        } );
    auto hw =
        Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), weights );
    for ( int row = 0; row < layout.total; ++row )
        for ( int c = 0; c < columns; ++c )
            owned += hw( row ) * ha( row, c ) * hb( row, c );
    EXPECT_NEAR( everywhere, owned, tolerance( 1e-14 ) * scale );
}

TYPED_TEST( HaloTest, foldIsTheAdjointOfFill )
{
    using K = SideKind;
    for ( const K kind : { K::periodic, K::slip, K::no_slip, K::open } )
    {
        checkAdjoint<TypeParam, 1>( { kind } );
        checkAdjoint<TypeParam, 2>( { kind, K::slip } );
        checkAdjoint<TypeParam, 3>( { K::periodic, kind, K::no_slip } );
    }
}

TEST( Halo, tooFewCellsAreAnError )
{
    const Grid<1> grid( { 0 }, { 1 }, { 1 } );
    EXPECT_THROW( makeHalo<1>( nodeLayout<Cubic>( grid ), { SideKind::slip } ),
                  std::invalid_argument );
    EXPECT_NO_THROW(
        makeHalo<1>( nodeLayout<Linear>( grid ), { SideKind::slip } ) );
}

} // namespace
