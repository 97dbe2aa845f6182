#include <drivers/resume.hpp>

#include <drivers/tell.hpp>

#include <core/hdf5_file.hpp>
#include <core/revision.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <variant>
#include <vector>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

//! The first number of an entry of a checkpoint; nothing where there is none,
//! which resume will tell.
template <class T>
std::optional<T> numberOf( const Checkpoint& checkpoint, const char* name )
{
    const auto& entries = checkpoint.archive.entries();
    const auto entry = entries.find( name );
    if ( entry == entries.end() )
        return std::nullopt;
    const auto* list = std::get_if<std::vector<T>>( &entry->second.values );
    return list && !list->empty() ? std::optional( list->front() )
                                  : std::nullopt;
}

} // namespace

bool hasHdf5( const Communicator& ranks )
{
    try
    {
        requireHdf5( ranks );
        return true;
    }
    catch ( const IoError& )
    {
        return false;
    }
}

void checkpointFacts( Archive& archive, RunFacts& facts )
{
    archive( "start/mass", facts.initial.mass );
    archive( "start/momentum", facts.initial.momentum );
    archive( "start/internal", facts.initial.internal );
    archive( "start/kinetic", facts.initial.kinetic );
    archive( "start/affine", facts.initial.affine );
    archive( "start/particles", facts.particles_initial );
    archive( "particle_updates", facts.particle_updates );
    archive( "wall_seconds", facts.wall_seconds );
}

Checkpoint findCheckpoint( const Communicator& ranks, const std::string& name,
                           const fs::path& folder, const Json& input )
{
    auto checkpoint = name == "latest"
                          ? readNewestCheckpoint( ranks, folder, input )
                          : readCheckpoint( ranks, name, input );
    if ( !ranks.isRoot() )
        return checkpoint;
    for ( const auto& complaint : checkpoint.complaints )
        tell( "machpoint: {}\n", complaint );
    if ( !checkpoint.complaints.empty() )
        tell( "machpoint: falls back to {}; what was passed over is kept, with "
              ".unread added to its name\n",
              checkpoint.file.string() );
    if ( checkpoint.revision != revision )
        tell( "machpoint: {} was written by revision {}, and this is "
              "{}: the run may go on in another way\n",
              checkpoint.file.string(), checkpoint.revision, revision );
    return checkpoint;
}

void requireLaterEnd( const Checkpoint& restart, const double end,
                      const std::int64_t max_steps )
{
    const auto step = numberOf<std::int64_t>( restart, "step" );
    if ( step && *step > max_steps )
        throw InputError( { fmt::format(
            "--max-steps {}: {} has step {}; give a larger one, or a former "
            "checkpoint",
            max_steps, restart.file.string(), *step ) } );
    const auto time = numberOf<double>( restart, "time" );
    if ( time && *time > end * ( 1 + 1e-12 ) )
        throw InputError( { fmt::format(
            "/time/end: {:.6g} lies before t = {:.6g}, which {} has; give a "
            "later one, or a former checkpoint",
            end, *time, restart.file.string() ) } );
}

void resume( Checkpoint& restart,
             const std::function<void( Archive& )>& checkpoint )
{
    try
    {
        checkpoint( restart.archive );
        const auto& left = restart.archive.entries();
        const auto& outputs = OutputDirectory::entries;
        for ( const std::string name : outputs )
            if ( !left.contains( name ) )
                throw ArchiveError( "there is no " + name );
        for ( const auto& [name, entry] : left )
            if ( std::find( outputs.begin(), outputs.end(), name ) ==
                 outputs.end() )
                throw ArchiveError( name + " is unknown here" );
    }
    catch ( const ArchiveError& error )
    {
        throw IoError::onAll( fmt::format(
            "{}: cannot be restarted from: {}; restart with the program that "
            "wrote it",
            restart.file.string(), error.what() ) );
    }
}

// As the root sees the directories: ranks decide by it what they do together.
FormerRun formerRun( const Communicator& ranks,
                     const std::optional<Checkpoint>& restart,
                     const fs::path& directory, const bool overwrite )
{
    std::error_code error;
    if ( ranks.any( ranks.isRoot() && restart &&
                    fs::equivalent( fs::absolute( restart->file ).parent_path(),
                                    directory / "checkpoints", error ) ) )
        return FormerRun::go_on;
    return overwrite ? FormerRun::replace : FormerRun::refuse;
}

} // namespace Machpoint
