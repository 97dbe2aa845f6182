// Only what the scene calls for: kernels and allocations, counted by Kokkos
// Tools callbacks, with each optional effect and without it.
#include "scenes.hpp"

#include <boundary/walls.hpp>
#include <core/profile.hpp>
#include <core/registry.hpp>
#include <drivers/study_effects.hpp>
#include <drivers/warnings.hpp>
#include <physics/evaluate_gas.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <thread>

namespace
{

using namespace Machpoint;
using namespace Test;

using Counts = std::map<std::string, std::int64_t>;
Counts kernels;     // launches by label
Counts allocations; // bytes by label

void countKernel( const char* label, std::uint32_t, std::uint64_t* )
{
    ++kernels[label];
}
void countBytes( Kokkos::Tools::SpaceHandle, const char* label, const void*,
                 const std::uint64_t bytes )
{
    allocations[label] += static_cast<std::int64_t>( bytes );
}

//! The same of the memory where particles are.
void countOwnBytes( Kokkos::Tools::SpaceHandle space, const char* label,
                    const void* pointer, const std::uint64_t bytes )
{
    if ( std::string( space.name ) == MemorySpace::name() )
        countBytes( space, label, pointer, bytes );
}

//! Puts the callbacks of Kokkos Tools back that were there before.
class RestoredCallbacks
{
  public:
    RestoredCallbacks() = default;
    RestoredCallbacks( const RestoredCallbacks& ) = delete;
    ~RestoredCallbacks()
    {
        Kokkos::Tools::Experimental::set_callbacks( _former );
    }

