#include <core/checkpoint.hpp>

#include <core/hdf5_file.hpp>
#include <core/random.hpp>
#include <core/revision.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

// --- Checksum ----------------------------------------------------------------

std::uint64_t word( const Real value )
{
    return std::bit_cast<std::uint64_t>( value );
}
std::uint64_t word( const std::int64_t value )
{
    return static_cast<std::uint64_t>( value );
}
std::uint64_t word( const char value )
{
    return static_cast<unsigned char>( value );
}

//! Of part of an array: a sum over its elements, so that ranks can share it.
//! \param first number of the part's first element within the array
template <class List>
std::uint64_t checksum( const std::string& name, const List& values,
                        const std::uint64_t first )
{
    std::uint64_t place = 0;
    for ( const char letter : name )
        place = mixBits( place ^ word( letter ) );
    place += first;
    std::uint64_t sum = 0;
    for ( const auto& value : values )
        sum += mixBits( word( value ) ^ mixBits( place++ ) );
    return sum;
}

// --- Entries and datasets ----------------------------------------------------

std::string pathOf( const std::string& name, const bool is_distributed )
{
    return ( is_distributed ? "rows/" : "shared/" ) + name;
}

const char* typeOf( const Archive::Entry& entry )
{
    const char* names[] = { "real", "integer", "text" };
    return names[entry.values.index()];
}

Dataset describe( const std::string& path, const Archive::Entry& entry )
{
    return std::visit(
        [&]( const auto& values ) -> Dataset
        {
            using Value = typename std::decay_t<decltype( values )>::value_type;
            if constexpr ( std::is_same_v<Value, char> )
                return { path,
                         { values.size() },
                         values.data(),
                         Dataset::Type::byte };
            else
                return { path, entry.shape, values.data(),
                         datasetType<Value>() };
        },
        entry.values );
}

//! Reads what rank `rows_of_ranks` says, or all.
Archive::Entry readEntry( const Hdf5Reader& reader, const Json& description,
                          const std::size_t first, const std::size_t count )
{
    const auto name = description.at( "name" ).get<std::string>();
    const auto type = description.at( "type" ).get<std::string>();
    const bool is_distributed = description.at( "is_distributed" );
    const auto path = pathOf( name, is_distributed );
    Archive::Entry entry;
    entry.is_distributed = is_distributed;
    if ( type == "text" )
    {
        const auto bytes = reader.read<unsigned char>( path );
        entry.values = std::string( bytes.begin(), bytes.end() );
        return entry;
    }
    entry.shape = reader.shape( path );
    std::vector<std::size_t> start( entry.shape.size(), 0 );
    if ( is_distributed )
    {
        start.at( 0 ) = first;
        entry.shape.at( 0 ) = count;
    }
    if ( type == "real" )
        entry.values = reader.read<Real>( path, start, entry.shape );
    else
        entry.values = reader.read<std::int64_t>( path, start, entry.shape );
    return entry;
}

//! What the archive's own values add to the checksum. \param first row
std::uint64_t checksum( const std::string& path, const Archive::Entry& entry,
                        const std::size_t first )
{
    std::size_t columns = 1;
    for ( std::size_t axis = 1; axis < entry.shape.size(); ++axis )
        columns *= entry.shape[axis];
    return std::visit( [&]( const auto& values )
                       { return checksum( path, values, first * columns ); },
                       entry.values );
}

//! Of all entries, and of all ranks.
std::int64_t checksum( const Communicator& ranks, const std::string& header,
                       const Archive::Entries& entries,
                       const std::size_t first )
{
    std::uint64_t sum =
        ranks.isRoot() ? checksum( "header", header, 0 ) : std::uint64_t( 0 );
    for ( const auto& [name, entry] : entries )
        if ( entry.is_distributed || ranks.isRoot() )
            sum += checksum( pathOf( name, entry.is_distributed ), entry,
                             entry.is_distributed ? first : 0 );
    return ranks.sum( static_cast<std::int64_t>( sum ) );
}

// --- Inputs ------------------------------------------------------------------

