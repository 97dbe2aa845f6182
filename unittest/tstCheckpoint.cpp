// Checkpoints: a run that is read back goes on as if nothing had happened, and
// a file that does not belong is refused.
#include "file_size_limit.hpp"
#include "rows.hpp"
#include "scenes.hpp"

#include <core/checkpoint.hpp>
#include <core/hdf5_file.hpp>
#include <core/random.hpp>
#include <core/registry.hpp>
#include <core/series.hpp>

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <tuple>

#include <unistd.h>

namespace
{

using namespace Machpoint;
using namespace Test;

constexpr std::int64_t first_made_id = std::int64_t( 1 ) << 60;

//! A gas with a shock in a closed box, or a stream around a body; in 2D around
//! two balls that touch, where images leave a gap.
Json scene( const std::string& method, const int dimension, const bool is_open )
{
    Json input;
    if ( is_open )
    {
        const Json ball = { { "type", "sphere" },
                            { "center", repeat( dimension, 0.5 ) },
                            { "radius", 0.15 } };
        auto other = ball;
        other["center"].back() = 0.2;
        input = streamPast(
            dimension == 1
                ? ball
                : Json{ { "type", "union" }, { "shapes", { ball, other } } },
            dimension, dimension == 1 ? 60 : 24, 6, method, "quadratic" );
    }
    else
        input = shockTube( dimension, dimension == 1 ? 60 : 20, 2, method,
                           "quadratic" );
    input["particles"]["placement"] = "random";
    addViscosity( input );
    input["physics"].push_back(
        { { "type", "viscosity" }, { "shear", 1e-4 } } );
    input["physics"].push_back(
        { { "type", "heat_conduction" }, { "conductivity", 1e-4 } } );
    if ( method == "conservative" )
    {
        input["method"]["split_volume"] = 0.4;
        input["method"]["merge_volume"] = 0.4;
    }
    return input;
}

//! An entry with its rows at hand, to be kept, compared and changed.
struct Kept
{
    std::vector<std::size_t> shape;
    std::variant<std::vector<float>, std::vector<double>,
                 std::vector<std::int64_t>, std::string>
        values;
    bool is_distributed = false;

    bool operator==( const Kept& other ) const
    {
        return shape == other.shape && is_distributed == other.is_distributed &&
               sameBits( other );
    }