  private:
    Kokkos::Tools::Experimental::EventSet _former =
        Kokkos::Tools::Experimental::get_callbacks();
};

struct Tally
{
    Counts kernels, allocations;
};

//! What building a scene and 20 steps of it launch and allocate.
Tally tally( const Json& input )
{
    namespace Tools = Kokkos::Tools::Experimental;
    const RestoredCallbacks restored;
    kernels.clear();
    allocations.clear();
    Tools::set_begin_parallel_for_callback( &countKernel );
    Tools::set_begin_parallel_reduce_callback( &countKernel );
    Tools::set_begin_parallel_scan_callback( &countKernel );
    Tools::set_allocate_data_callback( &countBytes );
    {
        auto run = simulate( input );
        advance( *run, 20 );
    }
    return { kernels, allocations };
}

//! The entries of `all` whose label is not among `own`.
Counts without( const Counts& all, const std::set<std::string>& own )
{
    Counts rest;
    for ( const auto& [label, count] : all )
        if ( !own.count( label ) )
            rest[label] = count;
    return rest;
}

Json baseScene()
{
    return box( 2, 8, 2, "apic", "quadratic", "periodic" );
}

//! Kernels and memory of this code; kernels that Kokkos launches to clear or
//! copy memory carry other labels, and copies for the host a suffix.
Counts ours( const Counts& all )
{
    Counts rest;
    for ( const auto& [label, count] : all )
        if ( label.rfind( "Machpoint::", 0 ) == 0 &&
             !label.ends_with( "_mirror" ) )
            rest[label] = count;
    return rest;
}

//! A scene with viscosity and gravity, less all that can be left out: what a
//! study of effects calls the bare method.
Json bareScene( const std::string& method )
{
    auto input = box( 2, 8, 2, method, "quadratic", "periodic" );
    addViscosity( input );
    input["physics"].push_back(
        { { "type", "gravity" }, { "acceleration", { 0.1, 0.0 } } } );
    const auto settings = withoutAll( resolveInput( input, "test" ) );
    for ( const auto& item : settings.items() )
        applyOverride( input, item.key() + "=" + item.value().dump() );
    return input;
}

//! What every method launches in 20 steps with an equation of state between
//! periodic sides. \param sums on nodes in a step
Counts timeLoop( const int sums )
{
    Counts counts = {
        { "Machpoint::evaluateGas", 21 },   // once before the first step
        { "Machpoint::cellOfParticle", 1 }, // in step 0; they are in order
        { "Machpoint::descents", 1 },
        { "Machpoint::putParticles", 2 }, // what steps advance, and the rest
        { "Machpoint::clearSidecar", 1 }, // made once
        { "Machpoint::gridVelocity", 20 },
        { "Machpoint::advanceGridVelocity", 20 },
        { "Machpoint::notedRows", 40 },  // who left the domain, who is to go
        { "Machpoint::periodic", 40 } }; // an axis in one pass
    if ( runs_on_host )
        counts["Machpoint::clearSums"] = 20 * sums;
    if ( runs_on_host && ExecutionSpace().concurrency() > 1 )
        counts["Machpoint::sumOfThreads"] = 20 * sums;
    return counts;
}

// A scene with none of the optional effects launches exactly the kernels of
// its method, each as often as the time loop says.
TEST( Effects, bareApicLaunchesItsOwnKernelsOnly )
{
    auto expected = timeLoop( 1 );
    expected["Machpoint::particlesToGrid"] = 20;
    expected["Machpoint::fold"] = 40; // axis by axis
    expected["Machpoint::fill"] = 40;
    expected["Machpoint::gridToParticles"] = 20;
    EXPECT_EQ( ours( tally( bareScene( "apic" ) ).kernels ), expected );
}

TEST( Effects, bareConservativeLaunchesItsOwnKernelsOnly )
{
    auto expected = timeLoop( 1 );
    // and the rates and the flow
    expected["Machpoint::clearSidecar"] = 3;
    expected["Machpoint::depositParticles"] = 20;
    expected["Machpoint::fold"] = 40;
    expected["Machpoint::fill"] = 120; // moments, v with v', their motion
    expected["Machpoint::measureMotion"] = 20;
    expected["Machpoint::applyPressure"] = 20;
    expected["Machpoint::stableTimeStep"] = 5;
    expected.erase( "Machpoint::advanceGridVelocity" ); // within it
    expected["Machpoint::gatherParticles"] = 20;
    EXPECT_EQ( ours( tally( bareScene( "conservative" ) ).kernels ), expected );
}

TEST( Effects, barePaperLaunchesItsOwnKernelsOnly )
{
    auto expected = timeLoop( 2 );
    expected["Machpoint::particlesToGrid"] = 20;
    expected["Machpoint::fold"] = 80;
    expected["Machpoint::fill"] = 80; // v with v', and the second velocity
    expected["Machpoint::updateParticleVelocity"] = 20;
    expected["Machpoint::momentumToGrid"] = 20;
    expected["Machpoint::divideByMass"] = 20;
    expected["Machpoint::updateParticles"] = 20;
    EXPECT_EQ( ours( tally( bareScene( "paper" ) ).kernels ), expected );
}

// Particles are sorted where they are out of order, and only there.
TEST( Effects, sortsOnlyWhatIsOutOfOrder )
{
    auto input = box( 2, 8, 2, "apic", "quadratic", "periodic" );
    input["particles"]["sort_every"] = 10;
    EXPECT_EQ( tally( input ).kernels.count( "Machpoint::permute" ), 0u );
    input["initial"][0]["velocity"] = { 1.0, 1.0 }; // .3 of a cell in 10 steps
    EXPECT_GT( tally( input ).kernels.count( "Machpoint::permute" ), 0u );
}

// In 1D particles keep their order, but for those that come round.
TEST( Line, isSortedWhereGasHasComeRound )
{
    auto input = box( 1, 256, 2, "apic", "quadratic", "periodic" );
    input["particles"]["sort_every"] = 10;
    EXPECT_EQ( tally( input ).kernels.count( "Machpoint::permute" ), 0u );
    input["initial"][0]["velocity"] = { 1.0 };
    EXPECT_GT( tally( input ).kernels.count( "Machpoint::permute" ), 0u );
}

// What has a line in the end table is what a study of effects leaves out: each
// part that has passes of its own, by the name of its declaration.
TEST( Effects, partsHaveTheNamesThatTheyAreDeclaredWith )
{
    auto input = box( 2, 8, 2, "conservative", "quadratic", "periodic" );
    addViscosity( input );
    input["method"]["pressure_relaxation"] = 0.05;
    input["method"]["heat_mixing"] = 2;
    std::set<std::string> declared, found;
    for ( const auto& effect :
          optionalEffects( resolveInput( input, "test" ) ) )
        declared.insert( effect.name );
    const RestoredCallbacks restored;
    Profile::start();
    auto run = simulate( input );
    advance( *run, 20 );
    for ( const auto& entry : Profile::effects() )
        if ( entry.name.rfind( "periodic", 0 ) != 0 &&
             entry.name != "ideal_gas" )
        {
            EXPECT_EQ( declared.count( entry.name ), 1u ) << entry.name;
            // Retries have a kernel of their own only where a step is suspect
            // or rows move, viscosity works within P2G.
            if ( entry.name == "retries" ||
                 entry.name == "artificial_viscosity" )
                EXPECT_EQ( entry.kernels, 0 ) << entry.name;
            else
                EXPECT_GT( entry.kernels, 0 ) << entry.name;
            found.insert( entry.name );
        }
    EXPECT_EQ( found,
               ( std::set<std::string>{
                   "artificial_viscosity", "viscosity limiter",
                   "pressure relaxation", "heat mixing", "heat conduction",
                   "splitting", "merging", "midpoint", "retries" } ) );
}

struct Effect
{
    std::string name;
    std::string list; // "physics" or "boundary"
    Json entry;
    std::set<std::string> kernels; // labels that are its own
    std::set<std::string> memory;  // likewise
    Counts shared = {};            // launches of what others launch, too
};

//! What a step launches for sums on nodes. \param sums that are folded
//! \param fills fields of which periodic images are copied
Counts nodeSums( const int sums, const int fills )
{
    Counts counts = { { "Machpoint::fold", 40 * sums }, // axis by axis
                      { "Machpoint::fill", 40 * fills } };
    if ( runs_on_host )
        counts["Machpoint::clearSums"] = 20 * sums;
    if ( runs_on_host && ExecutionSpace().concurrency() > 1 )
        counts["Machpoint::sumOfThreads"] = 20 * sums;
    return counts;
}

//! The same of an effect that gives particles heat, kept until after G2P.
Counts nodeSumsAndHeat( const int sums, const int fills )
{
    auto counts = nodeSums( sums, fills );
    counts["Machpoint::clearSidecar"] = 1;
    return counts;
}

//! Threads' copies of the nodes, which each sum has of its own.
const std::set<std::string> copies = {
    "Machpoint::cleared", "Machpoint::copiesOfNodes", "Machpoint::copyOfNodes",
    "Machpoint::usedBlocks" };

class OptionalEffect : public testing::TestWithParam<int>
{
};

const std::vector<Effect>& effects()
{
    static const std::vector<Effect> list = {
        { "artificial_viscosity",
          "physics",
          { { "type", "artificial_viscosity" } },
          { "Machpoint::artificialViscosity", "Machpoint::limitViscosity" },
          {} },
        { "gravity",
          "physics",
          { { "type", "gravity" }, { "acceleration", { 0.1, 0.0 } } },
          { "Machpoint::copyDeposit", "Machpoint::pushNodes",
            "Machpoint::workOnNodes" },
          { "Machpoint::gravity" },
          { { "Machpoint::fold", 40 } } }, // of its own force
        { "viscosity",
          "physics",
          { { "type", "viscosity" }, { "shear", 1e-3 } },
          { "Machpoint::viscousStress", "Machpoint::viscousForce",
            "Machpoint::viscousHeat", "Machpoint::giveHeat" },
          { "Machpoint::viscousStress", "Machpoint::frictionHeat" },
          nodeSumsAndHeat( 1, 2 ) }, // v and v', twice
        { "heat_conduction",
          "physics",
          { { "type", "heat_conduction" }, { "conductivity", 1e-3 } },
          { "Machpoint::nodeTemperature", "Machpoint::divideTemperature",
            "Machpoint::heatFlux", "Machpoint::heatingOfNodes",
            "Machpoint::conductedHeatOfParticles", "Machpoint::giveHeat" },
          { "Machpoint::nodeTemperature", "Machpoint::heatFlux",
            "Machpoint::conductedHeat" },
          nodeSumsAndHeat( 2, 2 ) },
        { "obstacle",
          "boundary",
          // Smaller than the gap between nodes: it leaves the flow alone, so
          // that the rest of the step is the same.
          { { "type", "obstacle" },
            { "shape",
              { { "type", "sphere" },
                { "center", { 0.5, 0.5 } },
                { "radius", 0.01 } } } },
          { "Machpoint::listNodes", "Machpoint::obstacle",
            "Machpoint::noteNear", "Machpoint::nearObstacle",
            "Machpoint::pushOut" },
          { "Machpoint::solidNodes", "Machpoint::nearObstacle",
            "Machpoint::shape_solids", "Machpoint::bodies",
            "Machpoint::imageReach" } } };
    return list;
}

// With the effect: its kernels run. Without: none of them, and not a byte of
// its memory. What remains is the base method to the last launch and byte.
TEST_P( OptionalEffect, costsNothingWhenAbsent )
{
    const auto& effect = effects()[GetParam()];
    const auto absent = tally( baseScene() );
    auto input = baseScene();
    input[effect.list].push_back( effect.entry );
    const auto present = tally( input );

    for ( const auto& label : effect.kernels )
    {
        EXPECT_EQ( absent.kernels.count( label ), 0u ) << label;
        EXPECT_GT( present.kernels.count( label ), 0u ) << label;
    }
    for ( const auto& label : effect.memory )
    {
        EXPECT_EQ( absent.allocations.count( label ), 0u ) << label;
        EXPECT_GT( present.allocations.count( label ), 0u ) << label;
    }

    auto rest = ours( without( present.kernels, effect.kernels ) );
    for ( const auto& [label, count] : effect.shared )
        if ( ( rest[label] -= count ) == 0 )
            rest.erase( label );
    EXPECT_EQ( rest, ours( absent.kernels ) );
    const auto memoryOf = [&]( const Tally& scene )
    {
        return ours(
            without( without( scene.allocations, effect.memory ), copies ) );
    };
    EXPECT_EQ( memoryOf( present ), memoryOf( absent ) );
}

INSTANTIATE_TEST_SUITE_P( Each, OptionalEffect,
                          testing::Range( 0, int( effects().size() ) ),
                          []( const auto& info )
                          { return effects()[info.param].name; } );

// The parts of `conservative` are effects, too: off, they launch nothing and
// hold nothing.
struct CountedPart
{
    std::string key;
    Json on, off;
    std::set<std::string> kernels, memory;
};

class OptionalPart : public testing::TestWithParam<int>
{
};

const std::vector<CountedPart>& countedParts()
{
    static const std::vector<CountedPart> list = {
        { "viscosity_limiter", true, false, { "Machpoint::limitMotion" }, {} },
        { "pressure_relaxation",
          0.05,
          0,
          { "Machpoint::cellPressure", "Machpoint::meanCellPressure",
            "Machpoint::targetPressure", "Machpoint::exchangeVolume" },
          { "Machpoint::means" } },
        { "heat_mixing",
          2,
          0,
          { "Machpoint::sharedHeat", "Machpoint::mixHeat" },
          {} },
        { "heat_conduction", 20, 0, { "Machpoint::findFriction" }, {} },
        { "split_volume",
          0.75,
          0,
          { "Machpoint::trackStretch" },
          { "Machpoint::history" } },
        { "merge_volume",
          0.125,
          0,
          { "Machpoint::noteTiny" },
          { "Machpoint::history", "Machpoint::halfCellMarks" } },
        { "time", "midpoint", "symplectic", {}, { "Machpoint::drift" } } };
    return list;
}

TEST_P( OptionalPart, costsNothingWhenOff )
{
    const auto& part = countedParts()[GetParam()];
    auto input = box( 2, 8, 2, "conservative", "quadratic", "periodic" );
    addViscosity( input );
    for ( const auto& other : countedParts() )
        input["method"][other.key] = other.off;
    const auto off = tally( input );
    input["method"][part.key] = part.on;
    const auto on = tally( input );
    for ( const auto& label : part.kernels )
    {
        EXPECT_EQ( off.kernels.count( label ), 0u ) << label;
        EXPECT_GT( on.kernels.count( label ), 0u ) << label;
    }
    for ( const auto& label : part.memory )
    {
        EXPECT_EQ( off.allocations.count( label ), 0u ) << label;
        EXPECT_GT( on.allocations.count( label ), 0u ) << label;
    }
}

//! The messages of an input that is refused, one a line.
std::string refusal( const Json& input )
{
    try
    {
        resolveInput( input, "test" );
    }
    catch ( const InputError& error )
    {
        return error.what();
    }
    return "";
}

//! Overrides one hook by its base, one by itself, and one that nobody can see.
template <int Dim>
class ListenerBase : public Module<Dim>
{
  public:
    void gridWork( State<Dim>& ) override {}
};
template <int Dim>
class Listener : public ListenerBase<Dim>
{
  public:
    static constexpr const char* name = "listener";
    static Parameters declare( const int dimension )
    {
        return Parameters( name, "has three hooks", dimension );
    }
    static std::string fault( const Json&, const MethodFacts& method )
    {
        return method.name == "paper" ? ": hears nothing there" : "";
    }
    explicit Listener( const Json& ) {}
    bool particleSource( State<Dim>& ) override { return false; }

