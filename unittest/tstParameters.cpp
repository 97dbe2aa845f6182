/*!
  \file tstParameters.cpp
  \brief Tests of the strict parameter layer.
*/
#include <core/parameters.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace Machpoint
{
namespace
{

using Messages = std::vector<std::string>;

//---------------------------------------------------------------------------//
// A small input with every kind of key.

Family shapes()
{
    const auto members = []( int dimension )
    {
        Parameters sphere( "sphere", "a ball", dimension );
        sphere.vector( "center", "its center" );
        sphere.number( "radius", "its radius" ).above( 0 );

        Parameters polygon( "polygon", "a closed line", dimension );
        polygon.points( "vertices", "its corners" ).nonEmpty();

        Parameters all( "union", "several shapes", dimension );
        all.listOf( "shapes", shapes(), "what is united" ).nonEmpty();

        std::vector<Parameters> result = { sphere, all };
        // Only the plane has polygons.
        if ( dimension == 2 || dimension == 0 )
            result.push_back( polygon );
        return result;
    };
    return { "shape", members };
}

Parameters scene( int dimension )
{
    Parameters grid( "grid", "cells of equal size", dimension );
    grid.vector( "lower", "lower corner" );
    grid.integerVector( "cells", "number of cells along each axis" )
        .atLeast( 1 );

    Parameters output( "output", "what is written", dimension );
    output.number( "every", "time between outputs" ).above( 0 ).optional();
    output.boolean( "pictures", "whether to draw" ).defaultsTo( true );

    Parameters result( "scene", "a test", dimension );
    result.text( "scene", "its name" ).nonEmpty();
    result.object( "grid", grid, "the grid" );
    result
        .choice( "basis", { "linear", "quadratic", "cubic" },
                 "degree of the splines" )
        .defaultsTo( "quadratic" );
    result.integer( "seed", "of the random numbers" ).defaultsTo( 1 );
    result.number( "cfl", "Courant number" )
        .unit( "cell widths" )
        .source( "eq. 3" )
        .above( 0 )
        .atMost( 1 )
        .defaultsTo( 0.4 );
    result.oneOf( "body", shapes(), "an obstacle" ).optional();
    result.listOf( "bodies", shapes(), "more obstacles" )
        .defaultsTo( Json::array() );
    result.object( "output", output, "what is written" );
    return result;
}

const char* const sample = R"({
  "scene": "größe",
  "grid": { "lower": [0, -1.5e0], "cells": [4, 8] },
  "cfl": 0.25,
  "seed": -7,
  "basis": "cubic",
  "body": { "type": "union", "shapes": [
    { "type": "sphere", "center": [0.5, 0.5], "radius": 0.25 },
    { "type": "polygon", "vertices": [[0, 0], [1, 0], [0, 1]] } ] },
  "output": { "every": 0.02, "pictures": false }
})";

//---------------------------------------------------------------------------//
// Helpers.

Messages parseErrors( const std::string& text )
{
    try
    {
        parseJson( text, "f" );
    }
    catch ( const InputError& error )
    {
        return error.messages();
    }
    return {};
}

Messages errorsOf( const Json& input, const Parameters& parameters )
{
    Messages errors;
    resolve( input, parameters, "f", errors );
    return errors;
}

//! Errors of the sample with one override.
Messages errorsWith( const std::string& assignment )
{
    auto input = parseJson( sample, "f" );
    applyOverride( input, assignment );
    return errorsOf( input, scene( 2 ) );
}

std::string overrideError( const std::string& document,
                           const std::string& assignment )
{
    auto input = parseJson( document, "f" );
    const auto before = input;
    try
    {
        applyOverride( input, assignment );
    }
    catch ( const InputError& error )
    {
        EXPECT_EQ( input, before ) << "a refused override changed the input";
        return error.what();
    }
    return "";
}

bool contains( const std::string& text, const std::string& part )
{
    return text.find( part ) != std::string::npos;
}

void expectOneError( const Messages& errors, const std::string& part )
{
    ASSERT_EQ( errors.size(), 1U ) << InputError( errors ).what();
    EXPECT_TRUE( contains( errors[0], part ) ) << errors[0];
}

//---------------------------------------------------------------------------//
// Parsing.

TEST( Parameters, ParsingKeepsOrderAndValues )
{
    const auto json = parseJson(
        R"( {"b": [1, -2, 3.5, true, null, "x"], "a": {}, "c": []} )", "f" );
    EXPECT_EQ( json.dump(), R"({"b":[1,-2,3.5,true,null,"x"],"a":{},"c":[]})" );
    EXPECT_TRUE( json["b"][0].is_number_integer() );
    EXPECT_TRUE( json["b"][2].is_number_float() );
    EXPECT_EQ( parseJson( "3", "f" ), Json( 3 ) );
}

TEST( Parameters, DuplicateKeysAreErrorsAtAnyDepth )
{
    EXPECT_EQ( parseErrors( R"({"physics": [{"gamma": 1, "gamma": 2}]})" ),
               Messages( { "f: /physics/0/gamma: given twice" } ) );
    EXPECT_EQ( parseErrors( R"({"a": [0, [{"b/~": {"c": 1, "c": 1}}]],
                                "d": 1, "a": 2, "d": 3, "d": 4})" ),
               Messages( { "f: /a/1/0/b~1~0/c: given twice",
                           "f: /a: given twice", "f: /d: given twice" } ) );
    // Equal keys in different objects are fine.
    EXPECT_EQ( parseErrors( R"([{"a": 1}, {"a": {"a": 1}}])" ), Messages() );
}

