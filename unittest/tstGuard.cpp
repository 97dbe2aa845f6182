// Steps that break the gas: they are rejected and repeated with half their
// length, and where that does not help the run ends with the last good state.
#include "scenes.hpp"

#include <core/registry.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace
{

using namespace Machpoint;
using namespace Test;

//! Breaks the energy of the particle with id 7 in given steps, as long as dt is
//! above a threshold.
template <int Dim>
class Saboteur : public Module<Dim>
{
  public:
    static constexpr const char* name = "saboteur";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "breaks the gas", dimension );
        p.integer( "step", "in which" );
        p.number( "above", "time steps longer than this" ).defaultsTo( 0 );
        p.choice( "fault",
                  { "nan", "negative", "volume", "far", "mass", "end", "stop",
                    "limit" },
                  "how; end: it is for the module to say so; stop: by no step; "
                  "limit: by one that is no number" );
        p.boolean( "early", "before the step has ended" ).defaultsTo( false );
        p.boolean( "late", "after the step's check" ).defaultsTo( false );
        return p;
    }
    explicit Saboteur( const Json& json )
        : _step( json.at( "step" ) ), _above( json.at( "above" ) ),
          _fault( json.at( "fault" ) ), _early( json.at( "early" ) ),
          _late( json.at( "late" ) )
    {
    }
    bool particleSource( State<Dim>& state ) override
    {
        state.ledger.energy_in += 1;
        if ( !_late && !_early )
            act( state );
        return !_late;
    }
    void applyToGrid( State<Dim>& state, const GridVelocity& ) override
    {
        if ( _early )
            act( state );
    }
    void applyToParticles( State<Dim>& state ) override
    {
        if ( !_late )
            return;
        act( state );
        if ( state.step == _step )
            removeParticle( state );
    }
    Real limitTimeStep( State<Dim>& state ) override
    {
        const bool acts = state.step == _step;
        return acts && _fault == "stop" ? 1e-30_rt
               : acts && _fault == "limit"
                   ? std::numeric_limits<Real>::quiet_NaN()
                   : Kokkos::Experimental::infinity_v<Real>;
    }
    //! What is late also removes a particle, so that others change their rows.
    bool isOpen() const override { return _late; }
    void removeParticle( State<Dim>& state ) const
    {
        const auto id = state.particles.template slice<Id>();
        const auto noted = state.noted;
        const IndexList row( "row", 1 );
        Kokkos::parallel_for(
            "findParticle", Range( 0, state.particles.size() ),
            KOKKOS_LAMBDA( const int p ) {
                if ( id( p ) == 3 )
                    row( 0 ) = p;
            } );
        state.particles.keepIdentities( row );
        Kokkos::parallel_for(
            "removeParticle", Range( 0, 1 ), KOKKOS_LAMBDA( const int k ) {
                id( row( k ) ) = -1;
                noted.note( row( k ) );
            } );
    }
    void act( const State<Dim>& state ) const
    {
        if ( state.step != _step || state.dt <= _above )
            return;
        if ( _fault == "end" )
            throw NumericalFailure( "it is over" );
        const auto m = state.particles.template slice<Mass>();
        const auto id = state.particles.template slice<Id>();
        const auto x = state.particles.template slice<Position>();
        const auto V = state.particles.template slice<Volume>();
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const Real nan = std::numeric_limits<Real>::quiet_NaN();
        const int fault = _fault == "nan"        ? 0
                          : _fault == "negative" ? 1
                          : _fault == "volume"   ? 2
                          : _fault == "far"      ? 3
                          : _fault == "mass"     ? 4
                                                 : 5;
        const Real h = state.grid.minSpacing();
        Kokkos::parallel_for(
            "sabotage", Range( 0, state.particles.size() ),
            KOKKOS_LAMBDA( const int p ) {
                if ( id( p ) != 7 )
                    return;
                if ( fault == 0 )
                    e( p ) = nan;
                if ( fault == 1 )
                    e( p ) = -1;
                if ( fault == 2 )
                    V( p ) = 0;
                if ( fault == 3 )
                    x( p, 0 ) += 1.5 * h;
                if ( fault == 4 )
                    m( p ) = nan;
            } );
    }

  private:
    std::int64_t _step;
    Real _above;
    std::string _fault;
    bool _early, _late;
};

