/*!
  \file node_force.hpp
  \brief Layer 3: a force on nodes that is not the gas's own, and the work that
  it does.
*/
#ifndef MACHPOINT_NODE_FORCE_HPP
#define MACHPOINT_NODE_FORCE_HPP

#include <core/transfer.hpp>

namespace Machpoint
{

//! Folds what the weight of gas is in proportion to, or that itself. Nodes on
//! walls rest along axes along which these hold them. \param sum [nodes][Dim]
template <int Dim>
void foldWeight( const State<Dim>& state, NodeSum& sum )
{
    sum.fold( state.halo, vectorComponents<Dim, 1>( state.weight_parity ) );
    state.halo.restOnWalls( sum.field(),
                            vectorComponents<Dim, 1>( Parity::velocity ) );
}

/*!
  \brief Adds dt f / m to v' of every stored node.
  \param[in,out] field [nodes][>= Dim], folded (foldWeight); becomes f itself
  \param scale f over the field, axis by axis [Dim]
*/
template <int Dim>
void pushNodes( const State<Dim>& state, const NodeView& field,
                const Vector<Dim>& scale )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const Real dt = state.dt;
    forEach(
        "Machpoint::pushNodes", state.layout.total,
        MACHPOINT_LAMBDA( const int i ) {
            const Real m = moments( i, 0 );
            for ( int d = 0; d < Dim; ++d )
            {
                field( i, d ) *= scale[d];
                velocities( i, Dim + d ) += perMass( dt * field( i, d ), m );
            }
        } );
}

//! dt sum_i f_i . (v_i + v'_i) / 2 over this rank's nodes: all that the force
//! gives to the gas, as fold is the adjoint of fill. energy
//! \param force [nodes][Dim]
template <int Dim>
ReproducibleSum workOnNodes( const State<Dim>& state, const NodeView& force )
{
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const auto weights = state.halo.weights();
    const Real dt = state.dt;
    ReproducibleSum work;
    reduceEach(
        "Machpoint::workOnNodes", layout.total, few_rows,
        MACHPOINT_LAMBDA( const int row, ReproducibleSum& sum ) {
            const Real share = weights( layout.indices( row ) );
            if ( share == 0 )
                return;
            for ( int d = 0; d < Dim; ++d )
                sum += dt * share * force( row, d ) * 0.5_rt *
                       ( velocities( row, d ) + velocities( row, Dim + d ) );
        },
        work );
    return work;
}

} // namespace Machpoint

#endif