TEST( Parameters, TheFirstOfDuplicateKeysCounts )
{
    Messages errors;
    const auto json = parseJson(
        R"({"a": [{"b": 1, "b": [2]}], "c": 3, "a": 4})", "f", errors );
    EXPECT_EQ( json.dump(), R"({"a":[{"b":1}],"c":3})" );
    EXPECT_EQ( errors,
               Messages( { "f: /a/0/b: given twice", "f: /a: given twice" } ) );
    // What is no JSON cannot be gone on with.
    EXPECT_THROW( parseJson( R"({"a": 1, "a": 2)", "f", errors ), InputError );
}

TEST( Parameters, SyntaxErrorsNameLineAndColumn )
{
    expectOneError( parseErrors( "{\n  \"a\": 1,\n  \"b\": }\n" ), "f:3:8: " );
    // A column counts characters: ö has two bytes.
    expectOneError( parseErrors( "[\"ö\", x]" ), "f:1:7: " );
    expectOneError( parseErrors( R"({"a": [1, 2)" ), "f:1:12: " );
    expectOneError( parseErrors( R"({"a": [1, 2)" ), "unexpected end of" );
    expectOneError( parseErrors( "[1] [2]" ), "f:1:5: " );
    expectOneError( parseErrors( "[1, 2,]" ), "f:1:7: " );
    expectOneError( parseErrors( "[1 // one\n]" ), "f:1:4: " );
    expectOneError( parseErrors( "{'a': 1}" ), "f:1:2: " );
    expectOneError( parseErrors( "[01]" ), "f:1:3: " );
}

TEST( Parameters, WhatIsNotJsonIsAnError )
{
    for ( const std::string word :
          { "NaN", "nan", "Infinity", "-Infinity", "inf", "True", "+1", ".5",
            "1.", "0x10", "1e999", "-1e999", "\"\\x\"", "\"\t\"" } )
    {
        const auto errors = parseErrors( "[" + word + "]" );
        ASSERT_EQ( errors.size(), 1U ) << word;
        EXPECT_TRUE( contains( errors[0], "f:1:" ) ) << errors[0];
    }
    expectOneError( parseErrors( "[1e999]" ), "1e999" );
}

TEST( Parameters, JunkIsAnErrorFitForATerminal )
{
    expectOneError( parseErrors( "" ), "f: empty" );
    expectOneError( parseErrors( " \n\t\r\n " ), "f: empty" );
    // The library would stop at the zero byte and be content.
    expectOneError( parseErrors( std::string( "{}\n\0}", 5 ) ),
                    "f:2:1: a zero byte" );
    expectOneError( parseErrors( "\x89HDF\r\n\x1a\n" ), "f:1:1: " );
    for ( const std::string bytes :
          { "[\"\xff\"]", "[\"\xc3\"]", "[\"\xed\xa0\x80\"]", "[\"\\ud800\"]",
            "[\"\x1b[31m\"]", "\xfe\xff", "[\"a\nb\"]" } )
    {
        const auto errors = parseErrors( bytes );
        ASSERT_EQ( errors.size(), 1U ) << bytes;
        // Writing throws for what is not UTF-8.
        EXPECT_NO_THROW( Json( errors[0] ).dump() );
        for ( const unsigned char c : errors[0] )
            EXPECT_GE( c, 0x20 ) << errors[0];
    }
    const auto lengthy = parseErrors( "[\"" + std::string( 100000, 'x' ) );
    ASSERT_EQ( lengthy.size(), 1U );
    EXPECT_LT( lengthy[0].size(), 200U );
}

TEST( Parameters, DepthIsLimited )
{
    const auto nested = []( std::size_t depth )
    { return std::string( depth, '[' ) + std::string( depth, ']' ); };
    EXPECT_EQ( parseErrors( nested( 64 ) ), Messages() );
    expectOneError( parseErrors( nested( 65 ) ), "deeper than 64 levels" );
    expectOneError( parseErrors( std::string( 1000000, '[' ) ),
                    "deeper than 64 levels" );
    std::string objects;
    for ( int i = 0; i < 100000; ++i )
        objects += R"({"a":)";
    expectOneError( parseErrors( objects ), "f: /a/a/a" );
}

TEST( Parameters, InputErrorJoinsItsMessages )
{
    const InputError error( { "one", "two" } );
    EXPECT_STREQ( error.what(), "one\ntwo" );
    EXPECT_EQ( error.messages(), Messages( { "one", "two" } ) );
}

//---------------------------------------------------------------------------//
// Defaults.

TEST( Parameters, DefaultsAreFilledInDeclaredOrder )
{
    const auto input = parseJson(
        R"({"cfl": 1, "grid": {"cells": [3], "lower": [0]}, "scene": "s"})",
        "f" );
    Messages errors;
    const auto resolved = resolve( input, scene( 1 ), "f", errors );
    EXPECT_EQ( errors, Messages() );
    // "output" may be absent because each of its keys may; "every" and "body"
    // are optional and stay absent; the whole number stays as it was written.
    EXPECT_EQ( resolved.dump(),
               R"({"scene":"s","grid":{"lower":[0],"cells":[3]},)"
               R"("basis":"quadratic","seed":1,"cfl":1,"bodies":[],)"
               R"("output":{"pictures":true}})" );
}

TEST( Parameters, ResolvingTwiceChangesNothing )
{
    Messages errors;
    const auto once =
        resolve( parseJson( sample, "f" ), scene( 2 ), "f", errors );
    const auto twice = resolve( once, scene( 2 ), "f", errors );
    EXPECT_EQ( errors, Messages() );
    EXPECT_EQ( once.dump(), twice.dump() );
}

