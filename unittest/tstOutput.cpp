/*!
  \file tstOutput.cpp
  \brief The output directory: layout, refusals, failures of the disk, XDMF.
*/
#include "file_size_limit.hpp"

#include <core/output.hpp>

#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <unistd.h>

#ifdef MACHPOINT_ENABLE_HDF5
#include <hdf5.h>
#endif

namespace fs = std::filesystem;
using Machpoint::Dataset;
using Machpoint::FormerRun;
using Machpoint::IoError;
using Machpoint::OutputDirectory;
using Test::FileSizeLimit;

namespace
{

// A directory of its own for each test, gone with it.
class Output : public ::testing::Test
{
  protected:
    void SetUp() override
    {
        auto pattern =
            ( fs::temp_directory_path() / "machpoint_XXXXXX" ).string();
        ASSERT_NE( ::mkdtemp( pattern.data() ), nullptr );
        _scratch = pattern;
    }

    void TearDown() override { fs::remove_all( _scratch ); }

    fs::path _scratch;
};

#ifdef MACHPOINT_ENABLE_HDF5

std::string read( const fs::path& file )
{
    std::ifstream in( file );
    return { std::istreambuf_iterator<char>( in ), {} };
}

// Every file below a directory, relative to it.
std::set<std::string> tree( const fs::path& directory )
{
    std::set<std::string> files;
    for ( const auto& entry : fs::recursive_directory_iterator( directory ) )
        if ( !entry.is_directory() )
            files.insert( fs::relative( entry.path(), directory ).string() );
    return files;
}

// Runs something that must throw an IoError and returns its message.
template <class Action>
std::string messageOf( const Action& action )
{
    try
    {
        action();
    }
    catch ( const IoError& error )
    {
        return error.what();
    }
    ADD_FAILURE() << "no IoError was thrown";
    return {};
}

// A dataset or attribute read back: its shape and its values.
template <class T>
struct ReadBack
{
    std::vector<hsize_t> shape;
    std::vector<T> values;
};

template <class T>
hid_t memoryType()
{
    return std::is_same_v<T, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
}

template <class T>
ReadBack<T> sized( hid_t space )
{
    ReadBack<T> result;
    result.shape.resize( H5Sget_simple_extent_ndims( space ) );
    H5Sget_simple_extent_dims( space, result.shape.data(), nullptr );
    result.values.resize( H5Sget_simple_extent_npoints( space ) );
    return result;
}

template <class T>
ReadBack<T> readDataset( const fs::path& path, const std::string& name )
{
    const auto file = H5Fopen( path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT );
    const auto dataset = H5Dopen2( file, name.c_str(), H5P_DEFAULT );
    EXPECT_GE( dataset, 0 ) << path << ":" << name;
    const auto type = H5Dget_type( dataset );
    EXPECT_GT( H5Tequal( type, memoryType<T>() ), 0 ) << name;
    const auto space = H5Dget_space( dataset );
    auto result = sized<T>( space );
    EXPECT_GE( H5Dread( dataset, memoryType<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                        result.values.data() ),
               0 );
    H5Sclose( space );
    H5Tclose( type );
    H5Dclose( dataset );
    H5Fclose( file );
    return result;
}

template <class T>
ReadBack<T> readAttribute( const fs::path& path, const std::string& name )
{
    const auto file = H5Fopen( path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT );
    const auto attribute = H5Aopen( file, name.c_str(), H5P_DEFAULT );
    EXPECT_GE( attribute, 0 ) << path << ":" << name;
    const auto space = H5Aget_space( attribute );
    auto result = sized<T>( space );
    EXPECT_GE( H5Aread( attribute, memoryType<T>(), result.values.data() ), 0 );
    H5Sclose( space );
    H5Aclose( attribute );
    H5Fclose( file );
    return result;
}

// 0, 1, 2, ...: every element tells where it stands.
std::vector<double> ramp( std::size_t count )
{
    std::vector<double> values( count );
    std::iota( values.begin(), values.end(), 0.0 );
    return values;
}

void writeSmallRun( OutputDirectory& output, std::size_t dim )
{
    const auto values = ramp( 24 * dim );
    const std::vector<std::size_t> nodes( dim, 2 );
    for ( std::int64_t step : { 0, 12 } )
    {
        output.writeParticles( step, 0.125 * step,
                               { { "position", { 8, dim }, values.data() },
                                 { "velocity", { 8, dim }, values.data() },
                                 { "density", { 8 }, values.data() } } );
        output.writeGrid( step, 0.125 * step, std::vector( dim, 0.0 ),
                          std::vector( dim, 1.0 ),
                          { { "density", nodes, values.data() } } );
    }
    output.writeExact( 12, 1.2, { { "position", { 4 }, values.data() } } );
    output.writeSeries( "series/cylinder.csv", { "time", "force_x" },
                        { { 0.5, 0.1 } } );
    output.writeSummary( "{}\n" );
}

const std::set<std::string> small_run = {
    "particles/00000000.h5", "particles/00000012.h5",
    "grid/00000000.h5",      "grid/00000012.h5",
    "exact/00000012.h5",     "series/cylinder.csv",
    "particles.xdmf",        "grid.xdmf",
    "summary.json" };

//---------------------------------------------------------------------------//

TEST_F( Output, WritesExactlyTheFilesOfTheLayout )
{
    OutputDirectory output( _scratch / "a" / "run", FormerRun::refuse, 2 );
    EXPECT_EQ( tree( output.path() ), std::set<std::string>{} );
    writeSmallRun( output, 2 );
    EXPECT_EQ( tree( output.path() ), small_run );
}

TEST_F( Output, ParticlesComeBackWithShapesTypesAndAttributes )
{
    for ( std::size_t dim : { 1, 2, 3 } )
    {
        const auto directory = _scratch / std::to_string( dim );
        OutputDirectory output( directory, FormerRun::refuse,
                                static_cast<int>( dim ) );
        const std::size_t n = 5;
        const auto position = ramp( n * dim );
        // Beyond 2^53, where a double would lose it.
        const std::vector<std::int64_t> id = { 0, 1, -7, 3, ( 1ll << 53 ) + 1 };
        output.writeParticles(
            42, 0.1,
            { { "position", { n, dim }, position.data() },
              { "id", { n }, id.data(), Dataset::Type::integer } } );

        const auto file = directory / "particles" / "00000042.h5";
        const auto x = readDataset<double>( file, "position" );
        EXPECT_EQ( x.shape, ( std::vector<hsize_t>{ n, dim } ) );
        EXPECT_EQ( x.values, position );
        const auto ids = readDataset<std::int64_t>( file, "id" );
        EXPECT_EQ( ids.shape, ( std::vector<hsize_t>{ n } ) );
        EXPECT_EQ( ids.values, id );
        const auto time = readAttribute<double>( file, "time" );
        EXPECT_TRUE( time.shape.empty() );
        EXPECT_EQ( time.values, std::vector{ 0.1 } );
        const auto step = readAttribute<std::int64_t>( file, "step" );
        EXPECT_TRUE( step.shape.empty() );
        EXPECT_EQ( step.values, std::vector<std::int64_t>{ 42 } );
    }
}

TEST_F( Output, PointsOfALineGetAZeroBesideEach )
{
    OutputDirectory output( _scratch, FormerRun::refuse, 1 );
    const auto position = ramp( 3 );
    output.writeParticles( 0, 0.0,
                           { { "position", { 3, 1 }, position.data() } } );
    const auto points = readDataset<double>(
        _scratch / "particles" / "00000000.h5", "xdmf/position" );
    EXPECT_EQ( points.shape, ( std::vector<hsize_t>{ 3, 2 } ) );
    EXPECT_EQ( points.values, ( std::vector{ 0.0, 0.0, 1.0, 0.0, 2.0, 0.0 } ) );
}

TEST_F( Output, GridComesBackWithItsGeometry )
{
    OutputDirectory output( _scratch, FormerRun::refuse, 3 );
    const auto values = ramp( 2 * 3 * 4 * 3 );
    output.writeGrid( 7, 0.5, { 1.0, 2.0, 3.0 }, { 0.1, 0.2, 0.3 },
                      { { "density", { 2, 3, 4 }, values.data() },
                        { "velocity", { 2, 3, 4, 3 }, values.data() } } );

    const auto file = _scratch / "grid" / "00000007.h5";
    const auto density = readDataset<double>( file, "density" );
    EXPECT_EQ( density.shape, ( std::vector<hsize_t>{ 2, 3, 4 } ) );
    EXPECT_EQ( density.values, ramp( 2 * 3 * 4 ) );
    const auto velocity = readDataset<double>( file, "velocity" );
    EXPECT_EQ( velocity.shape, ( std::vector<hsize_t>{ 2, 3, 4, 3 } ) );
    EXPECT_EQ( velocity.values, values );
    EXPECT_EQ( readAttribute<double>( file, "lower" ).values,
               ( std::vector{ 1.0, 2.0, 3.0 } ) );
    EXPECT_EQ( readAttribute<double>( file, "spacing" ).values,
               ( std::vector{ 0.1, 0.2, 0.3 } ) );
    EXPECT_EQ( readAttribute<double>( file, "time" ).values,
               std::vector{ 0.5 } );
    EXPECT_EQ( readAttribute<std::int64_t>( file, "step" ).values,
               std::vector<std::int64_t>{ 7 } );
}

// HDF5 would note when each object was made, in seconds.
TEST_F( Output, RunsThatAreAlikeLeaveTheSameBytes )
{
    for ( const int compression : { 0, 4 } )
    {
        std::map<std::string, std::string> first;
        for ( const char* name : { "a", "b" } )
        {
            const auto folder = _scratch / std::to_string( compression ) / name;
            OutputDirectory output( folder, FormerRun::refuse, 2, true,
                                    compression );
            writeSmallRun( output, 2 );
            for ( const auto& file : tree( folder ) )
                if ( *name == 'a' )
                    first[file] = read( folder / file );
                else
                    EXPECT_TRUE( first[file] == read( folder / file ) ) << file;
            if ( *name == 'a' )
                std::this_thread::sleep_for(
                    std::chrono::milliseconds( 1100 ) );
        }
    }
}

TEST_F( Output, CompressionKeepsValuesAndSavesRoom )
{
    const std::size_t n = 100000;
    const auto position = ramp( 2 * n );
    const auto raw = 2 * n * sizeof( double );
    std::vector<std::size_t> sizes;
    for ( const int compression : { 0, 1, 9 } )
    {
        OutputDirectory output( _scratch, FormerRun::replace, 2, true,
                                compression );
        output.writeParticles( 0, 0.0,
                               { { "position", { n, 2 }, position.data() } } );
        const auto file = _scratch / "particles" / "00000000.h5";
        EXPECT_EQ( readDataset<double>( file, "position" ).values, position );
        sizes.push_back( fs::file_size( file ) );
    }
    EXPECT_LT( sizes[0], raw + 4096 ); // nothing beside the data but headers
    EXPECT_LT( sizes[1], raw / 2 );    // numbers in order compress well
    EXPECT_LE( sizes[2], sizes[1] );
}

TEST_F( Output, ARunWithoutParticlesIsWritten )
{
    OutputDirectory output( _scratch, FormerRun::refuse, 2 );
    output.writeParticles( 0, 0.0, { { "position", { 0, 2 } } } );
    const auto x = readDataset<double>( _scratch / "particles" / "00000000.h5",
                                        "position" );
    EXPECT_EQ( x.shape, ( std::vector<hsize_t>{ 0, 2 } ) );
}

TEST_F( Output, SeriesKeepsEveryDigit )
{
    OutputDirectory output( _scratch, FormerRun::refuse, 2 );
    output.writeSeries( "series/wing.csv", { "time", "force_x" },
                        { { 0.1, 1.0 / 3.0 }, { 0.2, -1e-300 } } );
    std::istringstream table( read( _scratch / "series" / "wing.csv" ) );
    std::string line;
    std::getline( table, line );
    EXPECT_EQ( line, "time,force_x" );
    double time, force;
    char comma;
    ASSERT_TRUE( table >> time >> comma >> force );
    EXPECT_EQ( time, 0.1 );
    EXPECT_EQ( force, 1.0 / 3.0 );
    ASSERT_TRUE( table >> time >> comma >> force );
    EXPECT_EQ( force, -1e-300 );
}

TEST_F( Output, DataThatDoesNotFitTheLayoutIsRefused )
{
    OutputDirectory output( _scratch, FormerRun::refuse, 2 );
    const auto values = ramp( 100 );
    const Dataset position = { "position", { 4, 2 }, values.data() };
    const auto particles = [&]( std::vector<Dataset> datasets )
    { output.writeParticles( 0, 0.0, datasets ); };
    const auto grid = [&]( std::vector<double> lower,
                           std::vector<Dataset> datasets ) {
        output.writeGrid( 0, 0.0, lower, { 1.0, 1.0 }, datasets );
    };

    EXPECT_THROW( particles( {} ), std::invalid_argument );
    EXPECT_THROW( particles( { { "position", { 4, 3 }, values.data() } } ),
                  std::invalid_argument );
    EXPECT_THROW( particles( { position, { "mass", { 5 }, values.data() } } ),
                  std::invalid_argument );
    EXPECT_THROW( grid( { 0.0, 0.0 }, {} ), std::invalid_argument );
    EXPECT_THROW( grid( { 0.0 }, { { "density", { 4, 4 }, values.data() } } ),
                  std::invalid_argument );
    EXPECT_THROW(
        grid( { 0.0, 0.0 }, { { "density", { 4, 4 }, values.data() },
                              { "velocity", { 4, 4, 3 }, values.data() } } ),
        std::invalid_argument );
    EXPECT_THROW( output.writeSeries( "../cylinder.csv", {}, {} ),
                  std::invalid_argument );
    EXPECT_THROW( output.writeSeries( "series/a.csv", { "time" }, { {} } ),
                  std::invalid_argument );
    EXPECT_EQ( tree( _scratch ), std::set<std::string>{} );
}

//---------------------------------------------------------------------------//

TEST_F( Output, AnotherRunIsRefusedAndLeftAlone )
{
    // Either sign of a run is enough: a killed one has no summary yet.
    for ( const std::string sign : { "summary.json", "particles/", "grid/" } )
    {
        const auto directory = _scratch / ( "run_" + sign.substr( 0, 4 ) );
        fs::create_directory( directory );
        if ( sign.back() == '/' )
            fs::create_directory( directory / sign );
        else
            std::ofstream( directory / sign ) << "former";
        const auto before = tree( directory );
        const auto message = messageOf(
            [&] { OutputDirectory( directory, FormerRun::refuse, 1 ); } );
        EXPECT_NE( message.find( directory.string() ), std::string::npos );
        EXPECT_NE( message.find( "--overwrite" ), std::string::npos );
        EXPECT_EQ( tree( directory ), before );
    }
}

TEST_F( Output, ADirectoryWithOtherThingsIsTaken )
{
    std::ofstream( _scratch / "notes.txt" ) << "mine";
    OutputDirectory output( _scratch, FormerRun::refuse, 2 );
    EXPECT_EQ( tree( _scratch ), std::set<std::string>{ "notes.txt" } );
}

TEST_F( Output, OverwriteRemovesWhatARunWroteAndNothingElse )
{
    {
        OutputDirectory output( _scratch, FormerRun::refuse, 2 );
        writeSmallRun( output, 2 );
    }
    const std::set<std::string> foreign = {
        "notes.txt",           "particles/notes.h5", "particles/00000003.txt",
        "grid/12.h5",          "series/sub/a.csv",   "my.xdmf",
        "checkpoints/0001.h5", "photograph.png" };
    const std::set<std::string> ours = { "profiles.png", "movie.mp4",
                                         "particles/00000099.h5.tmp",
                                         "summary.json.tmp" };
    for ( const auto& files : { foreign, ours } )
        for ( const auto& file : files )
        {
            fs::create_directories( ( _scratch / file ).parent_path() );
            std::ofstream( _scratch / file ) << file;
        }

    OutputDirectory output( _scratch, FormerRun::replace, 2 );
    EXPECT_EQ( tree( _scratch ), foreign );
    EXPECT_FALSE( fs::exists( _scratch / "exact" ) );
    EXPECT_EQ( read( _scratch / "particles/notes.h5" ), "particles/notes.h5" );

    writeSmallRun( output, 2 );
    auto both = foreign;
    both.insert( small_run.begin(), small_run.end() );
    EXPECT_EQ( tree( _scratch ), both );
}

TEST_F( Output, TwoRunsDoNotShareADirectory )
{
    for ( const auto former : { FormerRun::replace, FormerRun::go_on } )
    {
        {
            OutputDirectory output( _scratch, FormerRun::replace, 2 );
            writeSmallRun( output, 2 );
            const auto message =
                messageOf( [&] { OutputDirectory( _scratch, former, 2 ); } );
            EXPECT_NE( message.find( _scratch.string() ), std::string::npos );
            EXPECT_NE( message.find( "is writing there" ), std::string::npos )
                << message;
            EXPECT_EQ( tree( _scratch ), small_run );
        }
        // It is free again.
        OutputDirectory( _scratch, FormerRun::replace, 2 );
        EXPECT_EQ( tree( _scratch ), std::set<std::string>() );
    }
}

TEST_F( Output, APathBelowAFileIsAnError )
{
    std::ofstream( _scratch / "file" ) << "mine";
    for ( const auto& path : { _scratch / "file", _scratch / "file" / "run" } )
        for ( const auto former : { FormerRun::refuse, FormerRun::replace } )
        {
            const auto message =
                messageOf( [&] { OutputDirectory( path, former, 1 ); } );
            EXPECT_NE( message.find( path.string() ), std::string::npos );
            EXPECT_NE( message.find( std::strerror( ENOTDIR ) ),
                       std::string::npos )
                << message;
            EXPECT_NE( message.find( "--output" ), std::string::npos );
        }
    EXPECT_EQ( read( _scratch / "file" ), "mine" );
}

TEST_F( Output, AnUnwritableDirectoryIsAnErrorBeforeTheRun )
{
    if ( ::geteuid() == 0 )
        GTEST_SKIP() << "root may write to every directory";
    fs::permissions( _scratch, fs::perms::owner_read | fs::perms::owner_exec );
    const auto message =
        messageOf( [&] { OutputDirectory( _scratch, FormerRun::refuse, 1 ); } );
    fs::permissions( _scratch, fs::perms::owner_all );
    EXPECT_NE( message.find( std::strerror( EACCES ) ), std::string::npos )
        << message;
}

//---------------------------------------------------------------------------//

// Many outputs do not cost their number squared: the list of them is not
// written anew for each, but complete in the end.
TEST_F( Output, TheListOfManyOutputsLagsByAHundredth )
{
    const double x = 0.5;
    OutputDirectory output( _scratch, FormerRun::refuse, 1 );
    const auto listed = [&]
    {
        const auto text = read( _scratch / "particles.xdmf" );
        int count = 0;
        for ( auto at = text.find( "<Time" ); at != std::string::npos;
              at = text.find( "<Time", at + 1 ) )
            ++count;
        return count;
    };
    int renewed = 0, before = 0;
    for ( int step = 1; step <= 300; ++step )
    {
        output.writeParticles(
            step, step,
            { { "position", { 1, 1 }, &x }, { "mass", { 1 }, &x } } );
        const int now = listed();
        EXPECT_GE( now, step - step / 100 );
        renewed += now != before ? 1 : 0;
        before = now;
    }
    EXPECT_LT( renewed, 250 );
    output.writeSummary( "{}" );
    EXPECT_EQ( listed(), 300 );
}

TEST_F( Output, AFullDiskLeavesNoTraceWhereverItStrikes )
{
    const auto values = ramp( 600 );
    const auto write = [&]( OutputDirectory& output, std::int64_t step )
    {
        output.writeParticles( step, 0.0,
                               { { "position", { 300, 2 }, values.data() },
                                 { "mass", { 300 }, values.data() } } );
    };
    OutputDirectory output( _scratch, FormerRun::refuse, 2 );
    write( output, 0 );
    const auto whole = tree( _scratch );
    const auto collection = read( _scratch / "particles.xdmf" );
    const auto size = fs::file_size( _scratch / "particles" / "00000000.h5" );

    // The header, the data, the closing metadata: each gets its failure.
    for ( rlim_t bytes = 0; bytes < size; bytes += 128 )
    {
        const auto message = messageOf(
            [&]
            {
                const FileSizeLimit limit( bytes );
                write( output, 1 );
            } );
        EXPECT_NE( message.find( "particles/00000001.h5:" ), std::string::npos )
            << message;
        EXPECT_NE( message.find( std::strerror( EFBIG ) ), std::string::npos )
            << bytes << " bytes: " << message;
        EXPECT_NE( message.find( "free some space" ), std::string::npos );
        ASSERT_EQ( tree( _scratch ), whole );
    }
    EXPECT_EQ( read( _scratch / "particles.xdmf" ), collection );

    // The same run goes on once there is room.
    write( output, 1 );
    EXPECT_EQ( readDataset<double>( _scratch / "particles" / "00000001.h5",
                                    "position" )
                   .values,
               values );
}

// HDF5 has it open then, and closes it only where what it still has to write
// gets the room that emptying gives back.
TEST_F( Output, AFileThatGetsNoRoomStaysToBeEmptied )
{
    const auto target = _scratch / "large.h5";
    const auto temporary = Machpoint::temporaryName( target );
    std::ofstream( temporary ) << "what HDF5 has written";
    constexpr auto exbibyte = std::size_t{ 1 } << 60;
    try
    {
        Machpoint::reserveFile( target, exbibyte );
        GTEST_SKIP() << "this file system cannot reserve room";
    }
    catch ( const IoError& )
    {
    }
    ASSERT_TRUE( fs::exists( temporary ) );
    Machpoint::emptyTemporary( target );
    EXPECT_EQ( fs::file_size( temporary ), 0u );
    Machpoint::dropTemporary( target );
    EXPECT_TRUE( fs::is_empty( _scratch ) );
}

TEST_F( Output, AFullDiskKeepsTheFormerText )
{
    OutputDirectory output( _scratch, FormerRun::refuse, 1 );
    output.writeSummary( "former" );
    const FileSizeLimit limit( 8 );
    messageOf( [&] { output.writeSummary( "longer than eight bytes" ); } );
    EXPECT_EQ( read( _scratch / "summary.json" ), "former" );
    EXPECT_EQ( tree( _scratch ), std::set<std::string>{ "summary.json" } );
}

//---------------------------------------------------------------------------//

struct Element
{
    std::string name;
    std::map<std::string, std::string> attributes;
    std::string text; // what follows the start tag, up to the next tag
};

// Reads as much XML as XDMF uses (no comments, no entities) and checks that
// the elements nest.
std::vector<Element> readElements( const std::string& xml )
{
    std::vector<Element> elements;
    std::vector<std::string> open;
    for ( auto begin = xml.find( '<' ); begin != std::string::npos; )
    {
        const auto end = xml.find( '>', begin );
        const auto next = xml.find( '<', begin + 1 );
        EXPECT_LT( end, next ) << "a tag that does not end";
        auto tag = xml.substr( begin + 1, end - begin - 1 );
        if ( tag.front() == '/' )
        {
            EXPECT_TRUE( !open.empty() && open.back() == tag.substr( 1 ) )
                << tag;
            if ( !open.empty() )
                open.pop_back();
        }
        else if ( tag.front() != '?' )
        {
            const bool is_empty = tag.back() == '/';
            if ( is_empty )
                tag.pop_back();
            Element element;
            std::istringstream words( tag );
            words >> element.name >> std::ws;
            std::string key, value;
            while ( std::getline( words, key, '=' ) && words.get() == '"' &&
                    std::getline( words, value, '"' ) )
            {
                element.attributes[key] = value;
                words >> std::ws;
            }
            EXPECT_TRUE( words.eof() ) << tag;
            element.text = xml.substr( end + 1, next - end - 1 );
            if ( !is_empty )
                open.push_back( element.name );
            elements.push_back( element );
        }
        begin = next;
    }
    EXPECT_TRUE( open.empty() );
    return elements;
}

TEST_F( Output, XdmfNamesEveryTimeAndOnlyDatasetsThatExist )
{
    for ( std::size_t dim : { 1, 2, 3 } )
    {
        const auto directory = _scratch / std::to_string( dim );
        OutputDirectory output( directory, FormerRun::refuse,
                                static_cast<int>( dim ) );
        writeSmallRun( output, dim );
        for ( const std::string kind : { "particles", "grid" } )
        {
            std::vector<std::string> times;
            std::map<std::string, int> references;
            for ( auto& element :
                  readElements( read( directory / ( kind + ".xdmf" ) ) ) )
            {
                if ( element.name == "Time" )
                    times.push_back( element.attributes["Value"] );
                if ( element.attributes["Format"] != "HDF" )
                    continue;

                // Dimensions may add flat axes, but must hold as many numbers
                // as the dataset has.
                std::istringstream extents( element.attributes["Dimensions"] );
                std::size_t size = 1;
                for ( std::size_t extent; extents >> extent; )
                    size *= extent;
                const auto colon = element.text.find( ':' );
                const auto file = element.text.substr( 0, colon );
                const auto dataset = element.text.substr( colon + 1 );
                const auto data =
                    readDataset<double>( directory / file, dataset );
                EXPECT_EQ( data.values.size(), size ) << element.text;
                ++references[dataset];
            }
            EXPECT_EQ( times, ( std::vector<std::string>{ "0", "1.5" } ) );
            const std::string points =
                dim == 1 ? "/xdmf/position" : "/position";
            const std::map<std::string, int> expected =
                kind == "grid"
                    ? std::map<std::string, int>{ { "/density", 2 } }
                    : std::map<std::string, int>{ { points, 2 },
                                                  { "/velocity", 2 },
                                                  { "/density", 2 } };
            EXPECT_EQ( references, expected );
        }
    }
}

#else

TEST_F( Output, ABuildWithoutHdf5SaysSo )
{
    try
    {
        OutputDirectory output( _scratch / "run", FormerRun::refuse, 1 );
        FAIL() << "no IoError was thrown";
    }
    catch ( const IoError& error )
    {
        EXPECT_NE( std::string( error.what() ).find( "HDF5" ),
                   std::string::npos );
        EXPECT_NE( std::string( error.what() ).find( "Machpoint_ENABLE_HDF5" ),
                   std::string::npos );
    }
    EXPECT_FALSE( fs::exists( _scratch / "run" ) );
}

#endif

} // end anonymous namespace