  private:
    bool sameBits( const Kept& other ) const
    {
        return std::visit(
            [&]( const auto& values )
            {
                using List = std::decay_t<decltype( values )>;
                const auto* list = std::get_if<List>( &other.values );
                return list && values.size() == list->size() &&
                       std::memcmp( values.data(), list->data(),
                                    values.size() * sizeof( values[0] ) ) == 0;
            },
            this->values );
    }
};
using Entries = std::map<std::string, Kept>;

template <class T>
Kept kept( const std::vector<std::size_t>&, const Rows<T>& rows )
{
    return { { rows.count, rows.columns }, listOf( rows ), true };
}
template <class Values>
Kept kept( const std::vector<std::size_t>& shape, const Values& values )
{
    return { shape, values };
}

Entries kept( const Archive& archive )
{
    Entries entries;
    for ( const auto& [name, entry] : archive.entries() )
        entries[name] = std::visit( [&]( const auto& values )
                                    { return kept( entry.shape, values ); },
                                    entry.values );
    return entries;
}

//! For reading; the entries must outlive it.
Archive archiveOf( const Entries& entries )
{
    Archive::Entries list;
    for ( const auto& [name, entry] : entries )
        std::visit(
            [&]<class Values>( const Values& values )
            {
                auto& made = list[name];
                if constexpr ( !std::is_same_v<Values, std::string> )
                    if ( entry.is_distributed )
                    {
                        made.values = rowsOf( values, entry.shape.at( 1 ) );
                        return;
                    }
                made = { entry.shape, values };
            },
            entry.values );
    return Archive( std::move( list ) );
}

Entries save( Simulation& simulation )
{
    Archive archive;
    simulation.checkpoint( archive );
    return kept( archive );
}

void load( Simulation& simulation, const Entries& entries )
{
    auto archive = archiveOf( entries );
    simulation.checkpoint( archive );
    EXPECT_TRUE( archive.entries().empty() ) << "entries that nobody read";
}

//! Names of the entries that differ in any bit.
std::vector<std::string> differences( const Entries& a, const Entries& b )
{
    std::vector<std::string> names;
    for ( const auto& [name, entry] : a )
        if ( !b.contains( name ) || !( b.at( name ) == entry ) )
            names.push_back( name );
    for ( const auto& [name, entry] : b )
        if ( !a.contains( name ) )
            names.push_back( name );
    return names;
}

template <class T>
const std::vector<T>& values( const Entries& entries, const std::string& name )
{
    return std::get<std::vector<T>>( entries.at( name ).values );
}

const std::vector<std::string> none;

class AnyScene
    : public testing::TestWithParam<std::tuple<std::string, int, bool>>
{
  protected:
    Json input() const
    {
        const auto& [method, dimension, is_open] = GetParam();
        return scene( method, dimension, is_open );
    }
};

//! Threads and devices add in an order of their own. CMakeLists.txt names the
//! tests that ask for this, to run them on one thread.
bool repeatsExactly()
{
    return ExecutionSpace().concurrency() == 1;
}

// Nothing that a module or the time loop carries is forgotten.
TEST_P( AnyScene, goesOnAlike )
{
    if ( !repeatsExactly() )
        GTEST_SKIP() << "sums repeat exactly on one thread alone";
    constexpr int half = 43; // between two sorts, and two merges
    auto whole = simulate( input() );
    advance( *whole, half );
    const auto middle = save( *whole );
    advance( *whole, half );
    const auto end = save( *whole );
    EXPECT_NE( differences( middle, end ), none );

    auto second = simulate( input() );
    load( *second, middle );
    EXPECT_EQ( second->steps(), half );
    advance( *second, half );
    EXPECT_EQ( differences( save( *second ), end ), none );
}

// So also on threads and devices.
TEST_P( AnyScene, isReadAsItWasWritten )
{
    auto first = simulate( input() );
    advance( *first, 12 );
    const auto written = save( *first );
    auto second = simulate( input() );
    EXPECT_NE( differences( save( *second ), written ), none );
    load( *second, written );
    EXPECT_EQ( differences( save( *second ), written ), none );
    EXPECT_EQ( second->particles(), first->particles() );
    EXPECT_EQ( second->limiter(), first->limiter() );
    EXPECT_EQ( second->totals().mass, first->totals().mass );
    EXPECT_EQ( second->ledger().mass_in, first->ledger().mass_in );
    EXPECT_EQ( second->extrema().max_mach, first->extrema().max_mach );
}

INSTANTIATE_TEST_SUITE_P(
    Each, AnyScene,
    testing::Combine( testing::Values( "paper", "apic", "conservative" ),
                      testing::Values( 1, 2 ), testing::Bool() ),
    []( const auto& info )
    {
        return fmt::format( "{}{}D{}", std::get<0>( info.param ),
                            std::get<1>( info.param ),
                            std::get<2>( info.param ) ? "open" : "closed" );
    } );

// The scenes above would not tell much if particles stayed what they are.
TEST( Checkpoint, scenesEnterLeaveSplitAndMerge )
{
    auto run = simulate( scene( "conservative", 2, true ) );
    const auto start = save( *run );
    advance( *run, 43 );
    const auto end = save( *run );
    EXPECT_GT( values<std::int64_t>( end, "next_id" )[0], first_made_id );
    EXPECT_GT( run->ledger().mass_in, 0 );
    EXPECT_GT( run->ledger().mass_out, 0 );
    EXPECT_EQ( values<double>( end, "modules/4 obstacle body/series" ).size(),
               43u * 4 );
    // Heavier than any of the start: merged.
    auto heaviest = []( const Entries& entries )
    {
        const auto& mass = values<Real>( entries, "particles/mass" );
        return *std::max_element( mass.begin(), mass.end() );
    };
    EXPECT_GT( heaviest( end ), 1.01 * heaviest( start ) );
}

// What the equality of goesOnAlike rests on: a wrong value shows.
TEST( Checkpoint, everyValueCounts )
{
    if ( !repeatsExactly() )
        GTEST_SKIP() << "sums repeat exactly on one thread alone";
    const auto input = scene( "conservative", 2, true );
    auto run = simulate( input );
    advance( *run, 25 ); // the next step tracks how particles are stretched
    const auto middle = save( *run );
    advance( *run, 20 );
    const auto end = save( *run );
    auto expectDifference = [&]( const Entries& wrong, const std::string& name )
    {
        auto second = simulate( input );
        load( *second, wrong );
        advance( *second, 20 );
        EXPECT_NE( differences( save( *second ), end ), none ) << name;
    };
    for ( const std::string name :
          { "time", "time_step", "extrema/max_mach",
            "modules/5 inflow x_lower/advanced", "particles/volume",
            "particles/velocity_gradient", "particles/Machpoint::drift/1",
            "particles/Machpoint::history/0" } )
    {
        auto wrong = middle;
        std::visit(
            [&, factor = name == "extrema/max_mach" ? 100 : 1.01]( auto& list )
            {
                for ( auto& value : list )
                    value *= factor;
            },
            wrong.at( name ).values );
        expectDifference( wrong, name );
    }
    auto wrong = middle;
    auto& mass_in = wrong.at( "ledger/mass_in" ).values;
    ++std::get<std::vector<std::int64_t>>( mass_in )[0];
    expectDifference( wrong, "ledger/mass_in" );
}

//! Counts what happens to each particle, and breaks the gas once in a while.
template <int Dim>
class StepCounter : public Module<Dim>
{
    using Members = Cabana::MemberTypes<Real, std::int64_t>;

