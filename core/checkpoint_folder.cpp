/*!
  \file checkpoint_folder.cpp
  \brief The checkpoints of a folder: the newest that can be read, and those
  that are kept, set aside or removed.
*/
#include <core/checkpoint.hpp>

#include <core/file.hpp>

#include <algorithm>
#include <string>
#include <system_error>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

//! The checkpoints of a folder, the newest first. \param ending of their names
std::vector<fs::path> listCheckpoints( const fs::path& folder,
                                       const std::string& ending = "" )
{
    std::vector<fs::path> list;
    std::error_code error;
    for ( fs::directory_iterator entry( folder, error ), end;
          !error && entry != end; entry.increment( error ) )
        if ( auto file = entry->path();
             ending.empty() ? isStepFile( file )
                            : file.extension() == ending &&
                                  isStepFile( file.replace_extension() ) )
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

//! The root's list, on all ranks: a shared file system may show the others an
//! older folder, and files are read by all ranks together.
std::vector<fs::path> listOfRoot( const Communicator& ranks,
                                  const fs::path& folder )
{
    std::vector<char> text;
    onRoot( ranks,
            [&]
            {
                for ( const auto& file : listCheckpoints( folder ) )
                {
                    const auto name = file.string();
                    text.insert( text.end(), name.begin(), name.end() );
                    text.push_back( '\0' );
                }
            } );
    text = ranks.gatherAll( text );
    std::vector<fs::path> list;
    for ( auto name = text.begin(); name != text.end(); )
    {
        const auto end = std::find( name, text.end(), '\0' );
        list.emplace_back( name, end );
        name = end + 1;
    }
    return list;
}

} // namespace

Checkpoint readNewestCheckpoint( const Communicator& ranks,
                                 const fs::path& folder, const Json& input )
{
    std::vector<fs::path> passed_over;
    std::vector<std::string> complaints;
    for ( const auto& file : listOfRoot( ranks, folder ) )
    {
        try
        {
            auto checkpoint = readCheckpoint( ranks, file, input );
            checkpoint.passed_over = passed_over;
            checkpoint.complaints = complaints;
            return checkpoint;
        }
        catch ( const IoError& error )
        {
            passed_over.push_back( file );
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

void setAside( const std::vector<fs::path>& files )
{
    for ( const auto& file : files )
    {
        std::error_code error;
        fs::rename( file, file.string() + ".unread", error );
        if ( error && error != std::errc::no_such_file_or_directory )
            throw IoError( file, "cannot rename the file", error.value() );
    }
}

void removeCheckpointsAfter( const fs::path& folder, const std::int64_t step )
{
    for ( const auto& file : listCheckpoints( folder ) )
        if ( std::stoll( file.stem().string() ) > step )
            removeFile( file );
    // What a killed run left of one.
    for ( const auto& file : listCheckpoints( folder, ".tmp" ) )
        removeFile( file );
}

} // namespace Machpoint
