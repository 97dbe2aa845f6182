#include <core/large_pages.hpp>
#include <core/types.hpp>

#include <cstdint>
#include <string_view>

#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace Machpoint
{

#ifdef __linux__
namespace
{

constexpr std::uint64_t least_size = std::uint64_t( 4 ) << 20;

namespace Tools = Kokkos::Tools;

//! Of a tool, if there is one.
Tools::allocateDataFunction next = nullptr;

//! Kokkos calls this before anything is written there.
void advise( const Tools::SpaceHandle space, const char* const label,
             const void* const memory, const std::uint64_t size )
{
    if ( next )
        next( space, label, memory, size );
    if ( size < least_size ||
         !std::string_view( label ).starts_with( "Machpoint::" ) )
        return;
    static const auto page =
        static_cast<std::uintptr_t>( sysconf( _SC_PAGESIZE ) );
    const auto first = reinterpret_cast<std::uintptr_t>( memory );
    const std::uintptr_t begin = ( first + page - 1 ) / page * page;
    const std::uintptr_t end = ( first + size ) / page * page;
    // Refused, it is as slow as without.
    madvise( reinterpret_cast<void*>( begin ), end - begin, MADV_HUGEPAGE );
}

} // namespace

void askForLargePages()
{
    if constexpr ( !runs_on_host )
        return;
    const auto present = Tools::Experimental::get_callbacks().allocate_data;
    if ( present == advise )
        return;
    next = present;
    Tools::Experimental::set_allocate_data_callback( advise );
}
#else
void askForLargePages() {}
#endif

} // namespace Machpoint
