/*!
  \file scene_run.hpp
  \brief Layer 5: a scene in a run, between the kernels of its steps: how its
  modules are called, and how its nodes and particles keep their places.
*/
#ifndef MACHPOINT_SCENE_RUN_HPP
#define MACHPOINT_SCENE_RUN_HPP

#include <core/image_gaps.hpp>
#include <core/image_weight.hpp>
#include <core/node_sum.hpp>
#include <core/profile.hpp>
#include <core/sampling.hpp>
#include <core/scene.hpp>
#include <core/simulation.hpp>
#include <core/sorting.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

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
  \brief A scene in a run, around its steps: calls its modules, keeps its nodes
  on this rank's box and its particles sorted, and on the ranks that have their
  cells; and tells a driver of it.
*/
template <int Dim>
class SceneRun : public Simulation
{
  public:
    int dimension() const override { return Dim; }
    double time() const override { return _scene.state.time; }
    double timeStep() const override { return _scene.state.dt; }
    std::int64_t steps() const override { return _scene.state.step; }
    std::int64_t particles() const override { return _particles; }
    double bytesPerParticle() const override
    {
        const auto& particles = _scene.state.particles;
        const auto count = comm().sum( std::int64_t( particles.size() ) );
        const auto bytes = comm().sum( std::int64_t( particles.bytes() ) );
        return count == 0 ? 0.0 : static_cast<double>( bytes ) / count;
    }
    Totals totals() const override { return sumParticles( _scene.state ); }
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

  protected:
    //! \param input resolved \throws InputError
    SceneRun( const Json& input, const Scheme& scheme )
        : _scheme( scheme ), _scene( makeScene<Dim>( input, scheme.nodes ) ),
          _balancer( input.at( "decomposition" ).at( "balance" ) )
    {
        auto& state = _scene.state;
        state.affine_moment = scheme.affine_moment;
        state.stencil_nodes = scheme.stencil_nodes;
        if ( !scheme.positive_energy )
            state.least_heat = -Kokkos::Experimental::infinity_v<Real>;
        makeNodes();
    }

    State<Dim>& state() { return _scene.state; }
    const State<Dim>& state() const { return _scene.state; }
    EquationOfState<Dim>& gas() const { return *_scene.gas; }

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

    //! Calls action( module ) for the modules that have a hook of their own,
    //! in the order of the input, but the equation of state first, bodies
    //! before sides, and of sides periodic ones first.
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

  private:
    //! \name What a method does
    //! @{
    //! Allocates its node fields for the box that this rank has now.
    virtual void layOutFields() = 0;
    //! Row of the first node that a particle at x sees.
    virtual int firstRow( const Vector<Dim>& x ) const = 0;
    //! Fields on the nodes, of particles whose pressures are known.
    virtual GridData sampleNodes() const = 0;
    //! @}

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
        const int count = _scene.state.particles.size() - first;
        if ( count > 0 )
            forEach(
                "Machpoint::noteNew", count,
                MACHPOINT_LAMBDA( const int k ) { noted.note( first + k ); },
                few_particles );
    }

  protected:
    Scheme _scheme;
    Scene<Dim> _scene;
    Balancer<Dim> _balancer;
    std::int64_t _particles = 0; // on all ranks
};

} // namespace Machpoint

#endif
