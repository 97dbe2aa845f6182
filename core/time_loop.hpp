/*!
  \file time_loop.hpp
  \brief Layer 5: the time loop, with the names and numbers of Algorithm 1: all
  of it that is the same for every method on every basis, so that it is compiled
  once for each dimension.
*/
#ifndef MACHPOINT_TIME_LOOP_HPP
#define MACHPOINT_TIME_LOOP_HPP

#include <core/fault.hpp>
#include <core/image_weight.hpp>
#include <core/profile.hpp>
#include <core/scene_run.hpp>
#include <core/time_step.hpp>

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief One scene, advanced by what a Stepper says of its method: the private
  virtual functions, in the order of the step.

  A Stepper's constructor ends with setUp.
*/
template <int Dim>
class TimeLoop : public SceneRun<Dim>
{
    using Run = SceneRun<Dim>;
    //! \name Of the scene
    //! @{
    using Run::_balancer, Run::_particles, Run::_scene, Run::_scheme;
    using Run::balance, Run::layOut, Run::sortParticles;
    using Run::call, Run::each, Run::withEach;
    using Run::comm;
    using Run::findLeavers, Run::noteFrom;
    using Run::migrateAll, Run::migrateNoted;
    //! @}

  public:
    /*!
      Algorithm 1 of Baioni et al. 2023 (docs/method.md); `conservative` adds
      to it (docs/conservative.md). A step that breaks the gas is repeated from
      its start with half the time step.
    */
    void step( const double until ) override
    {
        auto& state = _scene.state;
        prepare();
        for ( double part = 1;; part /= 2 )
        {
            state.dt = _time_step.choose( until, part );
            orTakeBack( [&] { advance(); } );
            const auto fault = findFault();
            if ( fault.empty() )
                break;
            reject( fault, part );
        }
        orTakeBack(
            [&]
            {
                applyBoundaries();
                inject();
                migrateNoted();
            } );
        state.time =
            state.dt >= until - state.time ? until : state.time + state.dt;
        ++state.step;
    }

    const std::string& limiter() const override { return _time_step.limiter(); }
    Extrema extrema() const override { return _time_step.extrema(); }
    void surveyExtrema() override
    {
        _scene.gas->particleState( _scene.state );
        survey( {} );
    }
    std::int64_t retries() const override { return _retries; }
    void checkpoint( Archive& archive ) override
    {
        auto& state = _scene.state;
        archive( "time", state.time );
        archive( "time_step", state.dt );
        archive( "step", state.step );
        archive( "next_id", state.next_id );
        archive( "retries", _retries );
        auto& ledger = state.ledger;
        checkpointOfRanks( archive, comm(), "ledger/mass_in", ledger.mass_in );
        checkpointOfRanks( archive, comm(), "ledger/mass_out",
                           ledger.mass_out );
        checkpointOfRanks( archive, comm(), "ledger/energy_in",
                           ledger.energy_in );
        _time_step.checkpoint( archive );
        _balancer.checkpoint( archive );
        state.decomposition.checkpoint( archive );
        state.particles.checkpoint( archive );
        for ( std::size_t k = 0; k < _scene.modules.size(); ++k )
        {
            const auto& active = _scene.modules[k];
            const Archive::Group group(
                archive, fmt::format( "modules/{} {}", k, active.name ) );
            call( active, "checkpoint",
                  [&]( Module<Dim>& module )
                  { module.checkpoint( archive ); } );
        }
        if ( !archive.isReading() )
            return;
        // Rows go to the ranks that now have their cells.
        if ( comm().size() > 1 )
            layOut();
        migrateAll();
        keepLedger();
        if ( _most_retries > 0 )
            state.particles.save();
    }

  protected:
    //! \param input resolved \throws InputError
    TimeLoop( const Json& input, const Scheme& scheme )
        : Run( input, scheme ),
          _sort_every( input.at( "particles" ).at( "sort_every" ) ),
          _most_retries( input.at( "time" ).at( "retries" ) )
    {
    }