TEST( Parameters, DefaultsAreResolvedThemselves )
{
    Family colours = {
        "colour", []( int dimension )
        {
            Parameters grey( "grey", "no hue", dimension );
            grey.number( "light", "0 is black" ).defaultsTo( 0.5 );
            return std::vector<Parameters>{ grey };
        } };
    Parameters picture( "picture", "", 2 );
    picture.oneOf( "colour", colours, "of the line" )
        .defaultsTo( { { "type", "grey" } } );
    Messages errors;
    const auto resolved = resolve( Json::object(), picture, "f", errors );
    EXPECT_EQ( errors, Messages() );
    EXPECT_EQ( resolved.dump(), R"({"colour":{"type":"grey","light":0.5}})" );
}

TEST( Parameters, ObjectThatNeedsAKeyIsMissing )
{
    expectOneError( errorsOf( { { "scene", "s" } }, scene( 1 ) ),
                    "f: /grid: missing; an object (the grid)" );
}

//---------------------------------------------------------------------------//
// Keys.

TEST( Parameters, UnknownKeysAreErrorsWithSuggestion )
{
    EXPECT_EQ( errorsWith( "grid.lowr=[0, 0]" ),
               Messages( { "f: /grid/lowr: unknown key; did you mean "
                           "\"lower\"?" } ) );
    EXPECT_EQ( errorsWith( "grid.temperature=1" ),
               Messages( { "f: /grid/temperature: unknown key; expected "
                           "\"lower\", \"cells\"" } ) );
    EXPECT_EQ( errorsWith( "body.shapes.0.raduis=1" ),
               Messages( { "f: /body/shapes/0/raduis: unknown key; did you "
                           "mean \"radius\"?" } ) );
    EXPECT_EQ( errorsOf( { { "a", 1 } }, Parameters( "empty", "", 1 ) ),
               Messages( { "f: /a: unknown key; none is expected here" } ) );
    // "type" is a key only where it chooses from a family.
    EXPECT_EQ( errorsWith( "type=scene" ).size(), 1U );
}

TEST( Parameters, UnknownKeysAreFitForATerminal )
{
    const Json input = { { "a/b~c\n\x1b", 1 } };
    EXPECT_EQ( errorsOf( input, Parameters( "empty", "", 1 ) ),
               Messages( { "f: /a~1b~0c??: unknown key; none is expected "
                           "here" } ) );
}

TEST( Parameters, MissingKeysAreErrorsThatSayWhatTheyAre )
{
    const Json grid = { { "lower", { 0, 0 } } };
    EXPECT_EQ( errorsOf( { { "scene", "s" }, { "grid", grid } }, scene( 2 ) ),
               Messages( { "f: /grid/cells: missing; a list of 2 whole numbers "
                           "(number of cells along each axis)" } ) );
}

TEST( Parameters, MisspeltKeyIsNotReportedAsMissingToo )
{
    const Json grid = { { "lower", { 0 } }, { "cels", { 1 } } };
    EXPECT_EQ( errorsOf( { { "scene", "s" }, { "grid", grid } }, scene( 1 ) ),
               Messages( { "f: /grid/cels: unknown key; did you mean "
                           "\"cells\"?" } ) );
}

TEST( Parameters, AllErrorsAreReportedTogether )
{
    const auto input = parseJson(
        R"({"scene": "", "grid": {"lower": [0, 0]}, "cfl": 2, "sed": 1,
            "body": {"type": "sphere", "center": [0, "x"], "radius": 0}})",
        "f" );
    EXPECT_EQ( errorsOf( input, scene( 2 ) ),
               Messages( { "f: /sed: unknown key; did you mean \"seed\"?",
                           "f: /scene: must not be empty",
                           "f: /grid/cells: missing; a list of 2 whole numbers "
                           "(number of cells along each axis)",
                           "f: /cfl: must be > 0 and <= 1, got 2",
                           "f: /body/center/1: expected a number, got \"x\"",
                           "f: /body/radius: must be > 0, got 0" } ) );
}

//---------------------------------------------------------------------------//
// Values.

TEST( Parameters, WrongTypesSayWhatWasExpectedAndFound )
{
    const std::vector<std::pair<std::string, std::string>> cases = {
        { "cfl=fast", "f: /cfl: expected a number, got \"fast\"" },
        { "cfl=null", "f: /cfl: expected a number, got null" },
        { "cfl=true", "f: /cfl: expected a number, got true" },
        { "cfl=[0.1]", "f: /cfl: expected a number, got a list of 1 entry" },
        { "seed={}", "f: /seed: expected a whole number, got an object" },
        { "scene=3", "f: /scene: expected a text, got 3" },
        { "output.pictures=1",
          "f: /output/pictures: expected true or false, got 1" },
        { "output.pictures=yes",
          "f: /output/pictures: expected true or false, got \"yes\"" },
        { "grid=[]", "f: /grid: expected an object, got a list of 0 entries" },
        { "grid.lower=0",
          "f: /grid/lower: expected a list of 2 numbers, got 0" },
        { "grid.lower=[0]",
          "f: /grid/lower: expected a list of 2 numbers, got a list of 1 "
          "entry" },
        { "grid.lower={\"x\": 0, \"y\": 0}",
          "f: /grid/lower: expected a list of 2 numbers, got an object" },
        { "grid.cells=[1,2,3]",
          "f: /grid/cells: expected a list of 2 whole numbers, got a list of "
          "3 entries" },
        { "grid.cells=[1,[2]]",
          "f: /grid/cells/1: expected a whole number, got a list of 1 entry" },
        { "bodies={}", "f: /bodies: expected a list of objects with a "
                       "\"type\", got an object" },
        { "bodies=[3]",
          "f: /bodies/0: expected an object with a \"type\", got 3" },
        { "body=sphere",
          "f: /body: expected an object with a \"type\", got \"sphere\"" },
        { "body.shapes[1].vertices=[0,0]",
          "f: /body/shapes/1/vertices/0: expected a list of 2 numbers, got 0" },
        { "body.shapes[1].vertices=3",
          "f: /body/shapes/1/vertices: expected a list of points, each a list "
          "of 2 numbers, got 3" } };
    for ( const auto& [assignment, message] : cases )
    {
        const auto errors = errorsWith( assignment );
        ASSERT_FALSE( errors.empty() ) << assignment;
        EXPECT_EQ( errors[0], message );
    }
    EXPECT_EQ( errorsOf( Json::array(), scene( 1 ) ),
               Messages( { "f: /: expected an object, got a list of 0 "
                           "entries" } ) );
}

