/*!
  \file checkpoint.cpp
  \brief A checkpoint, written and read back.
*/
#include <core/checkpoint.hpp>

#include <core/hdf5_file.hpp>
#include <core/random.hpp>
#include <core/revision.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <new>
#include <span>
#include <variant>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

// --- Checksum ----------------------------------------------------------------

std::uint64_t word( const double value )
{
    return std::bit_cast<std::uint64_t>( value );
}
std::uint64_t word( const float value )
{
    return std::bit_cast<std::uint32_t>( value );
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
std::uint64_t checksum( const std::string& path, const List& values,
                        const std::uint64_t first )
{
    std::uint64_t place = 0;
    for ( const char letter : path )
        place = mixBits( place ^ word( letter ) );
    place += first;
    std::uint64_t sum = 0;
    for ( const auto& value : values )
        sum += mixBits( word( value ) ^ mixBits( place++ ) );
    return sum;
}

//! The same rows, whose checksum is taken up as they are fetched.
//! \param offset of the rank's first row within the whole table
template <class T>
Rows<T> summed( const Rows<T>& rows, const std::string& path,
                const std::size_t offset, std::uint64_t& sum )
{
    return {
        rows.count, rows.columns,
        [=, &sum]( const std::size_t first, const std::size_t count, T* values )
        {
            rows.fetch( first, count, values );
            sum += checksum( path, std::span( values, count * rows.columns ),
                             ( offset + first ) * rows.columns );
        } };
}

// --- Entries and datasets ----------------------------------------------------

//! Has each rank rows of its own, rather than all the same?
bool isDistributed( const Archive::Entry& entry )
{
    return std::visit(
        []<class Values>( const Values& )
        {
            return requires( Values v )
            {
                v.fetch;
            };
        },
        entry.values );
}

std::string pathOf( const std::string& name, const bool is_distributed )
{
    return ( is_distributed ? "rows/" : "shared/" ) + name;
}

const char* typeOf( const Archive::Entry& entry )
{
    const char* names[] = { "single", "real", "integer", "text",
                            "single", "real", "integer" };
    return names[entry.values.index()];
}

//! \name Datasets of what an entry may hold
//! \param sum takes the checksum up, that of rows as they are fetched
//! \param offset of the rank's first row
//! @{
Dataset describe( const std::string& path, const std::string& text,
                  const Archive::Entry&, std::size_t, std::uint64_t& sum )
{
    sum += checksum( path, text, 0 );
    return { path, { text.size() }, text.data(), Dataset::Type::byte };
}
template <class T>
Dataset describe( const std::string& path, const std::vector<T>& values,
                  const Archive::Entry& entry, std::size_t, std::uint64_t& sum )
{
    sum += checksum( path, values, 0 );
    return { path, entry.shape, values.data(), datasetType<T>() };
}
template <class T>
Dataset describe( const std::string& path, const Rows<T>& rows,
                  const Archive::Entry&, const std::size_t offset,
                  std::uint64_t& sum )
{
    Dataset dataset{
        path, { rows.count, rows.columns }, nullptr, datasetType<T>() };
    dataset.fetch =
        [all = summed( rows, path, offset, sum )](
            const std::size_t first, const std::size_t count, void* values )
    { all.fetch( first, count, static_cast<T*>( values ) ); };
    return dataset;
}
//! @}

//! \name What entries hold; the checksum is taken up
//! @{
std::string readText( const Hdf5Reader& reader, const std::string& path,
                      std::uint64_t& sum )
{
    const auto bytes = reader.read<unsigned char>( path );
    const std::string text( bytes.begin(), bytes.end() );
    sum += checksum( path, text, 0 );
    return text;
}
template <class T>
Archive::Entry readTable( const Hdf5Reader& reader, const std::string& path,
                          std::uint64_t& sum )
{
    auto values = reader.read<T>( path );
    sum += checksum( path, values, 0 );
    return { reader.shape( path ), std::move( values ) };
}
//! \param offset, count this rank's rows of the file's
template <class T>
Archive::Entry readRows( const std::shared_ptr<const Hdf5Reader>& reader,
                         const std::string& path, const std::size_t offset,
                         const std::size_t count, std::uint64_t& sum )
{
    const auto columns = reader->shape( path ).at( 1 );
    const Rows<T> rows{
        count, columns,
        [=]( const std::size_t first, const std::size_t n, T* values ) {
            reader->read( path, { offset + first, 0 }, { n, columns }, values );
        } };
    summed( rows, path, offset, sum ).forEachBlock( []( auto&&... ) {} );
    return { {}, rows };
}
//! @}

// --- Inputs ------------------------------------------------------------------

//! Says where two inputs differ, but for what may; of a list of numbers where
//! it does first. \param[in,out] found a line is appended for each place
void compare( const Json* there, const Json* here, const std::string& place,
              std::vector<std::string>& found )
{
    for ( const char* free :
          { "/time/end", "/output", "/checkpoint", "/decomposition" } )
        if ( place == free )
            return;
    auto text = []( const Json* value )
    { return value ? value->dump() : std::string( "absent" ); };
    if ( there && here && *there == *here )
        return;
    if ( !there || !here || !there->is_structured() ||
         there->type() != here->type() )
    {
        found.push_back( fmt::format( "{} is {} here, but {} in the checkpoint",
                                      place, text( here ), text( there ) ) );
        return;
    }
    if ( here->is_array() )
    {
        const auto before = found.size();
        for ( std::size_t k = 0; k < std::max( there->size(), here->size() );
              ++k )
        {
            const auto* a = k < there->size() ? &( *there )[k] : nullptr;
            const auto* b = k < here->size() ? &( *here )[k] : nullptr;
            compare( a, b, fmt::format( "{}/{}", place, k ), found );
            if ( found.size() > before && !( b ? b : a )->is_object() )
                return;
        }
        return;
    }
    auto at = []( const Json& json, const std::string& key ) -> const Json*
    {
        const auto entry = json.find( key );
        return entry == json.end() ? nullptr : &*entry;
    };
    for ( const auto& item : here->items() )
        compare( at( *there, item.key() ), &item.value(),
                 place + "/" + item.key(), found );
    for ( const auto& item : there->items() )
        if ( !here->contains( item.key() ) )
            compare( &item.value(), nullptr, place + "/" + item.key(), found );
}

// --- Files -------------------------------------------------------------------

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
    std::uint64_t sum = 0; //!< what the checksum is over all ranks
    std::string header;
    Archive::Entries entries;
};