Json sabotaged( const std::string& method, const Json& fault )
{
    static const bool registered = []
    {
        registerPhysics<Saboteur>();
        return true;
    }();
    static_cast<void>( registered );
    auto input = shockTube( 1, 50, 3, method,
                            method == "paper" ? "linear" : "quadratic" );
    addViscosity( input );
    Json saboteur = { { "type", "saboteur" }, { "step", 20 } };
    setKeys( saboteur, fault );
    input["physics"].push_back( saboteur );
    return input;
}

//! Every particle by id: position, velocity, energy, volume, mass.
std::map<std::int64_t, std::array<Real, 5>> stateById( Simulation& run )
{
    const auto data = run.particleData();
    std::map<std::int64_t, std::array<Real, 5>> list;
    for ( std::size_t p = 0; p < data.id.size(); ++p )
        list[data.id[p]] = { data.position[p], data.velocity[p],
                             data.specific_internal_energy[p], data.volume[p],
                             data.mass[p] };
    return list;
}

// A step that fails unless it is shorter is repeated until it is; then the run
// is that of a run which took the short step at once.
TEST( Guard, repeatsWithHalfTheStep )
{
    for ( const auto& method : methods )
    {
        auto probe = simulate(
            sabotaged( method, { { "fault", "nan" }, { "step", 1000000 } } ) );
        advance( *probe, 21 );
        const Real dt = probe->timeStep();
        for ( const std::string fault : { "nan", "negative", "volume", "far" } )
        {
            if ( method == "paper" && fault == "negative" )
                continue; // the paper's scheme promises no positive energy
            auto run = simulate( sabotaged(
                method, { { "fault", fault }, { "above", 0.3 * dt } } ) );
            advance( *run, 21 );
            EXPECT_EQ( run->retries(), 2 ) << method << fault;
            EXPECT_NEAR( run->timeStep(), dt / 4, tolerance( 1e-12 ) * dt )
                << method << fault;
            EXPECT_EQ( run->limiter(), "a repeated step" ) << method << fault;
            EXPECT_EQ( run->ledger().energy_in, 21 ) << method << fault;

            auto direct = simulate( sabotaged(
                method, { { "fault", fault }, { "step", 1000000 } } ) );
            advance( *direct, 20 );
            direct->step( direct->time() + dt / 4 );
            // Up to the rounding of its dt.
            const auto repeated = stateById( *run ),
                       once = stateById( *direct );
            ASSERT_EQ( repeated.size(), once.size() );
            for ( const auto& [id, values] : repeated )
                for ( std::size_t k = 0; k < values.size(); ++k )
                    EXPECT_NEAR( values[k], once.at( id )[k],
                                 tolerance( 1e-12 ) )
                        << method << fault << id;
        }
    }
}

// A step that an output cuts short is halved like any other: from what it was,
// not from what it would have been, which would repeat it as it was.
TEST( Guard, halvesAStepThatIsCut )
{
    auto input = box( 1, 100, 3, "conservative", "quadratic", "periodic" );
    constexpr double speed = 30, cut = 1.5 * 0.01 / ( speed + 1 );
    input["initial"][0]["velocity"] = { speed };
    input["time"]["cfl"] = 100;
    input["time"]["retries"] = 4;
    auto run = simulate( input );
    for ( int k = 1; k <= 3; ++k )
        while ( run->time() < k * cut )
            run->step( k * cut );
    EXPECT_GT( run->retries(), 0 );
}