TEST( Parameters, WholeNumbersMustBeWrittenAsSuch )
{
    EXPECT_EQ( errorsWith( "seed=3.7" ),
               Messages( { "f: /seed: expected a whole number, got 3.7" } ) );
    EXPECT_EQ( errorsWith( "seed=3.0" ),
               Messages( { "f: /seed: expected a whole number without point "
                           "or exponent, got 3.0" } ) );
    expectOneError( errorsWith( "grid.cells=[4, 1e2]" ),
                    "f: /grid/cells/1: expected a whole number without" );
}

TEST( Parameters, WholeNumbersMustFitIn64Bits )
{
    EXPECT_EQ( errorsWith( "seed=9223372036854775807" ), Messages() );
    EXPECT_EQ( errorsWith( "seed=-9223372036854775808" ), Messages() );
    for ( const std::string number :
          { "9223372036854775808", "18446744073709551615",
            "18446744073709551616", "-9223372036854775809", "1e300",
            "123456789012345678901234567890" } )
        expectOneError( errorsWith( "seed=" + number ),
                        "must be a whole number from -9223372036854775808 to "
                        "9223372036854775807, got " );
}

TEST( Parameters, NumbersMustBeFinite )
{
    Parameters parameters( "p", "", 1 );
    parameters.number( "x", "" );
    for ( const double x : { std::nan( "" ), HUGE_VAL, -HUGE_VAL } )
        EXPECT_EQ( errorsOf( { { "x", x } }, parameters ),
                   Messages( { "f: /x: must be finite" } ) );
}

TEST( Parameters, RangesAreChecked )
{
    Parameters parameters( "p", "", 1 );
    parameters.number( "above", "" ).above( 1 ).optional();
    parameters.number( "at_least", "" ).atLeast( 1 ).optional();
    parameters.number( "below", "" ).below( 1 ).optional();
    parameters.number( "at_most", "" ).atMost( 1 ).optional();
    parameters.integer( "both", "" ).above( -2 ).atMost( 2 ).optional();

    const std::vector<std::pair<Json, std::string>> cases = {
        { { { "above", 1.0 } }, "f: /above: must be > 1, got 1.0" },
        { { { "above", 0.9 } }, "f: /above: must be > 1, got 0.9" },
        { { { "above", 1.1 } }, "" },
        { { { "at_least", 0.9 } }, "f: /at_least: must be >= 1, got 0.9" },
        { { { "at_least", 1 } }, "" },
        { { { "below", 1 } }, "f: /below: must be < 1, got 1" },
        { { { "below", 0.9 } }, "" },
        { { { "at_most", 1.1 } }, "f: /at_most: must be <= 1, got 1.1" },
        { { { "at_most", 1 } }, "" },
        { { { "both", -2 } }, "f: /both: must be > -2 and <= 2, got -2" },
        { { { "both", 3 } }, "f: /both: must be > -2 and <= 2, got 3" },
        { { { "both", 2 } }, "" } };
    for ( const auto& [input, message] : cases )
        EXPECT_EQ( errorsOf( input, parameters ),
                   message.empty() ? Messages() : Messages( { message } ) )
            << input;
}

TEST( Parameters, RangesHoldForEachEntry )
{
    EXPECT_EQ( errorsWith( "grid.cells=[0, -1]" ),
               Messages( { "f: /grid/cells/0: must be >= 1, got 0",
                           "f: /grid/cells/1: must be >= 1, got -1" } ) );
    Parameters parameters( "p", "", 2 );
    parameters.points( "points", "" ).atLeast( 0 );
    EXPECT_EQ(
        errorsOf( { { "points", { { 0, 1 }, { 2, -3 } } } }, parameters ),
        Messages( { "f: /points/1/1: must be >= 0, got -3" } ) );
}

TEST( Parameters, EmptyListsAreErrorsWhereDeclared )
{
    EXPECT_EQ(
        errorsWith( "body.shapes=[]" ),
        Messages( { "f: /body/shapes: must have at least one entry" } ) );
    EXPECT_EQ( errorsWith( "body.shapes[1].vertices=[]" ),
               Messages( { "f: /body/shapes/1/vertices: must have at least one "
                           "entry" } ) );
    EXPECT_EQ( errorsWith( "bodies=[]" ), Messages() );
}

TEST( Parameters, ChoicesListWhatIsAllowed )
{
    EXPECT_EQ( errorsWith( "basis=quadratc" ),
               Messages( { "f: /basis: expected one of \"linear\", "
                           "\"quadratic\", \"cubic\", got \"quadratc\"; did "
                           "you mean \"quadratic\"?" } ) );
    EXPECT_EQ( errorsWith( "basis=septic" ),
               Messages( { "f: /basis: expected one of \"linear\", "
                           "\"quadratic\", \"cubic\", got \"septic\"" } ) );
    EXPECT_EQ( errorsWith( "basis=2" ),
               Messages( { "f: /basis: expected one of \"linear\", "
                           "\"quadratic\", \"cubic\", got 2" } ) );
}

