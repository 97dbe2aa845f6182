/*!
  \file kokkos_session.hpp
  \brief Layer 1: Kokkos, started as this program needs it.
*/
#ifndef MACHPOINT_KOKKOS_SESSION_HPP
#define MACHPOINT_KOKKOS_SESSION_HPP

namespace Machpoint
{

/*!
  \brief Starts and ends Kokkos: without fences at kernels (Profile::announce),
  with large pages (askForLargePages), and on one thread if the backend is
  Serial.

  Kokkos may know OpenMP beside Serial. Its threads then wait for work that
  never comes, as fast as they can, and take that time from other runs on the
  machine.

  Kokkos' own flags are not ours; its environment variables work. One object,
  made after MpiSession.
*/
class KokkosSession
{
  public:
    KokkosSession();
    ~KokkosSession();
    KokkosSession( const KokkosSession& ) = delete;
    KokkosSession& operator=( const KokkosSession& ) = delete;
};

} // namespace Machpoint

#endif
