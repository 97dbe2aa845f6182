#include <core/for_each.hpp>

namespace Machpoint::Impl
{

namespace
{

//! While it lives, copies of Views are not counted, as in Kokkos' own loops.
class Uncounted
{
  public:
    using Records = Kokkos::Impl::SharedAllocationRecord<void, void>;

    Uncounted() : _counted( Records::tracking_enabled() )
    {
        Records::tracking_disable();
    }
    ~Uncounted()
    {
        if ( _counted )
            Records::tracking_enable();
    }
    Uncounted( const Uncounted& ) = delete;

  private:
    const bool _counted;
};

struct Shares
{
    const void* turns;
    void ( *take )( const void*, int, int );
    int count;
    int share; //!< turns of a thread

    void operator()( const int thread ) const
    {
        const int first = Kokkos::min( thread * share, count );
        const int last = Kokkos::min( first + share, count );
        if ( first == last )
            return;
        const Uncounted uncounted;
        take( turns, first, last );
    }
};

} // namespace

void shareTurns( const char* label, const int count, const int share,
                 const void* turns, void ( *take )( const void*, int, int ) )
{
    // No backend of a GPU calls this.
    using Threads = std::conditional_t<runs_on_host, ExecutionSpace,
                                       Kokkos::DefaultHostExecutionSpace>;
    const Shares shares{ turns, take, count, share };
    if ( share < count )
        return Kokkos::parallel_for(
            label, Kokkos::RangePolicy<Threads>( 0, loopThreads() ), shares );
    static const std::uint32_t device =
        Kokkos::Tools::Experimental::device_id( ExecutionSpace() );
    const bool is_told = Kokkos::Tools::profileLibraryLoaded();
    std::uint64_t id = 0;
    if ( is_told )
        Kokkos::Tools::beginParallelFor( label, device, &id );
    shares( 0 );
    if ( is_told )
        Kokkos::Tools::endParallelFor( id );
}

} // namespace Machpoint::Impl
