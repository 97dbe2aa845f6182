/*!
  \file tstMpiCheckpoint.cpp
  \brief Checkpoints of several ranks: each gets its own rows back.
*/
#include "mpi_scratch.hpp"
#include "rows.hpp"

#include <core/checkpoint.hpp>
#include <core/hdf5_file.hpp>

#include <gtest/gtest.h>

#include <fstream>
#include <numeric>
#include <string>
#include <vector>

namespace fs = std::filesystem;
using namespace Machpoint;

namespace
{

class MpiCheckpoint : public ::Test::MpiScratch
{
  protected:
    //! Rank r has the rows before( r ) to before( r + 1 ); the first has none.
    static std::int64_t before( const int r ) { return r * ( r - 1 ) / 2 * 7; }

    //! What a rank carries: its rows of a table, and what all share.
    struct Carried
    {
        double time = 0.5;
        std::int64_t step = 12;
        std::string limiter = "wave speed";
        std::vector<double> series = { 1, 2, 3, 4 };
        std::vector<Real> x;
        std::vector<std::int64_t> id;

        void checkpoint( Archive& archive )
        {
            archive( "time", time );
            archive( "step", step );
            archive( "limiter", limiter );
            archive.table( "series", series, 2 );
            auto x_rows = ::Test::rowsOf( x, 2 );
            auto id_rows = ::Test::rowsOf( id, 1 );
            archive.rows( "particles/x", x_rows );
            archive.rows( "particles/id", id_rows );
            if ( archive.isReading() )
            {
                x = ::Test::listOf( x_rows );
                id = ::Test::listOf( id_rows );
            }
        }
    };

    Carried own() const
    {
        Carried carried;
        for ( auto row = before( _ranks.rank() );
              row < before( _ranks.rank() + 1 ); ++row )
        {
            carried.id.push_back( row );
            carried.x.push_back( 0.5 * static_cast<Real>( row ) );
            carried.x.push_back( -static_cast<Real>( row ) );
        }
        return carried;
    }

    fs::path write() const
    {
        auto carried = own();
        Archive archive;
        carried.checkpoint( archive );
        return writeCheckpoint( _ranks, _scratch / "checkpoints", _input,
                                archive );
    }

    Json _input = { { "scene", "test" } };
};

TEST_F( MpiCheckpoint, everyRankGetsItsOwnRowsBack )
{
    auto read = readCheckpoint( _ranks, write(), _input );
    Carried carried{ 0, 0, "", {}, {}, {} };
    carried.checkpoint( read.archive );
    const auto expected = own();
    EXPECT_EQ( carried.time, expected.time );
    EXPECT_EQ( carried.step, expected.step );
    EXPECT_EQ( carried.limiter, expected.limiter );
    EXPECT_EQ( carried.series, expected.series );
    EXPECT_EQ( carried.x, expected.x );
    EXPECT_EQ( carried.id, expected.id );
}

// A file that one rank wrote is read by any number of them.
TEST_F( MpiCheckpoint, otherNumbersOfRanksShareTheRows )
{
    if ( _ranks.size() == 1 )
        GTEST_SKIP() << "needs another number of ranks than one";
    const auto file = write();
    // The same, but for the one dataset that tells who had which rows.
    const auto total = before( _ranks.size() );
    const Hdf5Reader reader( file );
    const auto header = reader.read<unsigned char>( "header" );
    const auto checksum = reader.attribute<std::int64_t>( "checksum" );
    const auto x = reader.read<Real>( "rows/particles/x" );
    const auto id = reader.read<std::int64_t>( "rows/particles/id" );
    const auto time = reader.read<double>( "shared/time" );
    const auto step = reader.read<std::int64_t>( "shared/step" );
    const auto series = reader.read<double>( "shared/series" );
    const auto limiter = reader.read<unsigned char>( "shared/limiter" );
    const auto rows = static_cast<std::size_t>( total );
    const auto copy = _scratch / "one.h5";
    writeHdf5(
        _ranks, copy,
        { { "machpoint_checkpoint",
            {},
            &checkpoint_format,
            Dataset::Type::integer },
          { "checksum", {}, checksum.data(), Dataset::Type::integer } },
        { { "header", { header.size() }, header.data(), Dataset::Type::byte },
          { "rows_of_ranks", { 1 }, &total, Dataset::Type::integer },
          { "rows/particles/x", { rows, 2 }, x.data(), datasetType<Real>() },
          { "rows/particles/id",
            { rows, 1 },
            id.data(),
            Dataset::Type::integer },
          { "shared/time", {}, time.data() },
          { "shared/step", {}, step.data(), Dataset::Type::integer },
          { "shared/series", { 2, 2 }, series.data() },
          { "shared/limiter",
            { limiter.size() },
            limiter.data(),
            Dataset::Type::byte } } );
    auto read = readCheckpoint( _ranks, copy, _input );
    Carried carried{ 0, 0, "", {}, {}, {} };
    carried.checkpoint( read.archive );
    EXPECT_EQ( carried.series, own().series );
    EXPECT_EQ( carried.x.size(), 2 * carried.id.size() );
    EXPECT_LE( std::abs( static_cast<std::int64_t>( carried.id.size() ) -
                         total / _ranks.size() ),
               1 );
    std::vector<std::int64_t> all( rows );
    std::iota( all.begin(), all.end(), 0 );
    EXPECT_EQ( _ranks.gatherAll( carried.id ), all );
}

// One byte is noticed by all, be it of what they share or of the rows of one.
TEST_F( MpiCheckpoint, damageIsAnErrorOnAllRanks )
{
    std::vector<std::string> wholes = { "wave speed" };
    if ( _ranks.size() > 1 ) // else there are no rows
    {
        // The last rank's last row of x.
        const auto row = static_cast<Real>( before( _ranks.size() ) - 1 );
        const Real x[] = { Real( 0.5 ) * row, -row };
        wholes.emplace_back( reinterpret_cast<const char*>( x ), sizeof( x ) );
    }
    fs::path file;
    for ( const auto& whole : wholes )
    {
        file = write();
        if ( _ranks.isRoot() )
        {
            std::fstream stream( file, std::ios::in | std::ios::out |
                                           std::ios::binary );
            const std::string bytes( std::istreambuf_iterator<char>( stream ),
                                     {} );
            const auto place = bytes.find( whole );
            EXPECT_NE( place, std::string::npos );
            EXPECT_EQ( place, bytes.rfind( whole ) );
            stream.seekp( static_cast<std::streamoff>( place ) );
            stream.put( static_cast<char>( whole[0] ^ 1 ) );
        }
        _ranks.any( false );
        EXPECT_THROW( readCheckpoint( _ranks, file, _input ), IoError );
    }
    if ( _ranks.isRoot() )
        fs::resize_file( file, 1000 );
    _ranks.any( false );
    EXPECT_THROW( readCheckpoint( _ranks, file, _input ), IoError );
    EXPECT_THROW(
        readNewestCheckpoint( _ranks, _scratch / "checkpoints", _input ),
        IoError );
}

// A shared file system may show other ranks an older folder.
TEST_F( MpiCheckpoint, theRootSaysWhichIsTheNewest )
{
    const auto file = write();
    const auto seen = _scratch / ( _ranks.isRoot() ? "checkpoints" : "older" );
    EXPECT_EQ( readNewestCheckpoint( _ranks, seen, _input ).file, file );
}

} // namespace
