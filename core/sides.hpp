/*!
  \file sides.hpp
  \brief Layer 3: the sides of the domain: what lies beyond them, how the fields
  of nodes are mirrored there, and what nodes on them count.
*/
#ifndef MACHPOINT_SIDES_HPP
#define MACHPOINT_SIDES_HPP

#include <core/grid.hpp>

#include <cstddef>

namespace Machpoint
{

//! What lies beyond one side of the domain.
enum class SideKind : int
{
    periodic, //!< shifted image, unchanged
    slip,     //!< mirror, normal component negated
    no_slip,  //!< mirror, all components negated
    open      //!< mirror, zero gradient
};

//! How a component of a node field changes under reflection.
enum class Parity : int
{
    scalar,   //!< not at all
    velocity, //!< component of a velocity or momentum
    force,    //!< component of a force that particles add with their momentum
    //! Component of a gradient of a scalar that is mirrored by any wall.
    gradient
};

//! A component of a node field: what it is, along which axis, and where. A
//! field on faces or cells keeps in node i's row the value halfway to node
//! i + 1 along each axis of the set `staggered`.
struct NodeComponent
{
    Parity parity = Parity::scalar;
    int axis = 0;      //!< of a vector's component
    int staggered = 0; //!< bit d: halfway to the next node along axis d
};

//! Sign of the image of a component across a side with normal `axis`.
KOKKOS_INLINE_FUNCTION Real imageSign( const SideKind kind,
                                       const NodeComponent& component,
                                       const int axis )
{
    if ( component.parity == Parity::scalar || kind == SideKind::periodic )
        return 1;
    if ( kind == SideKind::no_slip && component.parity != Parity::gradient )
        return -1;
    const bool normal = component.axis == axis;
    // Beyond an open side the same gas goes on, so its pressure balances.
    if ( kind == SideKind::open && component.parity == Parity::velocity )
        return 1;
    return normal ? -1 : 1;
}

//! The components of a field: n of them.
template <std::size_t N>
using NodeComponents = Kokkos::Array<NodeComponent, N>;

//! \name Component lists of the fields that methods use
//! @{
//! mass, momentum [Dim], force [Dim]
template <int Dim>
NodeComponents<1 + 2 * Dim> momentComponents()
{
    NodeComponents<1 + 2 * Dim> list{};
    for ( int d = 0; d < Dim; ++d )
    {
        list[1 + d] = { Parity::velocity, d };
        list[1 + Dim + d] = { Parity::force, d };
    }
    return list;
}
//! `vectors` vectors [Dim] of the given parity, one after the other
template <int Dim, int Vectors>
NodeComponents<Vectors * Dim> vectorComponents( const Parity parity )
{
    NodeComponents<Vectors * Dim> list{};
    for ( int c = 0; c < Vectors * Dim; ++c )
        list[c] = { parity, c % Dim };
    return list;
}
//! @}

//! Kind of each node of a side, [nodes of the side, halo included]; not read
//! where the rank's box does not reach the side.
using KindView = Kokkos::View<SideKind*, MemorySpace>;

//! Share of an owned node that belongs to this domain: 1/2 on a wall that runs
//! through vertices (its own image counts too), 0 on the upper of two periodic
//! vertices. Sums over owned nodes with this weight count everything once.
template <int Dim>
struct NodeWeights
{
    NodeLayout<Dim> layout;                 //!< this rank's nodes
    Kokkos::Array<KindView, 2 * Dim> kinds; //!< of each side; see Halo

    //! \param i a stored node [Dim] \return 0 for one that is not owned
    KOKKOS_INLINE_FUNCTION Real operator()( const Indices<Dim>& i ) const
    {
        if ( !layout.isOwned( i ) )
            return 0;
        Real share = 1;
        if ( layout.centred )
            return share;
        for ( int d = 0; d < Dim; ++d )
        {
            const int last = layout.cells[d];
            if ( i[d] != 0 && i[d] != last )
                continue;
            int t = 0;
            for ( int b = Dim - 1; b >= 0; --b )
                if ( b != d )
                    t = t * layout.extent[b] + i[b] - layout.lowest( b );
            const auto kind = kinds[2 * d + ( i[d] == 0 ? 0 : 1 )]( t );
            if ( kind != SideKind::periodic )
                share *= 0.5_rt;
            else if ( i[d] == last )
                share = 0;
        }
        return share;
    }
};

} // namespace Machpoint

#endif