    //! Initial particles and modules. \throws InputError
    void setUp()
    {
        each( "set-up", Hook::layOut, &Module<Dim>::layOut );
        each( "set-up", Hook::initialize, &Module<Dim>::initialize );
        each( "set-up", Hook::particleState, &Module<Dim>::particleState );
        _particles =
            comm().sum( std::int64_t( _scene.state.particles.size() ) );
        this->imbalance();
        survey( {} );
    }

    //! The images of the particles where they stand now.
    void mirrorParticles()
    {
        _scene.state.images.count = 0;
        each( "images", Hook::mirrorParticles, &Module<Dim>::mirrorParticles );
    }

    //! Applies boundaries to a node velocity.
    void constrain( const GridVelocity& velocity )
    {
        Profile::Phase phase( "grid boundaries" );
        withEach( Hook::applyToGrid, [&]( Module<Dim>& module )
                  { module.applyToGrid( _scene.state, velocity ); } );
    }

  private:
    //! \name What a method does
    //! @{
    //! Before anything else: rearranges particles.
    virtual void prepareParticles() = 0;
    //! Lines 2 to 4. Calls mirrorParticles if images of particles deposit.
    virtual void particlesToGrid() = 0;
    //! Sums that ranks and sides have to share, and node velocities.
    virtual void foldMoments() = 0;
    //! Line 5.
    virtual void advanceVelocities() = 0;
    //! Largest time step that the arrangement of this rank's particles allows.
    virtual double stableTimeStep() const = 0;
    //! Lines 6 to 10.
    virtual void gridToParticles() = 0;
    //! @}

    //! All that comes before the choice of dt: rearranged, checked and sorted
    //! particles.
    void prepare()
    {
        auto& state = _scene.state;
        {
            Profile::Phase phase( "prepare" );
            prepareParticles();
        }
        each( "particle state", Hook::particleState,
              &Module<Dim>::particleState ); // 1
        const auto own = limits();
        {
            Profile::Phase phase( "guard" );
            survey( own );
        }
        // A state that is sound, so that the one before is not needed.
        if ( state.step % _sort_every == 0 )
            sortParticles();
        balance();
        keepLedger();
    }

    //! Largest time step that each module allows this rank.
    std::vector<double> limits()
    {
        Profile::Phase phase( "time step" );
        std::vector<double> found( _scene.modules.size(),
                                   std::numeric_limits<double>::infinity() );
        for ( std::size_t k = 0; k < found.size(); ++k )
        {
            const auto& active = _scene.modules[k];
            if ( !active.hooks.has( Hook::limitTimeStep ) )
                continue;
            call( active, nameOf( Hook::limitTimeStep ),
                  [&]( Module<Dim>& module )
                  { found[k] = module.limitTimeStep( _scene.state ); } );
            // What is no limit, NaN for one, shall not get lost on the way.
            if ( !( found[k] > 0 ) )
                found[k] = 0;
        }
        return found;
    }

    //! Surveys the gas where a step starts or ends. \param limits of the time
    //! step, this rank's \throws NumericalFailure where it is not sound
    void survey( const std::vector<double>& limits )
    {
        auto fault = _time_step.survey( limits );
        if ( fault.empty() )
            return;
        if ( _most_retries > 0 && _scene.state.step > 0 )
        {
            fault += "; it was sound when the last step was checked, so look "
                     "at boundaries, sources and inflows, too, which come "
                     "after that";
            restore();
        }
        throw NumericalFailure( fault );
    }

    //! Keeps what is not of the particles for a step that is repeated.
    void keepLedger()
    {
        const auto& state = _scene.state;
        _saved_ledger = state.ledger;
        _saved_time = state.time;
        _saved_step = state.step;
    }