  public:
    static constexpr const char* name = "step_counter";

    static Parameters declare( const int dimension )
    {
        return Parameters( name, "counts steps", dimension );
    }
    explicit StepCounter( const Json& ) {}
    void initialize( State<Dim>& state ) override
    {
        _counts = &state.particles.template addSidecar<Members>(
            "test::count", DuringStep::edits );
    }
    bool particleSource( State<Dim>& state ) override
    {
        const auto real = Cabana::slice<0>( _counts->data() );
        const auto whole = Cabana::slice<1>( _counts->data() );
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const bool breaks = state.step % 4 == 2 && !_was_rejected;
        forEach(
            "countStep", state.particles.size(),
            MACHPOINT_LAMBDA( const int p ) {
                real( p ) += 1;
                whole( p ) += 1;
                if ( breaks )
                    e( p ) = -1;
            } );
        _was_rejected = false;
        return true;
    }
    void rejectStep( State<Dim>& ) override { _was_rejected = true; }

  private:
    Sidecar<Members>* _counts = nullptr;
    bool _was_rejected = false;
};

// A sidecar that a module edits knows nothing of steps that were taken back,
// whether particles halve and merge, and whether the run begins anew.
TEST( Checkpoint, editedSidecarsCountEachStepOnce )
{
    registerPhysics<StepCounter>();
    auto input = scene( "conservative", 1, false );
    input["physics"].push_back( { { "type", "step_counter" } } );
    auto run = simulate( input );
    advance( *run, 10 );
    auto second = simulate( input );
    load( *second, save( *run ) );
    advance( *second, 33 );
    EXPECT_GE( second->retries(), 10 );
    const auto entries = save( *second );
    const auto& mass = values<Real>( entries, "particles/mass" );
    EXPECT_NE( *std::min_element( mass.begin(), mass.end() ),
               *std::max_element( mass.begin(), mass.end() ) );
    for ( const Real count :
          values<Real>( entries, "particles/test::count/0" ) )
        EXPECT_EQ( count, 43 );
    for ( const auto count :
          values<std::int64_t>( entries, "particles/test::count/1" ) )
        EXPECT_EQ( count, 43 );
}

// A step that breaks the gas right after a restart has a state to return to.
TEST( Checkpoint, failuresReturnToTheStateThatWasRead )
{
    const auto input = scene( "conservative", 1, false );
    auto run = simulate( input );
    advance( *run, 5 );
    auto entries = save( *run );
    std::get<std::vector<Real>>( entries.at( "particles/volume" ).values )[0] =
        -1;
    auto second = simulate( input );
    load( *second, entries );
    EXPECT_THROW( second->step( 1e9 ), NumericalFailure );
    EXPECT_EQ( second->particles(), run->particles() );
    EXPECT_EQ( second->steps(), 5 );
}

// A module's mistake must end in a message, not in memory that is nobody's.
TEST( Checkpoint, seriesWhoseRowsDoNotFitAreRefused )
{
    auto columns = []( const std::size_t count )
    { return std::vector<std::string>( count, "x" ); };
    for ( const std::size_t count : { 0, 2, 3, 4 } )
    {
        Series series{ "wing", columns( count ), { { 1, 2, 3 }, { 4, 5, 6 } } };
        Archive archive;
        if ( count != 3 )
        {
            EXPECT_THROW( series.checkpoint( archive ), std::logic_error );
            continue;
        }
        series.checkpoint( archive );
        EXPECT_EQ( series.rows.size(), 2 );
        Series read{ "wing", columns( count ), {} };
        Archive reading( archive.entries() );
        read.checkpoint( reading );
        EXPECT_EQ( read.rows, series.rows );
    }
    std::vector<double> values( 3 );
    Archive archive;
    EXPECT_THROW( archive.table( "odd", values, 2 ), std::logic_error );
    EXPECT_THROW( archive.table( "none", values, 0 ), std::logic_error );
}

TEST( Checkpoint, archivesRefuseWhatDoesNotFit )
{
    auto run = simulate( scene( "conservative", 2, true ) );
    advance( *run, 3 );
    const auto good = save( *run );
    auto refuses = [&]( const Entries& entries )
    {
        auto archive = archiveOf( entries );
        auto second = simulate( scene( "conservative", 2, true ) );
        EXPECT_THROW( second->checkpoint( archive ), ArchiveError );
    };
    for ( const auto& [name, entry] : good )
    {
        auto entries = good;
        entries.erase( name );
        refuses( entries );
    }
    auto entries = good; // a sidecar shorter than the particles
    auto& table = entries.at( "particles/Machpoint::history/1" );
    --table.shape.at( 0 );
    std::get<std::vector<Real>>( table.values ).pop_back();
    refuses( entries );
    entries = good; // a number that is a text
    entries.at( "time" ).values = std::string( "soon" );
    refuses( entries );
    Archive twice;
    Real value = 1;
    twice( "value", value );
    EXPECT_THROW( twice( "value", value ), std::logic_error );
}

// --- Files -------------------------------------------------------------------

#ifdef MACHPOINT_ENABLE_HDF5

namespace fs = std::filesystem;

std::vector<char> bytesOf( const fs::path& file )
{
    std::ifstream stream( file, std::ios::binary );
    return { std::istreambuf_iterator<char>( stream ), {} };
}

void writeBytes( const fs::path& file, const std::vector<char>& bytes )
{
    std::ofstream( file, std::ios::binary )
        .write( bytes.data(), static_cast<std::streamsize>( bytes.size() ) );
}

template <class Error>
std::string messageOf( const fs::path& file, const Json& input )
{
    try
    {
        readCheckpoint( Communicator(), file, input );
    }
    catch ( const Error& error )
    {
        return error.what();
    }
    ADD_FAILURE() << file << " was read";
    return {};
}

//! A folder with the checkpoints of a run, of steps 3 and 6.
class File : public testing::Test
{
  protected:
    File()
        : _input( resolveInput( scene( "conservative", 2, true ), "test" ) ),
          _run( makeSimulation( _input ) )
    {
        for ( auto* file : { &_first, &_second } )
        {
            advance( *_run, 3 );
            Archive archive;
            _run->checkpoint( archive );
            *file = writeCheckpoint( Communicator(), _folder, _input, archive );
        }
    }
    ~File() override { fs::remove_all( _folder ); }

