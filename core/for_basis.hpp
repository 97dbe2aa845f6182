/*!
  \file for_basis.hpp
  \brief Layer 3: the basis of a run, for effects that move numbers between
  particles and nodes. (Modules are compiled once for each dimension.)
*/
#ifndef MACHPOINT_FOR_BASIS_HPP
#define MACHPOINT_FOR_BASIS_HPP

#include <core/state.hpp>
#include <core/stepper_list.hpp>

namespace Machpoint
{

//! Calls action( Basis() ) with the run's basis, which is one of those that
//! this build has.
template <int Dim, class Action>
void forBasis( const State<Dim>& state, const Action& action )
{
#define MACHPOINT_ACT( Basis )                                                 \
    if ( state.stencil_nodes == Basis::nodes )                                 \
        return action( Basis() );
    MACHPOINT_FOR_EACH_BASIS( MACHPOINT_ACT )
#undef MACHPOINT_ACT
}

} // namespace Machpoint

#endif
