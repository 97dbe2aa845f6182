/*!
  \file tstModules.cpp
  \brief Modules from outside: what is asked of them before a run, and what they
  are told that do it wrong.
*/
#include "scenes.hpp"

#include <boundary/walls.hpp>
#include <core/file.hpp>
#include <core/registry.hpp>
#include <drivers/study_effects.hpp>
#include <drivers/study_input.hpp>
#include <drivers/warnings.hpp>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>

#include <unistd.h>

namespace
{

using namespace Machpoint;
using namespace Test;

//! What the modules below do wrong at the moment; empty: nothing.
std::string mistake;

//! Heats the gas in a region; has a series, and a part that can be left out.
template <int Dim>
class Heater : public Module<Dim>
{
  public:
    static constexpr const char* name = "heater";
    static Parameters declare( const int dimension )
    {
        if ( mistake == "declare" )
            throw std::runtime_error( "table.dat is not there" );
        Parameters p( mistake == "name" ? "heather" : name, "heats the gas",
                      dimension );
        p.text( "name", "of its series" ).defaultsTo( "heat" );
        p.number( "glow", "a part of it" )
            .switches( "glow of heat", 0 )
            .atLeast( 0 )
            .defaultsTo( mistake == "number"  ? Json( "text" )
                         : mistake == "range" ? Json( -1 )
                                              : Json( 1 ) );
        p.choice( "of", { "gas", "coal" }, "what burns" )
            .defaultsTo( mistake == "choice" ? "caol" : "coal" );
        p.vector( "at", "centre" )
            .defaultsTo(
                mistake == "vector"
                    ? Json( 0 )
                    : Json( std::vector( dimension ? dimension : 1, 0.0 ) ) );
        if ( mistake == "type" )
            p.text( "type", "of fuel" ).defaultsTo( "coal" );
        if ( mistake == "region" )
            p.text( "region", "where" ).defaultsTo( "here" );
        else
            p.oneOf( "region", shapeFamily(), "where" ).optional();
        return p;
    }
    static std::string fault( const Json& entry, const MethodFacts& )
    {
        return mistake == "fault"   ? "is too hot; cool it"
               : mistake == "throw" ? entry.at( "fuel" ).get<std::string>()
                                    : "";
    }
    static std::vector<std::string> columns() { return { "given" }; }
    explicit Heater( const Json& )
    {
        if ( mistake == "constructor" )
            throw std::runtime_error( "table.dat is not there" );
    }
};

//! A wall that heats, and says nothing else of itself than the wall does.
template <int Dim>
class HotWall : public SlipWall<Dim>
{
  public:
    static constexpr const char* name = "hot_wall";
    static Parameters declare( const int dimension )
    {
        Parameters p( name, "a wall that heats", dimension );
        SideBoundary<Dim>::declareSide( p );
        p.number( "glow", "a part of it" )
            .switches( "glow of walls", 0 )
            .defaultsTo( 0 );
        return p;
    }
    static std::vector<SideClaim> sides( const Json& entry )
    {
        auto claims = SlipWall<Dim>::sides( entry );
        if ( mistake == "side" )
            claims[0].side = 2 * Dim;
        else if ( mistake == "lower side" )
            claims[0].side = -1;
        return claims;
    }
    explicit HotWall( const Json& json ) : SlipWall<Dim>( json ) {}
    bool particleSource( State<Dim>& ) override { return true; }
};

class ModulesFromOutside : public testing::Test
{
  protected:
    static void SetUpTestSuite()
    {
        registerPhysics<Heater>();
        registerBoundary<HotWall>();
    }
    void TearDown() override { mistake.clear(); }

    //! Gas at rest in 1D, with a heater.
    static Json heated()
    {
        auto input = box( 1, 20, 3, "conservative", "quadratic", "slip_wall" );
        input["physics"].push_back( { { "type", "heater" } } );
        return input;
    }

    static std::string messageOf( const std::function<void()>& action )
    {
        try
        {
            action();
        }
        catch ( const std::exception& error )
        {
            return error.what();
        }
        return "";
    }