// What no short step mends ends the run: with a message that says which
// quantity, where, when and what to try, and with the last good state.
TEST( Guard, endsWithTheLastGoodState )
{
    // A GPU adds in another order in every run.
    const Real rounding = runs_on_host ? 0 : tolerance( 1e-12 );
    for ( const auto& method : methods )
        for ( const bool late : { false, true } )
        {
            auto run = simulate(
                sabotaged( method, { { "fault", "nan" }, { "late", late } } ) );
            auto good = simulate( sabotaged(
                method, { { "fault", "nan" }, { "step", 1000000 } } ) );
            advance( *run, 20 );
            advance( *good, 20 );
            bool failed = false;
            try
            {
                advance( *run, 2 );
            }
            catch ( const NumericalFailure& failure )
            {
                failed = true;
                const std::string text = failure.what();
                // The parts of conservative spread what is broken.
                for ( const std::string part :
                      { late ? "particle " : "particle 7", "not finite",
                        "specific internal energy", "step ", "t = ", "try " } )
                    EXPECT_NE( text.find( part ), std::string::npos ) << text;
            }
            EXPECT_TRUE( failed ) << method << late;
            EXPECT_EQ( run->retries(), late ? 0 : 10 ) << method << late;
            const auto state = stateById( *run );
            if ( method == "conservative" ) // which first rearranged particles
            {
                EXPECT_EQ( run->totals().mass, good->totals().mass );
                EXPECT_NEAR( run->totals().energy(), good->totals().energy(),
                             tolerance( 1e-13 ) );
            }
            else
                for ( const auto& [id, values] : stateById( *good ) )
                    for ( std::size_t k = 0; k < values.size(); ++k )
                        EXPECT_NEAR( state.at( id )[k], values[k], rounding )
                            << method << late << id;
            EXPECT_NEAR( run->time(), good->time(), rounding )
                << method << late;
            for ( const auto& [id, values] : state )
                for ( const Real value : values )
                    ASSERT_TRUE( std::isfinite( value ) );
        }
}

// So does a module that ends the run in the middle of a step.
TEST( Guard, aModuleThatEndsTheRunTakesItsStepBack )
{
    for ( const auto& method : methods )
        for ( const char* when : { "early", "in time", "late" } )
        {
            auto run =
                simulate( sabotaged( method, { { "fault", "end" },
                                               { "early", when[0] == 'e' },
                                               { "late", when[0] == 'l' } } ) );
            auto good = simulate( sabotaged(
                method, { { "fault", "end" }, { "step", 1000000 } } ) );
            advance( *run, 20 );
            advance( *good, 20 );
            EXPECT_THROW( advance( *run, 1 ), NumericalFailure );
            EXPECT_EQ( run->steps(), 20 );
            const Real rounding = tolerance( 1e-12 );
            EXPECT_NEAR( run->time(), good->time(), rounding );
            EXPECT_NEAR( run->totals().energy(), good->totals().energy(),
                         tolerance( 1e-13 ) )
                << method << when;
            if ( method == "conservative" )
                continue; // it first rearranges particles
            EXPECT_EQ( run->particles(), good->particles() );
            const auto state = stateById( *run );
            for ( const auto& [id, values] : stateById( *good ) )
                for ( std::size_t k = 0; k < values.size(); ++k )
                    EXPECT_NEAR( state.at( id )[k], values[k], rounding )
                        << method << when << id;
        }
}