  private:
    void inject( State<Dim>& ) override {}
};

TEST( Effects, noHookIsCalledThatAModuleDoesNotHave )
{
    constexpr auto hooks = hooksOf<2, Listener<2>>();
    for ( const auto hook :
          { Hook::gridWork, Hook::particleSource, Hook::inject } )
        EXPECT_TRUE( hooks.has( hook ) );
    for ( const auto hook :
          { Hook::layOut, Hook::initialize, Hook::particleState,
            Hook::limitTimeStep, Hook::mirrorParticles, Hook::keepDeposit,
            Hook::gridForce, Hook::applyToGrid, Hook::applyToParticles } )
        EXPECT_FALSE( hooks.has( hook ) );

    registerPhysics<Listener>();
    EXPECT_THROW( registerPhysics<Listener>(), std::invalid_argument );
    auto input = baseScene();
    input["physics"].push_back( { { "type", "listener" } } );
    const RestoredCallbacks restored;
    Profile::start();
    auto run = simulate( input );
    advance( *run, 5 );
    const auto& effects = Profile::effects();
    const auto found = std::find_if( effects.begin(), effects.end(),
                                     []( const ProfileEntry& effect )
                                     { return effect.name == "listener"; } );
    ASSERT_NE( found, effects.end() );
    EXPECT_EQ( found->calls, 1 + 3 * 5 ); // made, and in every step

    input["method"]["name"] = "paper";
    EXPECT_EQ( refusal( input ), "test: /physics/1: hears nothing there" );
}

//! A boundary from outside that takes both ends of x, and says all that one can
//! before it is made.
template <int Dim>
class Plugs : public Module<Dim>
{
  public:
    static constexpr const char* name = "plugs";
    static Parameters declare( const int dimension )
    {
        Parameters p( name, "walls at both ends of x", dimension );
        p.number( "weight", "told to nobody" );
        p.text( "of", "the method that made it up" ).optional();
        return p;
    }
    static void complete( Json& entry, const MethodFacts& method )
    {
        if ( !entry.contains( "of" ) )
            entry["of"] = method.name;
    }
    static std::string fault( const Json& entry, const MethodFacts& method )
    {
        return entry.at( "weight" ) > 0 && method.has_images
                   ? ""
                   : "/weight: must be > 0";
    }
    static std::vector<SideClaim> sides( const Json& )
    {
        return { { 0, SideKind::slip }, { 1, SideKind::slip } };
    }
    static GasState beyond( const Json&, const int side, const GasState& gas )
    {
        return SlipWall<Dim>::beyond( {}, side, gas );
    }
    explicit Plugs( const Json& )
        : _lower( Json{ { "side", "x_lower" } } ),
          _upper( Json{ { "side", "x_upper" } } )
    {
    }
    void applyToParticles( State<Dim>& state ) override
    {
        _lower.applyToParticles( state );
        _upper.applyToParticles( state );
    }