    static std::string refused( const Json& input )
    {
        return messageOf( [&] { resolveInput( input, "test" ); } );
    }
};

TEST_F( ModulesFromOutside, aShapeIsCheckedWhereverItIsDeclared )
{
    auto input = heated();
    input["physics"][1]["region"] = {
        { "type", "box" }, { "lower", { 0.6 } }, { "upper", { 0.4 } } };
    EXPECT_EQ( refused( input ), "test: /physics/1/region/upper/0: must be "
                                 "greater than lower (0.6), not 0.4" );
    input["physics"][1]["region"]["upper"] = { 0.8 };
    EXPECT_EQ( refused( input ), "" );
    // In a member of a union, too.
    input["physics"][1]["region"] = {
        { "type", "union" },
        { "shapes", Json::array( { Json{ { "type", "half_space" },
                                         { "point", { 0.0 } },
                                         { "normal", { 0.0 } } } } ) } };
    EXPECT_NE( refused( input ).find( "/physics/1/region/shapes/0/normal" ),
               std::string::npos );
}

TEST_F( ModulesFromOutside, aSeriesHasANameOfItsOwn )
{
    auto input = heated();
    input["physics"][1]["name"] = "a/b";
    EXPECT_NE( refused( input ).find( "test: /physics/1/name: names a file" ),
               std::string::npos );
    input["physics"][1]["name"] = "";
    EXPECT_NE( refused( input ).find( "/physics/1/name: names a file or "
                                      "directory, so it must not be empty" ),
               std::string::npos );
    input["physics"][1]["name"] = "body";
    EXPECT_EQ( refused( input ), "" );
    input["boundary"].push_back( { { "type", "obstacle" },
                                   { "name", "body" },
                                   { "shape",
                                     { { "type", "sphere" },
                                       { "center", { 0.5 } },
                                       { "radius", 0.2 } } } } );
    EXPECT_EQ( refused( input ),
               "test: /boundary/2/name: a second entry of the name \"body\" "
               "(the first is at /physics/1/name); its report would replace "
               "that one" );
}

TEST_F( ModulesFromOutside, errorsOfTheirOwnNameThem )
{
    const auto input = heated();
    mistake = "constructor";
    EXPECT_EQ( messageOf( [&] { simulate( input ); } ),
               "table.dat is not there (heater in its constructor)" );
    mistake = "declare";
    EXPECT_EQ( refused( input ), "table.dat is not there (heater in declare)" );
    mistake = "throw";
    EXPECT_NE( refused( input ).find( "'fuel' not found (heater in fault)" ),
               std::string::npos );
    mistake = "fault";
    EXPECT_EQ( refused( input ), "test: /physics/1: is too hot; cool it" );
}

TEST_F( ModulesFromOutside, whatTheyDeclareIsLookedAt )
{
    mistake = "name";
    EXPECT_EQ( refused( heated() ),
               "the type is called \"heater\" and declares \"heather\": give "
               "both one name (heater in declare)" );
    for ( const auto* key : { "type", "region" } )
    {
        mistake = key;
        EXPECT_NE( refused( heated() ).find( "the key \"" + mistake + "\" is" ),
                   std::string::npos )
            << key;
    }
}

// An input that says nothing of a key is not to blame for its default.
TEST_F( ModulesFromOutside, wrongDefaultsAreTheTypesOwn )
{
    const std::map<std::string, std::string> told = {
        { "number", "/glow: expected a number, got \"text\"" },
        { "range", "/glow: must be >= 0, got -1" },
        { "choice", "/of: expected one of \"gas\", \"coal\", got \"caol\"; did "
                    "you mean \"coal\"?" },
        { "vector", "/at: expected a list of 1 number, got 0" } };
    EXPECT_EQ( refused( heated() ), "" );
    for ( const auto& [what, text] : told )
    {
        mistake = what;
        EXPECT_EQ( refused( heated() ),
                   "a default is wrong: " + text + " (heater in declare)" );
    }
}

TEST_F( ModulesFromOutside, aClaimOfNoSideIsAnError )
{
    auto input = heated();
    input["boundary"][0] = { { "type", "hot_wall" }, { "side", "x_lower" } };
    EXPECT_EQ( refused( input ), "" );
    mistake = "side";
    EXPECT_EQ( refused( input ),
               "hot_wall claims side 2; in 1D they are 0 to 1, 2 * axis + "
               "(upper ? 1 : 0)" );
    mistake = "lower side";
    EXPECT_NE( refused( input ).find( "hot_wall claims side -1" ),
               std::string::npos );
}

// A study of effects leaves out an effect, and what a key of it, or of
// boundaries, switches; all by the names of the end table.
TEST_F( ModulesFromOutside, keysOfEntriesSwitchEffects )
{
    auto input = heated();
    for ( const auto* end : { "lower", "upper" } )
        input["boundary"][*end == 'l' ? 0 : 1] = {
            { "type", "hot_wall" },
            { "side", std::string( "x_" ) + end },
            { "glow", 2 } };
    const auto resolved = resolveInput( input, "test" );
    std::map<std::string, Json> off;
    for ( const auto& effect : optionalEffects( resolved ) )
        off[effect.name] = effect.off;
    ASSERT_EQ( off.count( "heater heat" ), 1u );
    EXPECT_EQ( off["heater heat"]["physics"].size(), 1u );
    EXPECT_EQ( off["glow of heat"].dump(), R"({"physics.1.glow":0})" );
    EXPECT_EQ( off["glow of walls"].dump(),
               R"({"boundary.0.glow":0,"boundary.1.glow":0})" );

    const auto all = withoutAll( resolved );
    for ( const auto& item : all.items() )
        applyOverride( input, item.key() + "=" + item.value().dump() );
    EXPECT_TRUE( optionalEffects( resolveInput( input, "test" ) ).empty() );
}

// A study takes columns of an effect's series for an error.
TEST_F( ModulesFromOutside, seriesOfEffectsAreErrorsOfStudies )
{
    const auto folder = std::filesystem::temp_directory_path() /
                        ( "machpoint_modules_" + std::to_string( getpid() ) );
    makeDirectory( folder );
    std::ofstream( folder / "scene.json" ) << heated().dump();
    std::ofstream( folder / "study.json" )
        << R"({ "study": "heat", "input": "scene.json", "kind": "effects",
                "error": "heat.given" })";
    Study study;
    EXPECT_EQ( messageOf( [&] { study = loadStudy( folder / "study.json" ); } ),
               "" );
    EXPECT_EQ( study.error, "heat.given" );
    std::filesystem::remove_all( folder );
}

