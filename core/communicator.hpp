/*!
  \file communicator.hpp
  \brief Layer 1: the processes of a run, and what they tell each other on the
  host. One process, or a build without MPI, is the case of one rank.
*/
#ifndef MACHPOINT_COMMUNICATOR_HPP
#define MACHPOINT_COMMUNICATOR_HPP

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#ifdef MACHPOINT_ENABLE_MPI
#include <mpi.h>
#endif

namespace Machpoint
{

/*!
  \brief Starts and ends MPI, if a launcher such as mpirun started the program.

  Without a launcher MPI stays off: a single run then starts in milliseconds and
  needs no daemon. One object, made by main before anything else.
*/
class MpiSession
{
  public:
    //! \param argc, argv of main; MPI may take words of its own out
    MpiSession( int& argc, char**& argv );
    ~MpiSession();
    MpiSession( const MpiSession& ) = delete;
    MpiSession& operator=( const MpiSession& ) = delete;
};

//! How many processes the launcher of this one says that it started; 1 without
//! a launcher. More than a Communicator has where this build lacks MPI, or has
//! another MPI than the launcher.
int launchedProcesses();

//! Does MPI read and write this build's memory? It does not know a GPU's unless
//! it was built and started for it; messages then go through copies on the
//! host.
bool mpiReachesMemory();

//! Is it a GPU's memory that MPI reaches?
bool mpiIsGpuAware();

/*!
  \brief The ranks of a run. Every member but rank, size, isRoot, allArrive,
  abort and handle is collective: all ranks call it, in the same order.
*/
class Communicator
{
  public:
    //! All ranks of the run; one where MPI is off.
    Communicator();

    //! This one's number, 0 to size() - 1.
    int rank() const { return _rank; }
    //! How many there are.
    int size() const { return _size; }
    //! The rank that prints, and that writes what is not a field.
    bool isRoot() const { return _rank == 0; }

    //! \name Reductions over ranks, element by element
    //! Sums are taken in the order of the ranks, so they repeat exactly. Lists
    //! have the same length on all ranks.
    //! @{
    std::vector<double> sum( const std::vector<double>& values ) const;
    std::int64_t sum( std::int64_t value ) const
    {
        return sumCounts( { value } )[0];
    }
    double sum( double value ) const { return sum( std::vector{ value } )[0]; }
    std::vector<std::int64_t>
    sumCounts( std::vector<std::int64_t> values ) const;
    std::vector<double> max( std::vector<double> values ) const;
    double max( double value ) const { return max( std::vector{ value } )[0]; }
    double min( double value ) const { return -max( -value ); }
    bool any( bool value ) const { return max( value ? 1.0 : 0.0 ) > 0; }
    //! @}

    //! Sum of the values of the ranks before this one; 0 on the first.
    std::int64_t sumBefore( std::int64_t value ) const;

    //! \name What ranks tell each other
    //! \throws std::runtime_error where it is more than 2 GiB together
    //! @{
    //! The text of one rank, on every rank.
    std::string from( int rank, const std::string& text ) const;
    //! The root's text, on every rank.
    std::string fromRoot( const std::string& text ) const
    {
        return from( 0, text );
    }

    //! The lists of all ranks, one after the other, on every rank.
    template <class T>
    std::vector<T> gatherAll( const std::vector<T>& own ) const
    {
        static_assert( std::is_trivially_copyable_v<T> );
        return typed<T>(
            gatherBytes( own.data(), own.size() * sizeof( T ), true ) );
    }
    //! The same on the root alone; empty elsewhere.
    template <class T>
    std::vector<T> gather( const std::vector<T>& own ) const
    {
        static_assert( std::is_trivially_copyable_v<T> );
        return typed<T>(
            gatherBytes( own.data(), own.size() * sizeof( T ), false ) );
    }
    //! @}

    //! Do all ranks call this within so many seconds? For a failure that one
    //! rank may have met alone, while the others wait for what it would send.
    bool allArrive( double seconds = 10 ) const;
    //! Ends all ranks at once; for a failure that only this rank has met.
    [[noreturn]] void abort( int exit_code ) const;

#ifdef MACHPOINT_ENABLE_MPI
    //! For libraries that speak MPI; MPI_COMM_NULL where MPI is off.
    MPI_Comm handle() const
    {
        return _handle;
    }
#endif

  private:
    std::vector<char> gatherBytes( const void* data, std::size_t bytes,
                                   bool everywhere ) const;
    template <class T>
    static std::vector<T> typed( const std::vector<char>& bytes )
    {
        std::vector<T> list( bytes.size() / sizeof( T ) );
        if ( !list.empty() )
            std::memcpy( list.data(), bytes.data(), bytes.size() );
        return list;
    }

    int _rank = 0;
    int _size = 1;
#ifdef MACHPOINT_ENABLE_MPI
    MPI_Comm _handle = MPI_COMM_NULL;
#endif
};

} // namespace Machpoint

#endif
