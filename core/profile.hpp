/*!
  \file profile.hpp
  \brief Who spent what: seconds per phase of the time step; kernels, seconds
  and bytes per effect, counted by Kokkos Tools callbacks.
*/
#ifndef MACHPOINT_PROFILE_HPP
#define MACHPOINT_PROFILE_HPP

#include <core/types.hpp>

#include <Kokkos_Timer.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace Machpoint
{

//! One line of the end table.
struct ProfileEntry
{
    std::string name;
    std::int64_t calls = 0;   //!< how often it was begun
    std::int64_t kernels = 0; //!< parallel_for, _reduce and _scan launched
    std::int64_t bytes = 0;   //!< allocated less freed
    double seconds = 0;       //!< of wall time
};

/*!
  \brief The run's profile. There is one, because Kokkos' callbacks are plain
  functions; callbacks that a profiling tool installed before go on working.
*/
class Profile
{
  public:
    /*!
      \brief Before Kokkos is initialized: says that counting needs no fences.

      Without, Kokkos waits for all that runs before each kernel, as it would
      have to for a tool that takes the time of each: where there is little to
      do, a step on a GPU takes half as long again (docs/performance_tried.md).
    */
    static void announce();
    //! Clears all entries and installs the callbacks (once).
    static void start();

    //! In the order in which they began for the first time.
    static const std::vector<ProfileEntry>& phases();
    //! The same of effects.
    static const std::vector<ProfileEntry>& effects();
    //! Kernels launched since start(), by whomever.
    static std::int64_t kernels();
    //! Most bytes that arrays have held at once since start(), host and device.
    static std::int64_t mostBytes();

    //! Attributes time, kernels and memory to a phase while it lives; within
    //! another one to the inner one alone.
    class Phase
    {
      public:
        //! \param name of its entry, which phases may share
        explicit Phase( std::string_view name );
        ~Phase();
        Phase( const Phase& ) = delete;

      private:
        std::size_t _entry, _outer;
        Kokkos::Timer _timer;
    };

    //! The same for an effect, but that time counts for both.
    class Effect
    {
      public:
        //! \param name of its entry, as in the end table
        explicit Effect( std::string_view name );
        ~Effect();
        Effect( const Effect& ) = delete;

      private:
        std::size_t _entry, _outer;
        Kokkos::Timer _timer;
    };
};

} // namespace Machpoint

#endif