// What ends a run names its cause: a step so short that it would not end, a
// limit that is no number, a particle without a mass, a module that says so.
TEST( Guard, aRunThatEndsNamesItsCause )
{
    const std::vector<std::pair<std::string, std::vector<std::string>>> cases =
        { { "stop",
            { "the time step 1e-30 at step 20", "limited by saboteur",
              "look for" } },
          { "limit", { "saboteur allows no time step", "step 20" } },
          { "mass",
            { "particle 7 at", "no positive, finite mass", "step 20" } },
          { "end", { "it is over (saboteur in particleSource, step 20)" } } };
    for ( const auto& [fault, parts] : cases )
    {
        auto run = simulate( sabotaged( "apic", { { "fault", fault } } ) );
        advance( *run, 20 );
        const double time = run->time();
        std::string text;
        try
        {
            run->step( 1 );
        }
        catch ( const NumericalFailure& failure )
        {
            text = failure.what();
        }
        for ( const auto& part : parts )
            EXPECT_NE( text.find( part ), std::string::npos ) << text;
        EXPECT_EQ( run->time(), time );
        EXPECT_EQ( run->steps(), 20 );
    }
}

// What an output leaves of two steps is parted evenly: no step is of round-off,
// and there are as many as before.
TEST( Guard, noStepIsOfRoundOff )
{
    auto input = box( 1, 50, 3, "conservative", "quadratic", "periodic" );
    input["initial"][0]["velocity"] = { 1 };
    auto run = simulate( input );
    advance( *run, 20 ); // past the start
    EXPECT_EQ( run->limiter(), "wave speed" );
    const double full = run->timeStep();
    for ( const double part : { 1e-13, 1e-6, 0.3, 0.9, 1 - 1e-13 } )
    {
        const double until = run->time() + ( 3 + part ) * full;
        const auto before = run->steps();
        while ( run->time() < until )
        {
            run->step( until );
            EXPECT_GT( run->timeStep(), 0.49 * full ) << part;
        }
        EXPECT_EQ( run->limiter(), "output time" ) << part;
        EXPECT_EQ( run->time(), until );
        EXPECT_EQ( run->steps() - before, part < 1e-7 ? 3 : 4 ) << part;
    }
}

// A step that is taken back leaves no row in a body's series.
TEST( Guard, aSeriesEndsWithTheLastGoodState )
{
    for ( const auto& method : methods )
        for ( const bool late : { false, true } )
        {
            auto input =
                sabotaged( method, { { "fault", "nan" }, { "late", late } } );
            input["boundary"].push_back( { { "type", "obstacle" },
                                           { "name", "wall" },
                                           { "shape",
                                             { { "type", "half_space" },
                                               { "point", { 0.9 } },
                                               { "normal", { -1 } } } } } );
            auto run = simulate( input );
            EXPECT_THROW( advance( *run, 30 ), NumericalFailure );
            const auto& rows = run->series().at( 0 )->rows;
            EXPECT_EQ( static_cast<std::int64_t>( rows.size() ), run->steps() )
                << method << late;
            EXPECT_NEAR( rows.back().at( 0 ), run->time(), 1e-12 );
        }
}

// What broke in a run's last step, after its check or without one, is found
// where the state is asked for.
TEST( Guard, findsWhatBrokeInTheLastStep )
{
    for ( const int retries : { 10, 0 } )
    {
        auto input = sabotaged(
            "apic", { { "fault", "nan" }, { "late", retries > 0 } } );
        input["time"]["retries"] = retries;
        auto run = simulate( input );
        advance( *run, 20 );
        EXPECT_NO_THROW( run->surveyExtrema() );
        advance( *run, 1 );
        EXPECT_EQ( run->steps(), 21 );
        EXPECT_THROW( run->surveyExtrema(), NumericalFailure );
        EXPECT_EQ( run->steps(), retries > 0 ? 20 : 21 );
        if ( retries == 0 )
            continue;
        EXPECT_NO_THROW( run->surveyExtrema() );
    }
}

// Without retries nothing is copied and nothing checked after the step.
TEST( Guard, canBeSwitchedOff )
{
    auto input = sabotaged( "apic", { { "fault", "far" } } );
    const Real guarded = simulate( input )->bytesPerParticle();
    input["time"]["retries"] = 0;
    auto run = simulate( input );
    advance( *run, 30 );
    EXPECT_EQ( run->retries(), 0 );
    EXPECT_LE( run->bytesPerParticle(), guarded );
}

