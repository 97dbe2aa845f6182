/*!
  \file method_defaults.hpp
  \brief Layer 5: what a method need not say.

  A method is a struct with a name (`method.name`), a summary for `machpoint
  list`, a default basis, `affine` (do particles carry an affine velocity
  field?), a Storage (whose layOut allocates its node fields, again when the
  rank's box has moved) and gridToParticles; the time loop calls the members
  below in the order of the time step, and a method that has more to do there
  hides them.
*/
#ifndef MACHPOINT_METHOD_DEFAULTS_HPP
#define MACHPOINT_METHOD_DEFAULTS_HPP

#include <core/module.hpp>
#include <core/transfer.hpp>

#include <limits>

namespace Machpoint
{

//! The members of a method that `paper` and `apic` share.
struct MethodDefaults
{
    //! Cells beyond the box from which particles scatter.
    static constexpr int reach = 0;
    //! Layers that the halo needs besides along an axis that is cut, so that a
    //! rank makes there itself what particles read.
    static constexpr int margin = 0;
    //! Does it read moments beyond walls and open sides?
    static constexpr bool needs_outer_moments = false;
    //! Does the scheme promise a positive energy, so that a step which breaks
    //! the promise is repeated?
    static constexpr bool positive_energy = true;
    //! Has it no other way than artificial viscosity to give a shock a width?
    static constexpr bool shocks_need_viscosity = true;

    //! Column of velocities with 1 - beta (GridVelocity::lag); -1: beta is 1.
    template <int Dim>
    static constexpr int lag_column = -1;

    //! Columns of Nodes::moments: mass, momentum [Dim], force [Dim].
    template <int Dim>
    static constexpr int moment_columns = 1 + 2 * Dim;
    //! Columns of Nodes::velocities: v [Dim], v' [Dim].
    template <int Dim>
    static constexpr int velocity_columns = 2 * Dim;

    //! Before anything else: rearrange particles.
    template <class Basis, int Dim, class StorageType>
    static void prepare( State<Dim>&, StorageType&, EquationOfState<Dim>& )
    {
    }

    //! What the moments' columns are.
    template <int Dim>
    static auto momentComponents()
    {
        return Machpoint::momentComponents<Dim>();
    }

    //! What the velocities' columns are.
    template <int Dim>
    static auto velocityComponents()
    {
        return vectorComponents<Dim, 2>( Parity::velocity );
    }

    //! Largest time step that the arrangement of this rank's particles allows.
    //! Asked for after P2G, every few steps, for those to come. time
    template <class Basis, int Dim, class StorageType>
    static double stableTimeStep( const State<Dim>&, const StorageType&,
                                  const EquationOfState<Dim>& )
    {
        return std::numeric_limits<double>::infinity();
    }

    //! Node velocities before the step.
    template <int Dim, class StorageType>
    static void gridVelocity( const State<Dim>& state, const StorageType&,
                              const NodeRows& rows )
    {
        Machpoint::gridVelocity( state, rows );
    }

    //! Line 5: node velocities after the step.
    template <int Dim, class StorageType>
    static void advanceGridVelocity( const State<Dim>& state, StorageType& )
    {
        Machpoint::advanceGridVelocity( state );
    }
};

} // namespace Machpoint

#endif
