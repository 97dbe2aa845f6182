/*!
  \file time_step.hpp
  \brief Layer 5: how long a step is: the gas at its start, over all ranks, and
  what modules and the method allow.
*/
#ifndef MACHPOINT_TIME_STEP_HPP
#define MACHPOINT_TIME_STEP_HPP

#include <core/fault.hpp>
#include <core/scene.hpp>

#include <fmt/format.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace Machpoint
{

//! Looks at the gas ahead of a step and chooses dt by what it has seen.
template <int Dim>
class TimeStep
{
  public:
    //! \param scene must outlive it
    explicit TimeStep( const Scene<Dim>& scene ) : _scene( scene ) {}

    /*!
      \brief Is the gas sound, how fast is it, what are its extremes? One
      reduction tells all ranks all of it.
      \param limits of the time step that each module allows this rank; none
      where no step follows
      \return what is wrong with the gas on any rank: empty if nothing
      \throws NumericalFailure a module allows no time step
    */
    std::string survey( std::vector<double> limits )
    {
        const auto& state = _scene.state;
        const auto& found = state.survey;
        const auto& own = found.extrema;
        limits.push_back( _stable );
        std::vector<double> largest = {
            found.broken >= 0 ? 1.0 : 0.0, -own.min_density,
            -own.min_specific_internal_energy, own.max_mach, found.fastest };
        for ( const double limit : limits )
            largest.push_back( -limit );
        largest = state.decomposition.comm().max( largest );
        if ( largest[0] > 0 )
        {
            Fault worst{ found.broken };
            if ( found.broken >= 0 )
                worst.kind = kindOfBroken( state, found.broken );
            return describeWorst( state, worst );
        }
        _latest = { static_cast<Real>( -largest[1] ),
                    static_cast<Real>( -largest[2] ),
                    static_cast<Real>( largest[3] ) };
        _fastest = largest[4];
        for ( std::size_t k = 0; k < limits.size(); ++k )
            limits[k] = -largest[5 + k];
        _limits = std::move( limits );
        // The last one is the method's.
        for ( std::size_t k = 0; k + 1 < _limits.size(); ++k )
            if ( _limits[k] <= 0 )
                throw NumericalFailure( fmt::format(
                    "{} allows no time step ahead of step {}, t = {:.8g}: its "
                    "limit is no positive number; look at its parameters, and "
                    "at the gas that it sees",
                    _scene.modules[k].name, state.step, state.time ) );
        return {};
    }

    //! dt = CFL h / max(c + |v|), or less where an effect asks for it. What
    //! was surveyed last is the start of a step from now on.
    //! \param until the next output \param part of it, for a step that is
    //! repeated \throws NumericalFailure the run would not end
    double choose( const double until, const double part )
    {
        const auto& state = _scene.state;
        _of_steps += _latest;
        double dt = Kokkos::Experimental::infinity_v<double>;
        if ( _fastest > 0 )
            dt = state.cfl * state.grid.minSpacing() / _fastest;
        _limiter = "wave speed";
        for ( std::size_t k = 0; k < _limits.size(); ++k )
            if ( _limits[k] < dt )
            {
                dt = _limits[k];
                _limiter = k < _scene.modules.size() ? _scene.modules[k].name
                                                     : "stability";
            }
        if ( state.step < start_up_steps )
            dt *= start_up_factor;
        if ( part == 1 && !( dt > 1e-14 * ( until - state.time ) &&
                             state.time + dt > state.time ) )
            throw NumericalFailure( fmt::format(
                "the time step {:.3g} at step {}, t = {:.8g}, limited by {}, "
                "is too small for the {:.3g} up to the next output; the run "
                "would not end: look for a particle that is hot or fast beyond "
                "reason, or write and end earlier",
                dt, state.step, state.time, _limiter, until - state.time ) );
        // What is left before an output is parted evenly: a step of round-off
        // would be one for nothing, and forces are impulses over dt.
        const double rest = until - state.time;
        if ( 2 * dt > rest )
        {
            dt = dt * ( 1 + 1e-6 ) >= rest ? rest : 0.5 * rest;
            _limiter = "output time";
        }
        // Of what it would have been, lest it be the same once more.
        if ( part < 1 )
        {
            dt *= part;
            _limiter = "a repeated step";
        }
        return dt;
    }

    //! From the next survey on: what the arrangement of this rank's particles
    //! allows.
    void limitByStability( const double stable ) { _stable = stable; }

    //! What limited dt: a module's name or a few words.
    const std::string& limiter() const { return _limiter; }
    //! Over all ranks, the starts of steps and the last survey.
    Extrema extrema() const
    {
        auto all = _of_steps;
        all += _latest;
        return all;
    }

    //! Collective. \throws ArchiveError
    void checkpoint( Archive& archive )
    {
        archive( "limiter", _limiter );
        _stable = _scene.state.decomposition.comm().min( _stable );
        archive( "stable_time_step", _stable );
        archive( "extrema/min_density", _of_steps.min_density );
        archive( "extrema/min_specific_internal_energy",
                 _of_steps.min_specific_internal_energy );
        archive( "extrema/max_mach", _of_steps.max_mach );
    }

  private:
    const Scene<Dim>& _scene;
    //! \name Over all ranks, of the last survey
    //! @{
    double _fastest = 0;         // max of c + |v|
    std::vector<double> _limits; // of the modules, behind them the method's
    Extrema _latest;
    //! @}
    double _stable = std::numeric_limits<double>::infinity();
    std::string _limiter;
    Extrema _of_steps; // at their starts
};

} // namespace Machpoint

#endif