// A new state beside the old one, too large for the cache and so written past
// it, is the state that a step without an old one leaves.
TEST( Guard, theOldStateChangesNothing )
{
    const int cells = is_single ? 460 : is_mixed ? 360 : 320;
    for ( const auto& method : methods )
    {
        auto input = shockTube( 2, cells, 2, method,
                                method == "paper" ? "linear" : "quadratic" );
        auto kept = simulate( input );
        input["time"]["retries"] = 0;
        auto overwritten = simulate( input );
        for ( auto* run : { kept.get(), overwritten.get() } )
            advance( *run, 3 );
        const auto a = kept->particleData(), b = overwritten->particleData();
        ASSERT_GT( kept->bytesPerParticle() * a.id.size(), cached_bytes );
        ASSERT_EQ( a.id, b.id );
        for ( const auto& [name, one, other] :
              { std::tuple{ "position", &a.position, &b.position },
                { "velocity", &a.velocity, &b.velocity },
                { "volume", &a.volume, &b.volume },
                { "energy", &a.specific_internal_energy,
                  &b.specific_internal_energy } } )
        {
            Real most = 0;
            for ( std::size_t k = 0; k < one->size(); ++k )
                most = std::max<Real>(
                    most, std::abs( ( *one )[k] - ( *other )[k] ) );
            EXPECT_LT( most, tolerance( 1e-12 ) ) << method << " " << name;
        }
    }
}

// Reproducible sums ask particles twice for what they add, where `midpoint` has
// moved them by then.
TEST( Guard, reproducibleSumsNeedNoOldState )
{
    if ( is_single )
        GTEST_SKIP() << "reproducible sums are of doubles";
    auto input = shockTube( 2, 12, 2, "conservative", "linear" );
    input["reproducible"] = true;
    auto guarded = simulate( input );
    input["time"]["retries"] = 0;
    auto unguarded = simulate( input );
    for ( auto* run : { guarded.get(), unguarded.get() } )
        advance( *run, 5 );
    EXPECT_EQ( guarded->retries(), 0 );
    const auto a = guarded->particleData(), b = unguarded->particleData();
    EXPECT_EQ( a.id, b.id );
    EXPECT_EQ( a.position, b.position );
    EXPECT_EQ( a.volume, b.volume );
    EXPECT_EQ( a.specific_internal_energy, b.specific_internal_energy );
}

// Far too long a time step: the guard finds one that works, or gives up with
// a finite state; it never hands on a broken one.
TEST( Guard, survivesAbsurdCourantNumbers )
{
    for ( const auto& method : methods )
    {
        auto input = shockTube( 1, 50, 3, method,
                                method == "paper" ? "linear" : "quadratic" );
        addViscosity( input );
        input["time"]["cfl"] = 50;
        auto run = simulate( input );
        try
        {
            for ( int k = 0; k < 50 && run->time() < 0.2; ++k )
                run->step( 0.2 );
        }
        catch ( const NumericalFailure& )
        {
        }
        EXPECT_GT( run->retries(), 0 ) << method;
        for ( const auto& [id, values] : stateById( *run ) )
            for ( const Real value : values )
                ASSERT_TRUE( std::isfinite( value ) ) << method;
    }
}

// A broken initial state is reported with its place, not computed on.
TEST( Guard, namesWhatIsWrongAtTheStart )
{
    auto input = shockTube( 1, 50, 3, "paper", "linear" );
    input["initial"][0]["left"]["velocity"] = { 1e200 }; // its square is not
    try
    {
        simulate( input );
    }
    catch ( const InputError& error )
    {
        const std::string text = error.what();
        for ( const auto& part : { "/initial/0", "speed", " at (0." } )
            EXPECT_NE( text.find( part ), std::string::npos ) << text;
        return;
    }
    FAIL() << "a velocity whose square overflows must not be computed with";
}

} // namespace
