#include <core/traffic.hpp>

#include <utility>

namespace Machpoint
{

namespace
{

Traffic traffic;
Traffic aside; // what outputs send
Activity current = Activity::compute;
Kokkos::Timer timer; // since the current activity began

Activity change( const Activity next )
{
    traffic.seconds[static_cast<std::size_t>( current )] += timer.seconds();
    timer.reset();
    return std::exchange( current, next );
}

} // namespace

Traffic Traffic::operator-( const Traffic& before ) const
{
    Traffic rest = *this;
    rest.halo_bytes -= before.halo_bytes;
    rest.halo_messages -= before.halo_messages;
    rest.migrated_particles -= before.migrated_particles;
    rest.migrated_bytes -= before.migrated_bytes;
    rest.collectives -= before.collectives;
    for ( std::size_t k = 0; k < seconds.size(); ++k )
        rest.seconds[k] -= before.seconds[k];
    return rest;
}

Traffic& Traffic::own()
{
    return current == Activity::output ? aside : traffic;
}

void Traffic::start()
{
    traffic = {};
    current = Activity::compute;
    timer.reset();
}

Traffic Traffic::upToNow()
{
    change( current );
    return traffic;
}

Traffic::Timer::Timer( const Activity activity )
    : _counts( current == Activity::compute )
{
    if ( !_counts )
        return;
    ExecutionSpace().fence( "Machpoint::Traffic" );
    change( activity );
}

Traffic::Timer::~Timer()
{
    if ( _counts )
        change( Activity::compute );
}

} // namespace Machpoint