  private:
    SlipWall<Dim> _lower, _upper;
};

//! Of particles in 1D.
std::map<std::int64_t, double> velocitiesById( Simulation& run )
{
    const auto data = run.particleData();
    std::map<std::int64_t, double> velocities;
    for ( std::size_t p = 0; p < data.id.size(); ++p )
        velocities[data.id[p]] = data.velocity[p];
    return velocities;
}

// What a type says of its entry counts as if it were one of ours.
TEST( BoundaryFromOutside, isAskedAboutItsEntry )
{
    static const bool registered = []
    {
        registerBoundary<Plugs>();
        return true;
    }();
    static_cast<void>( registered );
    auto input = shockTube( 1, 40, 3, "conservative", "quadratic" );
    addViscosity( input );
    auto walls = simulate( input );
    auto own = input;
    own["boundary"] =
        Json::array( { { { "type", "plugs" }, { "weight", 1 } } } );
    auto plugs = simulate( own );
    for ( auto* run : { walls.get(), plugs.get() } )
        advanceTo( *run, 0.6 ); // waves are back from both ends
    // Rows of particles that share a cell may differ on a GPU.
    const auto a = velocitiesById( *walls ), b = velocitiesById( *plugs );
    ASSERT_EQ( a.size(), b.size() );
    for ( const auto& [id, velocity] : a )
        EXPECT_NEAR( velocity, b.at( id ), tolerance( 1e-11 ) );
    EXPECT_EQ( resolveInput( own, "test" )["boundary"][0]["of"],
               "conservative" );

    own["boundary"][0]["weight"] = 0;
    EXPECT_EQ( refusal( own ), "test: /boundary/0/weight: must be > 0" );
    own["boundary"][0]["weight"] = 1;
    own["boundary"].push_back(
        { { "type", "slip_wall" }, { "side", "x_upper" } } );
    EXPECT_NE( refusal( own ).find( "more than one entry for side x_upper" ),
               std::string::npos );

    // Gas that runs into a plug, and nothing that gives the shock a width.
    auto bare = box( 1, 40, 3, "conservative", "quadratic", "periodic" );
    bare["initial"][0]["velocity"] = { 0.5 };
    EXPECT_TRUE( findWarnings( resolveInput( bare, "test" ) ).empty() );
    bare["boundary"] = own["boundary"];
    bare["boundary"].erase( 1 );
    const auto warnings = findWarnings( resolveInput( bare, "test" ) );
    ASSERT_EQ( warnings.size(), 1u );
    EXPECT_NE( warnings[0].find( "the side x_" ), std::string::npos )
        << warnings[0];
}

//! A gas from outside: p (1 / rho - b) = (gamma - 1) e, of Noble and Abel.
template <int Dim>
class NobleAbel : public EquationOfState<Dim>
{
  public:
    static constexpr const char* name = "noble_abel";
    static Parameters declare( const int dimension )
    {
        Parameters p( name, "of molecules that need room", dimension );
        p.number( "covolume", "b" ).unit( "volume/mass" ).atLeast( 0 );
        return p;
    }
    explicit NobleAbel( const Json& json ) : _b( json.at( "covolume" ) ) {}

