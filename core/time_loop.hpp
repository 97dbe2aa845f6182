/*!
  \file time_loop.hpp
  \brief Layer 5: the time loop, with the names and numbers of Algorithm 1: all
  of it that is the same for every method on every basis, so that it is compiled
  once for each dimension.
*/
#ifndef MACHPOINT_TIME_LOOP_HPP
#define MACHPOINT_TIME_LOOP_HPP

#include <core/fault.hpp>
#include <core/image_gaps.hpp>
#include <core/image_weight.hpp>
#include <core/node_sum.hpp>
#include <core/profile.hpp>
#include <core/sampling.hpp>
#include <core/scene.hpp>
#include <core/simulation.hpp>
#include <core/sorting.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace Machpoint
{

//! What the time loop must know of a method on a basis.
struct Scheme
{
    NodeNeeds nodes;   //!< for their layout
    int stencil_nodes; //!< that a particle sees along an axis
    //! \name Of Nodes
    //! @{
    int moment_columns, velocity_columns;
    //! @}
    bool affine; //!< do particles carry an affine velocity field?
    AffineMoment affine_moment; //!< of their kinetic energy; 0 if not
    bool positive_energy;       //!< is a step repeated that makes it negative?
    int lag_column;             //!< GridVelocity::lag of v
};

/*!
  \brief One scene, advanced by what a Stepper says of its method: the private
  virtual functions, in the order of the step.

  A Stepper's constructor ends with setUp.
*/
template <int Dim>
class TimeLoop : public Simulation
{
  public:
    /*!
      Algorithm 1 of Baioni et al. 2023 (docs/method.md); `conservative` adds
      to it (docs/conservative.md). A step that breaks the gas is repeated from
      its start with half the time step.
    */
    void step( const double until ) override
    {
        prepare();
        for ( double part = 1;; part /= 2 )
        {
            chooseTimeStep( until, part );
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
        auto& state = _scene.state;
        state.time =
            state.dt >= until - state.time ? until : state.time + state.dt;
        ++state.step;
    }

    int dimension() const override { return Dim; }
    double time() const override { return _scene.state.time; }
    double timeStep() const override { return _scene.state.dt; }
    std::int64_t steps() const override { return _scene.state.step; }
    std::int64_t particles() const override { return _particles; }
    const std::string& limiter() const override { return _limiter; }
    double bytesPerParticle() const override
    {
        const auto& particles = _scene.state.particles;
        const auto count = comm().sum( std::int64_t( particles.size() ) );
        const auto bytes = comm().sum( std::int64_t( particles.bytes() ) );
        return count == 0 ? 0.0 : static_cast<double>( bytes ) / count;
    }
    Totals totals() const override { return sumParticles( _scene.state ); }
    const Extrema& extrema() const override { return _extrema; }
    void surveyExtrema() override
    {
        _scene.gas->particleState( _scene.state );
        const auto& own = _scene.state.survey.extrema;
        takeIn( comm().max( std::vector<double>{
            -own.min_density, -own.min_specific_internal_energy,
            own.max_mach } ) );
    }
    std::int64_t retries() const override { return _retries; }
    LedgerTotals ledger() const override
    {
        const auto all = ledgerOfRanks();
        return { all.mass_in.value(), all.mass_out.value(),
                 all.energy_in.value() };
    }
    Imbalance imbalance() override
    {
        _balancer.look( _scene.state.decomposition, _scene.state.particles );
        return _balancer.seen();
    }
    bool isOpen() const override { return _scene.is_open; }
    bool conservesMomentum( const int axis ) const override
    {
        for ( const auto& active : _scene.modules )
            if ( active.module->exertsForce( axis ) )
                return false;
        return !_scene.is_open && !_scene.has_wall[axis];
    }
    ParticleData particleData() override
    {
        _scene.gas->particleState( _scene.state ); // pressure without q
        return copyParticles( _scene.state );
    }
    GridData gridData() override
    {
        _scene.gas->particleState( _scene.state );
        return sampleNodes();
    }
    std::vector<const Series*> series() const override
    {
        std::vector<const Series*> list;
        for ( const auto& active : _scene.modules )
            if ( active.module->series() )
                list.push_back( active.module->series() );
        return list;
    }
    void checkpoint( Archive& archive ) override
    {
        auto& state = _scene.state;
        archive( "time", state.time );
        archive( "time_step", state.dt );
        archive( "step", state.step );
        archive( "next_id", state.next_id );
        archive( "limiter", _limiter );
        archive( "retries", _retries );
        auto ledger = ledgerOfRanks();
        ledger.mass_in.checkpoint( archive, "ledger/mass_in" );
        ledger.mass_out.checkpoint( archive, "ledger/mass_out" );
        ledger.energy_in.checkpoint( archive, "ledger/energy_in" );
        _stable = comm().min( _stable );
        archive( "stable_time_step", _stable );
        archive( "extrema/min_density", _extrema.min_density );
        archive( "extrema/min_specific_internal_energy",
                 _extrema.min_specific_internal_energy );
        archive( "extrema/max_mach", _extrema.max_mach );
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
        // What was recorded together is one rank's from here on, and rows go
        // to the ranks that now have their cells.
        state.ledger = comm().isRoot() ? ledger : Ledger{};
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
        : _scheme( scheme ), _scene( makeScene<Dim>( input, scheme.nodes ) ),
          _balancer( input.at( "decomposition" ).at( "balance" ) ),
          _sort_every( input.at( "particles" ).at( "sort_every" ) ),
          _most_retries( input.at( "time" ).at( "retries" ) )
    {
        auto& state = _scene.state;
        state.affine_moment = scheme.affine_moment;
        state.stencil_nodes = scheme.stencil_nodes;
        if ( !scheme.positive_energy )
            state.least_heat = -Kokkos::Experimental::infinity_v<Real>;
        makeNodes();
    }

    //! Initial particles and modules. \throws InputError
    void setUp()
    {
        each( "set-up", Hook::layOut, &Module<Dim>::layOut );
        each( "set-up", Hook::initialize, &Module<Dim>::initialize );
        each( "set-up", Hook::particleState, &Module<Dim>::particleState );
        _particles =
            comm().sum( std::int64_t( _scene.state.particles.size() ) );
        imbalance();
        survey( {} );
    }

    State<Dim>& state() { return _scene.state; }
    const State<Dim>& state() const { return _scene.state; }
    EquationOfState<Dim>& gas() const { return *_scene.gas; }

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
    //! Allocates its node fields for the box that this rank has now.
    virtual void layOutFields() = 0;
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
    //! Row of the first node that a particle at x sees.
    virtual int firstRow( const Vector<Dim>& x ) const = 0;
    //! Fields on the nodes, of particles whose pressures are known.
    virtual GridData sampleNodes() const = 0;
    //! @}

    const Communicator& comm() const
    {
        return _scene.state.decomposition.comm();
    }

    Ledger ledgerOfRanks() const
    {
        const auto& own = _scene.state.ledger;
        const auto sums =
            sumOfRanks( comm(), { own.mass_in, own.mass_out, own.energy_in } );
        return { sums[0], sums[1], sums[2] };
    }

    //! Allocates the node fields of any method.
    void makeNodes()
    {
        auto& state = _scene.state;
        state.nodes.moment_sum =
            makeNodeSum( "Machpoint::moments", state, _scheme.moment_columns );
        state.nodes.moments = state.nodes.moment_sum.field();
        state.nodes.velocities =
            NodeView( "Machpoint::velocities", state.layout.total,
                      _scheme.velocity_columns );
        layOutImageWeight( state );
        state.image_gaps = findImageGaps( state );
    }

    //! Makes all that hangs on this rank's box, for the box that it has now.
    void layOut()
    {
        {
            Profile::Phase phase( "balance" );
            Machpoint::layOut( _scene );
            makeNodes();
            layOutFields();
        }
        each( "balance", Hook::layOut, &Module<Dim>::layOut );
    }

    //! Every few steps: moves the boxes where one has too many particles.
    void balance()
    {
        auto& state = _scene.state;
        if ( !_balancer.isDue( comm(), state.step ) )
            return;
        {
            Profile::Phase phase( "balance" );
            // A box must be wider than its halo.
            Indices<Dim> fewest{};
            for ( int d = 0; d < Dim; ++d )
                fewest[d] = state.layout.halo[d] + 1;
            if ( !_balancer.moveCuts( state.decomposition, state.grid,
                                      state.particles, fewest ) )
                return;
        }
        layOut();
        migrateAll();
        sortParticles();
    }

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
            _stable = stableTimeStep();
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

    //! \name Particles that are marked go, others to the ranks that have their
    //! cells
    //! @{
    //! All are looked at.
    void migrateAll()
    {
        const Profile::Phase phase( "migration" );
        auto& state = _scene.state;
        _particles = state.particles.migrate(
            comm(), state.decomposition.finder( state.grid ) );
    }
    //! Those of state.noted are.
    void migrateNoted()
    {
        const Profile::Phase phase( "migration" );
        auto& state = _scene.state;
        _particles = state.particles.migrate(
            comm(), state.decomposition.finder( state.grid ), state.noted );
    }
    //! @}

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

    //! Calls action( module ) for the modules that have a hook of their own,
    //! in the order of the input.
    template <class Action>
    void withEach( const Hook hook, const Action& action )
    {
        for ( const auto& active : _scene.modules )
            if ( active.hooks.has( hook ) )
                call( active, nameOf( hook ), action );
    }
    //! Calls action( module ). An error of the module tells whose it is; what
    //! one rank has met alone ends them all. \param function of the module
    template <class Action>
    void call( const ActiveModule<Dim>& active, const char* function,
               const Action& action )
    {
        const Profile::Effect effect( active.name );
        auto where = [&]
        {
            return fmt::format( "{}, step {}", whereOf( active.name, function ),
                                _scene.state.step );
        };
        try
        {
            naming( [&] { action( *active.module ); }, where );
        }
        catch ( const NumericalFailure& failure )
        {
            const auto text = fmt::format( "{} ({})", failure.what(), where() );
            if ( !comm().allArrive() )
                throw std::runtime_error( text );
            throw NumericalFailure( text );
        }
    }
    //! Calls their hook.
    void each( const char* phase_name, const Hook which,
               void ( Module<Dim>::*hook )( State<Dim>& ) )
    {
        const Profile::Phase phase( phase_name );
        withEach( which, [&]( Module<Dim>& module )
                  { ( module.*hook )( _scene.state ); } );
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

    //! Largest time step that each module, and last the method, allows this
    //! rank.
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
        found.push_back( _stable );
        return found;
    }

    /*!
      \brief Is the gas sound, how fast is it, what are its extremes? One
      reduction tells all ranks all of it.
      \param limits of the time step, this rank's
    */
    void survey( const std::vector<double>& limits )
    {
        const auto& found = _scene.state.survey;
        const auto& own = found.extrema;
        std::vector<double> largest = {
            found.broken >= 0 ? 1.0 : 0.0, found.fastest, -own.min_density,
            -own.min_specific_internal_energy, own.max_mach };
        for ( const double limit : limits )
            largest.push_back( -limit );
        largest = comm().max( largest );
        if ( largest[0] > 0 )
        {
            const auto fault = describeWorst(
                _scene.state,
                Fault{ found.broken, found.broken >= 0 ? FaultKind::not_finite
                                                       : FaultKind::none } );
            // A boundary or a source broke the gas after the step's check.
            if ( _most_retries > 0 && _scene.state.step > 0 )
                restore();
            throw NumericalFailure( fault );
        }
        _fastest = largest[1];
        takeIn( { largest[2], largest[3], largest[4] } );
        _limits.clear();
        for ( std::size_t k = 5; k < largest.size(); ++k )
            _limits.push_back( -largest[k] );
        // The last one is the method's.
        for ( std::size_t k = 0; k + 1 < _limits.size(); ++k )
            if ( _limits[k] <= 0 )
                throw NumericalFailure( fmt::format(
                    "{} allows no time step ahead of step {}, t = {:.8g}: its "
                    "limit is no positive number; look at its parameters, and "
                    "at the gas that it sees",
                    _scene.modules[k].name, _scene.state.step,
                    _scene.state.time ) );
    }

    //! \param largest of all ranks: -density, -energy, Mach number
    void takeIn( const std::vector<double>& largest )
    {
        _extrema += Extrema{ static_cast<Real>( -largest[0] ),
                             static_cast<Real>( -largest[1] ),
                             static_cast<Real>( largest[2] ) };
    }

    //! dt = CFL h / max(c + |v|), or less where an effect asks for it.
    //! \param part of it, for a step that is repeated
    void chooseTimeStep( const double until, const double part )
    {
        auto& state = _scene.state;
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
        if ( part == 1 && !( dt > 1e-14 * ( until - state.time ) ) )
            throw NumericalFailure( fmt::format(
                "the time step fell to {:.3g} at step {}, t = {:.8g}, limited "
                "by {}; the run would not end: look for a particle that is "
                "hot or fast beyond reason",
                dt, state.step, state.time, _limiter ) );
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
        state.dt = dt;
    }

    void sortParticles()
    {
        Profile::Phase phase( "sort" );
        auto& state = _scene.state;
        const auto& box = state.layout.box;
        auto cells = cellsOf( state.particles.template slice<Position>(),
                              state.grid, box );
        if ( state.reproducible || !areNearlySorted( cells ) )
        {
            // Handed over, as the order needs the memory of the cells.
            const auto bins =
                Cabana::binByKey( std::exchange( cells, {} ), box.totalCells(),
                                  0, state.particles.size() );
            state.particles.permute( bins );
            if ( state.reproducible )
                checkCrowding( mostInCell( bins ) );
        }
        setSeams();
    }

    //! Gives each thread the nodes from the first that its particles see.
    void setSeams()
    {
        if constexpr ( NodeSeams::has_threads )
        {
            const auto& state = _scene.state;
            const auto x = state.particles.template slice<Position>();
            const int n = state.particles.size();
            const int share =
                shareOf( countPacks( n ), loopThreads(), few_stencils<Dim> ) *
                lane_count;
            int first = 0;
            for ( int t = 1; t < state.seams.threads(); ++t )
            {
                const int row =
                    t * share < n ? firstRow( loadVector<Dim>( x, t * share ) )
                                  : state.layout.total;
                // A half may stand beyond the box, ahead of its cell's order.
                first = std::max( first, row );
                state.seams.set( t, first );
            }
        }
    }

    //! \throws NumericalFailure where a node has more terms than a reproducible
    //! sum holds; half of them are for images, and what comes before the next
    //! sort
    void checkCrowding( const int own_most ) const
    {
        int limit = 1 << ( RoundedTerms::log2_terms - 1 );
        for ( int d = 0; d < Dim; ++d )
            limit /= _scheme.stencil_nodes;
        const double most = comm().max( static_cast<double>( own_most ) );
        if ( most > limit )
            throw NumericalFailure( fmt::format(
                "{} particles share a cell at step {}, and with reproducible "
                "sums {} can: take fewer particles.per_cell, a larger "
                "method.merge_volume, or reproducible false",
                most, _scene.state.step, limit ) );
    }

  public:
    //! Makes state.leavers, of what was noted. Public, as the next one, only
    //! because nvcc wants the parent function of a device lambda to be
    //! accessible.
    void findLeavers()
    {
        auto& state = _scene.state;
        const auto x = state.particles.template slice<Position>();
        const auto domain = domainBounds( state.grid );
        state.leavers = state.noted.rows(
            state.particles.size(), MACHPOINT_LAMBDA( const int p ) {
                return domain.excludes( loadVector<Dim>( x, p ) );
            } );
        if ( !_scene.is_open )
            return;
        const Profile::Effect effect( "retries" );
        state.particles.keepIdentities( state.leavers );
    }

    //! Notes the particles from a row on, which have just entered.
    void noteFrom( const int first )
    {
        const auto noted = _scene.state.noted;
        const int n = _scene.state.particles.size();
        if ( n > first )
            Kokkos::parallel_for(
                "Machpoint::noteNew", Range( first, n ),
                MACHPOINT_LAMBDA( const int p ) { noted.note( p ); } );
    }

  private:
    Scheme _scheme;
    Scene<Dim> _scene;
    Balancer<Dim> _balancer;
    int _sort_every;
    int _most_retries;
    std::int64_t _particles = 0; // on all ranks
    std::int64_t _retries = 0;
    bool _has_sources = false; // after G2P, in this step
    //! \name Over all ranks, before the step
    //! @{
    double _fastest = 0;         // max of c + |v|
    std::vector<double> _limits; // of the time step, [modules + 1]
    //! @}
    //! That the arrangement of this rank's particles allows.
    double _stable = std::numeric_limits<double>::infinity();
    Ledger _saved_ledger;
    double _saved_time = 0;
    std::int64_t _saved_step = 0;
    std::string _limiter;
    Extrema _extrema;
};

} // namespace Machpoint

#endif