//! Says where two inputs differ first; "" where only keys do that may.
std::string difference( const Json* there, const Json* here,
                        const std::string& place )
{
    for ( const char* free : { "/time/end", "/output", "/checkpoint" } )
        if ( place == free )
            return "";
    auto text = []( const Json* value )
    { return value ? value->dump() : std::string( "absent" ); };
    if ( there && here && there->is_structured() &&
         there->type() == here->type() )
    {
        auto at = []( const Json& json, const auto& key ) -> const Json*
        {
            const auto found = json.find( key );
            return found == json.end() ? nullptr : &*found;
        };
        std::string found;
        if ( here->is_array() )
            for ( std::size_t k = 0;
                  found.empty() && k < std::max( there->size(), here->size() );
                  ++k )
                found =
                    difference( k < there->size() ? &( *there )[k] : nullptr,
                                k < here->size() ? &( *here )[k] : nullptr,
                                fmt::format( "{}/{}", place, k ) );
        else
            for ( const auto* json : { here, there } )
                for ( const auto& item : json->items() )
                    if ( found.empty() )
                        found = difference( at( *there, item.key() ),
                                            at( *here, item.key() ),
                                            place + "/" + item.key() );
        return found;
    }
    if ( there && here && *there == *here )
        return "";
    return fmt::format( "{} is {} here, but {} in the checkpoint", place,
                        text( here ), text( there ) );
}

// --- Files -------------------------------------------------------------------

bool isCheckpoint( const fs::path& file )
{
    const auto stem = file.stem().string();
    return file.extension() == ".h5" && stem.size() >= 8 &&
           std::all_of( stem.begin(), stem.end(),
                        []( const char c ) { return c >= '0' && c <= '9'; } );
}

//! The checkpoints of a folder, the newest first.
std::vector<fs::path> listCheckpoints( const fs::path& folder )
{
    std::vector<fs::path> list;
    std::error_code error;
    for ( fs::directory_iterator entry( folder, error ), end;
          !error && entry != end; entry.increment( error ) )
        if ( isCheckpoint( entry->path() ) )
            list.push_back( entry->path() );
    if ( error && error != std::errc::no_such_file_or_directory )
        throw IoError( folder, "cannot list the directory", error.value() );
    // Longer names are later steps, too.
    std::sort( list.begin(), list.end(),
               []( const fs::path& a, const fs::path& b )
               {
                   const auto x = a.stem().string(), y = b.stem().string();
                   return x.size() != y.size() ? x.size() > y.size() : x > y;
               } );
    return list;
}

[[noreturn]] void refuse( const fs::path& file, const std::string& reason )
{
    throw IoError( fmt::format( "{}: cannot be restarted from: {}; take "
                                "another checkpoint",
                                file.string(), reason ) );
}

//! Everything that a file says, its checksum not yet compared.
struct Content
{
    std::int64_t format = 0;
    std::int64_t checksum = 0;
    std::string header;
    Archive::Entries entries;
    std::size_t first = 0; //!< this rank's first row
};

Content readContent( const Communicator& ranks, const fs::path& file )
{
    const Hdf5Reader reader( file );
    if ( !reader.has( "header" ) )
        refuse( file, "it is no checkpoint of machpoint; those are in "
                      "DIR/checkpoints" );
    Content content;
    content.format =
        reader.attribute<std::int64_t>( "machpoint_checkpoint" ).at( 0 );
    if ( content.format != checkpoint_format )
        return content;
    content.checksum = reader.attribute<std::int64_t>( "checksum" ).at( 0 );
    const auto bytes = reader.read<unsigned char>( "header" );
    content.header.assign( bytes.begin(), bytes.end() );
    const auto rows = reader.read<std::int64_t>( "rows_of_ranks" );
    std::int64_t total = 0;
    for ( const auto n : rows )
        total += n;
    const auto rank = static_cast<std::size_t>( ranks.rank() );
    std::int64_t first = total * ranks.rank() / ranks.size();
    std::int64_t count = total * ( ranks.rank() + 1 ) / ranks.size() - first;
    if ( static_cast<int>( rows.size() ) == ranks.size() )
    {
        first = 0;
        for ( std::size_t r = 0; r < rank; ++r )
            first += rows[r];
        count = rows[rank];
    }
    content.first = static_cast<std::size_t>( first );
    for ( const auto header = Json::parse( content.header );
          const auto& description : header.at( "entries" ) )
        content.entries[description.at( "name" )] =
            readEntry( reader, description, content.first,
                       static_cast<std::size_t>( count ) );
    return content;
}

} // namespace