TEST( Parameters, VectorsOfAnyDimensionHaveOneToThreeEntries )
{
    Parameters parameters( "p", "", 0 );
    parameters.vector( "x", "" );
    EXPECT_EQ( errorsOf( { { "x", { 1, 2, 3 } } }, parameters ), Messages() );
    for ( const Json& x : { Json::array(), Json( { 1, 2, 3, 4 } ) } )
        expectOneError( errorsOf( { { "x", x } }, parameters ),
                        "f: /x: expected a list of 1 to 3 numbers, got a list "
                        "of " );
}

//---------------------------------------------------------------------------//
// Families.

TEST( Parameters, UnknownTypeListsTheFamilyAndNothingElse )
{
    EXPECT_EQ( errorsWith( R"(body={"type": "shpere", "wrong": [], "x": 1})" ),
               Messages( { "f: /body/type: expected one of \"sphere\", "
                           "\"union\", \"polygon\", got \"shpere\"; did you "
                           "mean \"sphere\"?" } ) );
    EXPECT_EQ( errorsWith( R"(bodies=[{"type": 3, "wrong": []}])" ),
               Messages( { "f: /bodies/0/type: expected one of \"sphere\", "
                           "\"union\", \"polygon\", got 3" } ) );
}

TEST( Parameters, MissingTypeIsAnError )
{
    EXPECT_EQ( errorsWith( R"(body={"center": [0, 0], "radius": -1})" ),
               Messages( { "f: /body/type: missing; one of \"sphere\", "
                           "\"union\", \"polygon\"" } ) );
    EXPECT_EQ( errorsWith( R"(bodies=[{"tpye": "sphere", "radius": -1}])" ),
               Messages( { "f: /bodies/0/tpye: unknown key; did you mean "
                           "\"type\"?" } ) );
}

TEST( Parameters, TypeOfAnotherDimensionIsNotAvailable )
{
    const Json input = {
        { "scene", "s" },
        { "grid", { { "lower", { 0, 0, 0 } }, { "cells", { 1, 1, 1 } } } },
        { "body", { { "type", "polygon" } } } };
    EXPECT_EQ( errorsOf( input, scene( 3 ) ),
               Messages( { "f: /body/type: polygon is not available in 3 "
                           "dimensions; expected one of \"sphere\", "
                           "\"union\"" } ) );
    Parameters line( "line", "", 1 );
    line.oneOf( "body", shapes(), "" );
    expectOneError( errorsOf( { { "body", { { "type", "polygon" } } } }, line ),
                    "polygon is not available in 1 dimension;" );
}

TEST( Parameters, FamiliesMayContainThemselves )
{
    const std::string good =
        R"({"type": "sphere", "center": [0, 0], "radius": 1})";
    auto nested = good;
    for ( int level = 0; level < 20; ++level )
        nested = R"({"type": "union", "shapes": [)" + nested + "]}";
    EXPECT_EQ( errorsWith( "body=" + nested ), Messages() );

    const std::string bad =
        R"({"type": "union", "shapes": [)" + good +
        R"(, {"type": "union", "shapes": [{"type": "cube"}]}]})";
    expectOneError( errorsWith( "body=" + bad ),
                    "f: /body/shapes/1/shapes/0/type: expected one of" );
}

//---------------------------------------------------------------------------//
// Declaring.

TEST( Parameters, DeclaringAKeyTwiceIsALogicError )
{
    Parameters parameters( "p", "", 1 );
    auto& first = parameters.number( "x", "" );
    EXPECT_THROW( parameters.text( "x", "" ), std::logic_error );
    EXPECT_THROW( Parameters( "p", "", 4 ), std::logic_error );
    // References outlive later declarations.
    for ( int i = 0; i < 1000; ++i )
        parameters.number( std::to_string( i ), "" );
    EXPECT_EQ( &first, &parameters.keys().front() );
}

//---------------------------------------------------------------------------//
// Overrides.

TEST( Parameters, OverridesReachEveryPlace )
{
    auto input = parseJson( sample, "f" );
    applyOverride( input, "basis=linear" );
    applyOverride( input, "grid.cells=[400, 200]" );
    applyOverride( input, "grid.lower.1=2" );
    applyOverride( input, "grid.lower[0]=-1e-3" );
    applyOverride( input, "body.shapes[0].radius=0.5" );
    applyOverride( input, "body.shapes.1.vertices[2][0]=7" );
    applyOverride( input, "output.pictures=true" );
    applyOverride( input, "new={\"a\": null}" );
    applyOverride( input, "new.b=c=d e" );
    EXPECT_EQ( input["basis"], "linear" );
    EXPECT_EQ( input["grid"]["cells"], Json( { 400, 200 } ) );
    EXPECT_EQ( input["grid"]["lower"], Json( { -1e-3, 2 } ) );
    EXPECT_EQ( input["body"]["shapes"][0]["radius"], 0.5 );
    EXPECT_EQ( input["body"]["shapes"][1]["vertices"][2], Json( { 7, 1 } ) );
    EXPECT_EQ( input["output"]["pictures"], true );
    EXPECT_EQ( input["new"].dump(), R"({"a":null,"b":"c=d e"})" );
}