    fs::path _folder = fs::temp_directory_path() /
                       fmt::format( "machpoint_checkpoints_{}", ::getpid() );
    Json _input;
    std::unique_ptr<Simulation> _run;
    fs::path _first, _second;
};

TEST_F( File, holdsTheArchive )
{
    EXPECT_EQ( _second.filename(), "00000006.h5" );
    const auto read = readCheckpoint( Communicator(), _second, _input );
    EXPECT_EQ( differences( kept( read.archive ), save( *_run ) ), none );
    EXPECT_FALSE( read.revision.empty() );
    EXPECT_EQ( std::distance( fs::directory_iterator( _folder ), {} ), 2 );
}

TEST_F( File, truncatedFilesAreRefused )
{
    const auto size = fs::file_size( _second );
    for ( const auto length :
          { size * 9 / 10, size / 2, size / 3, std::uintmax_t( 100 ),
            std::uintmax_t( 8 ), std::uintmax_t( 0 ) } )
    {
        fs::resize_file( _second, length );
        const auto message = messageOf<IoError>( _second, _input );
        EXPECT_NE( message.find( _second.string() ), std::string::npos );
    }
}

// A byte that counts for nothing may change; any other is noticed.
TEST_F( File, damagedFilesAreRefused )
{
    const auto whole = bytesOf( _second );
    const auto expected = save( *_run );
    int refused = 0;
    constexpr int draws = 400;
    for ( int k = 0; k < draws; ++k )
    {
        auto bytes = whole;
        // Half of them where HDF5 keeps its own books.
        const auto room = k % 2 ? bytes.size() : std::size_t( 4096 );
        const auto place = static_cast<std::size_t>(
            uniformRandom( 5, k, 0 ) * static_cast<Real>( room ) );
        bytes[place] = static_cast<char>(
            bytes[place] ^
            static_cast<char>( 1 + 254 * uniformRandom( 5, k, 1 ) ) );
        writeBytes( _second, bytes );
        try
        {
            const auto read = readCheckpoint( Communicator(), _second, _input );
            EXPECT_EQ( differences( kept( read.archive ), expected ), none )
                << "byte " << place;
        }
        catch ( const IoError& )
        {
            ++refused;
        }
        catch ( const InputError& ) // the format's number
        {
            ++refused;
        }
    }
    EXPECT_GT( refused, draws / 3 );
    EXPECT_LT( refused, draws );
    std::vector<char> noise( 20000 );
    for ( std::size_t k = 0; k < noise.size(); ++k )
        noise[k] = static_cast<char>( 255 * uniformRandom( 6, k, 0 ) );
    writeBytes( _second, noise );
    messageOf<IoError>( _second, _input );
}

TEST_F( File, foreignFilesAreRefused )
{
    const std::vector<double> x = { 1, 2 };
    const auto file = _folder / "foreign.h5";
    writeHdf5( Communicator(), file, {}, { { "position", { 2 }, x.data() } } );
    EXPECT_NE( messageOf<IoError>( file, _input ).find( "no checkpoint" ),
               std::string::npos );
    messageOf<IoError>( _folder / "absent.h5", _input );
    messageOf<IoError>( _folder, _input );
}

TEST_F( File, otherFormatsAreRefused )
{
    const std::vector<unsigned char> header = { '{', '}' };
    for ( const std::int64_t format : { 0, 1, 99 } )
    {
        const auto file = _folder / "format.h5";
        writeHdf5(
            Communicator(), file,
            { { "machpoint_checkpoint", {}, &format, Dataset::Type::integer } },
            { { "header", { 2 }, header.data(), Dataset::Type::byte } } );
        EXPECT_NE( messageOf<InputError>( file, _input )
                       .find( fmt::format( "has format {}", format ) ),
                   std::string::npos );
    }
}

TEST_F( File, otherScenesAreRefused )
{
    const std::vector<std::tuple<std::string, Json, std::string>> changes = {
        { "/scene", "other", "/scene is \"other\" here, but \"test\" in" },
        { "/dimension", 3, "/dimension is 3 here, but 2 in" },
        { "/grid/cells/1", 25, "/grid/cells/1 is 25 here, but 24 in" },
        { "/method/basis", "cubic", "/method/basis is \"cubic\" here, but" },
        { "/method/name", "apic", "/method/name is \"apic\" here, but" },
        { "/time/retries", 3, "/time/retries is 3 here, but 10 in" },
        { "/boundary/4/shape/radius", 0.2, "/boundary/4/shape/radius is 0.2" },
        { "/boundary/5", Json::object(), "/boundary/5 is {} here, but absent" },
        { "/physics", Json::array(), "/physics/0 is absent here, but {" },
        { "/exact", Json::object(), "/exact is {} here, but absent" } };
    for ( const auto& [place, value, words] : changes )
    {
        auto other = _input;
        other[Json::json_pointer( place )] = value;
        const auto message = messageOf<InputError>( _second, other );
        EXPECT_NE( message.find( words ), std::string::npos ) << message;
        EXPECT_NE( message.find( _second.string() ), std::string::npos );
        // Older ones are of the same scene.
        EXPECT_THROW( readNewestCheckpoint( Communicator(), _folder, other ),
                      InputError );
    }
}

TEST_F( File, whatIsWrittenAndWhenMayDiffer )
{
    auto other = _input;
    other["time"]["end"] = 7;
    other["output"]["every"] = 0.5;
    other["checkpoint"] = { { "keep", 5 } };
    const auto read = readCheckpoint( Communicator(), _second, other );
    EXPECT_FALSE( read.archive.entries().empty() );
}

TEST_F( File, theNewestThatCanBeReadIsTaken )
{
    const auto newest = [&]
    { return readNewestCheckpoint( Communicator(), _folder, _input ); };
    EXPECT_EQ( newest().file, _second );
    EXPECT_TRUE( newest().complaints.empty() );
    writeBytes( _folder / "notes.h5", {} );
    writeBytes( _folder / "100000000.h5", { 'n', 'o' } ); // of nine digits
    EXPECT_EQ( newest().file, _second );
    fs::resize_file( _second, 1000 );
    const auto read = newest();
    EXPECT_EQ( read.file, _first );
    ASSERT_EQ( read.complaints.size(), 2u );
    EXPECT_NE( read.complaints[1].find( _second.string() ), std::string::npos );
    setAside( read.passed_over );
    removeCheckpointsAfter( _folder, 5 );
    EXPECT_TRUE( fs::exists( _folder / "100000000.h5.unread" ) );
    EXPECT_TRUE( fs::exists( _second.string() + ".unread" ) );
    EXPECT_EQ( newest().file, _first );
    EXPECT_TRUE( newest().passed_over.empty() );
    setAside( read.passed_over ); // are gone
    fs::resize_file( _first, 1000 );
    EXPECT_THROW( newest(), IoError );
    fs::remove_all( _folder );
    EXPECT_THROW( newest(), IoError );
}

// Be the file that fails that of a new step, or one in place of a former.
TEST_F( File, aFullDiskSparesTheFormerOnes )
{
    for ( const int steps : { 0, 3 } )
    {
        const auto whole = bytesOf( _second );
        advance( *_run, steps );
        Archive archive;
        _run->checkpoint( archive );
        const auto write = [&]
        { return writeCheckpoint( Communicator(), _folder, _input, archive ); };
        for ( const auto bytes : { std::size_t( 0 ), whole.size() / 2 } )
        {
            const auto writeToFullDisk = [&]
            {
                const FileSizeLimit limit( bytes );
                write();
            };
            EXPECT_THROW( writeToFullDisk(), IoError );
            EXPECT_EQ( std::distance( fs::directory_iterator( _folder ), {} ),
                       2 ); // and no draft
            EXPECT_TRUE( bytesOf( _second ) == whole );
            const auto newest =
                readNewestCheckpoint( Communicator(), _folder, _input );
            EXPECT_EQ( newest.file, _second );
            EXPECT_TRUE( newest.complaints.empty() );
        }
        // The same once there is room.
        EXPECT_EQ( write(),
                   _folder / fmt::format( "{:08}.h5", _run->steps() ) );
    }
}

TEST_F( File, onlyCheckpointsAreRemoved )
{
    const auto notes = _folder / "notes.h5", draft = _folder / "notes.h5.tmp",
               half = _folder / "00000003.h5.tmp"; // of a run that was killed
    for ( const auto& file : { notes, draft, half } )
        writeBytes( file, {} );
    keepCheckpoints( _folder, 2 );
    EXPECT_TRUE( fs::exists( _first ) );
    keepCheckpoints( _folder, 1 );
    EXPECT_FALSE( fs::exists( _first ) );
    EXPECT_TRUE( fs::exists( _second ) );
    removeCheckpointsAfter( _folder, 6 );
    EXPECT_TRUE( fs::exists( _second ) );
    removeCheckpointsAfter( _folder, 5 );
    EXPECT_FALSE( fs::exists( _second ) );
    EXPECT_FALSE( fs::exists( half ) );
    EXPECT_TRUE( fs::exists( notes ) );
    EXPECT_TRUE( fs::exists( draft ) );
}

#endif

} // namespace
