/*!
  \file tstStudy.cpp
  \brief The arithmetic of a study: matrix, laws, Pareto front, advice; and of
  a single run's price.
*/
#include <drivers/dry_run.hpp>
#include <drivers/error_estimate.hpp>
#include <drivers/study_error.hpp>
#include <drivers/study_fit.hpp>
#include <drivers/study_probe.hpp>

#include <core/file.hpp>
#include <core/hdf5_file.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <unistd.h>

namespace Machpoint
{
namespace
{

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
// Of exp, log and pow, a few times over.
constexpr double round_off = 1e-12;

TEST( Study, MatrixIsTheProductOfEachBlockLastPathFastest )
{
    const auto rows = expandMatrix( Json::parse( R"([
        { "method.name": ["a", "b"], "grid.cells": [[1], [2]] } ])" ) );
    ASSERT_EQ( rows.size(), 4u );
    EXPECT_EQ( rows[0].dump(), R"({"method.name":"a","grid.cells":[1]})" );
    EXPECT_EQ( rows[1].dump(), R"({"method.name":"a","grid.cells":[2]})" );
    EXPECT_EQ( rows[2].dump(), R"({"method.name":"b","grid.cells":[1]})" );
    EXPECT_EQ( rows[3].dump(), R"({"method.name":"b","grid.cells":[2]})" );
}

TEST( Study, WhatBlocksShareCountsOnce )
{
    const auto rows = expandMatrix( Json::parse( R"([
        { "x": [1, 2] }, { "x": [2, 3], "y": [0] }, { "x": [2, 4] } ])" ) );
    ASSERT_EQ( rows.size(), 5u );
    EXPECT_EQ( rows[2].dump(), R"({"x":2,"y":0})" );
    EXPECT_EQ( rows[4].dump(), R"({"x":4})" );
}

TEST( Study, PowerLawIsFoundExactly )
{
    const auto law = fitPowerLaw( { { 2, 3 * std::pow( 2, 1.7 ) },
                                    { 5, 3 * std::pow( 5, 1.7 ) },
                                    { 40, 3 * std::pow( 40, 1.7 ) } } );
    ASSERT_TRUE( law );
    EXPECT_NEAR( law->factor, 3, round_off );
    EXPECT_NEAR( law->exponent, 1.7, round_off );
    EXPECT_NEAR( law->scatter, 1, round_off );
}

TEST( Study, ScatterIsAFactor )
{
    // log y is +-log 2 about 0 at both ends alike: the law is 1, off by 2.
    const auto law =
        fitPowerLaw( { { 1, 2 }, { 1, .5 }, { 10, 2 }, { 10, .5 } } );
    ASSERT_TRUE( law );
    EXPECT_NEAR( law->exponent, 0, round_off );
    EXPECT_NEAR( law->scatter, 2, round_off );
}

TEST( Study, NoLawWithoutTwoDifferentPoints )
{
    EXPECT_FALSE( fitPowerLaw( {} ) );
    EXPECT_FALSE( fitPowerLaw( { { 3, 1 }, { 3, 2 }, { 3, 7 } } ) );
    // What has no logarithm does not count.
    EXPECT_FALSE( fitPowerLaw( { { 3, 1 }, { 4, 0 }, { 5, nan } } ) );
}

TEST( Study, PredictionGoesThroughThePointsAndContinuesTheLast )
{
    const std::vector<Point> points = {
        { 10, 1 }, { 100, 10 }, { 1000, 1000 } };
    for ( const auto& point : points )
        EXPECT_NEAR( predict( points, point.x ), point.y, round_off * point.y );
    EXPECT_NEAR( predict( points, 31.6227766 ), 3.16227766, 1e-8 );
    EXPECT_NEAR( predict( points, 1 ), 0.1, round_off );         // slope 1
    EXPECT_NEAR( predict( points, 1e4 ), 1e5, 1e5 * round_off ); // slope 2
    EXPECT_EQ( predict( { { 7, 3 } }, 99 ), 3 );
}

TEST( Study, ParetoFront )
{
    //  0 is beaten by 3; 2 ties with 1 in cost; 4 has no error; 5 is beaten by
    //  1
    const std::vector<Point> points = { { 2, 9 }, { 3, 2 },    { 3, 4 },
                                        { 1, 8 }, { .5, nan }, { 4, 2 } };
    EXPECT_EQ( paretoFront( points ), ( std::vector<std::size_t>{ 3, 1 } ) );
    EXPECT_TRUE( paretoFront( {} ).empty() );
}

//! A plane whose time is cells^1.5 / 1e3 and whose error is h^2.
Line secondOrder()
{
    Line line{ "second order", 2, {}, {}, {} };
    for ( const std::int64_t n : { 10, 20, 40 } )
    {
        const double cells = static_cast<double>( n * n );
        line.cells.push_back( { n, n } );
        line.seconds.push_back( std::pow( cells, 1.5 ) / 1e3 );
        line.errors.push_back( 1 / cells );
    }
    return line;
}

TEST( Study, LawsOfALine )
{
    const auto laws = fitLaws( secondOrder() );
    EXPECT_NEAR( laws.cost->exponent, 1.5, round_off );
    EXPECT_NEAR( *laws.order, 2, round_off );
    // Half the error: h / sqrt(2), cells x 2, time x 2^1.5.
    EXPECT_NEAR( *laws.halving, std::pow( 2, 1.5 ), 1e-10 );
}

TEST( Study, LawsAreThoseOfTheFinestRuns )
{
    auto line = secondOrder();
    line.cells.insert( line.cells.begin(), { 5, 5 } );
    line.seconds.insert( line.seconds.begin(), 100.0 );
    line.errors.insert( line.errors.begin(), 1e-9 );
    const auto laws = fitLaws( line );
    EXPECT_NEAR( laws.cost->exponent, 1.5, round_off );
    EXPECT_NEAR( *laws.order, 2, round_off );
}

TEST( Study, AnErrorThatDoesNotFallIsNotHalved )
{
    auto line = secondOrder();
    line.errors = { 1, 1.1, 1.2 };
    const auto laws = fitLaws( line );
    EXPECT_LT( *laws.order, 0 );
    EXPECT_FALSE( laws.halving );
}

TEST( Study, CandidatesLieOnTheGridsOfTheRuns )
{
    Line line = secondOrder();
    for ( auto& cells : line.cells )
        cells[1] *= 2;
    const auto all = candidates( line, 5 );
    // 10, 20, ..., 40 and on to twice the finest.
    ASSERT_EQ( all.size(), 8u );
    for ( std::size_t k = 0; k < all.size(); ++k )
    {
        const auto n = static_cast<std::int64_t>( 10 * ( k + 1 ) );
        EXPECT_EQ( all[k].cells, ( std::vector<std::int64_t>{ n, 2 * n } ) );
        EXPECT_EQ( all[k].line, 5u );
    }
    // The line's laws hold throughout, here with twice the cells.
    EXPECT_NEAR( all[7].error, 1.0 / ( 80 * 80 ), 1e-12 );
}

TEST( Study, CandidatesKeepAxesThatStay )
{
    Line line = secondOrder();
    for ( auto& cells : line.cells )
        cells[0] = 4;
    const auto all = candidates( line, 0 );
    ASSERT_EQ( all.size(), 8u );
    for ( std::size_t k = 0; k < all.size(); ++k )
        EXPECT_EQ( all[k].cells,
                   ( std::vector<std::int64_t>{
                       4, static_cast<std::int64_t>( 10 * ( k + 1 ) ) } ) );
    // Nor do they go below what was run where shapes differ.
    line.cells.front() = { 4, 10 };
    line.cells.back() = { 8, 80 };
    for ( const auto& candidate : candidates( line, 0 ) )
    {
        EXPECT_GE( candidate.cells[0], 4 );
        EXPECT_GE( candidate.cells[1], 10 );
    }
}

// Of grids with as many cells in other shapes the dearest and the roughest
// counts.
TEST( Study, EqualCountsOfCellsAreOnePoint )
{
    const auto square = secondOrder();
    auto line = square;
    line.cells.push_back( { 20, 80 } ); // as many as 40 x 40
    line.seconds.push_back( line.seconds.back() / 2 );
    line.errors.push_back( 2 * line.errors.back() );
    const auto all = candidates( line, 0 );
    const auto same =
        std::find_if( all.begin(), all.end(),
                      [&]( const auto& candidate )
                      { return candidate.cells == line.cells.back(); } );
    ASSERT_NE( same, all.end() );
    EXPECT_NEAR( same->seconds, square.seconds.back(), round_off );
    EXPECT_NEAR( same->error, 2 * square.errors.back(), round_off );
}

TEST( Study, AnErrorThatFallsFasterThanTheSchemeIsNotCarriedOn )
{
    auto line = secondOrder();
    EXPECT_FALSE( unbelievedOrder( line ) );
    line.errors.front() = 8 * line.errors[1]; // order 3 ahead of the finest two
    EXPECT_FALSE( unbelievedOrder( line ) );
    line.errors[1] = 8 * line.errors[2];
    EXPECT_NEAR( *unbelievedOrder( line ), 3, round_off );
    line.errors.front() = 2 * line.errors[1]; // together of order 2
    EXPECT_NEAR( *fitLaws( line ).order, 2, round_off );
    EXPECT_TRUE( fitLaws( line ).is_too_fast );
    EXPECT_FALSE( fitLaws( line ).halving );
    line.errors.front() = 8 * line.errors[1];
    EXPECT_NEAR( *fitLaws( line ).order, 3, round_off );
    EXPECT_FALSE( fitLaws( line ).halving );
    for ( const auto& candidate : candidates( line, 0 ) )
        if ( candidate.cells[0] <= 40 ) // between runs as measured
            EXPECT_NEAR( candidate.error,
                         line.errors[2] *
                             std::pow( 40.0 / candidate.cells[0], 3 ),
                         1e-10 );
        else
            EXPECT_EQ( candidate.error, line.errors[2] );
    // What is most accurate is then what has been run.
    EXPECT_EQ( mostAccurate( { line }, 1e9 )->cells, line.cells[2] );
    // A run that has no error does not count as the finest.
    line.errors.back() = nan;
    EXPECT_NEAR( *unbelievedOrder( line ), 3, round_off );
    line.errors = { nan, nan, 1 };
    EXPECT_FALSE( unbelievedOrder( line ) );
}

TEST( Study, ALineWithOneErrorPredictsThatRunAlone )
{
    auto line = secondOrder();
    line.errors = { nan, 0.5, nan };
    const auto all = candidates( line, 0 );
    ASSERT_EQ( all.size(), 1u );
    EXPECT_EQ( all[0].cells, line.cells[1] );
    EXPECT_EQ( all[0].seconds, line.seconds[1] );
    EXPECT_EQ( all[0].error, 0.5 );
    line.errors = { nan, nan, nan };
    EXPECT_TRUE( candidates( line, 0 ).empty() );
}

TEST( Study, AdviceTakesTheBestLine )
{
    auto dear = secondOrder(), rough = secondOrder();
    for ( auto& seconds : dear.seconds )
        seconds *= 10;
    for ( auto& error : rough.errors )
        error *= 100;
    const std::vector<Line> lines = { dear, rough, secondOrder() };

    // 1 / 30^2 is just enough, and 30 x 30 cells take 27 s.
    auto choice = cheapest( lines, 1.0 / 899 );
    ASSERT_TRUE( choice );
    EXPECT_EQ( choice->line, 2u );
    EXPECT_EQ( choice->cells, ( std::vector<std::int64_t>{ 30, 30 } ) );
    EXPECT_NEAR( choice->seconds, 27, 1e-9 );
    choice = mostAccurate( lines, 27.1 );
    ASSERT_TRUE( choice );
    EXPECT_EQ( choice->line, 2u );
    EXPECT_EQ( choice->cells, ( std::vector<std::int64_t>{ 30, 30 } ) );

    // Beyond twice the finest grid nothing is promised, nor below the coarsest.
    EXPECT_TRUE( cheapest( lines, 1.0 / 6400 * ( 1 + 1e-9 ) ) );
    EXPECT_FALSE( cheapest( lines, 1.0 / 6401 ) );
    EXPECT_FALSE( mostAccurate( lines, 0.99 ) );
}

TEST( Study, ErrorsAreExtrapolatedWithTheOrderThatThreeGridsShow )
{
    // f_h = f + C h^p, so that |f_2h - f_h| = C h^p ( 2^p - 1 ).
    for ( const double p : { 0.8, 1.0, 2.0 } )
    {
        const double near = std::pow( 2, p ) - 1;
        const auto e = extrapolate( near, near * std::pow( 2, p ), 2, 2 );
        ASSERT_TRUE( e.observed );
        EXPECT_NEAR( *e.observed, p, round_off );
        EXPECT_NEAR( e.error, 1, 10 * round_off );
        // Of 50, 25 and 13 cells, say, whose ratios differ.
        const double b = 25.0 / 13;
        const auto uneven = extrapolate(
            near, std::pow( 2, p ) * ( std::pow( b, p ) - 1 ), 2, b );
        EXPECT_NEAR( *uneven.observed, p, 10 * round_off );
        EXPECT_NEAR( uneven.error, 1, 100 * round_off );
    }
    // Two grids: first order.
    EXPECT_NEAR( extrapolate( 3, std::nullopt, 2, 2 ).error, 3, round_off );
    EXPECT_NEAR( extrapolate( 3, std::nullopt, 2.5, 2 ).error, 2, round_off );
    EXPECT_FALSE( extrapolate( 3, std::nullopt, 2, 2 ).observed );
    // What is beyond belief is shown, but not used.
    auto e = extrapolate( 1, 16, 2, 2 );
    EXPECT_NEAR( *e.observed, 4, round_off );
    EXPECT_NEAR( e.error, 1.0 / 3, round_off );
    e = extrapolate( 1, 0.5, 2, 2 );
    EXPECT_NEAR( *e.observed, -1, round_off );
    EXPECT_NEAR( e.error, 1 / ( std::sqrt( 2 ) - 1 ), 10 * round_off );
}

//! A run of n cells: 8 steps and 2 more for each cell, 3 particles a cell to
//! begin with and twice as many after half of the steps, 1 second for each.
Rung rungOf( const std::int64_t n )
{
    Rung rung;
    rung.cells = { n };
    rung.fineness = static_cast<double>( n );
    rung.fixed = 8;
    rung.first = 3 * n;
    rung.last = rung.most = 6 * n;
    const std::int64_t steps = 8 + 2 * n;
    for ( std::int64_t k = 1; k <= steps; ++k )
    {
        const auto particles = 2 * k <= steps ? 3 * n : 6 * n;
        rung.costs.push_back(
            { static_cast<double>( particles ), particles,
              static_cast<double>( k ) / static_cast<double>( steps ) } );
    }
    return rung;
}

TEST( Study, ARunIsForetoldByCoarserOnes )
{
    const std::vector<Rung> rungs = { rungOf( 25 ), rungOf( 50 ) };
    const auto run = rungOf( 200 );
    // The first quarter of it, on a machine half as fast.
    Calibration calibration = run;
    calibration.costs.resize( run.costs.size() / 4 );
    for ( auto& cost : calibration.costs )
        cost.seconds *= 2;
    const auto told = forecast( rungs, 200, 600, calibration );
    EXPECT_NEAR( told.steps, 408, round_off );
    EXPECT_NEAR( told.last, 1200, 1e-9 );
    EXPECT_NEAR( told.most, 1200, 1e-9 );
    EXPECT_NEAR( told.seconds, 2 * 408 * 900, 1e-6 );

    // Later steps of a rung that take longer do so in the run as well.
    auto slower = rungs;
    for ( auto& cost : slower[1].costs )
        if ( cost.time > 0.25 )
            cost.seconds *= 3;
    EXPECT_NEAR( forecast( slower, 200, 600, calibration ).seconds,
                 3 * told.seconds, 1e-6 );
    // One rung alone, or two of the same smallest spacing.
    EXPECT_NEAR( forecast( { rungs[1] }, 200, 600, calibration ).steps, 408,
                 round_off );
    EXPECT_NEAR(
        forecast( { rungs[1], rungs[1] }, 200, 600, calibration ).steps, 408,
        round_off );
    // A coarse grid that sees another flow, with too many steps or too few.
    auto odd = rungs;
    odd[0].costs = odd[1].costs;
    EXPECT_NEAR( forecast( odd, 200, 600, calibration ).steps, 408, round_off );
    odd[0].costs.resize( 10 );
    EXPECT_NEAR( forecast( odd, 200, 600, calibration ).steps, 432, round_off );
}

// What the run itself has taken is no guess: steps that go as the cells
// squared, say, are more than coarser grids foretell.
TEST( Study, ARunTakesNoFewerStepsThanItHasTaken )
{
    const std::vector<Rung> rungs = { rungOf( 50 ) };
    Calibration calibration = rungOf( 100 );
    EXPECT_NEAR( forecast( rungs, 100, 300, calibration ).steps, 208,
                 round_off );
    // 500 steps up to the middle of it, where the rung has 54 of its 108.
    calibration.costs.clear();
    for ( std::int64_t k = 1; k <= 500; ++k )
        calibration.costs.push_back(
            { 300, 300, 0.5 * static_cast<double>( k ) / 500 } );
    EXPECT_NEAR( forecast( rungs, 100, 300, calibration ).steps, 1000,
                 round_off );
    // Steps of another grid tell nothing.
    calibration.fineness = 50;
    EXPECT_NEAR( forecast( rungs, 100, 300, calibration ).steps, 208,
                 round_off );
}

//! A directory that goes with the test.
class StudyFiles : public ::testing::Test
{
  protected:
    void SetUp() override
    {
        _folder = std::filesystem::temp_directory_path() /
                  ( "machpoint_study_" + std::to_string( getpid() ) );
        makeDirectory( _folder / "series" );
    }
    void TearDown() override { std::filesystem::remove_all( _folder ); }

