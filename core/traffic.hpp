/*!
  \file traffic.hpp
  \brief Layer 1: what this rank sends to others, and what its time goes into.
*/
#ifndef MACHPOINT_TRAFFIC_HPP
#define MACHPOINT_TRAFFIC_HPP

#include <core/types.hpp>

#include <Kokkos_Timer.hpp>

#include <array>

namespace Machpoint
{

//! What a rank does; every moment counts for one of them.
enum class Activity : std::size_t
{
    compute,     //!< all else
    halo,        //!< layers of nodes packed, sent and taken up
    halo_wait,   //!< until a neighbour's layers are here
    migration,   //!< particles that change ranks
    collectives, //!< sums over ranks, and the wait for the last of them
    output       //!< files, checkpoints included
};

//! Names of the activities, as in summary.json.
inline constexpr std::array activity_names = {
    "compute", "halo", "halo_wait", "migration", "collectives", "output" };

/*!
  \brief What this rank has sent since start(), and the seconds of each
  activity.

  There is one, like the profile: host code drives the time loop from one
  thread.
*/
struct Traffic
{
    //! \name What was sent
    //! @{
    std::int64_t halo_bytes = 0;
    std::int64_t halo_messages = 0;
    std::int64_t migrated_particles = 0;
    std::int64_t migrated_bytes = 0;
    //! @}
    std::int64_t collectives = 0; //!< calls of all ranks, of whatever size
    //! Wall time of each Activity.
    std::array<double, activity_names.size()> seconds{};

    //! What of this came after `before`.
    Traffic operator-( const Traffic& before ) const;

    //! This rank's, to add to; during an output another one, soon forgotten.
    static Traffic& own();
    //! Forgets all; from now on the rank computes.
    static void start();

    /*!
      \brief Attributes time to an activity while it lives.

      Only within `compute`: what output or migration calls for is theirs. On a
      device it fences first, so that kernels count as what launched them.
    */
    class Timer
    {
      public:
        explicit Timer( Activity activity );
        ~Timer();
        Timer( const Timer& ) = delete;
        Timer& operator=( const Timer& ) = delete;

      private:
        bool _counts;
    };

    //! What was sent and took time up to now. Ends no activity.
    static Traffic upToNow();
};

} // namespace Machpoint

#endif
