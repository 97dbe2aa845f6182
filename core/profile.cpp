#include <core/profile.hpp>

#include <algorithm>
#include <exception>
#include <utility>

namespace Machpoint
{

namespace
{

// Host code drives the time loop from one thread, so plain data will do.
std::vector<ProfileEntry> phase_entries;
std::vector<ProfileEntry> effect_entries;
constexpr std::size_t none = static_cast<std::size_t>( -1 );
std::size_t current_phase = none;
std::size_t current_effect = none;
std::int64_t all_kernels = 0;
std::int64_t bytes_now = 0;
std::int64_t most_bytes = 0;
bool is_idle = true; // no kernel since the last fence
Kokkos::Tools::Experimental::EventSet former;

std::size_t entry( std::vector<ProfileEntry>& entries,
                   const std::string_view name )
{
    const auto found =
        std::find_if( entries.begin(), entries.end(),
                      [&]( const ProfileEntry& e ) { return e.name == name; } );
    if ( found != entries.end() )
        return found - entries.begin();
    entries.push_back( ProfileEntry{ std::string( name ) } );
    return entries.size() - 1;
}

template <class Action>
void forCurrent( const Action& action )
{
    if ( current_phase != none )
        action( phase_entries[current_phase] );
    if ( current_effect != none )
        action( effect_entries[current_effect] );
}

// Kernels on a device return before they are done.
void finishKernels()
{
    if ( !std::exchange( is_idle, true ) )
        ExecutionSpace().fence( "Machpoint::Profile" );
}

// In a destructor. What has gone wrong on the device the next call to Kokkos
// tells; an error that leaves one would end the program without a word.
void finishKernelsQuietly() noexcept
{
    try
    {
        finishKernels();
    }
    catch ( const std::exception& )
    {
    }
}

void countKernel()
{
    is_idle = false;
    ++all_kernels;
    forCurrent( []( ProfileEntry& e ) { ++e.kernels; } );
}

void beginFor( const char* name, const std::uint32_t device, std::uint64_t* id )
{
    countKernel();
    if ( former.begin_parallel_for )
        former.begin_parallel_for( name, device, id );
}

void beginReduce( const char* name, const std::uint32_t device,
                  std::uint64_t* id )
{
    countKernel();
    if ( former.begin_parallel_reduce )
        former.begin_parallel_reduce( name, device, id );
}

void beginScan( const char* name, const std::uint32_t device,
                std::uint64_t* id )
{
    countKernel();
    if ( former.begin_parallel_scan )
        former.begin_parallel_scan( name, device, id );
}

void allocate( const Kokkos::Tools::SpaceHandle space, const char* label,
               const void* const pointer, const std::uint64_t size )
{
    bytes_now += static_cast<std::int64_t>( size );
    most_bytes = std::max( most_bytes, bytes_now );
    forCurrent( [&]( ProfileEntry& e ) { e.bytes += size; } );
    if ( former.allocate_data )
        former.allocate_data( space, label, pointer, size );
}

void deallocate( const Kokkos::Tools::SpaceHandle space, const char* label,
                 const void* const pointer, const std::uint64_t size )
{
    bytes_now -= static_cast<std::int64_t>( size );
    forCurrent( [&]( ProfileEntry& e ) { e.bytes -= size; } );
    if ( former.deallocate_data )
        former.deallocate_data( space, label, pointer, size );
}

void requestNoFences( const std::uint32_t, Kokkos_Tools_ToolSettings* settings )
{
    settings->requires_global_fencing = false;
}

} // namespace

void Profile::announce()
{
    Kokkos::Tools::Experimental::set_request_tool_settings_callback(
        &requestNoFences );
}

void Profile::start()
{
    namespace Tools = Kokkos::Tools::Experimental;
    phase_entries.clear();
    effect_entries.clear();
    all_kernels = bytes_now = most_bytes = 0;
    const auto installed = Tools::get_callbacks();
    if ( installed.begin_parallel_for == &beginFor )
        return;
    former = installed;
    Tools::set_begin_parallel_for_callback( &beginFor );
    Tools::set_begin_parallel_reduce_callback( &beginReduce );
    Tools::set_begin_parallel_scan_callback( &beginScan );
    Tools::set_allocate_data_callback( &allocate );
    Tools::set_deallocate_data_callback( &deallocate );
}

const std::vector<ProfileEntry>& Profile::phases()
{
    return phase_entries;
}
const std::vector<ProfileEntry>& Profile::effects()
{
    return effect_entries;
}

std::int64_t Profile::kernels()
{
    return all_kernels;
}
std::int64_t Profile::mostBytes()
{
    return most_bytes;
}

Profile::Phase::Phase( const std::string_view name )
    : _entry( entry( phase_entries, name ) ),
      _outer( std::exchange( current_phase, _entry ) )
{
    if ( _outer != none )
    {
        finishKernels(); // those of the outer one
        _timer.reset();
    }
}

Profile::Phase::~Phase()
{
    finishKernelsQuietly();
    const double seconds = _timer.seconds();
    ++phase_entries[_entry].calls;
    phase_entries[_entry].seconds += seconds;
    if ( _outer != none )
        phase_entries[_outer].seconds -= seconds;
    current_phase = _outer;
}

Profile::Effect::Effect( const std::string_view name )
    : _entry( entry( effect_entries, name ) ),
      _outer( std::exchange( current_effect, _entry ) )
{
    finishKernels(); // those of others
    _timer.reset();
}

Profile::Effect::~Effect()
{
    finishKernelsQuietly();
    ++effect_entries[_entry].calls;
    effect_entries[_entry].seconds += _timer.seconds();
    current_effect = _outer;
}

} // namespace Machpoint