    void writeSeries( const std::string& text )
    {
        std::ofstream( _folder / "series/body.csv" ) << text;
    }

    std::filesystem::path _folder;
};

TEST_F( StudyFiles, SeriesMeansWeightTheSecondHalfBySteps )
{
    writeSeries( "time,force_x\n1,100\n2,100\n2.5,3\n4,7\n" );
    const auto means = seriesMeans( _folder );
    EXPECT_NEAR( means.at( "body.force_x" ).get<double>(),
                 ( 0.5 * 3 + 1.5 * 7 ) / 2, round_off );
}

TEST_F( StudyFiles, ATornSeriesIsAnError )
{
    writeSeries( "time,force_x\n1,100\n2\n" );
    EXPECT_THROW( seriesMeans( _folder ), IoError );
}

#ifdef MACHPOINT_ENABLE_HDF5
//! A grid output of density 1 + x + shift on n x 1 nodes, all else 1.
void writeGrid( const std::filesystem::path& folder, const double lower,
                const double spacing, const std::size_t n, const double shift,
                const std::size_t empty )
{
    makeDirectory( folder / "grid" );
    std::vector<double> density( n ), ones( 2 * n, 1 );
    for ( std::size_t i = 0; i < n; ++i )
        density[i] =
            i == empty ? 0
                       : 1 + lower + spacing * static_cast<double>( i ) + shift;
    const std::vector<double> first = { lower, 0.5 };
    const std::vector<double> spacings = { spacing, 1 };
    const double time = 1;
    const Communicator ranks;
    writeHdf5( ranks, folder / "grid/00000003.h5",
               { { "time", {}, &time },
                 { "lower", { 2 }, first.data() },
                 { "spacing", { 2 }, spacings.data() } },
               { { "density", { 1, n }, density.data() },
                 { "pressure", { 1, n }, ones.data() },
                 { "specific_internal_energy", { 1, n }, ones.data() },
                 { "velocity", { 1, n, 2 }, ones.data() } } );
}

TEST_F( StudyFiles, GridsAreComparedAtTheCentresOfTheFirstOnesCells )
{
    // Nodes at cell centres against nodes at vertices: what is linear is
    // interpolated exactly.
    writeGrid( _folder / "a", 0.5, 1, 4, 0, 99 );
    writeGrid( _folder / "b", 0, 0.5, 9, 0.25, 99 );
    writeGrid( _folder / "holed", 0.25, 1, 5, 0.25, 2 );
    const auto input = Json::parse(
        R"({ "grid": { "lower": [0, 0], "upper": [4, 1], "cells": [4, 1] } })" );
    auto errors = gridErrors( _folder / "a", _folder / "b", input );
    EXPECT_NEAR( errors.at( "density.L1" ).get<double>(), 4 * 0.25, round_off );
    EXPECT_NEAR( errors.at( "density.L2" ).get<double>(), 2 * 0.25, round_off );
    EXPECT_NEAR( errors.at( "density.Linf" ).get<double>(), 0.25, round_off );
    EXPECT_EQ( errors.at( "velocity.L1" ), 0 );
    // Of 1 + x + .25, whose mean over the four cells is 3.25.
    const auto changes = gridChanges( _folder / "a", _folder / "b", input );
    EXPECT_NEAR( changes.at( "density.change" ).get<double>(), 0.25 / 3.25,
                 round_off );
    EXPECT_EQ( changes.at( "velocity.change" ), 0 );
    EXPECT_EQ( changes.at( "pressure.change" ), 0 );
    // Centres 1.5 and 2.5 lie beside the empty node at 2.25.
    errors = gridErrors( _folder / "a", _folder / "holed", input );
    EXPECT_NEAR( errors.at( "density.L1" ).get<double>(), 2 * 0.25, round_off );
    EXPECT_THROW( gridErrors( _folder / "a", _folder / "none", input ),
                  IoError );
}

TEST_F( StudyFiles, ProbesReadPlacesAndLines )
{
    writeGrid( _folder, 0.5, 1, 4, 0, 99 ); // density 1 + x
    const auto probes = Json::parse( R"([
        { "type": "point", "name": "here", "field": "density",
          "at": [1.25, 0.5] },
        { "type": "maximum", "name": "most", "field": "density",
          "from": [1, 0.5], "to": [3, 0.5] },
        { "type": "crossing", "name": "front", "field": "density", "value": 3,
          "from": [3.5, 0.5], "to": [0.5, 0.5] },
        { "type": "crossing", "name": "none", "field": "density", "value": 9,
          "from": [3.5, 0.5], "to": [0.5, 0.5] } ])" );
    const auto means = probeMeans( _folder, probes );
    EXPECT_NEAR( means.at( "here.density" ).get<double>(), 2.25, round_off );
    EXPECT_NEAR( means.at( "most.density" ).get<double>(), 4, round_off );
    EXPECT_NEAR( means.at( "front.distance" ).get<double>(), 1.5, round_off );
    EXPECT_TRUE( means.at( "none.distance" ).is_null() );
    EXPECT_EQ( misfitPlaces( probes[1], 3 ),
               ( std::vector<std::string>{ "from", "to" } ) );
    EXPECT_THROW( probeMeans( _folder / "none", probes ), IoError );
}
#endif

} // namespace
} // namespace Machpoint
