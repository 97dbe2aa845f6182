// The method `conservative` and its parts: what each promises exactly.
#include "scenes.hpp"

#include <core/conservative/gather.hpp>
#include <core/conservative/merging.hpp>
#include <core/random.hpp>
#include <core/scene.hpp>
#include <core/stencil.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace
{

using namespace Machpoint;
using namespace Test;

//! The 2D particle nearest to a place, which is to be there but for round-off.
std::size_t particleAt( const ParticleData& data, const double x,
                        const double y )
{
    std::size_t nearest = 0;
    double least = 1;
    for ( std::size_t p = 0; p < data.mass.size(); ++p )
    {
        const double distance = std::hypot( data.position[2 * p] - x,
                                            data.position[2 * p + 1] - y );
        if ( distance < least )
        {
            nearest = p;
            least = distance;
        }
    }
    EXPECT_LT( least, is_single ? 1e-3 : 1e-6 ) << x << " " << y;
    return nearest;
}

const std::vector<std::string> boundaries = { "slip_wall", "no_slip_wall",
                                              "periodic", "outflow" };

template <class Basis>
class HalfwayTest : public testing::Test
{
};
using Bases = testing::Types<Linear, Quadratic, Cubic>;
TYPED_TEST_SUITE( HalfwayTest, Bases );

// The weights between nodes are positive, sum to one, and their differences
// are the gradients of the node weights: d_a w_i = (w_(i-1/2) - w_(i+1/2)) / h.
TYPED_TEST( HalfwayTest, differencesAreTheGradients )
{
    const Grid<2> grid( { 0, 0 }, { 1, 3 }, { 5, 6 } );
    const auto layout = nodeLayout<TypeParam>( grid );
    constexpr int n = TypeParam::nodes;
    for ( int k = 0; k < 50; ++k )
    {
        const Vector<2> x = { uniformRandom( 1, k, 0 ),
                              3 * uniformRandom( 1, k, 1 ) };
        const Stencil<TypeParam, 2> s( grid, layout, x );
        const HalfwayWeights<TypeParam, 2> halfway( grid, s );
        for ( int d = 0; d < 2; ++d )
        {
            Real sum = 0, slopes = 0;
            for ( int i = 0; i < n; ++i )
            {
                const Real before = i > 0 ? halfway.c[d][i - 1] : 0.0;
                const Real after = i < n - 1 ? halfway.c[d][i] : 0.0;
                EXPECT_NEAR( s.dw[d][i] * grid.spacing[d], before - after,
                             tolerance( 1e-13 ) );
                if ( i < n - 1 )
                {
                    EXPECT_GE( after, -tolerance( 1e-15 ) );
                    sum += after;
                    slopes += halfway.dc[d][i];
                }
            }
            EXPECT_NEAR( sum, 1, tolerance( 1e-14 ) );
            EXPECT_NEAR( slopes, 0, tolerance( 1e-14 ) );
            // The slopes are the weights' derivatives.
            const Real step = ( is_single ? 1e-2 : 1e-6 ) * grid.spacing[d];
            auto y = x;
            y[d] += grid.cell( x[d] + step, d ) == grid.cell( x[d], d ) ? step
                                                                        : -step;
            const Stencil<TypeParam, 2> moved( grid, layout, y );
            const HalfwayWeights<TypeParam, 2> other( grid, moved );
            for ( int i = 0; i < n - 1; ++i )
                EXPECT_NEAR( ( other.c[d][i] - halfway.c[d][i] ) /
                                 ( y[d] - x[d] ) * grid.spacing[d],
                             halfway.dc[d][i], is_single ? 2e-2 : 1e-5 );
        }
    }
}

class AnyBox
    : public testing::TestWithParam<std::tuple<int, std::string, std::string>>
{
};

// A uniform pressure exerts no force, however the particles lie, beside any
// side: the faces are normalised by the volume that they receive.
TEST_P( AnyBox, uniformPressureHasNoForce )
{
    const auto [dimension, basis, boundary] = GetParam();
    const int cells[] = { 20, 8, 4 };
    // In 1D few particles at random would leave faces nearly empty, which
    // least_filling then treats as the edge of a vacuum.
    auto input = box( dimension, cells[dimension - 1], dimension == 1 ? 6 : 2,
                      "conservative", basis, boundary );
    addViscosity( input );
    input["particles"]["placement"] = "random";
    auto run = simulate( input );
    advance( *run, 100 );
    const auto data = run->particleData();
    EXPECT_LE( largest( data.velocity ), tolerance( 1e-11 ) );
    for ( const Real pressure : data.pressure )
        EXPECT_NEAR( pressure, 1, tolerance( 1e-10 ) );
}

INSTANTIATE_TEST_SUITE_P( Everywhere, AnyBox,
                          testing::Combine( testing::Values( 1, 2, 3 ),
                                            testing::ValuesIn( bases ),
                                            testing::ValuesIn( boundaries ) ) );

//! Every particle by id: position, velocity, density, energy.
std::map<std::int64_t, std::vector<Real>> byId( Simulation& run )
{
    const auto data = run.particleData();
    const int dim = run.dimension();
    std::map<std::int64_t, std::vector<Real>> list;
    for ( std::size_t p = 0; p < data.id.size(); ++p )
    {
        auto& row = list[data.id[p]];
        for ( int d = 0; d < dim; ++d )
        {
            row.push_back( data.position[p * dim + d] );
            row.push_back( data.velocity[p * dim + d] );
        }
        row.push_back( data.density[p] );
        row.push_back( data.specific_internal_energy[p] );
    }
    return list;
}

//! A shock tube in a box, and the same with a plane of images for its wall at
//! x = 1.
std::array<Json, 2> wallAndPlane( const std::string& basis,
                                  const std::string& time )
{
    auto wall = shockTube( 2, 12, 2, "conservative", basis );
    addViscosity( wall );
    wall["method"]["time"] = time;
    wall["method"]["split_volume"] = 0; // ids stay comparable
    wall["method"]["merge_volume"] = 0;
    wall["time"]["cfl"] = 0.4;
    auto plane = wall;
    plane["grid"]["upper"] = { 1.5, 1.0 };
    plane["grid"]["cells"] = { 18, 12 };
    plane["boundary"].push_back( { { "type", "obstacle" },
                                   { "image_reach", 4 },
                                   { "shape",
                                     { { "type", "half_space" },
                                       { "point", { 1, 0 } },
                                       { "normal", { -1, 0 } } } } } );
    return { wall, plane };
}

void expectSameGas( const Json& wall, const Json& plane, const Real end,
                    const std::string& label )
{
    auto a = simulate( wall ), b = simulate( plane );
    advanceTo( *a, end );
    advanceTo( *b, end );
    // Ids count cells, so they differ; positions identify.
    const auto x = a->particleData(), y = b->particleData();
    ASSERT_EQ( x.mass.size(), y.mass.size() );
    for ( std::size_t p = 0; p < x.mass.size(); ++p )
    {
        const auto twin =
            particleAt( y, x.position[2 * p], x.position[2 * p + 1] );
        EXPECT_NEAR( x.density[p], y.density[twin], tolerance( 1e-9 ) )
            << label;
    }
}

// A plane that follows the grid reflects by images as the box's own wall does
// by its halo.
TEST( Images, areTheWallsHaloOnAGridPlane )
{
    for ( const auto& basis : bases )
        for ( const std::string time : { "symplectic", "midpoint" } )
        {
            const auto [wall, plane] = wallAndPlane( basis, time );
            expectSameGas( wall, plane, 0.5, basis + " " + time );
        }
}

// So it does where the gas has weight: that of an image is mirrored, too. (Gas
// that falls aslant amplifies rounding.)
TEST( Images, areTheWallsHaloForHeavyGas )
{
    for ( const bool is_reproducible : { false, true } )
        for ( const Json& g : { Json{ 1.0, 0.0 }, Json{ 0.7, -0.9 } } )
        {
            auto [wall, plane] = wallAndPlane( "quadratic", "midpoint" );
            for ( auto* input : { &wall, &plane } )
            {
                ( *input )["reproducible"] = is_reproducible;
                ( *input )["physics"].push_back(
                    { { "type", "gravity" }, { "acceleration", g } } );
            }
            expectSameGas( wall, plane, 0.25, g.dump() );
        }
}

// So it does where gas leaves through a side that the plane meets: particles
// that are beyond it at half a step have their images there, too.
TEST( Images, areTheWallsHaloBeyondASide )
{
    for ( const auto& basis : bases )
    {
        auto [wall, plane] = wallAndPlane( basis, "midpoint" );
        for ( auto* input : { &wall, &plane } )
        {
            ( *input )["boundary"][2]["type"] = "outflow";
            for ( const std::string part : { "left", "right" } )
                ( *input )["initial"][0][part]["velocity"] = { 0, -3 };
        }
        expectSameGas( wall, plane, 0.1, basis );
    }
}

// Gas that stands on a body presses on it with the pressure at its foot, and
// the body does no work.
TEST( Images, carryAColumn )
{
    auto input = box( 1, 55, 3, "conservative", "quadratic", "slip_wall" );
    input["grid"]["lower"] = { -0.1 };
    input["physics"].push_back(
        { { "type", "gravity" }, { "acceleration", { -1 } } } );
    input["initial"][0] = { { "type", "hydrostatic" }, { "axis", "x" },
                            { "position", 0 },         { "density", 1 },
                            { "pressure", 1 },         { "gravity", -1 } };
    input["boundary"].push_back( { { "type", "obstacle" },
                                   { "shape",
                                     { { "type", "half_space" },
                                       { "point", { 0 } },
                                       { "normal", { 1 } } } } } );
    auto run = simulate( input );
    const Real before = run->totals().energy();
    advanceTo( *run, 1 );
    EXPECT_LE( largest( run->particleData().velocity ), 2e-4 );
    EXPECT_NEAR( run->totals().energy() - before, run->ledger().energy_in,
                 tolerance( 1e-13 ) );
    const auto rows = run->series().at( 0 )->rows;
    Real force = 0;
    for ( const auto& row : rows )
        force += row.at( 1 ) / static_cast<Real>( rows.size() );
    EXPECT_NEAR( force, -1, 1e-3 );
}

// Images leave gaps where the image of a place in the body is in another wall:
// behind acute corners, cusps and notches. No vacuum draws gas into them. (On
// hats few particles fill a face, whatever is left open for them.)
TEST( Images, letGasRestInCorners )
{
    const Json ball = {
        { "type", "sphere" }, { "center", { 0.5, 0.2 } }, { "radius", 0.2 } };
    const Json other = {
        { "type", "sphere" }, { "center", { 0.5, 0.6 } }, { "radius", 0.2 } };
    const std::vector<std::vector<Json>> scenes = {
        { { { "type", "half_space" },
            { "point", { 0.03, 0.25 } },
            { "normal", { -std::sqrt( 0.75 ), 0.5 } } } },
        { { { "type", "polygon" },
            { "vertices",
              { { 0.2, 0.2 },
                { 0.8, 0.2 },
                { 0.8, 0.6 },
                { 0.5, 0.3 },
                { 0.2, 0.6 } } } } },
        { ball },
        { { { "type", "union" }, { "shapes", { ball, other } } } },
        { ball, other } };
    for ( const auto& basis : bases )
        for ( const auto& bodies : scenes )
            for ( const int rows : { 24, 60 } ) // cells long or wide, too
            {
                auto input =
                    box( 2, 24, 2, "conservative", basis, "slip_wall" );
                addViscosity( input );
                input["grid"]["cells"] = { 24, rows };
                addBodies( input, bodies );
                auto run = simulate( input );
                advanceTo( *run, 0.5 );
                EXPECT_LE( largest( run->particleData().velocity ),
                           basis == "linear" ? 0.05 : 2e-3 )
                    << basis << rows << Json( bodies );
            }
}

// And where a corner lies anywhere in a cell, of one body or of two: few
// particles fill faces that images leave half empty.
TEST( Images, letGasRestInAnyCorner )
{
    const auto half_space = []( const Json& point, const Json& normal )
    {
        return Json{ { "type", "half_space" },
                     { "point", point },
                     { "normal", normal } };
    };
    for ( const auto& [u, v] : { std::pair( 0.75, 0.45 ),
                                 { 0.4, 0.73 },
                                 { 0.33, 0.26 },
                                 { 0.42, 0.74 } } )
        for ( const bool is_one : { false, true } )
        {
            const Json corner = { ( 8 + u ) / 32, ( 8 + v ) / 32 };
            const Json left = half_space( corner, { 1, 0 } );
            const Json floor = half_space( corner, { 0, 1 } );
            auto input =
                box( 2, 32, 2, "conservative", "quadratic", "slip_wall" );
            addViscosity( input );
            if ( is_one )
                addBodies( input, { { { "type", "union" },
                                      { "shapes", { left, floor } } } } );
            else
                addBodies( input, { left, floor } );
            auto run = simulate( input );
            advanceTo( *run, 0.5 );
            EXPECT_LE( largest( run->particleData().velocity ),
                       tolerance( 1e-12 ) )
                << u << " " << v << " " << is_one;
        }
}

// What is projected beside a body with images is a wall to it: what images
// leave empty in the cusp stands for the wall, and no image comes from within.
TEST( Images, letGasRestBesideAProjection )
{
    const Json pad = {
        { "type", "box" }, { "lower", { -1, -1 } }, { "upper", { 2, 0.125 } } };
    const Json ball = { { "type", "sphere" },
                        { "center", { 0.513, 0.325 } },
                        { "radius", 0.2 } };
    for ( const bool is_first : { false, true } )
    {
        auto input = box( 2, 32, 2, "conservative", "quadratic", "slip_wall" );
        addViscosity( input );
        addBodies( input, is_first ? std::vector<Json>{ pad, ball }
                                   : std::vector<Json>{ ball, pad } );
        input["boundary"][is_first ? 4 : 5]["treatment"] = "projection";
        input["particles"]["placement"] = "lattice";
        auto run = simulate( input );
        advanceTo( *run, 0.5 );
        EXPECT_LE( largest( run->particleData().velocity ), 0.02 ) << is_first;
    }
}

// So in 3D: around a ball on the floor.
TEST( Images, letGasRestBelowABall )
{
    auto input = box( 3, 12, 2, "conservative", "quadratic", "slip_wall" );
    addViscosity( input );
    input["boundary"].push_back( { { "type", "obstacle" },
                                   { "shape",
                                     { { "type", "sphere" },
                                       { "center", { 0.5, 0.5, 0.3 } },
                                       { "radius", 0.3 } } } } );
    auto run = simulate( input );
    advanceTo( *run, 0.5 );
    EXPECT_LE( largest( run->particleData().velocity ), 2e-3 );
}

// The gas between two bodies presses on each alike, and its nodes rest for one
// of them only: their forces sum to that on both as one.
TEST( Images, pressOnBodiesThatTouch )
{
    auto ball = []( const Real y )
    {
        return Json{ { "type", "sphere" },
                     { "center", { 0.5, y } },
                     { "radius", 0.15 } };
    };
    auto scene = [&]( const std::vector<Json>& bodies )
    {
        auto input = box( 2, 24, 2, "conservative", "quadratic", "slip_wall" );
        addViscosity( input );
        input["initial"][0]["velocity"] = { 0.5, 0 };
        addBodies( input, bodies );
        auto run = simulate( input );
        advanceTo( *run, 0.2 );
        return run;
    };
    const auto run = scene( { ball( 0.35 ), ball( 0.65 ) } );
    std::array<Vector<2>, 2> impulse{};
    for ( const int b : { 0, 1 } )
    {
        Real before = 0;
        for ( const auto& row : run->series().at( b )->rows )
        {
            for ( const int d : { 0, 1 } )
                impulse[b][d] += row.at( 1 + d ) * ( row.at( 0 ) - before );
            before = row.at( 0 );
        }
    }
    EXPECT_GT( impulse[0][0], 0.01 );
    EXPECT_NEAR( impulse[0][0] / impulse[1][0], 1, 0.02 );
    EXPECT_NEAR( impulse[0][1] / impulse[1][1], -1, 0.05 );
}

// Nothing is missing in a body whose faces are flush with sides of the domain,
// or that is made of parts which touch or overlap.
TEST( Images, findNoGapsWhereTheGasIsMirrored )
{
    auto scene = []( const Json& shape )
    {
        auto input = box( 2, 20, 2, "conservative", "quadratic", "slip_wall" );
        input["initial"][0]["velocity"] = { 0.3, 0.1 };
        input["method"]["split_volume"] = 0;
        input["method"]["merge_volume"] = 0;
        input["boundary"].push_back(
            { { "type", "obstacle" }, { "shape", shape } } );
        return input;
    };
    auto block = []( const Json& lower, const Json& upper ) {
        return Json{
            { "type", "box" }, { "lower", lower }, { "upper", upper } };
    };
    const auto whole = scene( block( { 0.4, -1 }, { 2, 0.32 } ) );
    expectSameGas( whole, scene( block( { 0.4, 0 }, { 1, 0.32 } ) ), 0.2,
                   "flush" );
    for ( const Real seam : { 0.7, 0.72 } )
        expectSameGas( whole,
                       scene( { { "type", "union" },
                                { "shapes",
                                  { block( { 0.4, -1 }, { 0.72, 0.32 } ),
                                    block( { seam, -1 }, { 2, 0.32 } ) } } } ),
                       0.2, "seam" );
}

// A body on a periodic side is mirrored as one in the middle: the images of gas
// beyond the side are on this one. It must be there for that.
TEST( Images, areTheSameAcrossPeriodicSides )
{
    const auto rhombus = []( const Real x, const Real y )
    {
        return Json{ { "type", "polygon" },
                     { "vertices",
                       { { x - 0.22, y },
                         { x, y - 0.13 },
                         { x + 0.22, y },
                         { x, y + 0.13 } } } };
    };
    const auto forces = [&]( const std::vector<Json>& shapes )
    {
        auto input = box( 2, 32, 2, "conservative", "quadratic", "periodic" );
        addViscosity( input );
        input["initial"][0]["velocity"] = { 0.6, 0.1 };
        addBodies( input, { Json{ { "type", "union" },
                                  { "shapes", Json( shapes ) } } } );
        auto run = simulate( input );
        advance( *run, 20 );
        return run->series().at( 0 )->rows;
    };
    const auto middle = forces( { rhombus( 0.5, 0.5 ) } );
    for ( const auto& rows :
          { forces( { rhombus( 0, 0.5 ), rhombus( 1, 0.5 ) } ),
            forces( { rhombus( 0.5, 0 ), rhombus( 0.5, 1 ) } ) } )
        for ( std::size_t k = 0; k < rows.size(); ++k )
            for ( int c = 0; c < 3; ++c )
                EXPECT_NEAR( rows[k][c], middle[k][c], tolerance( 1e-12 ) )
                    << k << c;
    EXPECT_THROW( forces( { rhombus( 0.72, 0.5 ) } ), InputError );
}

// Bodies may share a surface: there is one image of a particle, not none or
// two.
TEST( Images, areOfOneOfTheBodiesThatShareASurface )
{
    auto block = []( const Real left, const Real right )
    {
        return Json{ { "type", "box" },
                     { "lower", { left, -1 } },
                     { "upper", { right, 0.32 } } };
    };
    auto scene = []( const std::vector<Json>& bodies )
    {
        auto input = box( 2, 20, 2, "conservative", "quadratic", "slip_wall" );
        input["initial"][0]["velocity"] = { 0.3, -0.1 };
        input["method"]["split_volume"] = 0;
        input["method"]["merge_volume"] = 0;
        addBodies( input, bodies );
        return input;
    };
    const auto whole = scene( { block( 0.4, 2 ) } );
    expectSameGas( whole, scene( { block( 0.4, 2 ), block( 0.4, 2 ) } ), 0.2,
                   "the same twice" );
    expectSameGas( whole, scene( { block( 0.4, 0.8 ), block( 0.6, 2 ) } ), 0.2,
                   "overlapping" );
    expectSameGas( whole, scene( { block( 0.4, 0.7 ), block( 0.7, 2 ) } ), 0.2,
                   "side by side" );
}

// Gas that stands around a body lifts it by the weight that it displaces.
TEST( Images, liftABodyByWhatItDisplaces )
{
    auto input = box( 2, 32, 2, "conservative", "quadratic", "slip_wall" );
    input["physics"].push_back(
        { { "type", "gravity" }, { "acceleration", { 0, -1 } } } );
    input["initial"][0] = { { "type", "hydrostatic" }, { "axis", "y" },
                            { "position", 0 },         { "density", 1 },
                            { "pressure", 1 },         { "gravity", -1 } };
    const Real radius = 0.2;
    input["boundary"].push_back( { { "type", "obstacle" },
                                   { "shape",
                                     { { "type", "sphere" },
                                       { "center", { 0.5, 0.5 } },
                                       { "radius", radius } } } } );
    auto run = simulate( input );
    advanceTo( *run, 1 );
    const auto rows = run->series().at( 0 )->rows;
    Real force = 0;
    for ( const auto& row : rows )
        force += row.at( 2 ) / static_cast<Real>( rows.size() );
    // Integral of exp( -y ) over the disc, by rectangles.
    Real weight = 0;
    constexpr int strips = 1000;
    for ( int k = 0; k < strips; ++k )
    {
        const Real s = radius * ( ( k + 0.5_rt ) / strips * 2 - 1 );
        weight += 2 * radius / strips * 2 *
                  std::sqrt( radius * radius - s * s ) *
                  std::exp( -0.5_rt - s );
    }
    EXPECT_NEAR( force / weight, 1, 0.01 );
}

// Walls that hold the gas do no work, with or without the limiter, and with
// nodes on the wall (linear, cubic) or beside it.
TEST( NoSlipWall, keepsEnergy )
{
    for ( const auto& basis : bases )
        for ( const bool limits : { false, true } )
        {
            auto input = box( 2, 8, 2, "conservative", basis, "no_slip_wall" );
            addViscosity( input );
            input["method"]["viscosity_limiter"] = limits;
            input["initial"][0]["velocity"] = { 0.3, 0.3 };
            auto run = simulate( input );
            const Real before = run->totals().energy();
            advanceTo( *run, 0.3 );
            EXPECT_NEAR( run->totals().energy() / before, 1,
                         tolerance( 1e-14 ) )
                << basis << limits;
        }
}

struct Part
{
    const char* key;
    Json on;
    int dimension;
};

class Parts : public testing::TestWithParam<std::tuple<int, std::string>>
{
};

const std::vector<Part>& parts()
{
    static const std::vector<Part> list = {
        { "pressure_relaxation", 0.1, 1 }, { "pressure_relaxation", 0.1, 2 },
        { "heat_mixing", 2, 1 },           { "heat_mixing", 2, 2 },
        { "heat_conduction", 50, 2 },      { "heat_conduction", 50, 3 },
        { "split_volume", 0.5, 1 },        { "split_volume", 0.17, 2 },
        { "split_volume", 0.19, 3 },       { "merge_volume", 0.4, 1 },
        { "merge_volume", 0.4, 2 },        { "merge_volume", 0.4, 3 },
        { "volume_relaxation", 1, 2 },     { "particle_shifting", 0.2, 2 },
        { "blend_in_compression", 20, 2 } };
    return list;
}

//! Gas with everything but one part off.
Json only( const Part& part, const std::string& basis )
{
    const int cells[] = { 50, 16, 8 };
    auto input =
        shockTube( part.dimension, cells[part.dimension - 1],
                   part.dimension == 3 ? 2 : 3, "conservative", basis );
    addViscosity( input );
    for ( auto& side : input["boundary"] )
        side["type"] = "periodic";
    input["particles"]["placement"] = "random";
    // A shock that compresses by far more than particles may shrink before
    // they merge.
    input["physics"][0]["gamma"] = 1.1;
    input["initial"][0]["left"]["pressure"] = 100;
    input["initial"][0]["right"]["pressure"] = 0.01;
    for ( const char* key :
          { "pressure_relaxation", "heat_mixing", "heat_conduction",
            "split_volume", "merge_volume", "volume_relaxation",
            "particle_shifting", "blend_in_compression" } )
        input["method"][key] = 0;
    input["method"][part.key] = part.on;
    return input;
}

//! Variance of the volume that particles fill of squares between the cells'
//! centres, over a periodic box.
Real unevenness( Simulation& run, const int cells )
{
    const auto data = run.particleData();
    std::vector<Real> filled( cells * cells );
    for ( std::size_t p = 0; p < data.mass.size(); ++p )
    {
        const auto square = [&]( const int d )
        {
            const Real x = data.position[2 * p + d];
            return static_cast<int>( x * cells + 0.5_rt ) % cells;
        };
        filled.at( square( 1 ) * cells + square( 0 ) ) +=
            data.volume[p] * cells * cells;
    }
    Real sum = 0;
    for ( const Real theta : filled )
        sum += ( theta - 1 ) * ( theta - 1 ) / ( cells * cells );
    return sum;
}

// Each part alone keeps mass, momentum and energy, and does something.
TEST_P( Parts, conserveAlone )
{
    const auto part = parts().at( std::get<0>( GetParam() ) );
    const auto basis = std::get<1>( GetParam() );
    const auto label =
        fmt::format( "{} {} {}D", part.key, basis, part.dimension );
    auto with = only( part, basis );
    auto off = with;
    off["method"][part.key] = 0;
    auto a = simulate( with ), b = simulate( off );
    const auto before = a->totals();
    // What particles claim beyond the box, or leave of it.
    const auto excess = [&]( Simulation& run )
    {
        Real sum = 0;
        for ( const Real V : run.particleData().volume )
            sum += V;
        return std::abs( sum - 1 );
    };
    const Real end = part.dimension == 3 ? 0.05 : 0.02;
    advanceTo( *a, end );
    advanceTo( *b, end );
    const auto after = a->totals();
    EXPECT_NEAR( after.mass, before.mass, tolerance( 1e-13 ) * before.mass )
        << label;
    EXPECT_NEAR( after.energy(), before.energy(),
                 tolerance( 1e-12 ) * before.energy() )
        << label;
    for ( int d = 0; d < part.dimension; ++d )
        EXPECT_NEAR( after.momentum[d], 0, tolerance( 1e-12 ) ) << label;
    EXPECT_LE( excess( *a ), excess( *b ) + 0.03 ) << label;
    const std::string key = part.key;
    // Hats have no slope of the filling within a cell, so nothing shifts.
    const bool shifts = key == "particle_shifting" && basis != "linear";
    if ( key != "particle_shifting" || shifts )
    {
        EXPECT_FALSE( byId( *a ) == byId( *b ) ) << label;
    }
    if ( key == "volume_relaxation" || shifts )
    {
        EXPECT_LT( unevenness( *a, 16 ), 0.97_rt * unevenness( *b, 16 ) )
            << label;
    }
    const auto ids = a->particleData().id;
    EXPECT_EQ( std::set<std::int64_t>( ids.begin(), ids.end() ).size(),
               ids.size() );
    if ( key == "split_volume" )
    {
        EXPECT_GT( a->particles(), b->particles() ) << label;
    }
    if ( key == "merge_volume" )
    {
        EXPECT_LT( a->particles(), b->particles() ) << label;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Each, Parts,
    testing::Combine( testing::Range( 0, int( parts().size() ) ),
                      testing::ValuesIn( bases ) ) );

// Without its return the kinetic energy that transfers destroy is gone.
TEST( LossReturn, keepsTheEnergy )
{
    for ( const auto& basis : bases )
        for ( const bool returns : { false, true } )
        {
            auto input = shockTube( 2, 16, 2, "conservative", basis );
            addViscosity( input );
            input["method"]["loss_return"] = returns;
            auto run = simulate( input );
            const Real before = run->totals().energy();
            advanceTo( *run, 0.2 );
            const Real kept = run->totals().energy() / before;
            const Real small = tolerance( 1e-13 );
            EXPECT_LE( kept, returns ? 1 + small : 1 - 1e-5_rt ) << basis;
            EXPECT_GE( kept, returns ? 1 - small : 0.9_rt ) << basis;
        }
}

// No half is lighter than its part of what the particle began with.
TEST( Splitting, keepsToTheMassFloor )
{
    for ( const double floor : { 0.2, 0.04 } )
    {
        auto input = box( 1, 50, 2, "conservative", "quadratic", "outflow" );
        input["method"]["mass_floor"] = floor;
        input["method"]["merge_volume"] = 0;
        input["initial"][0]["region"] = {
            { "type", "box" }, { "lower", { 0.45 } }, { "upper", { 0.55 } } };
        auto run = simulate( input );
        const auto start = run->particleData();
        const Real whole = start.mass.at( 0 );
        advanceTo( *run, 0.08 );
        const auto data = run->particleData();
        const Real lightest =
            *std::min_element( data.mass.begin(), data.mass.end() );
        // Halves of halves: the last power of two above the floor.
        EXPECT_NEAR( lightest / whole,
                     std::exp2( std::ceil( std::log2( floor ) ) ),
                     tolerance( 1e-13 ) )
            << floor;
    }
}

//! Masses of 1D particles, of two gases that take turns, after some looks for
//! pairs. \param per_cell twice as many as there are in a half-cell
std::vector<Real> massesAfterMerging( const Real slip, const Real pressure,
                                      const int per_cell, const int looks )
{
    auto input = box( 1, 8, per_cell, "conservative", "quadratic", "periodic" );
    input["method"]["merge_volume"] = 1;
    const auto resolved = resolveInput( input, "test" );
    auto scene =
        makeScene<1>( resolved, { Quadratic::centred, Quadratic::halo, 0, 0 } );
    auto& state = scene.state;
    // Smaller than the gas's own, so that pairs may merge.
    state.per_cell = 1;
    auto host = state.particles.toHost();
    const auto v = host.slice<Velocity>();
    const auto V = host.slice<Volume>();
    const auto m = host.slice<Mass>();
    const auto e = host.slice<SpecificInternalEnergy>();
    for ( int p = 0; p < state.particles.size(); ++p )
    {
        const Real small = 0.4_rt; // lest volume be what keeps any apart
        V( p ) *= small;
        m( p ) *= small;
        if ( p % 2 )
        {
            v( p, 0 ) = slip;
            e( p ) *= pressure;
        }
    }
    state.particles.fromHost( host );
    auto& history = state.particles.addSidecar<HistoryMembers<1>>(
        "history", DuringStep::stays, WhenMerged::stays );
    // What a module keeps per mass: none is made, and none is lost.
    auto& own = state.particles.addSidecar<Cabana::MemberTypes<Real[2]>>(
        "own", DuringStep::edits );
    const auto numbers = Cabana::slice<0>( own.data() );
    const auto id = state.particles.slice<Id>();
    forEach(
        "number", state.particles.size(), MACHPOINT_LAMBDA( const int p ) {
            numbers( p, 0 ) = 1;
            numbers( p, 1 ) = static_cast<Real>( id( p ) % 7 );
        } );
    auto sumOf = [&]( const int column )
    {
        const auto values = Impl::copyMember<0>( own.data() );
        const auto masses = state.particles.copyMember<Mass>();
        Real sum = 0;
        for ( std::size_t p = 0; p < masses.size(); ++p )
            sum += masses[p] * values[2 * p + column];
        return sum;
    };
    const Real before[2] = { sumOf( 0 ), sumOf( 1 ) };
    const Impl::HalfCellMarks marks( state.layout.box.totalCells() * 2 );
    for ( int k = 0; k < looks; ++k )
        Impl::mergeParticles( state, PressureResponse{ 1.4, 0.4, 0 }, history,
                              marks, ConservativeParts( resolved["method"] ) );
    for ( const int column : { 0, 1 } )
        EXPECT_NEAR( sumOf( column ) / before[column], 1, tolerance( 1e-13 ) );
    return state.particles.copyMember<Mass>();
}

// Only the like merge: not gas that runs past another at a fifth of the speed
// of sound (here 1), and not hot with cold, 10 % from their mean
// (docs/conservative.md, section 9).
TEST( Merging, isOfLikeParticles )
{
    auto left = []( const Real slip, const Real pressure )
    { return massesAfterMerging( slip, pressure, 4, 1 ).size(); };
    EXPECT_EQ( left( 0, 1 ), 16u );
    EXPECT_EQ( left( 0.19, 1 ), 16u );
    EXPECT_EQ( left( 0.21, 1 ), 32u );
    EXPECT_EQ( left( 0, 1.2 ), 16u );
    EXPECT_EQ( left( 0, 1.25 ), 32u );
}

// Nothing becomes heavier than four of its kind: six of a half-cell become two.
TEST( Merging, makesNothingHeavierThanFour )
{
    const auto masses = massesAfterMerging( 0, 1, 12, 10 );
    EXPECT_EQ( masses.size(), 32u );
    EXPECT_NEAR( *std::max_element( masses.begin(), masses.end() ),
                 4 * 0.4 * 1.4 / 96, tolerance( 1e-13 ) );
}

// Which of equally near particles merge does not hang on the sides of their
// cells: a blast stays its own mirror image about both axes and both diagonals.
TEST( Merging, prefersNoDirection )
{
    auto input = box( 2, 32, 2, "conservative", "quadratic", "slip_wall" );
    addViscosity( input );
    input["method"]["split_volume"] = 0; // the fewer particles, the more merged
    input["initial"][0] = { { "type", "blast" },  { "density", 1 },
                            { "pressure", 1e-5 }, { "energy", 1 },
                            { "radius", 0.1 },    { "center", { 0.5, 0.5 } } };
    auto run = simulate( input );
    const int before = run->particles();
    advanceTo( *run, 0.25 );
    EXPECT_LT( run->particles(), before );
    const auto data = run->particleData();
    for ( std::size_t p = 0; p < data.mass.size(); ++p )
    {
        const double x = data.position[2 * p];
        const double y = data.position[2 * p + 1];
        for ( const auto image :
              { particleAt( data, 1 - x, y ), particleAt( data, x, 1 - y ),
                particleAt( data, y, x ) } )
            EXPECT_NEAR( data.volume[image], data.volume[p],
                         tolerance( 1e-9 ) );
    }
}

// Halves differ in their places alone, so gas that leaves a square stays its
// own mirror image about both axes and both diagonals.
TEST( Splitting, prefersNoDirection )
{
    for ( const auto& basis : bases )
        for ( const std::string time : { "symplectic", "midpoint" } )
        {
            auto input = box( 2, 16, 2, "conservative", basis, "slip_wall" );
            addViscosity( input );
            input["method"]["time"] = time;
            input["initial"][0]["region"] = { { "type", "box" },
                                              { "lower", { 0.25, 0.25 } },
                                              { "upper", { 0.75, 0.75 } } };
            auto run = simulate( input );
            const int before = run->particles();
            advanceTo( *run, 0.1 );
            EXPECT_GT( run->particles(), before ) << basis << time;
            const auto data = run->particleData();
            for ( std::size_t p = 0; p < data.mass.size(); ++p )
            {
                const double x = data.position[2 * p];
                const double y = data.position[2 * p + 1];
                for ( const auto image : { particleAt( data, 1 - x, y ),
                                           particleAt( data, x, 1 - y ),
                                           particleAt( data, y, x ) } )
                    EXPECT_NEAR( data.volume[image], data.volume[p],
                                 tolerance( 1e-9 ) )
                        << basis << time;
            }
        }
}

// Small errors of volume stay, larger ones shrink at the rate of compression;
// of shear only those past the wider band, and hardly any at low Mach numbers.
TEST( Relaxation, rate )
{
    using Impl::relaxationRate;
    EXPECT_EQ( relaxationRate( 0.02, -3.0, 0.0, 1.0 ), 0 );
    EXPECT_EQ( relaxationRate( 0.12, 0.0, 5.0, 1.0 ), 0 );
    EXPECT_NEAR( relaxationRate( 0.1, -3.0, 5.0, 1.0 ), 3 * 0.08,
                 tolerance( 1e-15 ) );
    EXPECT_NEAR( relaxationRate( -0.1, 3.0, 5.0, 1.0 ), -3 * 0.08,
                 tolerance( 1e-15 ) );
    EXPECT_NEAR( relaxationRate( 0.3, 0.0, 5.0, 1.0 ), 5 * 0.18,
                 tolerance( 1e-14 ) );
    // Below a rate that the grid would notice they vanish with its square.
    EXPECT_NEAR( relaxationRate( 0.3, 0.0, 5.0, 500.0 ), 5 * 0.18 * 1e-4,
                 tolerance( 1e-14 ) );
    EXPECT_NEAR( relaxationRate( 0.3, 5.0, 0.0, 500.0 ), 5 * 0.28 * 1e-4,
                 tolerance( 1e-14 ) );
    EXPECT_EQ( relaxationRate( 4.0, 1.0, 0.0, 0.0 ),
               relaxationRate( 0.5, 1.0, 0.0, 0.0 ) );
}

// Friction is conducted where the gas shears or spins, not where it is pressed
// together, whichever way that goes.
TEST( HeatConduction, knowsShearFromCompression )
{
    using Impl::shearOf;
    // Of a velocity along n that changes along t.
    const auto shear = []( const Real( &n )[2], const Real( &t )[2] )
    {
        VectorOf<2, Real> C[2];
        for ( int a = 0; a < 2; ++a )
            for ( int b = 0; b < 2; ++b )
                C[a][b] = 3 * n[a] * t[b];
        return shearOf<2>( C );
    };
    for ( const Real angle : { 0.0, 0.3, 0.8, 2.0 } )
    {
        const Real n[2] = { std::cos( angle ), std::sin( angle ) };
        const Real t[2] = { -n[1], n[0] };
        EXPECT_NEAR( shear( n, n ), 0, tolerance( 1e-15 ) ) << angle;
        EXPECT_NEAR( shear( n, t ), 1, tolerance( 1e-15 ) ) << angle;
    }
    // Spin alone, where |curl|^2 is twice |C|^2.
    const VectorOf<2, Real> spin[2] = { { 0, -2 }, { 2, 0 } };
    EXPECT_EQ( shearOf<2>( spin ), 1 );
    // A shock beside as much shear.
    const VectorOf<2, Real> both[2] = { { -2, 2 }, { 0, 0 } };
    EXPECT_NEAR( shearOf<2>( both ), 0.5, tolerance( 1e-15 ) );
    const VectorOf<3, Real> along[3] = {
        { 0, 0, 5 }, { 0, 0, 0 }, { 0, 0, 0 } };
    EXPECT_NEAR( shearOf<3>( along ), 1, tolerance( 1e-15 ) );
    // Gas that an inflow has imposed; and in one dimension nothing shears.
    const VectorOf<2, Real> uniform[2] = {};
    EXPECT_EQ( shearOf<2>( uniform ), 0 );
    const VectorOf<1, Real> still[1] = {}, closing[1] = { { -3 } };
    EXPECT_EQ( shearOf<1>( still ), 0 );
    EXPECT_EQ( shearOf<1>( closing ), 0 );
}

// A key that only `conservative` understands is an error elsewhere.
TEST( Parts, belongToConservative )
{
    auto input = box( 1, 10, 2, "apic", "quadratic", "slip_wall" );
    input["method"]["heat_mixing"] = 2;
    EXPECT_THROW( simulate( input ), InputError );
    input["method"]["name"] = "conservative";
    EXPECT_NO_THROW( simulate( input ) );
    input["method"]["name"] = "paper";
    input["method"].erase( "heat_mixing" );
    input["method"]["time"] = "midpoint";
    EXPECT_THROW( simulate( input ), InputError );
}

} // namespace