Content readContent( const Communicator& ranks, const fs::path& file )
{
    // Rows are read when the archive is, and so keep the file open.
    const auto reader = std::make_shared<const Hdf5Reader>( file );
    if ( !reader->has( "header" ) )
        refuse( file, "it is no checkpoint of machpoint; those are in "
                      "DIR/checkpoints" );
    Content content;
    content.format =
        reader->attribute<std::int64_t>( "machpoint_checkpoint" ).at( 0 );
    if ( content.format != checkpoint_format )
        return content;
    content.checksum = reader->attribute<std::int64_t>( "checksum" ).at( 0 );
    const auto rows = reader->read<std::int64_t>( "rows_of_ranks" );
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
    std::uint64_t shared = 0; // which the root alone counts
    content.header = readText( *reader, "header", shared );
    for ( const auto header = Json::parse( content.header );
          const auto& description : header.at( "entries" ) )
    {
        const auto name = description.at( "name" ).get<std::string>();
        const auto type = description.at( "type" ).get<std::string>();
        const bool is_distributed = description.at( "is_distributed" );
        const auto path = pathOf( name, is_distributed );
        auto& entry = content.entries[name];
        auto read = [&]<class T>( T )
        {
            return is_distributed
                       ? readRows<T>( reader, path, first, count, content.sum )
                       : readTable<T>( *reader, path, shared );
        };
        if ( type == "text" )
            entry = { {}, readText( *reader, path, shared ) };
        else if ( type == "real" )
            entry = read( double{} );
        else if ( type == "single" )
            entry = read( float{} );
        else
            entry = read( std::int64_t{} );
    }
    if ( ranks.isRoot() )
        content.sum += shared;
    return content;
}

