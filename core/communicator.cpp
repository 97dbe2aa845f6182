#include <core/communicator.hpp>
#include <core/traffic.hpp>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <thread>

#if defined( MACHPOINT_ENABLE_MPI ) && __has_include( <mpi-ext.h> )
#include <mpi-ext.h>
#endif

namespace Machpoint
{

int launchedProcesses()
{
    // Open MPI; MPICH, and what launches its programs.
    for ( const char* name : { "OMPI_COMM_WORLD_SIZE", "PMI_SIZE" } )
        if ( const char* text = std::getenv( name ) )
            return std::max( 1, std::atoi( text ) );
    return 1;
}

#ifdef MACHPOINT_ENABLE_MPI

namespace
{

//! Set by Open MPI, by PMI and PMIx launchers such as Slurm's, by MPICH.
constexpr const char* launcher_variables[] = {
    "OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "MPI_LOCALNRANKS" };

bool wasLaunched()
{
    return std::any_of(
        std::begin( launcher_variables ), std::end( launcher_variables ),
        []( const char* name ) { return std::getenv( name ) != nullptr; } );
}

//! Counts one call of all ranks, and its time.
struct Collective
{
    Collective() { ++Traffic::own().collectives; }
    Traffic::Timer timer{ Activity::collectives };
};

bool isRunning()
{
    int started = 0, ended = 0;
    MPI_Initialized( &started );
    MPI_Finalized( &ended );
    return started && !ended;
}

} // namespace

bool mpiIsGpuAware()
{
// An extension of Open MPI: what it was built for, and what it found at start.
#if defined( KOKKOS_ENABLE_CUDA ) && defined( MPIX_CUDA_AWARE_SUPPORT ) &&     \
    MPIX_CUDA_AWARE_SUPPORT
    return std::is_same_v<ExecutionSpace, Kokkos::Cuda> && isRunning() &&
           MPIX_Query_cuda_support() == 1;
#else
    return false;
#endif
}

MpiSession::MpiSession( int& argc, char**& argv )
{
    int provided = 0;
    // Threads compute; only the main one communicates.
    if ( wasLaunched() && !isRunning() )
        MPI_Init_thread( &argc, &argv, MPI_THREAD_FUNNELED, &provided );
}

MpiSession::~MpiSession()
{
    if ( isRunning() )
        MPI_Finalize();
}

Communicator::Communicator()
{
    if ( !isRunning() )
        return;
    _handle = MPI_COMM_WORLD;
    MPI_Comm_rank( _handle, &_rank );
    MPI_Comm_size( _handle, &_size );
}

std::vector<double> Communicator::sum( const std::vector<double>& values ) const
{
    if ( _size == 1 )
        return values;
    const Collective collective;
    const int n = static_cast<int>( values.size() );
    std::vector<double> all( values.size() * _size );
    MPI_Allgather( values.data(), n, MPI_DOUBLE, all.data(), n, MPI_DOUBLE,
                   _handle );
    std::vector<double> sums( values.size(), 0.0 );
    for ( std::size_t k = 0; k < all.size(); ++k )
        sums[k % sums.size()] += all[k];
    return sums;
}

std::vector<std::int64_t>
Communicator::sumCounts( std::vector<std::int64_t> values ) const
{
    if ( _size == 1 )
        return values;
    const Collective collective;
    MPI_Allreduce( MPI_IN_PLACE, values.data(),
                   static_cast<int>( values.size() ), MPI_INT64_T, MPI_SUM,
                   _handle );
    return values;
}

std::vector<double> Communicator::max( std::vector<double> values ) const
{
    if ( _size == 1 )
        return values;
    const Collective collective;
    MPI_Allreduce( MPI_IN_PLACE, values.data(),
                   static_cast<int>( values.size() ), MPI_DOUBLE, MPI_MAX,
                   _handle );
    return values;
}

bool Communicator::allArrive( const double seconds ) const
{
    if ( _size == 1 )
        return true;
    // Not a collective call, as the others may be in one. Whoever does not
    // arrive will not come any more: what is pending ends with the run.
    constexpr int tag = 3; // 0 to 2 are those of halo and migration
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration<double>( seconds );
    std::vector<MPI_Request> pending;
    for ( int r = 0; r < _size; ++r )
        if ( r != _rank )
        {
            MPI_Isend( nullptr, 0, MPI_BYTE, r, tag, _handle,
                       &pending.emplace_back() );
            MPI_Irecv( nullptr, 0, MPI_BYTE, r, tag, _handle,
                       &pending.emplace_back() );
        }
    int done = 0;
    while ( !done )
    {
        MPI_Testall( static_cast<int>( pending.size() ), pending.data(), &done,
                     MPI_STATUSES_IGNORE );
        if ( !done && Clock::now() > end )
            break;
        if ( !done )
            std::this_thread::sleep_for( std::chrono::milliseconds( 1 ) );
    }
    return done;
}

std::int64_t Communicator::sumBefore( std::int64_t value ) const
{
    if ( _size == 1 )
        return 0;
    const Collective collective;
    std::int64_t before = 0;
    MPI_Exscan( &value, &before, 1, MPI_INT64_T, MPI_SUM, _handle );
    return _rank == 0 ? 0 : before;
}

std::string Communicator::from( const int rank, const std::string& text ) const
{
    if ( _size == 1 )
        return text;
    const auto bytes =
        gatherBytes( text.data(), rank == _rank ? text.size() : 0, true );
    return { bytes.begin(), bytes.end() };
}

std::vector<char> Communicator::gatherBytes( const void* data,
                                             const std::size_t bytes,
                                             const bool everywhere ) const
{
    const auto* first = static_cast<const char*>( data );
    if ( _size == 1 )
        return { first, first + bytes };
    if ( bytes > std::numeric_limits<int>::max() )
        throw std::runtime_error( "a rank gathers more than 2 GiB" );
    const Collective sizes, lists;
    const int own = static_cast<int>( bytes );
    std::vector<int> counts( _size ), offsets( _size );
    MPI_Allgather( &own, 1, MPI_INT, counts.data(), 1, MPI_INT, _handle );
    const auto total =
        std::accumulate( counts.begin(), counts.end(), std::int64_t( 0 ) );
    if ( total > std::numeric_limits<int>::max() )
        throw std::runtime_error( "the ranks gather more than 2 GiB" );
    std::exclusive_scan( counts.begin(), counts.end(), offsets.begin(), 0 );
    std::vector<char> all( everywhere || isRoot() ? total : 0 );
    if ( everywhere )
        MPI_Allgatherv( first, own, MPI_BYTE, all.data(), counts.data(),
                        offsets.data(), MPI_BYTE, _handle );
    else
        MPI_Gatherv( first, own, MPI_BYTE, all.data(), counts.data(),
                     offsets.data(), MPI_BYTE, 0, _handle );
    return all;
}

void Communicator::abort( const int exit_code ) const
{
    if ( _handle != MPI_COMM_NULL )
        MPI_Abort( _handle, exit_code );
    std::_Exit( exit_code );
}

#else

bool mpiIsGpuAware()
{
    return false;
}

MpiSession::MpiSession( int&, char**& ) {}
MpiSession::~MpiSession() = default;

Communicator::Communicator() = default;

std::vector<double> Communicator::sum( const std::vector<double>& values ) const
{
    return values;
}

std::vector<std::int64_t>
Communicator::sumCounts( std::vector<std::int64_t> values ) const
{
    return values;
}

std::vector<double> Communicator::max( std::vector<double> values ) const
{
    return values;
}

bool Communicator::allArrive( double ) const
{
    return true;
}

std::int64_t Communicator::sumBefore( std::int64_t ) const
{
    return 0;
}

std::string Communicator::from( int, const std::string& text ) const
{
    return text;
}

std::vector<char> Communicator::gatherBytes( const void* data,
                                             const std::size_t bytes,
                                             bool ) const
{
    const auto* first = static_cast<const char*>( data );
    return { first, first + bytes };
}

void Communicator::abort( const int exit_code ) const
{
    std::_Exit( exit_code );
}

#endif

bool mpiReachesMemory()
{
    static const bool reaches =
        Kokkos::SpaceAccessibility<Kokkos::HostSpace,
                                   MemorySpace>::accessible ||
        mpiIsGpuAware();
    return reaches;
}

} // namespace Machpoint