    Real specificInternalEnergy( const Real density,
                                 const Real pressure ) const override
    {
        return pressure * ( 1 - _b * density ) / ( 0.4_rt * density );
    }
    GasSurvey evaluate( State<Dim>& state, const bool surveys ) override
    {
        return evaluateGas( state, surveys, Formula{ _b } );
    }
    PressureResponse response() const override { return { 1.4_rt, 0.4_rt }; }

    struct Formula
    {
        Real b;
        KOKKOS_FORCEINLINE_FUNCTION ThermodynamicState
        operator()( const Lanes& density, const Lanes& energy ) const
        {
            const Lanes room = 1.0_rt - b * density;
            const Lanes pressure = 0.4_rt * density * energy / room;
            return { pressure, 1.4_rt * pressure / ( density * room ) };
        }
    };

  private:
    Real _b;
};

// A gas of one's own runs, is checked, and has no exact solution of ours.
TEST( GasFromOutside, runs )
{
    static const bool registered = []
    {
        registerPhysics<NobleAbel>();
        return true;
    }();
    static_cast<void>( registered );
    auto input = shockTube( 1, 40, 3, "conservative", "quadratic" );
    addViscosity( input );
    auto ideal = simulate( input );
    auto own = input;
    own["physics"][0] = { { "type", "noble_abel" }, { "covolume", 0.0 } };
    auto none = simulate( own );
    own["physics"][0]["covolume"] = 0.3;
    auto some = simulate( own );
    EXPECT_TRUE( findWarnings( resolveInput( own, "test" ) ).empty() );
    for ( auto* run : { ideal.get(), none.get(), some.get() } )
        advanceTo( *run, 0.1 );
    const auto a = ideal->particleData(), b = none->particleData();
    ASSERT_EQ( a.id.size(), b.id.size() );
    for ( std::size_t p = 0; p < a.id.size(); ++p )
        EXPECT_NEAR( a.pressure[p], b.pressure[p], tolerance( 1e-11 ) );
    // Sound is faster in it, and so the gas between the waves another.
    EXPECT_GT( std::abs( largest( some->particleData().velocity ) -
                         largest( a.velocity ) ),
               1e-3 );

    own["exact"] = { { "type", "riemann" } };
    try
    {
        simulate( own );
        FAIL() << "an exact solution of an unknown gas";
    }
    catch ( const InputError& error )
    {
        EXPECT_NE( std::string( error.what() ).find( "/exact: needs" ),
                   std::string::npos )
            << error.what();
    }
}

TEST( Effects, timeOfAnInnerPhaseIsItsOwn )
{
    const RestoredCallbacks restored;
    Profile::start();
    const Kokkos::Timer timer;
    {
        const Profile::Phase outer( "outer" );
        const Profile::Phase inner( "inner" );
        std::this_thread::sleep_for( std::chrono::milliseconds( 5 ) );
    }
    const double all = timer.seconds();
    double sum = 0;
    for ( const auto& phase : Profile::phases() )
        sum += phase.seconds;
    EXPECT_EQ( Profile::phases().size(), 2u );
    EXPECT_GT( sum, 4e-3 );
    EXPECT_LE( sum, all );
}

//! A kernel that does nothing.
void launchNothing()
{
    Kokkos::parallel_for( "nothing", Range( 0, 1 ),
                          KOKKOS_LAMBDA( const int ){} );
}

// A GPU's error shows in the fence of a destructor, perhaps while another error
// is on its way: that must not end the program before it is told.
TEST( Effects, aFailingDeviceDoesNotEndTheProgram )
{
    const RestoredCallbacks restored;
    Profile::start();
    auto fail = []
    {
        launchNothing();
        Kokkos::Tools::Experimental::set_begin_fence_callback(
            []( const char*, const std::uint32_t, std::uint64_t* )
            { throw std::runtime_error( "the device fails" ); } );
    };
    {
        const Profile::Phase phase( "phase" );
        fail();
    }
    Kokkos::Tools::Experimental::set_begin_fence_callback( nullptr );
    {
        const Profile::Effect effect( "effect" );
        fail();
    }
    for ( const auto* entries : { &Profile::phases(), &Profile::effects() } )
    {
        ASSERT_EQ( entries->size(), 1u );
        EXPECT_EQ( entries->front().calls, 1 );
    }
}

// Conduction looks for friction; only gas that has felt some conducts heat.
TEST( Effects, gasWithoutFrictionConductsNoHeat )
{
    const auto quiet = box( 2, 8, 2, "conservative", "quadratic", "periodic" );
    EXPECT_EQ( tally( quiet ).kernels.count( "Machpoint::conductHeat" ), 0u );
    auto shocked = shockTube( 2, 16, 3, "conservative", "quadratic" );
    shocked["particles"]["placement"] = "random";
    EXPECT_GT( tally( shocked ).kernels.count( "Machpoint::conductHeat" ), 0u );
}

// The limiter is for the viscosity and two parts: without these there is
// nothing to limit.
TEST( Effects, nothingIsLimitedWithoutViscosity )
{
    auto input = box( 2, 8, 2, "conservative", "quadratic", "periodic" );
    input["method"]["blend_in_compression"] = 0;
    EXPECT_EQ( tally( input ).kernels.count( "Machpoint::limitMotion" ), 0u );
    addViscosity( input );
    EXPECT_GT( tally( input ).kernels.count( "Machpoint::limitMotion" ), 0u );
}

INSTANTIATE_TEST_SUITE_P( Each, OptionalPart,
                          testing::Range( 0, int( countedParts().size() ) ),
                          []( const auto& info )
                          { return countedParts()[info.param].key; } );

// Nothing is allocated in the time loop of a closed scene, sorts apart.
class Method : public testing::TestWithParam<std::string>
{
};

TEST_P( Method, allocatesNothingInTheLoopOfAClosedScene )
{
    auto input = box( 2, 8, 2, GetParam(), "quadratic", "periodic" );
    input["particles"]["sort_every"] = 1000000;
    addViscosity( input );
    auto run = simulate( input );
    advance( *run, 2 ); // the first step sorts
    const RestoredCallbacks restored;
    allocations.clear();
    Kokkos::Tools::Experimental::set_allocate_data_callback( &countBytes );
    advance( *run, 20 );
    EXPECT_EQ( allocations, Counts{} );
}

// Nor where particles enter, are halved and leave, once lists have been as long
// as they get.
TEST( OpenScene, allocatesNothingInTheLoop )
{
    auto input = streamPast(
        { { "type", "sphere" }, { "center", { 0.4, 0.5 } }, { "radius", 0.1 } },
        2, 24, 3, "conservative", "quadratic" );
    input["particles"]["sort_every"] = 1000000;
    input["method"]["merge_volume"] = 0; // it sorts
    auto run = simulate( input );
    advance( *run, 250 );
    const Real entered = run->ledger().mass_in;
    const Real left = run->ledger().mass_out;
    const RestoredCallbacks restored;
    allocations.clear();
    kernels.clear();
    Kokkos::Tools::Experimental::set_allocate_data_callback( &countOwnBytes );
    Kokkos::Tools::Experimental::set_begin_parallel_for_callback(
        &countKernel );
    advance( *run, 20 );
    EXPECT_EQ( allocations, Counts{} );
    EXPECT_GT( run->ledger().mass_in, entered );
    EXPECT_GT( run->ledger().mass_out, left );
    EXPECT_GT( kernels["Machpoint::splitParticles"], 0 );
}

INSTANTIATE_TEST_SUITE_P( Each, Method,
                          testing::Values( "paper", "apic", "conservative" ) );

} // namespace