fs::path writeCheckpoint( const Communicator& ranks, const fs::path& folder,
                          const Json& input, const Archive& archive )
{
    const auto& entries = archive.entries();
    Json header;
    header["revision"] = revision;
    header["input"] = input;
    header["entries"] = Json::array();
    std::vector<Dataset> shared, rows;
    for ( const auto& [name, entry] : entries )
    {
        header["entries"].push_back(
            { { "name", name },
              { "type", typeOf( entry ) },
              { "is_distributed", entry.is_distributed } } );
        ( entry.is_distributed ? rows : shared )
            .push_back(
                describe( pathOf( name, entry.is_distributed ), entry ) );
    }
    // All tables of a rank have one row per particle.
    const std::vector<std::int64_t> own = {
        rows.empty() ? 0 : static_cast<std::int64_t>( rows[0].shape.at( 0 ) ) };
    const auto rows_of_ranks = ranks.gatherAll( own );
    const Archive::Entry header_entry{ {}, header.dump() };
    const Archive::Entry rows_entry{ { rows_of_ranks.size() }, rows_of_ranks };
    auto datasets = stackRows( ranks, std::move( rows ) );
    datasets.insert( datasets.end(), shared.begin(), shared.end() );
    datasets.push_back( describe( "header", header_entry ) );
    datasets.push_back( describe( "rows_of_ranks", rows_entry ) );

    const auto sum =
        checksum( ranks, std::get<std::string>( header_entry.values ), entries,
                  static_cast<std::size_t>( ranks.sumBefore( own[0] ) ) );
    const auto time =
        std::get<std::vector<Real>>( entries.at( "time" ).values );
    const auto step =
        std::get<std::vector<std::int64_t>>( entries.at( "step" ).values );
    const auto file = folder / fmt::format( "{:08}.h5", step.at( 0 ) );
    onRoot( ranks, [&] { makeDirectory( folder ); } );
    writeHdf5( ranks, file,
               { { "machpoint_checkpoint",
                   {},
                   &checkpoint_format,
                   Dataset::Type::integer },
                 { "time", {}, time.data(), Dataset::Type::real },
                 { "step", {}, step.data(), Dataset::Type::integer },
                 { "checksum", {}, &sum, Dataset::Type::integer } },
               datasets );
    return file;
}

Checkpoint readCheckpoint( const Communicator& ranks, const fs::path& file,
                           const Json& input )
{
    Content content;
    Json header;
    together( ranks,
              [&]
              {
                  try
                  {
                      content = readContent( ranks, file );
                      if ( content.format == checkpoint_format )
                          header = Json::parse( content.header );
                  }
                  catch ( const IoError& )
                  {
                      throw;
                  }
                  catch ( const std::exception& )
                  {
                      // Nonsense for a length, a name or a text.
                      refuse( file, "it is damaged" );
                  }
              } );
    if ( content.format != checkpoint_format )
        throw InputError( { fmt::format(
            "the checkpoint {} has format {}, and this program reads format "
            "{}; restart with the program that wrote it",
            file.string(), content.format, checkpoint_format ) } );
    const auto sum =
        checksum( ranks, content.header, content.entries, content.first );
    if ( sum != content.checksum )
        throw IoError::onAll( fmt::format(
            "{}: cannot be restarted from: its checksum does not fit; take "
            "another checkpoint",
            file.string() ) );
    const auto other = difference( &header.at( "input" ), &input, "" );
    if ( !other.empty() )
        throw InputError( { fmt::format(
            "{} {}; restart with the input that it was written for", other,
            file.string() ) } );
    return { file,
             Archive( std::move( content.entries ) ),
             header.at( "revision" ).get<std::string>(),
             {} };
}

Checkpoint readNewestCheckpoint( const Communicator& ranks,
                                 const fs::path& folder, const Json& input )
{
    std::vector<std::string> complaints;
    for ( const auto& file : listCheckpoints( folder ) )
    {
        try
        {
            auto checkpoint = readCheckpoint( ranks, file, input );
            checkpoint.complaints = complaints;
            return checkpoint;
        }
        catch ( const IoError& error )
        {
            complaints.push_back( error.what() );
        }
    }
    auto message = folder.string() +
                   ": holds no checkpoint to restart from; start the run anew "
                   "without --restart, or name a file with --restart FILE";
    for ( const auto& complaint : complaints )
        message += "\n  " + complaint;
    throw IoError::onAll( message );
}

void keepCheckpoints( const fs::path& folder, const std::size_t keep )
{
    const auto list = listCheckpoints( folder );
    for ( std::size_t k = keep; k < list.size(); ++k )
        removeFile( list[k] );
}

void removeCheckpointsAfter( const fs::path& folder, const std::int64_t step )
{
    for ( const auto& file : listCheckpoints( folder ) )
        if ( std::stoll( file.stem().string() ) > step )
            removeFile( file );
}

} // namespace Machpoint
