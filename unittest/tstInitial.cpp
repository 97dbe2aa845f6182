/*!
  \file tstInitial.cpp
  \brief Initial states: their gradients, invariants and totals.
*/
#include "scenes.hpp"

#include <physics/modules.hpp>

#include <cmath>
#include <memory>
#include <numbers>

namespace
{

using namespace Machpoint;
using namespace Test;

constexpr double gamma_gas = 1.4;

//! An initial state of a dimension with its defaults; `keys` says the rest.
template <class Type>
std::unique_ptr<InitialState> make( const int dimension, const Json& keys,
                                    const double gamma = gamma_gas )
{
    std::vector<std::string> errors;
    const Json json =
        resolve( keys, Type::declare( dimension ), "test", errors );
    EXPECT_TRUE( errors.empty() ) << ( errors.empty() ? "" : errors[0] );
    const Json input = {
        { "physics",
          { { { "type", "ideal_gas" }, { "gamma", gamma } },
            { { "type", "viscosity" }, { "shear", 0.3 }, { "bulk", 0 } },
            { { "type", "heat_conduction" },
              { "conductivity", 0.4 * gamma } } } },
        { "boundary", Json::array() } };
    const SceneFacts facts{ dimension, input };
    if constexpr ( std::is_constructible_v<Type, const Json&,
                                           const SceneFacts&> )
        return std::make_unique<Type>( json, facts );
    else
        return std::make_unique<Type>( json );
}

//! Places off the symmetry planes and jumps of all states below.
std::vector<Vector3> places( const int dimension )
{
    std::vector<Vector3> list;
    for ( const double x : { -0.61, -0.13, 0.17, 0.44 } )
        for ( const double y : { -0.37, 0.08, 0.31 } )
            list.push_back( { x, dimension > 1 ? y : 0,
                              dimension > 2 ? 0.23 - x * y : 0 } );
    return list;
}

//! velocityGradient against central differences of the velocity.
void expectGradient( const InitialState& initial, const int dimension )
{
    const double step = 1e-5;
    double largest = 0;
    for ( const auto& x : places( dimension ) )
    {
        const auto gradient = initial.velocityGradient( x );
        for ( int b = 0; b < 3; ++b )
        {
            Vector3 before = x, after = x;
            before[b] -= step;
            after[b] += step;
            const auto low = initial.state( before ).velocity;
            const auto high = initial.state( after ).velocity;
            for ( int a = 0; a < 3; ++a )
            {
                // Beyond the dimension there is no gradient.
                const double expected =
                    b < dimension ? ( high[a] - low[a] ) / ( 2 * step ) : 0;
                // Third derivatives are below 3e3 here; round-off 1e-15 / step.
                EXPECT_NEAR( gradient[a][b], expected, 1e-7 )
                    << a << b << " at " << x[0] << ", " << x[1];
                largest = std::max( largest, std::abs( expected ) );
            }
        }
    }
    EXPECT_GT( largest, 1e-3 ); // else nothing has been compared
}

TEST( Initial, gradientsAreThoseOfTheVelocity )
{
    const Json vortex = { { "center", { 0.1, 0.2 } },
                          { "velocity", { 1, -1 } },
                          { "radius", 0.5 },
                          { "strength", 2 } };
    expectGradient( *make<IsentropicVortexState>( 2, vortex ), 2 );
    expectGradient( *make<AcousticWaveState>( 1, Json::object() ), 1 );
    expectGradient( *make<AcousticWaveState>( 3, { { "normal", { 1, -2, 2 } },
                                                   { "wavelength", 0.7 } } ),
                    3 );
    expectGradient( *make<ViscousShockState>( 2, { { "normal", { -3, 4 } },
                                                   { "density", 1.2 },
                                                   { "velocity", { 0.3, -1 } },
                                                   { "pressure", 0.9 },
                                                   { "position", 0.1 } } ),
                    2 );
    for ( const int d : { 2, 3 } )
    {
        expectGradient( *make<Noh>( d, Json::object() ), d );
        expectGradient( *make<TaylorGreen>( d, Json::object() ), d );
        expectGradient( *make<KelvinHelmholtz>( d, { { "thickness", 0.1 },
                                                     { "lower", -0.2 },
                                                     { "upper", 0.25 } } ),
                        d );
        for ( const char* axis : { "x", "y" } )
            expectGradient(
                *make<RayleighTaylor>( d, { { "axis", axis },
                                            { "amplitude", 0.3 },
                                            { "position", 0.05 } } ),
                d );
    }
}

//! Jumps are left to the grid.
TEST( Initial, jumpsHaveNoGradient )
{
    const auto shock = make<ShuOsher>( 1, Json::object() );
    EXPECT_EQ( shock->velocityGradient( { -4, 0, 0 } )[0][0], 0 );
    const auto wall = make<Noh>( 1, Json::object() );
    for ( const double x : { -0.3, 0.0, 1e-9, 0.4 } )
        EXPECT_EQ( wall->velocityGradient( { x, 0, 0 } )[0][0], 0 );
    const auto point = make<Noh>( 3, Json::object() );
    EXPECT_EQ( point->velocityGradient( { 0, 0, 0 } )[1][1], 0 );
    EXPECT_EQ( point->state( { 0, 0, 0 } ).velocity[1], 0 );
}

//! Along any line through a vortex dp/dr = rho v^2 / r, at one entropy.
TEST( Initial, vortexIsIsentropicAndInBalance )
{
    const auto vortex =
        make<IsentropicVortexState>( 2, { { "center", { 0.3, -0.2 } },
                                          { "density", 1.3 },
                                          { "velocity", { 2, 1 } },
                                          { "pressure", 0.8 },
                                          { "strength", 3 },
                                          { "radius", 0.6 } } );
    const double entropy = 0.8 / std::pow( 1.3, gamma_gas );
    for ( const double r : { 0.1, 0.6, 1.3 } )
    {
        const auto at = [&]( const double s ) {
            return vortex->state( { 0.3 + 0.6 * s, -0.2 + 0.8 * s, 0 } );
        };
        const auto gas = at( r );
        EXPECT_NEAR( gas.pressure / std::pow( gas.density, gamma_gas ), entropy,
                     1e-14 );
        const double u = gas.velocity[0] - 2, v = gas.velocity[1] - 1;
        EXPECT_NEAR( 0.6 * u + 0.8 * v, 0, 1e-15 );
        const double slope =
            ( at( r + 1e-5 ).pressure - at( r - 1e-5 ).pressure ) / 2e-5;
        EXPECT_NEAR( slope, gas.density * ( u * u + v * v ) / r, 1e-8 );
    }
    // At the radius it turns fastest, with strength / (2 pi R) R.
    const auto rim = vortex->state( { 0.9, -0.2, 0 } );
    EXPECT_NEAR( rim.velocity[1] - 1, 3 / ( 2 * std::numbers::pi ), 1e-14 );
    EXPECT_GT( rim.velocity[1],
               vortex->state( { 0.95, -0.2, 0 } ).velocity[1] );
    EXPECT_GT( rim.velocity[1],
               vortex->state( { 0.85, -0.2, 0 } ).velocity[1] );
}

//! A simple wave that runs to the right: entropy and v - 2 c / (gamma - 1).
TEST( Initial, waveKeepsEntropyAndInvariant )
{
    const auto wave = make<AcousticWaveState>( 1, { { "amplitude", 0.3 },
                                                    { "velocity", { 0.4 } },
                                                    { "density", 0.9 },
                                                    { "pressure", 1.7 } } );
    const double c0 = std::sqrt( gamma_gas * 1.7 / 0.9 );
    for ( const double x : { 0.0, 0.25, 0.6, 0.9 } )
    {
        const auto gas = wave->state( { x, 0, 0 } );
        EXPECT_NEAR( gas.pressure / std::pow( gas.density, gamma_gas ),
                     1.7 / std::pow( 0.9, gamma_gas ), 1e-14 );
        const double c = std::sqrt( gamma_gas * gas.pressure / gas.density );
        EXPECT_NEAR( gas.velocity[0] - 5 * c, 0.4 - 5 * c0, 1e-13 );
        EXPECT_NEAR( gas.velocity[0],
                     0.4 + 0.3 * c0 * std::sin( 2 * std::numbers::pi * x ),
                     1e-14 );
    }
}

TEST( Initial, shuOsherStartsFromTheJumpConditions )
{
    // The values of Shu and Osher 1989, to the digits that they give.
    const auto gas =
        make<ShuOsher>( 1, Json::object() )->state( { -4.1, 0, 0 } );
    EXPECT_NEAR( gas.density, 3.857143, 5e-7 );
    EXPECT_NEAR( gas.velocity[0], 2.629369, 5e-7 );
    EXPECT_NEAR( gas.pressure, 10.33333, 5e-6 );
}

TEST( Initial, rayleighTaylorIsHydrostatic )
{
    const auto layers = make<RayleighTaylor>( 2, { { "position", 0.1 } } );
    for ( const double y : { -0.3, 0.2, 0.5 } )
    {
        const double slope = ( layers->state( { 0, y + 1e-4, 0 } ).pressure -
                               layers->state( { 0, y - 1e-4, 0 } ).pressure ) /
                             2e-4;
        const auto gas = layers->state( { 0, y, 0 } );
        EXPECT_NEAR( slope, -0.1 * gas.density, 1e-10 );
        EXPECT_EQ( gas.density, y < 0.1 ? 1 : 2 );
    }
    EXPECT_NEAR( layers->state( { 0, 0.1, 0 } ).velocity[1], 0.01, 1e-16 );
    EXPECT_NEAR( layers->state( { 0.25, 0.1, 0 } ).velocity[1], 0, 1e-16 );
    EXPECT_NEAR( layers->state( { 0, 0.85, 0 } ).velocity[1], 0, 1e-16 );
}

TEST( Initial, kelvinHelmholtzBlendsSmoothly )
{
    const auto layer = make<KelvinHelmholtz>( 2, Json::object() );
    EXPECT_NEAR( layer->state( { 0, 0.5, 0 } ).density, 2, 1e-4 );
    EXPECT_NEAR( layer->state( { 0, 0, 0 } ).velocity[0], 0.5, 1e-4 );
    for ( const double y : { 0.25, 0.75 } )
    {
        EXPECT_NEAR( layer->state( { 0, y, 0 } ).density, 1.5, 1e-14 );
        EXPECT_NEAR( layer->state( { 0, y, 0 } ).velocity[0], 0, 1e-14 );
        EXPECT_NEAR( layer->state( { 0, y + 1e-9, 0 } ).density, 1.5, 1e-7 );
    }
}

//! Taylor's and Green's pressure is that of incompressible flow:
//! div( v . grad v ) rho = - laplacian p, at rates that cancel.
TEST( Initial, taylorGreenPressureBalances )
{
    for ( const int d : { 2, 3 } )
    {
        const auto vortices = make<TaylorGreen>( d, Json::object() );
        for ( const auto& x : places( d ) )
        {
            const auto L = vortices->velocityGradient( x );
            double divergence = 0, source = 0, laplacian = 0;
            const double h = 1e-4;
            for ( int a = 0; a < d; ++a )
            {
                divergence += L[a][a];
                for ( int b = 0; b < d; ++b )
                    source += L[a][b] * L[b][a];
                Vector3 low = x, high = x;
                low[a] -= h;
                high[a] += h;
                laplacian += ( vortices->state( low ).pressure +
                               vortices->state( high ).pressure -
                               2 * vortices->state( x ).pressure ) /
                             ( h * h );
            }
            EXPECT_NEAR( divergence, 0, 1e-13 );
            // Fourth derivatives of p are some 1e4, times h^2 / 12; round-off
            // of p = 71 is 1e-14 / h^2.
            EXPECT_NEAR( laplacian, -source, 2e-5 );
        }
    }
}

//! Mass and energies of a box that holds only a blast, or one over a uniform
//! gas.
TEST( Initial, blastAddsItsEnergy )
{
    for ( const int d : { 1, 2, 3 } )
    {
        auto input = box( d, 20, 2, "apic", "quadratic", "slip_wall" );
        const Json blast = { { "type", "blast" },
                             { "center", repeat( d, 0.5 ) },
                             { "radius", 0.05 }, // one cell
                             { "energy", 0.3 } };
        for ( const bool alone : { true, false } )
        {
            input["initial"] = Json::array( { blast } );
            if ( !alone )
                input["initial"].insert( input["initial"].begin(),
                                         Json{ { "type", "uniform" },
                                               { "density", 1.4 },
                                               { "velocity", repeat( d, 0.5 ) },
                                               { "pressure", 2 } } );
            const auto totals = simulate( input )->totals();
            // Up to 64000 particles are summed up to 5 one after the other.
            const double round_off = tolerance( 1e-11 );
            EXPECT_NEAR( totals.mass, alone ? 1 : 1.4, round_off );
            EXPECT_NEAR( totals.kinetic, alone ? 0 : 0.5 * 1.4 * d * 0.25,
                         round_off );
            // The walls stand 10 radii away; at half a radius apart the sum
            // over the lattice is the integral to round-off.
            EXPECT_NEAR( totals.internal, ( alone ? 1e-5 : 2 ) / 0.4 + 0.3,
                         round_off );
        }
    }
}

//! Beyond periodic sides a blast goes on.
TEST( Initial, blastHasImages )
{
    auto input = box( 2, 20, 2, "apic", "quadratic", "periodic" );
    input["initial"] = Json::array( { { { "type", "blast" },
                                        { "center", { 0, 1 } },
                                        { "radius", 0.05 },
                                        { "energy", 0.3 } } } );
    EXPECT_NEAR( simulate( input )->totals().internal, 1e-5 / 0.4 + 0.3,
                 tolerance( 1e-11 ) );
}

//! What the particles get: the gradient, and no gas outside of regions.
TEST( Initial, particlesGetTheGradient )
{
    // A wave along x in 1D: the affine energy of apic is h^2 / 8 m C^2.
    auto input = box( 1, 64, 4, "apic", "quadratic", "periodic" );
    input["initial"] = Json::array( { Json{ { "type", "acoustic_wave" } } } );
    const double k = 2 * std::numbers::pi, h = 1.0 / 64;
    // Mean of rho C^2 to leading order in the amplitude; the next one is its
    // square.
    const double mean = 1.4 * 0.5 * std::pow( 0.05 * k, 2 );
    EXPECT_NEAR( simulate( input )->totals().affine, h * h / 8 * mean,
                 0.01 * h * h / 8 * mean );
}

TEST( Initial, regionsLeaveEmptySpace )
{
    auto input = box( 1, 10, 2, "apic", "quadratic", "slip_wall" );
    input["initial"][0]["region"] = {
        { "type", "box" }, { "lower", { -1 } }, { "upper", { 0.35 } } };
    const auto simulation = simulate( input );
    EXPECT_NEAR( simulation->totals().mass, 1.4 * 0.35, tolerance( 1e-12 ) );
}

TEST( Initial, refusesWhatIsNoGas )
{
    auto input = box( 1, 10, 2, "apic", "quadratic", "periodic" );
    input["initial"] = Json::array(
        { Json{ { "type", "acoustic_wave" }, { "amplitude", 6 } } } );
    EXPECT_THROW( simulate( input ), InputError );
    input["initial"] = Json::array( { Json{ { "type", "taylor_green" } } } );
    EXPECT_THROW( simulate( input ), InputError ); // needs a plane
}

} // namespace