TEST( Parameters, OverrideValueIsJsonOrABareWord )
{
    const std::vector<std::pair<std::string, std::string>> cases = {
        { "1", "1" },           { "\"1\"", "\"1\"" },
        { "true", "true" },     { "1.50", "1.5" },
        { "null", "null" },     { "cubic", "\"cubic\"" },
        { "0012", "\"0012\"" }, { "out/x", "\"out/x\"" },
        { "NaN", "\"NaN\"" } };
    for ( const auto& [text, expected] : cases )
    {
        Json input = Json::object();
        applyOverride( input, "x=" + text );
        EXPECT_EQ( input["x"].dump(), expected );
    }
    for ( const std::string text :
          { "", "[1", "{\"a\": 1, \"a\": 2}", "\"open", "[1] 2" } )
        EXPECT_NE( overrideError( "{}", "x=" + text ), "" ) << text;
    EXPECT_TRUE( contains( overrideError( "{}", "x=[1" ),
                           "--set x=[1: value:1:3: unexpected end" ) );
    EXPECT_TRUE( contains( overrideError( "{}", "x=" ), "value: empty" ) );
    EXPECT_TRUE( contains( overrideError( "{}", "x={\"a\": 1, \"a\": 2}" ),
                           "/a: given twice" ) );
    EXPECT_TRUE( contains(
        overrideError( "{}", "x=" + std::string( 100, 'a' ) + "\xff" ),
        "not UTF-8" ) );
}

TEST( Parameters, WrongOverridesNameTheRemedy )
{
    const std::string document =
        R"({"scene": "s", "grid": {"cells": [4, 8]}, "physics": []})";
    const std::vector<std::pair<std::string, std::string>> cases = {
        { "scene", "expected path=value, as in method.basis=cubic" },
        { "=3", "expected path=value" },
        { "a..b=3", "expected path=value" },
        { ".a=3", "expected path=value" },
        { "a.=3", "expected path=value" },
        { "a[=3", "expected path=value" },
        { "a[x]=3", "expected path=value" },
        { "a[0]b=3", "expected path=value" },
        { "a]=3", "expected path=value" },
        { "gird.cells=3",
          "the input has no gird; did you mean \"grid\"?; to add it, give it "
          "as a whole, --set 'gird={...}'" },
        { "grid.x.y=3",
          "the input has no grid.x; to add it, give it as a whole, --set "
          "'grid.x={...}'" },
        { "bodies[0]=3", "--set 'bodies=[...]'" },
        { "scene.name=s",
          "scene is \"s\", no object, and has nothing inside; to replace it, "
          "--set scene=VALUE" },
        { "scene.0=s", "scene is \"s\", no list, and has nothing inside" },
        { "grid.cells.2=3",
          "grid.cells is a list of 2 entries, counted from 0; choose one of "
          "them or give the whole list, --set 'grid.cells=[...]'" },
        { "grid.cells.x=3", "grid.cells is a list of 2 entries" },
        { "grid.cells.-1=3", "grid.cells is a list of 2 entries" },
        { "grid.cells[99999999999999999999]=3", "is a list of 2 entries" },
        { "physics.0=3", "physics is a list of 0 entries" } };
    for ( const auto& [assignment, part] : cases )
    {
        const auto message = overrideError( document, assignment );
        EXPECT_TRUE( contains( message, part ) ) << message;
        EXPECT_TRUE( contains( message, "--set " + assignment ) ) << message;
    }
    EXPECT_TRUE( contains( overrideError( "3", "a=1" ), "the input is 3" ) );
}

TEST( Parameters, OverridesCannotNestWithoutLimit )
{
    Json input = Json::object();
    std::string path = "a";
    const auto deepen = [&]
    {
        for ( int i = 0; i < 1000; ++i, path += ".a" )
            applyOverride( input, path + "={}" );
    };
    EXPECT_THROW( deepen(), InputError );
}

TEST( Parameters, OverridesAreCheckedByResolve )
{
    EXPECT_EQ( errorsWith( "clf=0.3" ),
               Messages( { "f: /clf: unknown key; did you mean \"cfl\"?" } ) );
}

//---------------------------------------------------------------------------//
// Help and schema.

TEST( Parameters, HelpShowsEverythingDeclared )
{
    const auto text = describe( scene( 2 ) );
    for ( const std::string part :
          { "key", "cfl", "cell widths", "0.4", "> 0 and <= 1",
            "Courant number [eq. 3]", "linear, quadratic, cubic", "grid.cells",
            "list of 2 whole numbers", "required", "absent",
            "shape: sphere, union, polygon", "output.pictures",
            "its name (not empty)" } )
        EXPECT_TRUE( contains( text, part ) ) << part << "\n" << text;
    EXPECT_FALSE( contains( text, "a test" ) ); // whoever asks has a title
    EXPECT_FALSE( contains( describe( scene( 3 ) ), "polygon" ) );
    EXPECT_TRUE( contains( describe( Parameters( "none", "nothing", 1 ) ),
                           "no parameters" ) );
}

TEST( Parameters, HelpOfOneKey )
{
    for ( const std::string name : { "cells", "grid.cells" } )
    {
        const auto text = describe( scene( 2 ), name );
        EXPECT_TRUE( contains( text, "grid.cells" ) ) << text;
        EXPECT_TRUE( contains( text, "default" ) ) << text;
        EXPECT_FALSE( contains( text, "lower" ) ) << text;
    }
    EXPECT_EQ( describe( scene( 2 ), "ells" ), "" );
    EXPECT_EQ( describe( Parameters( "none", "nothing", 1 ), "cells" ), "" );
}

TEST( Parameters, DefaultsInWords )
{
    Parameters parameters( "test", "a test", 1 );
    parameters.number( "a", "one" ).optional( "2 in 1D, else 3" );
    EXPECT_TRUE( contains( describe( parameters ), "  2 in 1D, else 3\n" ) );
    EXPECT_EQ( jsonSchema( parameters )["properties"]["a"]["description"],
               "one; default: 2 in 1D, else 3" );
    EXPECT_EQ( errorsOf( Json::object(), parameters ), Messages() );
}