//! Of all ranks.
std::int64_t total( const Communicator& ranks, const std::uint64_t sum )
{
    return ranks.sum( static_cast<std::int64_t>( sum ) );
}

} // namespace

fs::path writeCheckpoint( const Communicator& ranks, const fs::path& folder,
                          const Json& input, const Archive& archive )
{
    const auto& entries = archive.entries();
    // All tables of a rank have one row per particle.
    std::int64_t own_rows = 0;
    for ( const auto& [name, entry] : entries )
        std::visit(
            [&]<class Values>( const Values& values )
            {
                if constexpr ( requires { values.count; } )
                    own_rows = static_cast<std::int64_t>( values.count );
            },
            entry.values );
    const auto rows_of_ranks = ranks.gatherAll( std::vector{ own_rows } );
    const auto offset = static_cast<std::size_t>( ranks.sumBefore( own_rows ) );

    Json header;
    header["revision"] = revision;
    header["precision"] = precision_name;
    header["input"] = input;
    header["entries"] = Json::array();
    std::uint64_t sum = 0, shared_sum = 0;
    std::vector<Dataset> shared, rows;
    for ( const auto& [name, entry] : entries )
    {
        const bool is_distributed = isDistributed( entry );
        header["entries"].push_back( { { "name", name },
                                       { "type", typeOf( entry ) },
                                       { "is_distributed", is_distributed } } );
        std::visit(
            [&]( const auto& values )
            {
                ( is_distributed ? rows : shared )
                    .push_back( describe( pathOf( name, is_distributed ),
                                          values, entry, offset,
                                          is_distributed ? sum : shared_sum ) );
            },
            entry.values );
    }
    const auto header_text = header.dump();
    shared.push_back( describe( "header", header_text, {}, 0, shared_sum ) );
    shared.push_back( { "rows_of_ranks",
                        { rows_of_ranks.size() },
                        rows_of_ranks.data(),
                        Dataset::Type::integer } );
    if ( ranks.isRoot() )
        sum += shared_sum;
    auto datasets = stackRows( ranks, std::move( rows ) );
    datasets.insert( datasets.end(), shared.begin(), shared.end() );

    std::int64_t checksum = 0; // known when all rows were fetched
    const auto time =
        std::get<std::vector<double>>( entries.at( "time" ).values );
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
                 { "checksum", {}, &checksum, Dataset::Type::integer } },
               datasets, 0, small_file,
               [&] { checksum = total( ranks, sum ); } );
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
                  catch ( const std::bad_alloc& )
                  {
                      refuse( file, "it takes more memory than there is, or is "
                                    "damaged" );
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
    if ( total( ranks, content.sum ) != content.checksum )
        throw IoError::onAll( fmt::format(
            "{}: cannot be restarted from: its checksum does not fit; take "
            "another checkpoint",
            file.string() ) );
    // Older ones do not say so.
    const auto precision = header.value( "precision", "double" );
    if ( precision != precision_name )
        throw InputError( { fmt::format(
            "the checkpoint {} has particles in {} precision, and this program "
            "computes in {}; restart with a build whose Machpoint_PRECISION is "
            "{}",
            file.string(), precision, precision_name, precision ) } );
    std::vector<std::string> differences;
    compare( &header.at( "input" ), &input, "", differences );
    for ( auto& difference : differences )
        difference +=
            fmt::format( " {}; restart with the input that it was written for",
                         file.string() );
    if ( !differences.empty() )
        throw InputError( differences );
    return { file,
             Archive( std::move( content.entries ) ),
             header.at( "revision" ).get<std::string>(),
             {},
             {} };
}

} // namespace Machpoint
