/*!
  \file tstShapes.cpp
  \brief Signed-distance shapes against analysis.
*/
#include "tolerance.hpp"

#include <core/shape_input.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace Machpoint
{
namespace
{

using Host = Kokkos::HostSpace;
using Test::tolerance;

template <int Dim>
Shape<Dim, Host> hostShape( const Json& json )
{
    return makeShape<Dim, Host>( json );
}

template <int Dim>
std::vector<Vector<Dim>> randomPoints( int n, Real lower, Real upper,
                                       unsigned seed )
{
    std::mt19937 engine( seed );
    std::uniform_real_distribution<Real> draw( lower, upper );
    std::vector<Vector<Dim>> points( n );
    for ( auto& x : points )
        for ( int d = 0; d < Dim; ++d )
            x[d] = draw( engine );
    return points;
}

template <int Dim>
Vector<Dim> along( const Vector<Dim>& x, Real step, const Vector<Dim>& n )
{
    Vector<Dim> y;
    for ( int d = 0; d < Dim; ++d )
        y[d] = x[d] + step * n[d];
    return y;
}

template <int Dim>
Real norm( const Vector<Dim>& a )
{
    return std::sqrt( dot<Dim>( a, a ) );
}

std::vector<Vector<2>> toOutline( const Json& vertices )
{
    std::vector<Vector<2>> outline;
    for ( const Json& vertex : vertices )
        outline.push_back( toVector<2>( vertex ) );
    return outline;
}

//---------------------------------------------------------------------------//
// References that share nothing with the code under test.

//! Distance to the closest point of any edge.
Real outlineDistance( const std::vector<Vector<2>>& outline,
                      const Vector<2>& x )
{
    Real least = largest_quantity;
    for ( std::size_t i = 0; i < outline.size(); ++i )
    {
        const auto &a = outline[i], &b = outline[( i + 1 ) % outline.size()];
        const Vector<2> e = along<2>( b, -1, a ), r = along<2>( x, -1, a );
        const Real s =
            std::clamp<Real>( dot<2>( r, e ) / dot<2>( e, e ), 0, 1 );
        least = std::min( least, norm<2>( along<2>( r, -s, e ) ) );
    }
    return least;
}

//! Is x inside, by counting the edges that a ray along +x crosses?
bool isInside( const std::vector<Vector<2>>& outline, const Vector<2>& x )
{
    bool inside = false;
    for ( std::size_t i = 0; i < outline.size(); ++i )
    {
        const auto &a = outline[i], &b = outline[( i + 1 ) % outline.size()];
        if ( ( a[1] > x[1] ) != ( b[1] > x[1] ) &&
             x[0] < a[0] + ( x[1] - a[1] ) * ( b[0] - a[0] ) / ( b[1] - a[1] ) )
            inside = !inside;
    }
    return inside;
}

/*!
  What holds for every shape: the normal has unit length and is the gradient
  of the distance, and a walk of the distance against it ends on the surface.

  Within `skip` of a ridge, where the closest point jumps, the gradient has no
  value; such points are told by their neighbours' normals and counted out.
*/
template <int Dim>
void expectSignedDistance( const Shape<Dim, Host>& shape,
                           const std::vector<Vector<Dim>>& points,
                           bool surface_is_reached = true )
{
    const Real h = is_single ? 2e-4 : 1e-6;
    int checked = 0;
    for ( const auto& x : points )
    {
        const Real d = shape.distance( x );
        const Vector<Dim> n = shape.normal( x );
        ASSERT_NEAR( norm<Dim>( n ), 1, tolerance( 1e-14 ) );
        ASSERT_LE( shape.distanceBound( x ), d + tolerance( 1e-14 ) );

        if ( surface_is_reached )
        {
            ASSERT_NEAR( shape.distance( along<Dim>( x, -d, n ) ), 0,
                         tolerance( 1e-13 ) );
        }

        bool is_smooth = true;
        Vector<Dim> gradient;
        for ( int a = 0; a < Dim; ++a )
        {
            Vector<Dim> upper = x, lower = x;
            upper[a] += h;
            lower[a] -= h;
            gradient[a] =
                ( shape.distance( upper ) - shape.distance( lower ) ) /
                ( 2 * h );
            is_smooth = is_smooth && dot<Dim>( shape.normal( upper ),
                                               shape.normal( lower ) ) >
                                         1 - ( is_single ? 1e-5 : 1e-8 );
        }
        if ( !is_smooth )
            continue;
        ++checked;
        // Round-off of the difference is 1e-16 / h (6e-8 / h), its error far
        // smaller.
        for ( int a = 0; a < Dim; ++a )
            ASSERT_NEAR( gradient[a], n[a], is_single ? 5e-3 : 1e-7 );
    }
    // Ridges fill no volume, so nearly all points must have counted.
    EXPECT_GT( checked, ( is_single ? 0.8 : 0.95 ) * points.size() );
}

//---------------------------------------------------------------------------//
// Simple solids

template <int Dim>
Json sphereJson()
{
    Json center = Json::array();
    for ( int d = 0; d < Dim; ++d )
        center.push_back( 0.25 - 0.125 * d );
    return { { "type", "sphere" }, { "center", center }, { "radius", 0.75 } };
}

template <int Dim>
void testSphere()
{
    const Json json = sphereJson<Dim>();
    const auto sphere = hostShape<Dim>( json );
    const auto center = toVector<Dim>( json["center"] );
    const auto points = randomPoints<Dim>( 1000, -2, 2, 11 );
    for ( const auto& x : points )
        EXPECT_NEAR( sphere.distance( x ),
                     norm<Dim>( along<Dim>( x, -1, center ) ) - 0.75,
                     tolerance( 1e-15 ) );
    expectSignedDistance<Dim>( sphere, points );

    EXPECT_EQ( sphere.distance( center ), -0.75 );
    EXPECT_EQ( norm<Dim>( sphere.normal( center ) ), 1 );
    Vector<Dim> far{};
    far[Dim - 1] = -1e12;
    EXPECT_NEAR( sphere.normal( far )[Dim - 1], -1, tolerance( 1e-14 ) );
}

TEST( Shapes, Sphere )
{
    testSphere<1>();
    testSphere<2>();
    testSphere<3>();
}

template <int Dim>
Json boxJson()
{
    Json lower = Json::array(), upper = Json::array();
    for ( int d = 0; d < Dim; ++d )
    {
        lower.push_back( -0.5 + 0.25 * d );
        upper.push_back( 1.0 );
    }
    return { { "type", "box" }, { "lower", lower }, { "upper", upper } };
}

template <int Dim>
void testBox()
{
    const Json json = boxJson<Dim>();
    const auto box = hostShape<Dim>( json );
    const auto lower = toVector<Dim>( json["lower"] );
    const auto upper = toVector<Dim>( json["upper"] );
    const auto points = randomPoints<Dim>( 2000, -2, 2.5, 12 );
    int inside = 0;
    for ( const auto& x : points )
    {
        // Outside the closest point is x clamped to the box, corners included.
        Vector<Dim> closest;
        Real depth = 1e300;
        for ( int d = 0; d < Dim; ++d )
        {
            closest[d] = std::clamp( x[d], lower[d], upper[d] );
            depth = std::min( { depth, x[d] - lower[d], upper[d] - x[d] } );
        }
        inside += depth > 0;
        EXPECT_NEAR( box.distance( x ),
                     depth > 0 ? -depth
                               : norm<Dim>( along<Dim>( x, -1, closest ) ),
                     tolerance( 1e-15 ) );
    }
    EXPECT_GT( inside, 20 );
    expectSignedDistance<Dim>( box, points );

    // On a corner, on a face, and at the centre there is a normal, too; at a
    // corner and below it that of all its faces.
    EXPECT_EQ( box.distance( upper ), 0 );
    Vector<Dim> below = upper;
    for ( auto& y : below )
        y -= 0.125_rt;
    EXPECT_EQ( box.distance( below ), -0.125_rt );
    for ( const auto& x : { upper, below } )
        for ( const Real n : box.normal( x ) )
            EXPECT_NEAR( n, 1 / std::sqrt( Real( Dim ) ), tolerance( 1e-15 ) );
    Vector<Dim> face = lower;
    for ( int d = 1; d < Dim; ++d )
        face[d] = 0.5;
    EXPECT_EQ( box.normal( face )[0], -1 );
    const auto center =
        along<Dim>( lower, 0.5, along<Dim>( upper, -1, lower ) );
    EXPECT_NEAR( norm<Dim>( box.normal( center ) ), 1, tolerance( 1e-15 ) );
}

TEST( Shapes, Box )
{
    testBox<1>();
    testBox<2>();
    testBox<3>();
}

template <int Dim>
void testHalfSpace()
{
    // (1, -2, 2) is 3 long in 3D; the solid is behind the surface.
    const std::vector<Real> direction = { 1, -2, 2 };
    Json point = Json::array(), normal = Json::array();
    Vector<Dim> p, n;
    for ( int d = 0; d < Dim; ++d )
    {
        p[d] = 0.5 + d;
        n[d] = direction[d];
        point.push_back( p[d] );
        normal.push_back( n[d] );
    }
    const auto half = hostShape<Dim>( { { "type", "half_space" },
                                        { "point", point },
                                        { "normal", normal } } );
    const auto points = randomPoints<Dim>( 500, -3, 3, 13 );
    for ( const auto& x : points )
        EXPECT_NEAR( half.distance( x ),
                     dot<Dim>( n, along<Dim>( x, -1, p ) ) / norm<Dim>( n ),
                     tolerance( 1e-14 ) );
    expectSignedDistance<Dim>( half, points );
    EXPECT_GT( half.distance( along<Dim>( p, 1, n ) ), 0 );
}

TEST( Shapes, HalfSpace )
{
    testHalfSpace<1>();
    testHalfSpace<2>();
    testHalfSpace<3>();
}

//---------------------------------------------------------------------------//
// Polygons

void testPolygon( const std::vector<Vector<2>>& outline, const Json& json,
                  Real lower, Real upper, unsigned seed )
{
    const auto polygon = hostShape<2>( json );
    const auto points = randomPoints<2>( 1500, lower, upper, seed );
    int inside = 0;
    for ( const auto& x : points )
    {
        const bool is_inside = isInside( outline, x );
        inside += is_inside;
        const Real d = outlineDistance( outline, x );
        ASSERT_NEAR( polygon.distance( x ), is_inside ? -d : d,
                     tolerance( 1e-13 ) )
            << x[0] << " " << x[1];
    }
    EXPECT_GT( inside, 15 );
    expectSignedDistance<2>( polygon, points );

    // At and close to every vertex, acute and reflex ones.
    std::mt19937 engine( seed );
    std::uniform_real_distribution<Real> angle( 0, 2 * std::numbers::pi );
    for ( const auto& vertex : outline )
    {
        EXPECT_EQ( polygon.distance( vertex ), 0 );
        EXPECT_NEAR( norm<2>( polygon.normal( vertex ) ), 1,
                     tolerance( 1e-14 ) );
        for ( int i = 0; i < 20; ++i )
        {
            const Real a = angle( engine );
            const auto x =
                along<2>( vertex, 1e-7, { std::cos( a ), std::sin( a ) } );
            const Real d = outlineDistance( outline, x );
            // The sign of what is on the line to round-off means nothing.
            if ( d > 1e-14 )
            {
                EXPECT_NEAR( polygon.distance( x ),
                             isInside( outline, x ) ? -d : d,
                             tolerance( 1e-15 ) );
            }
        }
    }
    EXPECT_NEAR( polygon.distance( { 1e8, 0 } ) / 1e8, 1, 1e-7 );
    EXPECT_NEAR( polygon.normal( { 1e8, 0 } )[0], 1, 1e-7 );
}

TEST( Shapes, PolygonConcave )
{
    // A thin wedge, a slot with parallel walls and reflex corners.
    const Json vertices = { { 0, 0 },      { 2, 0.1 },  { 0.6, 0.2 },
                            { 1, 1 },      { 0.55, 1 }, { 0.55, 0.3 },
                            { 0.45, 0.3 }, { 0.45, 1 }, { -0.5, 1 } };
    testPolygon( toOutline( vertices ),
                 { { "type", "polygon" }, { "vertices", vertices } }, -1, 2.5,
                 21 );
}

TEST( Shapes, PolygonOfManyArcs )
{
    // A star whose radius swings, so that several arcs compete for a point.
    Json vertices = Json::array();
    const int n = 333;
    for ( int i = 0; i < n; ++i )
    {
        const Real a = 2 * std::numbers::pi * i / n;
        const Real r = 1 + 0.4 * std::sin( 9 * a );
        vertices.push_back( { r * std::cos( a ), r * std::sin( a ) } );
    }
    testPolygon( toOutline( vertices ),
                 { { "type", "polygon" }, { "vertices", vertices } }, -2, 2,
                 22 );
}

TEST( Shapes, PolygonSquareIsBox )
{
    const auto polygon = hostShape<2>(
        { { "type", "polygon" },
          { "vertices", { { -0.5, 0 }, { 1, 0 }, { 1, 2 }, { -0.5, 2 } } } } );
    const auto box = hostShape<2>( { { "type", "box" },
                                     { "lower", { -0.5, 0 } },
                                     { "upper", { 1, 2 } } } );
    for ( const auto& x : randomPoints<2>( 2000, -2, 3, 23 ) )
    {
        EXPECT_NEAR( polygon.distance( x ), box.distance( x ),
                     tolerance( 1e-14 ) );
        for ( int d = 0; d < 2; ++d )
            EXPECT_NEAR( polygon.normal( x )[d], box.normal( x )[d],
                         tolerance( 1e-13 ) );
    }
}

//---------------------------------------------------------------------------//
// Aerofoils

Json naca( const std::string& digits, Real chord, Real x, Real y, Real angle )
{
    return { { "type", "naca4" },
             { "digits", digits },
             { "chord", chord },
             { "leading_edge", { x, y } },
             { "angle", angle } };
}

TEST( Shapes, NacaIsAPolygon )
{
    for ( const char* digits : { "0012", "2412", "6321" } )
    {
        const Json json = naca( digits, 2, -1, 0.25, 8 );
        const auto outline = naca4Outline( json );
        EXPECT_EQ( outline.size(), 400u );
        EXPECT_EQ( outlineError( outline ), "" );
        testPolygon( outline, json, -1.5, 1.5, 24 );
    }
}

//! Where the upper and lower surface stand at x: from bisection along y.
std::pair<Real, Real> surfaces( const Shape<2, Host>& wing, Real x,
                                Real inside )
{
    const auto find = [&]( Real in, Real out )
    {
        while ( std::abs( in - out ) > tolerance( 1e-14 ) )
            ( wing.distance( { x, 0.5_rt * ( in + out ) } ) < 0 ? in : out ) =
                0.5_rt * ( in + out );
        return in;
    };
    return { find( inside, inside + 1 ), find( inside, inside - 1 ) };
}

TEST( Shapes, NacaThickness )
{
    const auto wing = hostShape<2>( naca( "0012", 1, 0, 0, 0 ) );
    Real thickest = 0, place = 0;
    for ( Real x = 0.05; x < 0.95; x += 0.005 )
    {
        const auto [upper, lower] = surfaces( wing, x, 0 );
        EXPECT_NEAR( upper, -lower, tolerance( 1e-11 ) );
        if ( upper - lower > thickest )
        {
            thickest = upper - lower;
            place = x;
        }
    }
    // The polynomial's greatest value is 0.12003 at 30% of the chord; a chord
    // of the outline is at most 8e-3 long and lies within 2e-5 of the curve.
    EXPECT_NEAR( thickest, 0.12003, 3e-5 );
    EXPECT_NEAR( place, 0.30, 0.01 );

    // The nose circle of radius 1.1019 t^2 touches the leading edge.
    const Real radius = 1.1019 * 0.12 * 0.12;
    EXPECT_NEAR( wing.distance( { radius, 0 } ), -radius, 0.02 * radius );

    // Closed, pointed, and of the right length.
    EXPECT_NEAR( wing.distance( { 1, 0 } ), 0, tolerance( 1e-15 ) );
    EXPECT_NEAR( wing.distance( { 0, 0 } ), 0, tolerance( 1e-15 ) );
    EXPECT_NEAR( wing.distance( { 1.5, 0 } ), 0.5, tolerance( 1e-15 ) );
    EXPECT_NEAR( wing.distance( { -0.5, 0 } ), 0.5, tolerance( 1e-15 ) );
}

TEST( Shapes, NacaCamber )
{
    // 4% at 40% of the chord, where the camber line is level and the
    // thickness is laid off along y.
    const auto wing = hostShape<2>( naca( "4412", 1, 0, 0, 0 ) );
    const auto [upper, lower] = surfaces( wing, 0.4, 0.04 );
    EXPECT_NEAR( 0.5 * ( upper + lower ), 0.04, 2e-5 );
    const Real x = 0.4;
    const Real half =
        0.6 * ( 0.2969 * std::sqrt( x ) - 0.1260 * x - 0.3516 * x * x +
                0.2843 * x * x * x - 0.1036 * x * x * x * x );
    EXPECT_NEAR( upper - lower, 2 * half, 4e-5 );
}

TEST( Shapes, NacaAngle )
{
    // Nose up turns the tail down about the leading edge.
    const Real chord = 2, angle = 10 * std::numbers::pi / 180;
    const auto wing = hostShape<2>( naca( "0012", chord, 0.3, 0.7, 10 ) );
    const Vector<2> tail = { 0.3 + chord * std::cos( angle ),
                             0.7 - chord * std::sin( angle ) };
    EXPECT_NEAR( wing.distance( tail ), 0, tolerance( 1e-15 ) );
    EXPECT_NEAR( wing.distance( { 0.3, 0.7 } ), 0, tolerance( 1e-15 ) );
    const Vector<2> middle = { 0.5_rt * ( 0.3_rt + tail[0] ),
                               0.5_rt * ( 0.7_rt + tail[1] ) };
    EXPECT_LT( wing.distance( middle ), -0.09 );
    EXPECT_GT( wing.distance( { middle[0], 1.4_rt - middle[1] } ), 0.1 );
}

//---------------------------------------------------------------------------//
// Unions

Json unionJson()
{
    const Json polygon = {
        { "type", "polygon" },
        { "vertices", { { 1, -1 }, { 2, -1 }, { 1.5, 0.5 } } } };
    const Json inner = { { "type", "union" },
                         { "shapes", { polygon, boxJson<2>() } } };
    return { { "type", "union" },
             { "shapes",
               { sphereJson<2>(), inner, naca( "0012", 1, -1.5, -1, 5 ),
                 polygon } } };
}

TEST( Shapes, UnionIsLeast )
{
    const auto all = hostShape<2>( unionJson() );
    std::vector<Shape<2, Host>> members;
    const Json json = unionJson();
    for ( const int i : { 0, 2, 3 } )
        members.push_back( hostShape<2>( json["shapes"][i] ) );
    members.push_back( hostShape<2>( boxJson<2>() ) );

    const auto points = randomPoints<2>( 3000, -3, 3, 31 );
    for ( const auto& x : points )
    {
        Real least = largest_quantity;
        for ( const auto& member : members )
            least = std::min( least, member.distance( x ) );
        EXPECT_EQ( all.distance( x ), least );
    }
    // Where members overlap, the surface is farther than the distance says.
    expectSignedDistance<2>( all, points, false );
}

TEST( Shapes, EmptyShapeIsFarAway )
{
    const Shape<3, Host> nothing;
    EXPECT_GT( nothing.distance( { 0, 0, 0 } ), largest_quantity );
    EXPECT_EQ( norm<3>( nothing.normal( { 0, 0, 0 } ) ), 1 );
}

//! Where squares overflow, far away is still far away.
TEST( Shapes, FarAway )
{
    const auto all = hostShape<2>( unionJson() );
    for ( const Real x :
          { 1e10_rt * largest_speed, std::numeric_limits<Real>::infinity() } )
        EXPECT_GT( all.distance( { x, -x } ), largest_speed );
}

//---------------------------------------------------------------------------//
// Kernels

//! Evaluates in a kernel of the build's backend and compares with the host.
template <int Dim>
void testKernel( const Json& json )
{
    const int n = 2000;
    const auto points = randomPoints<Dim>( n, -3, 3, 41 );
    Kokkos::View<Vector<Dim>*, MemorySpace> x( "x", n );
    Kokkos::View<Nearest<Dim>*, MemorySpace> result( "result", n );
    Kokkos::View<Real*, MemorySpace> bound( "bound", n );
    auto x_host = Kokkos::create_mirror_view( x );
    for ( int i = 0; i < n; ++i )
        x_host( i ) = points[i];
    Kokkos::deep_copy( x, x_host );

    const auto shape = makeShape<Dim>( json );
    Kokkos::parallel_for(
        "Machpoint::testShape", Range( 0, n ), KOKKOS_LAMBDA( int i ) {
            result( i ) = { shape.distance( x( i ) ), shape.normal( x( i ) ) };
            bound( i ) = shape.distanceBound( x( i ) );
        } );

    const auto result_host =
        Kokkos::create_mirror_view_and_copy( Host(), result );
    const auto bound_host =
        Kokkos::create_mirror_view_and_copy( Host(), bound );
    const auto reference = hostShape<Dim>( json );
    for ( int i = 0; i < n; ++i )
    {
        // A device may contract to fused multiply-adds.
        EXPECT_NEAR( result_host( i ).distance, reference.distance( points[i] ),
                     tolerance( 1e-14 ) );
        EXPECT_NEAR(
            dot<Dim>( result_host( i ).normal, reference.normal( points[i] ) ),
            1, tolerance( 1e-12 ) );
        EXPECT_LE( bound_host( i ),
                   result_host( i ).distance + tolerance( 1e-14 ) );
    }
}

TEST( Shapes, Kernel )
{
    testKernel<1>( { { "type", "union" },
                     { "shapes", { sphereJson<1>(), boxJson<1>() } } } );
    testKernel<2>( unionJson() );
    testKernel<3>( { { "type", "union" },
                     { "shapes", { sphereJson<3>(), boxJson<3>() } } } );
}

//---------------------------------------------------------------------------//
// Declaration and checks

std::vector<std::string> errorsOf( const Json& json )
{
    std::vector<std::string> errors;
    checkShape( json, "/s", errors );
    return errors;
}

//! Expects one error that begins with a place and holds a phrase.
void expectError( const Json& json, const std::string& place,
                  const std::string& phrase )
{
    const auto errors = errorsOf( json );
    ASSERT_EQ( errors.size(), 1u ) << json;
    EXPECT_TRUE( errors[0].starts_with( place + ": " ) ) << errors[0];
    EXPECT_NE( errors[0].find( phrase ), std::string::npos ) << errors[0];
}

Json polygonJson( const Json& vertices )
{
    return { { "type", "polygon" }, { "vertices", vertices } };
}

TEST( Shapes, GoodShapesPass )
{
    EXPECT_EQ( errorsOf( unionJson() ), std::vector<std::string>{} );
    EXPECT_EQ( errorsOf( sphereJson<3>() ), std::vector<std::string>{} );
    for ( const char* digits : { "0001", "0412", "9912", "0099" } )
        EXPECT_EQ( errorsOf( naca( digits, 3, 0, 0, 30 ) ),
                   std::vector<std::string>{} )
            << digits;
    EXPECT_EQ( errorsOf( polygonJson( { { 0, 0 }, { 1, 0 }, { 0, 1 } } ) ),
               std::vector<std::string>{} );
    // A vertex in the middle of a straight side is no fault.
    EXPECT_EQ( errorsOf( polygonJson(
                   { { 0, 0 }, { 1, 0 }, { 2, 0 }, { 0.1, 0.1 } } ) ),
               std::vector<std::string>{} );
}

TEST( Shapes, BadPolygons )
{
    const auto bad = []( const Json& vertices, const std::string& phrase )
    { expectError( polygonJson( vertices ), "/s/vertices", phrase ); };
    bad( { { 0, 0 }, { 1, 0 } }, "at least 3 vertices, not 2" );
    bad( { { 0, 0 }, { 0, 1 }, { 1, 0 } }, "clockwise" );
    bad( { { 0, 0 }, { 1, 0 }, { 1, 0 }, { 0, 1 } }, "vertices 1 and 2" );
    bad( { { 0, 0 }, { 1, 0 }, { 0, 1 }, { 0, 0 } }, "closes by itself" );
    // a bow tie; a corner that touches a side; one vertex passed twice
    bad( { { 0, 0 }, { 1, 1 }, { 1, 0 }, { 0, 1 } }, "edges 0-1 and 2-3" );
    bad( { { 0, 0 }, { 2, 0 }, { 2, 2 }, { 1, 0 }, { 0, 2 } },
         "cross or touch" );
    bad( { { 0, 0 }, { 1, 1 }, { 2, 0 }, { 2, 2 }, { 1, 1 }, { 0, 2 } },
         "cross or touch" );
    // no area, a spike
    bad( { { 0, 0 }, { 1, 1 }, { 2, 2 } }, "turns back on itself" );
    bad( { { 0, 0 }, { 1, 0 }, { 1, 0.3 }, { 3, 0.9 }, { 1, 0.3 }, { 0, 1 } },
         "turns back on itself at vertex 3" );
}

TEST( Shapes, BadOthers )
{
    expectError(
        { { "type", "box" }, { "lower", { 0, 1 } }, { "upper", { 1, 1 } } },
        "/s/upper/1", "greater than lower (1), not 1" );
    expectError( { { "type", "half_space" },
                   { "point", { 0, 1 } },
                   { "normal", { 0, 0 } } },
                 "/s/normal", "direction" );
    expectError( naca( "012", 1, 0, 0, 0 ), "/s/digits", "four digits" );
    expectError( naca( "23012", 1, 0, 0, 0 ), "/s/digits", "four digits" );
    expectError( naca( "00-2", 1, 0, 0, 0 ), "/s/digits", "four digits" );
    expectError( naca( "2400", 1, 0, 0, 0 ), "/s/digits", "thickness" );
    expectError( naca( "2012", 1, 0, 0, 0 ), "/s/digits", "camber" );

    const Json bad = polygonJson( { { 0, 0 }, { 0, 1 }, { 1, 0 } } );
    const Json nested = { { "type", "union" },
                          { "shapes", Json::array( { bad } ) } };
    const Json list = { { "type", "union" },
                        { "shapes", { sphereJson<2>(), nested, bad } } };
    const auto errors = errorsOf( list );
    ASSERT_EQ( errors.size(), 2u );
    EXPECT_TRUE( errors[0].starts_with( "/s/shapes/1/shapes/0/vertices: " ) );
    EXPECT_TRUE( errors[1].starts_with( "/s/shapes/2/vertices: " ) );
    EXPECT_THROW( makeShape<3>( bad ), std::invalid_argument );
}

TEST( Shapes, Declaration )
{
    const auto names = []( int dimension )
    {
        std::vector<std::string> result;
        for ( const auto& shape : shapeFamily().members( dimension ) )
            result.push_back( shape.name() );
        return result;
    };
    const std::vector<std::string> solids = { "sphere", "box", "half_space",
                                              "union" };
    const std::vector<std::string> all = { "sphere",  "box",   "half_space",
                                           "polygon", "naca4", "union" };
    EXPECT_EQ( names( 1 ), solids );
    EXPECT_EQ( names( 2 ), all );
    EXPECT_EQ( names( 3 ), solids );
    EXPECT_EQ( names( 0 ), all );

    // From a written input to a shape: defaults filled in, ranges kept.
    Parameters parameters( "input", "an input with a shape", 2 );
    parameters.oneOf( "shape", shapeFamily(), "the shape" );
    std::vector<std::string> errors;
    const Json wing = { { "type", "naca4" },
                        { "digits", "0012" },
                        { "leading_edge", { 0, 0 } } };
    const Json resolved =
        resolve( { { "shape", wing } }, parameters, "f", errors );
    ASSERT_TRUE( errors.empty() ) << errors[0];
    EXPECT_NEAR( hostShape<2>( resolved["shape"] ).distance( { 1, 0 } ), 0,
                 tolerance( 1e-15 ) );
    resolve( { { "shape", unionJson() } }, parameters, "f", errors );
    EXPECT_TRUE( errors.empty() ) << errors[0];

    const Json flat = {
        { "type", "sphere" }, { "center", { 0, 0 } }, { "radius", 0 } };
    resolve( { { "shape", flat } }, parameters, "f", errors );
    EXPECT_EQ( errors.size(), 1u );
}

} // namespace
} // namespace Machpoint
