/*!
  \file launch.hpp
  \brief Layer 7: what the program is started with: the processes beside it, its
  threads, and Kokkos.
*/
#ifndef MACHPOINT_LAUNCH_HPP
#define MACHPOINT_LAUNCH_HPP

#include <core/communicator.hpp>
#include <core/kokkos_session.hpp>

#include <optional>
#include <string>

namespace Machpoint
{

//! \throws InputError where processes that were started together know nothing
//! of each other: each would do the whole run.
void requireAllProcesses( const Communicator& ranks );

//! The number of threads that Kokkos is to take here, and in processes that
//! this one starts; 0 where KOKKOS_NUM_THREADS is no number.
int threadCount();

//! What is wrong with the number of threads that this process is to have, which
//! Kokkos would abort or hang on; empty: nothing.
std::string faultOfThreads();

//! Starts Kokkos. \return why it starts on no GPU; empty: nothing is wrong
std::string startKokkos( std::optional<KokkosSession>& kokkos );

} // namespace Machpoint

#endif