// A type that derives from a wall does not say that it leaves the gas alone.
TEST_F( ModulesFromOutside, nothingIsCalledUndisturbedThatMightNotBe )
{
    auto input = box( 1, 20, 3, "conservative", "quadratic", "slip_wall" );
    addViscosity( input );
    auto warnings = findWarnings( resolveInput( input, "test" ) );
    ASSERT_EQ( warnings.size(), 1u );
    EXPECT_NE( warnings[0].find( "nothing disturbs it" ), std::string::npos );
    input["boundary"][0]["type"] = "hot_wall";
    EXPECT_TRUE( findWarnings( resolveInput( input, "test" ) ).empty() );
}

//! Has a hook's name in its mouth, but not the hook.
template <int Dim>
class Mumbler : public Module<Dim>
{
  public:
    explicit Mumbler( double ) {}
    bool particleSource( const State<Dim>& ) { return true; }
    void inject( State<Dim>&, int ) {}
    void gridWork( State<Dim>& ) noexcept override {}
};

// What a compiler is to refuse, in terms of what it asks.
TEST_F( ModulesFromOutside, hooksHaveTheirParameters )
{
    using Base = Module<2>;
    using Mute = Mumbler<2>;
    constexpr bool with_other_state =
        is_hook<Mute, decltype( &Mute::particleSource ),
                decltype( &Base::particleSource )>;
    constexpr bool with_a_number =
        is_hook<Mute, decltype( &Mute::inject ), decltype( &Base::inject )>;
    constexpr bool overridden =
        is_hook<Mute, decltype( &Mute::gridWork ), decltype( &Base::gridWork )>;
    constexpr bool inherited =
        is_hook<Mute, decltype( &Mute::layOut ), decltype( &Base::layOut )>;
    EXPECT_FALSE( with_other_state );
    EXPECT_FALSE( with_a_number );
    EXPECT_TRUE( overridden );
    EXPECT_TRUE( inherited );
    // Json would become a number.
    constexpr bool from_a_number = std::is_constructible_v<Mute, const Json&>;
    EXPECT_TRUE( from_a_number );
    EXPECT_FALSE( is_made_from_json<Mute> );
    EXPECT_TRUE( is_made_from_json<Heater<2>> );
}

// What a method needs is known without the dimension.
TEST_F( ModulesFromOutside, anInputWithoutDimensionIsToldSo )
{
    for ( const auto& method : methods )
    {
        auto input = heated();
        input["method"] = { { "name", method } };
        input.erase( "dimension" );
        const auto message = refused( input );
        EXPECT_TRUE( message.starts_with( "test: /dimension: missing" ) )
            << message;
        EXPECT_EQ( message.find( '\n' ), std::string::npos ) << message;
    }
}

} // namespace