TEST( Parameters, SchemaMirrorsTheDeclaration )
{
    const auto schema = jsonSchema( scene( 2 ) );
    EXPECT_EQ( schema["$schema"], "http://json-schema.org/draft-07/schema#" );
    EXPECT_EQ( schema["title"], "scene" );
    EXPECT_EQ( schema["type"], "object" );
    EXPECT_EQ( schema["additionalProperties"], false );
    // "output" may be absent because all of its keys may.
    EXPECT_EQ( schema["required"], Json( { "scene", "grid" } ) );

    const auto& properties = schema["properties"];
    EXPECT_EQ( properties["scene"]["minLength"], 1 );
    EXPECT_EQ( properties["seed"]["type"], "integer" );
    EXPECT_EQ( properties["seed"]["default"], 1 );
    EXPECT_EQ( properties["cfl"]["exclusiveMinimum"], 0 );
    EXPECT_EQ( properties["cfl"]["maximum"], 1 );
    EXPECT_EQ( properties["cfl"]["description"],
               "Courant number (cell widths) [eq. 3]" );
    EXPECT_EQ( properties["basis"]["enum"],
               Json( { "linear", "quadratic", "cubic" } ) );
    EXPECT_EQ( properties["body"]["allOf"][0]["$ref"], "#/definitions/shape" );
    EXPECT_EQ( properties["bodies"]["items"]["$ref"], "#/definitions/shape" );

    const auto& cells = properties["grid"]["properties"]["cells"];
    EXPECT_EQ( cells["items"]["type"], "integer" );
    EXPECT_EQ( cells["items"]["minimum"], 1 );
    EXPECT_EQ( cells["minItems"], 2 );
    EXPECT_EQ( cells["maxItems"], 2 );
    EXPECT_EQ( properties["grid"]["additionalProperties"], false );

    ASSERT_EQ( schema["definitions"].size(), 1U );
    const auto& members = schema["definitions"]["shape"]["oneOf"];
    ASSERT_EQ( members.size(), 3U );
    EXPECT_EQ( members[0]["properties"]["type"]["const"], "sphere" );
    EXPECT_EQ( members[0]["required"], Json( { "type", "center", "radius" } ) );
    const auto& united = members[1]["properties"]["shapes"];
    EXPECT_EQ( united["items"]["$ref"], "#/definitions/shape" );
    EXPECT_EQ( united["minItems"], 1 );
    EXPECT_EQ( members[2]["properties"]["vertices"]["items"]["maxItems"], 2 );
}

TEST( Parameters, AnythingIsTakenAsItIs )
{
    Parameters parameters( "p", "anything", 0 );
    parameters.anything( "vary", "a matrix" );
    Messages errors;
    for ( const auto* text : { "{ \"a.b\": [1] }", "[]", "null", "3" } )
    {
        const auto input = Json{ { "vary", Json::parse( text ) } };
        EXPECT_EQ( resolve( input, parameters, "f", errors ), input );
    }
    EXPECT_EQ( errors, Messages() );
    resolve( Json::object(), parameters, "f", errors );
    EXPECT_EQ( errors,
               Messages( { "f: /vary: missing; any JSON (a matrix)" } ) );
    const auto schema = jsonSchema( parameters );
    EXPECT_EQ( schema["properties"]["vary"],
               Json( { { "description", "a matrix" } } ) );
}

TEST( Parameters, SchemaOfAnyDimensionTakesOneToThreeEntries )
{
    const auto schema = jsonSchema( scene( 0 ) );
    const auto& lower = schema["properties"]["grid"]["properties"]["lower"];
    EXPECT_EQ( lower["minItems"], 1 );
    EXPECT_EQ( lower["maxItems"], 3 );
}

//---------------------------------------------------------------------------//
// Suggestions.

TEST( Parameters, NearestToleratesAThirdOfTheCharacters )
{
    const Messages words = { "type", "gamma", "x", "artificial_viscosity" };
    EXPECT_EQ( nearest( "type", words ), "type" );
    EXPECT_EQ( nearest( "tpye", words ), "type" ) << "swapped";
    EXPECT_EQ( nearest( "typ", words ), "type" ) << "deleted";
    EXPECT_EQ( nearest( "types", words ), "type" ) << "inserted";
    EXPECT_EQ( nearest( "tyfe", words ), "type" ) << "replaced";
    EXPECT_EQ( nearest( "TYPE", words ), "type" ) << "case";
    EXPECT_EQ( nearest( "tapa", words ), "" ) << "two edits of four";
    EXPECT_EQ( nearest( "agmam", words ), "gamma" ) << "two swaps of five";
    EXPECT_EQ( nearest( "artifical_viscocity", words ),
               "artificial_viscosity" );
    EXPECT_EQ( nearest( "y", words ), "" ) << "no letter is near another";
    EXPECT_EQ( nearest( "", words ), "" );
    EXPECT_EQ( nearest( "gamma", {} ), "" );
    EXPECT_EQ( nearest( "abcx", { "abcd", "abce" } ), "abcd" ) << "the first";
    EXPECT_EQ( nearest( "abcde", { "abcxy", "abcdx" } ), "abcdx" );
    EXPECT_EQ( nearest( std::string( 1000000, 'g' ), words ), "" );
}

//---------------------------------------------------------------------------//
// Whatever comes.

//! Parses and resolves; any exception other than InputError fails the test.
//! Returns 0 if there was a syntax error, 1 for other errors, 2 for none.
int outcome( const std::string& text )
{
    try
    {
        const auto input = parseJson( text, "f" );
        Messages errors;
        const auto resolved = resolve( input, scene( 2 ), "f", errors );
        if ( !errors.empty() )
        {
            // Messages must be one printable line each.
            for ( const auto& error : errors )
                for ( const unsigned char c : Json( error ).get<std::string>() )
                    EXPECT_GE( c, 0x20 ) << error;
            return 1;
        }
        // What was accepted can be written, read and accepted again.
        EXPECT_EQ( parseJson( resolved.dump(), "f" ), resolved );
        return 2;
    }
    catch ( const InputError& error )
    {
        EXPECT_FALSE( error.messages().empty() );
        return 0;
    }
}

