/*!
  \file module.hpp
  \brief Layer 4: what an effect or a boundary is. A module is a struct with a
  name, its declared parameters, and any of the hooks below; the time loop calls
  the hooks of the modules in the scene, in the order of the input, but the
  equation of state first, bodies before sides, and of sides periodic ones
  first. What its type says of an entry before that is in input_hooks.hpp.
*/
#ifndef MACHPOINT_MODULE_HPP
#define MACHPOINT_MODULE_HPP

#include <core/bounds.hpp>
#include <core/input_hooks.hpp>
#include <core/series.hpp>
#include <core/state.hpp>

namespace Machpoint
{

//! A velocity on the nodes, as a boundary sees it.
struct GridVelocity
{
    NodeView field;   //!< [nodes][>= first + Dim]
    int first = 0;    //!< column of component 0
    bool acts = true; //!< a change of it is an impulse on the gas; false
                      //!< for velocities that only serve as a gradient
    int lag = -1;     //!< column of 1 - beta, the part of a change of v that
                      //!< particles do not take up; -1: they take up all

    //! Part of a change in a row that is an impulse on the gas, 0 to 1.
    KOKKOS_INLINE_FUNCTION Real takenUp( const int row ) const
    {
        return lag < 0 ? 1.0_rt : 1 - field( row, lag );
    }
};

/*!
  \brief Base of all physics and boundary modules: hooks that do nothing.

  The time loop calls none of MACHPOINT_HOOKS that a module does not override
  (hooksOf). A hook of the time step may throw NumericalFailure, on all ranks
  alike: the run ends with the last good state. What one rank throws alone, and
  any other error, ends all of them at once.
*/
template <int Dim>
class Module
{
  public:
    virtual ~Module() = default;

    //! Its number in state.bodies, if its type has a `solid`; else -1.
    int body = -1;

    //! Allocate and list what hangs on this rank's nodes: before initialize,
    //! and again whenever state.layout has changed, because the ranks' boxes
    //! move with the gas. What must outlive that belongs on particles.
    virtual void layOut( State<Dim>& ) {}
    //! Before the first step: precompute.
    virtual void initialize( State<Dim>& ) {}
    //! Sets or adds to the pressure and sound speed of particles, and changes
    //! nothing else: a step that is repeated calls it once more. Who raises the
    //! sound speed bounds the step in limitTimeStep, too: the wave speed that
    //! it is chosen by is the gas's own. Sorting and other ranks come between
    //! limitTimeStep and keepDeposit, so rows are of other particles then.
    virtual void particleState( State<Dim>& ) {}
    //! Largest stable time step for this rank's gas, time, state.cfl included
    //! where it is due; infinity when there is no limit. One that is not
    //! positive, or NaN, ends the run.
    virtual Real limitTimeStep( State<Dim>& )
    {
        return Kokkos::Experimental::infinity_v<Real>;
    }
    //! Appends the mirror images of particles that it calls for, where these
    //! stand now; once for each time that a sum asks for them.
    virtual void mirrorParticles( State<Dim>& ) {}
    //! How near to its surface particles have an image, cells along the
    //! normal; 0: none has.
    virtual Real imageReach() const { return 0; }
    //! What it gives to all gas in keepDeposit and gridForce, by mass on the
    //! nodes, constant in time; an image is due its mirror image instead.
    //! length/time^2 [Dim]
    virtual Vector<Dim> acceleration() const { return {}; }
    //! Keeps what it needs of state.nodes.moment_sum from before the fold.
    virtual void keepDeposit( State<Dim>& ) {}
    //! Adds dt f / m of a force to v' on all stored nodes, walls and neighbours
    //! folded in.
    virtual void gridForce( State<Dim>& ) {}
    //! Constrains a velocity on all stored nodes: once v, once v', and where
    //! the method has one, a velocity that only serves as a gradient. A rank
    //! constrains its halo as the neighbour does the same nodes, which stand
    //! where NodeLayout::home says; what is beyond a wall is the wall's
    //! business. Sums take nodes with state.halo.weights(), 0 in the halo. A
    //! wall that moves with u does the work impulse . u, exactly if it holds
    //! the same nodes for v and v'; add it to the ledger. The impulse is
    //! m_i times the change, and GridVelocity::takenUp.
    virtual void applyToGrid( State<Dim>&, const GridVelocity& ) {}
    //! After the new node velocities are known: account for work done.
    virtual void gridWork( State<Dim>& ) {}
    //! Sources of particle momentum or energy, after G2P; not of mass, which
    //! a repeated step would add again. \return did it change any without a
    //! look at them (Watch::lookAtEnergy), so that all have to be checked?
    virtual bool particleSource( State<Dim>& ) { return false; }
    //! After particles moved: wrap, reflect, push out, or mark for removal
    //! (negative id). Those that are beyond the domain are state.leavers.
    //! Others that it moves or marks it must note in state.noted, or they stay
    //! where they are; before it marks one of them, or changes a mass, it calls
    //! state.particles.keepIdentities.
    virtual void applyToParticles( State<Dim>& ) {}
    //! Adds new particles at the end, each with an id of its own: from
    //! state.next_id on, which all ranks then advance alike. Those marked are
    //! still there.
    virtual void inject( State<Dim>& ) {}

    //! Does it take this place [Dim] on one of its sides (InputHooks::sides)?
    virtual bool covers( const Vector<Dim>& ) const { return true; }
    //! Is a point [Dim] inside a solid, so that no particle starts there? (A
    //! body whose type has a `solid` has none within that anyway.)
    virtual bool isSolid( const Vector<Dim>& ) const { return false; }
    //! Does gas enter or leave here, so that energy cannot balance? (An open
    //! side says so by its SideKind.)
    virtual bool isOpen() const { return false; }
    //! Does it act on the gas from outside, so that momentum along this axis
    //! changes?
    virtual bool exertsForce( int /*axis*/ ) const { return false; }
    //! Names all that this module carries from step to step and that its
    //! parameters do not tell, to write it or to read it back.
    //! \throws ArchiveError
    virtual void checkpoint( Archive& ) {}
    //! The step is repeated from its start: forget what it contributed. It got
    //! as far as particleSource; where a run ends, perhaps through inject.
    virtual void rejectStep( State<Dim>& ) {}
    //! Time series to be written with the output.
    virtual const Series* series() const { return nullptr; }
};

/*!
  \brief A module that closes the gas: pressure from density and energy.

  The host functions serve initial states and boundaries.
*/
template <int Dim>
class EquationOfState : public Module<Dim>
{
  public:
    //! \param density mass/length^Dim \param pressure of the gas
    //! \return energy/mass
    virtual Real specificInternalEnergy( Real density,
                                         Real pressure ) const = 0;
    //! Sets pressure and sound speed of all particles:
    //! physics/evaluate_gas.hpp does so by any formula.
    //! \param surveys does it look at them meanwhile, which takes longer?
    //! \return what it saw
    virtual GasSurvey evaluate( State<Dim>& state, bool surveys ) = 0;
    void particleState( State<Dim>& state ) final
    {
        state.survey = evaluate( state, true );
    }
    //! For integrators that need the pressure of half a step.
    virtual PressureResponse response() const = 0;
};

} // namespace Machpoint

#endif