    //! Lines 2 to 10: from particles to particles, sides not yet applied.
    void advance()
    {
        auto& state = _scene.state;
        {
            Profile::Phase phase( "guard" );
            const Profile::Effect effect( "retries" );
            // A reproducible sum asks particles twice for what they add, where
            // they are at the step's start.
            state.particles.beginStep( _most_retries > 0 ||
                                       state.reproducible );
        }
        state.noted.clear( state.particles.size() );
        {
            Profile::Phase phase( "P2G" );
            particlesToGrid(); // 2-4
        }
        each( "grid force", Hook::keepDeposit, &Module<Dim>::keepDeposit );
        {
            Profile::Phase phase( "grid" );
            foldMoments();
        }
        // FLIP takes up only v' - v, so there v alone gives no impulse.
        constrain( { state.nodes.velocities, 0, _scheme.affine,
                     _scheme.lag_column } ); // eq. 7
        {
            Profile::Phase phase( "grid" );
            advanceVelocities(); // 5
        }
        if ( state.step % stability_every == 0 )
        {
            Profile::Phase phase( "time step" );
            _time_step.limitByStability( stableTimeStep() );
        }
        each( "grid force", Hook::gridForce, &Module<Dim>::gridForce );
        applyImageWeight( state );
        constrain( { state.nodes.velocities, Dim } ); // eq. 7
        each( "grid work", Hook::gridWork, &Module<Dim>::gridWork );
        accountForImageWeight( state );
        {
            Profile::Phase phase( "G2P" );
            gridToParticles(); // 6-10
        }
        state.particles.endStep();
        applySources();
    }

    void applySources()
    {
        Profile::Phase phase( "particle source" );
        _has_sources = false;
        withEach( Hook::particleSource,
                  [&]( Module<Dim>& module )
                  {
                      if ( module.particleSource( _scene.state ) )
                          _has_sources = true;
                  } );
    }

    //! What is wrong with the gas on any rank: empty if nothing.
    std::string findFault()
    {
        if ( _most_retries == 0 )
            return {};
        Profile::Phase phase( "guard" );
        const Profile::Effect effect( "retries" );
        auto& state = _scene.state;
        if ( !isSuspected( state, Unsound ) && !_has_sources )
            return describeWorst( state, Fault{} );
        return describeWorst( state, Machpoint::findFault( state ) );
    }

    //! Returns to the start of the step. \throws NumericalFailure when a
    //! shorter step has been tried often enough
    void reject( const std::string& fault, const double part )
    {
        restore();
        if ( part * std::ldexp( 1.0, _most_retries ) < 1.5 )
            throw NumericalFailure( fault );
        ++_retries;
        each( "particle state", Hook::particleState,
              &Module<Dim>::particleState );
    }

    void restore()
    {
        auto& state = _scene.state;
        state.particles.restore();
        _particles = comm().sum( std::int64_t( state.particles.size() ) );
        state.ledger = _saved_ledger;
        state.time = _saved_time;
        state.step = _saved_step;
        for ( auto& active : _scene.modules )
            call( active, "rejectStep",
                  [&]( Module<Dim>& module ) { module.rejectStep( state ); } );
    }

    //! Leavers are looked for again where a module has moved others.
    void applyBoundaries()
    {
        Profile::Phase phase( "particle boundaries" );
        auto& state = _scene.state;
        int seen = -1;
        for ( const auto& active : _scene.modules )
        {
            if ( !active.hooks.has( Hook::applyToParticles ) )
                continue;
            if ( const int noted = state.noted.count(); noted != seen )
            {
                findLeavers();
                seen = noted;
            }
            call( active, nameOf( Hook::applyToParticles ),
                  [&]( Module<Dim>& module )
                  { module.applyToParticles( state ); } );
        }
    }

    //! New particles may be another rank's.
    void inject()
    {
        auto& state = _scene.state;
        const int n = state.particles.size();
        each( "inject", Hook::inject, &Module<Dim>::inject );
        noteFrom( n );
    }

    //! Part of a step. Where it fails, the start of the step is the last good
    //! state.
    template <class Action>
    void orTakeBack( const Action& action )
    {
        try
        {
            action();
        }
        catch ( const NumericalFailure& )
        {
            if ( _most_retries > 0 )
                restore();
            throw;
        }
    }

    int _sort_every;
    int _most_retries;
    std::int64_t _retries = 0;
    bool _has_sources = false; // after G2P, in this step
    TimeStep<Dim> _time_step{ _scene };
    Ledger _saved_ledger;
    double _saved_time = 0;
    std::int64_t _saved_step = 0;
};

} // namespace Machpoint

#endif
