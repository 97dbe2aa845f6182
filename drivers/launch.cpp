/*!
  \file launch.cpp
  \brief What the program is started with, checked, and Kokkos started.
*/
#include <drivers/launch.hpp>

#include <core/parameters.hpp>
#include <core/types.hpp>

#include <fmt/format.h>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace Machpoint
{

void requireAllProcesses( const Communicator& ranks )
{
    const int launched = launchedProcesses();
    if ( launched > ranks.size() )
        throw InputError( { fmt::format(
            "machpoint: {} processes were started, and this one knows of {}; "
            "start one, or configure with -DMachpoint_ENABLE_MPI=ON and start "
            "them with the mpirun of the same MPI (a main of one's own begins "
            "with a Machpoint::MpiSession)",
            launched, ranks.size() ) } );
}

int threadCount()
{
    if ( const char* text = std::getenv( "KOKKOS_NUM_THREADS" ) )
    {
        int count = 0;
        const char* end = text + std::strlen( text );
        const auto [rest, error] = std::from_chars( text, end, count );
        return error == std::errc() && rest == end ? count : 0;
    }
#ifdef _OPENMP
    return omp_get_max_threads();
#else
    return 1;
#endif
}

std::string faultOfThreads()
{
    constexpr int most = 512; // of Kokkos' OpenMP
    const int count = threadCount();
    const char* text = std::getenv( "KOKKOS_NUM_THREADS" );
    return count >= 1 && count <= most
               ? ""
               : fmt::format( "{}: must be a number of threads from 1 to {}, "
                              "not \"{}\"",
                              text ? "KOKKOS_NUM_THREADS" : "OMP_NUM_THREADS",
                              most, text ? text : std::to_string( count ) );
}

std::string startKokkos( std::optional<KokkosSession>& kokkos )
{
    try
    {
        kokkos.emplace();
        return "";
    }
    catch ( const std::runtime_error& error ) // of CUDA, not of memory
    {
        if ( runs_on_host )
            throw;
        return fmt::format( "cannot start on a GPU: {}; start this build where "
                            "one is free, or configure with "
                            "-DMachpoint_BACKEND=OPENMP",
                            error.what() );
    }
}

} // namespace Machpoint