std::vector<std::string> tokensOf( const std::string& text )
{
    std::vector<std::string> tokens;
    const std::string marks = "{}[]:, \n";
    for ( const char c : text )
        if ( tokens.empty() || contains( marks, std::string( 1, c ) ) ||
             contains( marks, tokens.back() ) )
            tokens.emplace_back( 1, c );
        else
            tokens.back() += c;
    return tokens;
}

TEST( Parameters, SurvivesMutatedInputs )
{
    std::mt19937 engine( 2 );
    const auto below = [&engine]( std::size_t bound )
    { return std::size_t( engine() % bound ); };
    const auto tokens = tokensOf( sample );
    const Messages junk = { "null",
                            "1e999",
                            "-0",
                            "[]",
                            "{}",
                            "\"\"",
                            "\"type\"",
                            "3.0",
                            "[[[",
                            "\xff",
                            "18446744073709551616" };

    int count[3] = { 0, 0, 0 };
    for ( int trial = 0; trial < 6000; ++trial )
    {
        std::string text = sample;
        if ( trial % 4 == 0 ) // flip a few bits
            for ( std::size_t i = 0; i <= below( 4 ); ++i )
                text[below( text.size() )] ^= char( 1U << below( 8 ) );
        else if ( trial % 4 == 1 ) // cut off, perhaps in a character
            text.resize( below( text.size() ) );
        else
        {
            auto mutated = tokens;
            if ( trial % 4 == 2 ) // swap tokens
                std::swap( mutated[below( tokens.size() )],
                           mutated[below( tokens.size() )] );
            else // put junk or another token in a token's place
                mutated[below( tokens.size() )] =
                    below( 2 ) ? junk[below( junk.size() )]
                               : tokens[below( tokens.size() )];
            text.clear();
            for ( const auto& token : mutated )
                text += token;
        }
        ++count[outcome( text )];
    }
    // The mutations must have exercised all three ends.
    for ( const int hits : count )
        EXPECT_GT( hits, 100 );
}

//! Any JSON in every place: replaces each value of the sample in turn.
TEST( Parameters, SurvivesAnyJsonInAnyPlace )
{
    const std::vector<Json> values = {
        nullptr,
        true,
        -1,
        0.5,
        1e300,
        "",
        "type",
        Json::array(),
        Json::object(),
        Json( { 1, "x", nullptr } ),
        { { "type", "sphere" } },
        { { "type", { { "type", "type" } } } },
        { { "type", "union" }, { "shapes", { { { "type", "union" } } } } },
        std::numeric_limits<std::uint64_t>::max() };
    EXPECT_EQ( outcome( sample ), 2 );
    const auto input = parseJson( sample, "f" );
    int rejected = 0;
    int trials = 0;
    const auto leaves = input.flatten();
    for ( const auto& item : leaves.items() )
        // Each prefix of the pointer to a leaf is a place.
        for ( auto place = Json::json_pointer( item.key() );; place.pop_back() )
        {
            for ( const auto& value : values )
            {
                auto mutated = input;
                mutated[place] = value;
                ++trials;
                rejected += outcome( mutated.dump() ) == 1;
            }
            if ( place.empty() )
                break;
        }
    // No place takes more than a third of these values.
    EXPECT_GT( rejected, trials * 2 / 3 );
}

TEST( Parameters, SurvivesMutatedOverrides )
{
    std::mt19937 engine( 3 );
    const Messages parts = { "body", "shapes", "grid", "cells",      ".",
                             ".",    "[",      "]",    "0",          "1",
                             "=",    "=",      "{}",   "[]",         "\"",
                             "7",    "\xff",   "new",  "99999999999" };
    const auto input = parseJson( sample, "f" );
    int accepted = 0;
    int refused = 0;
    for ( int trial = 0; trial < 5000; ++trial )
    {
        std::string assignment;
        for ( unsigned i = 0; i < 1 + engine() % 8; ++i )
            assignment += parts[engine() % parts.size()];
        auto mutated = input;
        try
        {
            applyOverride( mutated, assignment );
            outcome( mutated.dump() );
            ++accepted;
        }
        catch ( const InputError& )
        {
            EXPECT_EQ( mutated, input ) << assignment;
            ++refused;
        }
    }
    EXPECT_GT( accepted, 100 );
    EXPECT_GT( refused, 100 );
}

//---------------------------------------------------------------------------//
// Defaults of a declaration.

TEST( Defaults, ofObjectsAreLookedAtToo )
{
    Parameters inner( "inner", "an object", 2 );
    inner.vector( "place", "a place" ).defaultsTo( { 0, 0 } );
    inner.integer( "count", "how many" ).atLeast( 1 ).defaultsTo( 0.5 );
    Parameters outer( "outer", "an object", 2 );
    outer.object( "inner", inner, "an object" );
    outer.number( "gain", "a factor" ).above( 0 ).defaultsTo( 0 );
    outer.boolean( "is_on", "whether" ).defaultsTo( true );
    outer.listOf( "shapes", shapes(), "shapes" ).defaultsTo( Json::array() );
    EXPECT_EQ( wrongDefaults( outer ),
               ( Messages{ "/inner/count: expected a whole number, got 0.5",
                           "/gain: must be > 0, got 0" } ) );
    EXPECT_EQ( wrongDefaults( scene( 0 ) ), Messages{} );
}

} // namespace
} // namespace Machpoint
