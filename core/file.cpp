#include <core/file.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace fs = std::filesystem;

namespace Machpoint
{
namespace
{

std::string remedy( int error )
{
    switch ( error )
    {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
        return "free some space or choose another disk with --output DIR";
    case EACCES:
    case EPERM:
    case EROFS:
        return "choose a directory that you may write to with --output DIR";
    default:
        return "check the path that --output names, or choose another one";
    }
}

//! A file under its temporary name, gone again unless it is finished.
class OpenFile
{
  public:
    //! \param is_others is it there whatever happens here?
    OpenFile( const fs::path& target, const int flags,
              const bool is_others = false )
        : _target( target ), _temporary( temporaryName( target ) ),
          _file( ::open( _temporary.c_str(), flags | O_CLOEXEC, 0666 ) ),
          _is_others( is_others )
    {
        if ( _file < 0 )
            throw IoError( target, "cannot create the file", errno );
    }
    OpenFile( const OpenFile& ) = delete;
    OpenFile& operator=( const OpenFile& ) = delete;
    ~OpenFile()
    {
        if ( _file >= 0 )
            ::close( _file );
        if ( !_kept && !_is_others )
            ::unlink( _temporary.c_str() );
    }

    void write( const void* data, const std::size_t size )
    {
        const auto* bytes = static_cast<const char*>( data );
        for ( std::size_t done = 0; done < size; )
        {
            const auto count = ::write( _file, bytes + done, size - done );
            if ( count >= 0 )
                done += static_cast<std::size_t>( count );
            else
                require( errno == EINTR );
        }
    }

    //! \param mode of fallocate
    void reserve( const int mode, const std::size_t size )
    {
        require( ::fallocate( _file, mode, 0, static_cast<off_t>( size ) ) ==
                     0 ||
                 errno == EOPNOTSUPP || errno == ENOSYS || errno == EINTR );
    }

    //! What is reserved beyond the end.
    void giveBack()
    {
        const auto end = ::lseek( _file, 0, SEEK_END );
        require( end >= 0 && ::ftruncate( _file, end ) == 0 );
    }

    // A disk may refuse as late as fsync or close: delayed allocation and
    // network file systems report a full disk only there.
    void finish()
    {
        require( ::fsync( _file ) == 0 );
        close();
        require( ::rename( _temporary.c_str(), _target.c_str() ) == 0 );
    }

    //! Leaves it under its temporary name.
    void close()
    {
        require( ::close( std::exchange( _file, -1 ) ) == 0 );
        _kept = true;
    }

  private:
    void require( const bool success )
    {
        if ( success )
            return;
        const int error = errno;
        _kept = false;
        throw IoError( _target, "cannot write the file", error );
    }

    fs::path _target;
    fs::path _temporary;
    int _file;
    bool _is_others;
    bool _kept = false;
};

} // namespace

IoError::IoError( const fs::path& file, const std::string& operation,
                  int error )
    : std::runtime_error( fmt::format(
          "{}: {}: {}; {}", file.string(), operation,
          error ? std::strerror( error ) : "no reason given by the system",
          remedy( error ) ) )
{
}

bool isStepFile( const fs::path& file )
{
    const auto stem = file.stem().string();
    return file.extension() == ".h5" && stem.size() >= 8 && stem.size() <= 18 &&
           std::all_of( stem.begin(), stem.end(),
                        []( const char c ) { return c >= '0' && c <= '9'; } );
}

fs::path temporaryName( const fs::path& target )
{
    return target.string() + ".tmp";
}

void writeFile( const fs::path& target, const void* data,
                const std::size_t size )
{
    OpenFile file( target, O_WRONLY | O_CREAT | O_TRUNC );
    file.write( data, size );
    file.finish();
}

void requireRoom( const fs::path& target, const std::size_t size )
{
    OpenFile file( target, O_WRONLY | O_CREAT );
    file.reserve( 0, size );
    file.close();
}

void reserveFile( const fs::path& target, const std::size_t size )
{
    OpenFile file( target, O_WRONLY, true );
    file.reserve( FALLOC_FL_KEEP_SIZE, size );
    file.close();
}

void requireReachable( const fs::path& target )
{
    OpenFile( target, O_WRONLY, true ).close();
}

void emptyTemporary( const fs::path& target )
{
    // Where that fails, too, there is nothing more to try.
    static_cast<void>( ::truncate( temporaryName( target ).c_str(), 0 ) == 0 );
}

void dropTemporary( const fs::path& target )
{
    ::unlink( temporaryName( target ).c_str() );
}

void finishFile( const fs::path& target )
{
    OpenFile file( target, O_WRONLY );
    file.giveBack();
    file.finish();
}

void removeFile( const fs::path& file )
{
    for ( const auto& name : { file, temporaryName( file ) } )
    {
        std::error_code error;
        fs::remove( name, error );
        if ( error )
            throw IoError( name, "cannot remove the file", error.value() );
    }
}

void makeDirectory( const fs::path& directory )
{
    std::error_code error;
    fs::create_directories( directory, error );
    if ( error )
        throw IoError( directory, "cannot create the directory",
                       error.value() );
}

DirectoryLock::DirectoryLock( const fs::path& directory )
    : _file( ::open( directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC ) )
{
    if ( _file < 0 || ::flock( _file, LOCK_EX | LOCK_NB ) == 0 ||
         errno != EWOULDBLOCK )
        return;
    ::close( _file );
    throw IoError( fmt::format(
        "{}: another run or study is writing there; wait until it has ended, "
        "or choose another directory with --output DIR",
        directory.string() ) );
}

DirectoryLock::~DirectoryLock()
{
    if ( _file >= 0 )
        ::close( _file );
}

} // namespace Machpoint
