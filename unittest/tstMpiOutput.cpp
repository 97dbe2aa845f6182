/*!
  \file tstMpiOutput.cpp
  \brief What several ranks write together: blocks, compression, failures;
  and their errors.
*/
#include "file_size_limit.hpp"
#include "mpi_scratch.hpp"
#include "tolerance.hpp"

#include <core/hdf5_file.hpp>
#include <core/output.hpp>
#include <core/report.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <numeric>
#include <set>
#include <string>
#include <vector>

namespace fs = std::filesystem;
using namespace Machpoint;

namespace
{

class MpiOutput : public ::Test::MpiScratch
{
  protected:
    //! Every file below the directory, as all ranks see it now.
    std::set<std::string> tree() const
    {
        _ranks.any( false );
        std::set<std::string> files;
        for ( const auto& e : fs::recursive_directory_iterator( _scratch ) )
            if ( !e.is_directory() )
                files.insert( fs::relative( e.path(), _scratch ).string() );
        _ranks.any( false );
        return files;
    }

    //! Message of the IoError that an action throws; the same on all ranks.
    template <class Action>
    std::string messageOf( const Action& action ) const
    {
        std::string message;
        try
        {
            action();
        }
        catch ( const IoError& error )
        {
            message = error.what();
            EXPECT_TRUE( error.isOnAllRanks() );
        }
        EXPECT_NE( message, "" );
        EXPECT_EQ( message, _ranks.fromRoot( message ) );
        return message;
    }
};

//! Rows of a rank: the second has none, the others differ.
std::size_t rowsOf( const int rank )
{
    return rank == 1 ? 0 : 40000 + 7 * static_cast<std::size_t>( rank );
}

TEST_F( MpiOutput, RowsOfAllRanksMakeOneArray )
{
    std::size_t before = 0, total = 0;
    for ( int r = 0; r < _ranks.size(); ++r )
    {
        before += r < _ranks.rank() ? rowsOf( r ) : 0;
        total += rowsOf( r );
    }
    const auto n = rowsOf( _ranks.rank() );
    std::vector<double> position( 2 * n );
    std::iota( position.begin(), position.end(), 2.0 * before );
    std::vector<std::int64_t> id( n );
    std::iota( id.begin(), id.end(), before );
    const double time = 0.1;
    const std::vector<unsigned char> text = { 'g', 'a', 's' };

    std::vector<std::uintmax_t> sizes;
    for ( const auto small : { std::size_t( 0 ), small_file } )
        for ( const int compression : { 0, 4 } )
        {
            const auto file = _scratch / "rows.h5";
            auto datasets = stackRows(
                _ranks,
                { { "position", { n, 2 }, position.data() },
                  { "id", { n }, id.data(), datasetType<std::int64_t>() },
                  { "none", { 0 } } } );
            datasets.push_back( { "a/text",
                                  { 3 },
                                  text.data(),
                                  datasetType<unsigned char>() } );
            writeHdf5( _ranks, file, { { "time", {}, &time } }, datasets,
                       compression, small );

            const Hdf5Reader reader( file );
            using Shape = std::vector<std::size_t>;
            EXPECT_EQ( reader.shape( "position" ), ( Shape{ total, 2 } ) );
            EXPECT_EQ( reader.shape( "none" ), Shape{ 0 } );
            std::vector<double> positions( 2 * total );
            std::iota( positions.begin(), positions.end(), 0.0 );
            EXPECT_EQ( reader.read<double>( "position" ), positions );
            EXPECT_EQ(
                reader.read<double>( "position", { before, 0 }, { n, 2 } ),
                position );
            std::vector<std::int64_t> ids( total );
            std::iota( ids.begin(), ids.end(), 0 );
            EXPECT_EQ( reader.read<std::int64_t>( "id" ), ids );
            EXPECT_EQ( reader.read<unsigned char>( "a/text" ), text );
            EXPECT_EQ( reader.attribute<double>( "time" ),
                       std::vector{ time } );
            EXPECT_EQ( tree(), std::set<std::string>{ "rows.h5" } );
            sizes.push_back( fs::file_size( file ) );
        }
    // Numbers in order compress well, whoever writes them.
    EXPECT_LT( sizes[1], sizes[0] / 2 );
    EXPECT_LT( sizes[3], sizes[2] / 2 );
}

// Some ranks have several blocks to fetch and others none; what is said of all
// of them comes last.
TEST_F( MpiOutput, RowsMayBeFetchedAndCounted )
{
    const auto n = 20 * rowsOf( _ranks.rank() );
    const auto before = _ranks.sumBefore( n );
    const auto total = static_cast<std::size_t>(
        _ranks.sum( static_cast<std::int64_t>( n ) ) );
    for ( const auto small : { std::size_t( 0 ), std::size_t( 1 ) << 40 } )
    {
        std::int64_t fetched = 0, all = 0;
        Dataset rows{ "rows", { n, 3 }, nullptr, Dataset::Type::integer };
        rows.fetch = [&]( const std::size_t first, const std::size_t count,
                          void* values )
        {
            auto* list = static_cast<std::int64_t*>( values );
            std::iota( list, list + 3 * count, 3 * ( before + first ) );
            fetched += count;
        };
        const auto file = _scratch / "rows.h5";
        writeHdf5( _ranks, file,
                   { { "fetched", {}, &all, Dataset::Type::integer } },
                   stackRows( _ranks, { rows } ), 0, small,
                   [&] { all = _ranks.sum( fetched ); } );
        const Hdf5Reader reader( file );
        std::vector<std::int64_t> expected( 3 * total );
        std::iota( expected.begin(), expected.end(), 0 );
        EXPECT_EQ( reader.read<std::int64_t>( "rows" ), expected );
        EXPECT_EQ( reader.attribute<std::int64_t>( "fetched" ).at( 0 ),
                   static_cast<std::int64_t>( total ) );
        _ranks.any( false ); // all have read it
    }
}

TEST_F( MpiOutput, BlocksOfAGridMakeOneArray )
{
    // Two columns of blocks, as many rows of them as ranks need; the cut does
    // not fall in the middle.
    const std::size_t ny = 9, nx = 7, cut = 3;
    const std::size_t columns = _ranks.size() > 1 ? 2 : 1;
    const std::size_t rows = _ranks.size() / columns;
    const auto column = _ranks.rank() % columns, row = _ranks.rank() / columns;
    const auto x0 = column == 0 ? 0 : cut;
    const auto x1 = column + 1 == columns ? nx : cut;
    const auto y0 = row * ( ny / rows );
    const auto y1 = row + 1 == rows ? ny : y0 + ny / rows;
    std::vector<double> whole( ny * nx * 2 ), block;
    std::iota( whole.begin(), whole.end(), 0.0 );
    for ( auto y = y0; y < y1; ++y )
        for ( auto x = x0; x < x1; ++x )
            for ( std::size_t d : { 0, 1 } )
                block.push_back( whole[( y * nx + x ) * 2 + d] );

    for ( const int compression : { 0, 9 } )
    {
        OutputDirectory output( _scratch, FormerRun::replace, 2, true,
                                compression );
        Dataset velocity{ "velocity", { y1 - y0, x1 - x0, 2 }, block.data() };
        velocity.global_shape = { ny, nx, 2 };
        velocity.start = { y0, x0, 0 };
        const auto together = _scratch / "together.h5";
        writeHdf5( _ranks, together, {}, { velocity }, compression, 0 );
        EXPECT_EQ( Hdf5Reader( together ).read<double>( "velocity" ), whole );
        _ranks.any( false ); // all have read it
        onRoot( _ranks, [&] { removeFile( together ); } );
        output.writeGrid( 3, 0.5, { 0, 0 }, { 1, 1 }, { velocity } );
        const Hdf5Reader reader( _scratch / "grid" / "00000003.h5" );
        EXPECT_EQ( reader.read<double>( "velocity" ), whole );
        EXPECT_EQ( reader.attribute<std::int64_t>( "step" ),
                   std::vector<std::int64_t>{ 3 } );
        EXPECT_EQ( tree(), ( std::set<std::string>{ "grid.xdmf",
                                                    "grid/00000003.h5" } ) );
    }
}

TEST_F( MpiOutput, ParticlesOfAllRanksAreOneCloud )
{
    OutputDirectory output( _scratch, FormerRun::refuse, 1 );
    const auto n = static_cast<std::size_t>( _ranks.rank() );
    const std::vector<double> x( n, _ranks.rank() );
    output.writeParticles( 0, 0.0, { { "position", { n, 1 }, x.data() } } );
    output.writeSeries( "series/body.csv", { "time" }, { { 0.0 } } );
    output.writeSummary( "{}\n" );

    const Hdf5Reader reader( _scratch / "particles" / "00000000.h5" );
    std::vector<double> all, points;
    for ( int r = 0; r < _ranks.size(); ++r )
        all.insert( all.end(), r, r );
    for ( const auto position : all )
        points.insert( points.end(), { position, 0.0 } );
    EXPECT_EQ( reader.read<double>( "position" ), all );
    EXPECT_EQ( reader.read<double>( "xdmf/position" ), points );
    std::ifstream collection( _scratch / "particles.xdmf" );
    const std::string text( std::istreambuf_iterator<char>( collection ), {} );
    EXPECT_NE( text.find( "NumberOfElements=\"" + std::to_string( all.size() ) +
                          "\"" ),
               std::string::npos );
    EXPECT_EQ( tree(), ( std::set<std::string>{
                           "particles.xdmf", "particles/00000000.h5",
                           "series/body.csv", "summary.json" } ) );
}

//! Gas at rest of density 2 and pressure 3.
struct Still : ExactSolution
{
    GasState state( const Vector3&, double ) const override
    {
        return { 2.0, {}, 3.0 };
    }
};

TEST( MpiReport, ErrorsOfAllRanksAreThoseOfOneCloud )
{
    // Particle k stands at (k + 1/2) / n, alternately on each rank, and has
    // the error k in its density; those on the line stand for 1 / n each.
    const Communicator ranks;
    const int n = 4 * ranks.size();
    for ( const int dim : { 1, 2 } )
    {
        ParticleData own;
        Real L1 = 0, L2 = 0;
        for ( int k = 0; k < n; ++k )
        {
            L1 += Real( k ) / n;
            L2 += Real( k ) * k / n;
            if ( k % ranks.size() != ranks.rank() )
                continue;
            for ( int d = 0; d < dim; ++d )
            {
                own.position.push_back( ( k + 0.5 ) / n );
                own.velocity.push_back( 0.0 );
            }
            own.mass.push_back( 1.0 );
            own.volume.push_back( 1.0 / n );
            own.density.push_back( 2.0 + k );
            own.pressure.push_back( 3.0 );
            own.specific_internal_energy.push_back( 1.5 );
            own.id.push_back( k );
        }
        const Json input = {
            { "dimension", dim },
            { "grid",
              { { "lower", std::vector( dim, 0 ) },
                { "upper", std::vector( dim, 1 ) },
                { "cells", std::vector( dim, n ) } } },
            { "physics", { { { "type", "ideal_gas" }, { "gamma", 2.0 } } } } };
        const auto errors = measureErrors( own, Still(), input, 0.0 );
        EXPECT_REAL_EQ( errors[0].L1, L1 );
        EXPECT_REAL_EQ( errors[0].L2, std::sqrt( L2 ) );
        EXPECT_REAL_EQ( errors[0].Linf, n - 1 );
        EXPECT_EQ( errors[2].Linf, 0.0 );
    }
}

//---------------------------------------------------------------------------//

TEST_F( MpiOutput, WhatOneRankMeetsAllRanksThrow )
{
    const int last = _ranks.size() - 1;
    const auto message = messageOf(
        [&]
        {
            together( _ranks,
                      [&]
                      {
                          if ( _ranks.rank() == last )
                              throw IoError( "no room on the last" );
                      } );
        } );
    EXPECT_EQ( message, "no room on the last" );
}

TEST_F( MpiOutput, ADirectoryThatCannotBeMadeIsAnErrorEverywhere )
{
    if ( _ranks.isRoot() )
        std::ofstream( _scratch / "file" ) << "mine";
    const auto message = messageOf(
        [&] { OutputDirectory( _scratch / "file", FormerRun::refuse, 1 ); } );
    EXPECT_NE( message.find( std::strerror( ENOTDIR ) ), std::string::npos )
        << message;
    EXPECT_EQ( tree(), std::set<std::string>{ "file" } );
}

TEST_F( MpiOutput, AFullDiskIsAnErrorEverywhereAndLeavesNoTrace )
{
    const std::vector<double> values( 100000, 1.0 );
    std::size_t small = 0;
    const auto write = [&]
    {
        writeHdf5( _ranks, _scratch / "a.h5", {},
                   stackRows( _ranks, { { "a", { 100000 }, values.data() } } ),
                   0, small );
    };
    for ( const auto bytes : { std::size_t( 0 ), small_file } )
    {
        small = bytes;
        const auto message = messageOf(
            [&]
            {
                const ::Test::FileSizeLimit limit( 5000 );
                write();
            } );
        EXPECT_NE( message.find( "a.h5: cannot write the file: " +
                                 std::string( std::strerror( EFBIG ) ) ),
                   std::string::npos )
            << message;
        EXPECT_EQ( tree(), std::set<std::string>{} );

        write();
        EXPECT_EQ( tree(), std::set<std::string>{ "a.h5" } );
        onRoot( _ranks, [&] { removeFile( _scratch / "a.h5" ); } );
    }
}

TEST_F( MpiOutput, AReaderNamesWhatItLacks )
{
    const double time = 0.5;
    const auto file = _scratch / "a.h5";
    writeHdf5( _ranks, file, { { "time", {}, &time } },
               { { "a", { 1 }, &time } } );
    const auto expect = [&]( const char* reason, const auto& action )
    {
        const auto message = messageOf( [&] { together( _ranks, action ); } );
        EXPECT_NE( message.find( file.string() ), std::string::npos );
        EXPECT_NE( message.find( reason ), std::string::npos ) << message;
    };
    const Hdf5Reader reader( file );
    EXPECT_TRUE( reader.has( "a" ) );
    EXPECT_FALSE( reader.has( "b" ) );
    expect( "no dataset b", [&] { reader.shape( "b" ); } );
    expect( "a has another type", [&] { reader.read<std::int64_t>( "a" ); } );
    expect( "a is [1]", [&] { reader.read<double>( "a", { 0 }, { 2 } ); } );
    expect( "no attribute step",
            [&] { reader.attribute<std::int64_t>( "step" ); } );
    expect( "time has another type",
            [&] { reader.attribute<std::int64_t>( "time" ); } );
    expect( "cannot be read", [&] { Hdf5Reader( file / "none" ); } );
}

} // namespace
