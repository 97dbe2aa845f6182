/*!
  \file file_size_limit.hpp
  \brief A full disk, as far as the code that writes can tell.
*/
#ifndef MACHPOINT_UNITTEST_FILE_SIZE_LIMIT_HPP
#define MACHPOINT_UNITTEST_FILE_SIZE_LIMIT_HPP

#include <csignal>

#include <sys/resource.h>

namespace Test
{

//! While it lives, no file may grow beyond so many bytes: for the code that
//! writes it, what a full disk is, without the rights that mounting a small one
//! would need.
class FileSizeLimit
{
  public:
    explicit FileSizeLimit( const rlim_t bytes )
        : _handler( std::signal( SIGXFSZ, SIG_IGN ) )
    {
        ::getrlimit( RLIMIT_FSIZE, &_former );
        const rlimit limit = { bytes, _former.rlim_max };
        ::setrlimit( RLIMIT_FSIZE, &limit );
    }
    FileSizeLimit( const FileSizeLimit& ) = delete;
    FileSizeLimit& operator=( const FileSizeLimit& ) = delete;
    ~FileSizeLimit()
    {
        ::setrlimit( RLIMIT_FSIZE, &_former );
        std::signal( SIGXFSZ, _handler );
    }

  private:
    void ( *_handler )( int );
    rlimit _former;
};

} // namespace Test

#endif
