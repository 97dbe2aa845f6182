#include <core/kokkos_session.hpp>
#include <core/large_pages.hpp>
#include <core/profile.hpp>

#include <type_traits>

namespace Machpoint
{

KokkosSession::KokkosSession()
{
    Profile::announce();
    Kokkos::InitializationSettings settings;
    settings.set_disable_warnings( true );
#ifdef KOKKOS_ENABLE_SERIAL
    if ( std::is_same_v<ExecutionSpace, Kokkos::Serial> )
        settings.set_num_threads( 1 );
#endif
    Kokkos::initialize( settings );
    askForLargePages();
}

KokkosSession::~KokkosSession()
{
    Kokkos::finalize();
}

} // namespace Machpoint
