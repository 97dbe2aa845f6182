/*!
  \file halo.hpp
  \brief Layer 3: the grid's edge. Walls, open sides and periodicity are one
  mechanism: nodes beyond the owned box are images of nodes inside.

  `fold` adds what particles scattered beyond the edge to its image, `fill`
  copies the image back. A periodic side's image is shifted, a slip wall's is
  mirrored with the normal component negated, a no-slip wall's negated whole,
  an open side's mirrored as it is (zero gradient). See docs/method.md,
  section 3. Fold is the adjoint of fill, which keeps walls conservative.
*/
#ifndef MACHPOINT_HALO_HPP
#define MACHPOINT_HALO_HPP

#include <core/grid.hpp>

#include <stdexcept>
#include <string>

namespace Machpoint
{

//! What lies beyond one side of the domain.
enum class SideKind : int
{
    periodic,
    slip,    //!< mirror, normal component negated
    no_slip, //!< mirror, all components negated
    open     //!< mirror, zero gradient
};

//! How a component of a node field changes under reflection.
enum class Parity : int
{
    scalar,
    velocity, //!< component of a velocity or momentum
    force     //!< component of a force: the gradient of a mirrored scalar
};

//! A component of a node field: what it is, along which axis, and where. A
//! field on faces or cells keeps in node i's row the value halfway to node
//! i + 1 along each axis of the set `staggered`.
struct NodeComponent
{
    Parity parity = Parity::scalar;
    int axis = 0;
    int staggered = 0; //!< bit d: halfway to the next node along axis d
};

//! Sign of the image of a component across a side with normal `axis`.
KOKKOS_INLINE_FUNCTION Real imageSign( const SideKind kind,
                                       const NodeComponent& component,
                                       const int axis )
{
    if ( component.parity == Parity::scalar || kind == SideKind::periodic )
        return 1;
    if ( kind == SideKind::no_slip )
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

//! Images of nodes beyond the sides of the domain.
template <int Dim>
class Halo
{
  public:
    //! Kind of each node of a side, [nodes of the side, halo included].
    using KindView = Kokkos::View<SideKind*, MemorySpace>;

    Halo() = default;

    //! \param layout the nodes
    //! \param kinds for side 2 * axis + (upper ? 1 : 0), the kind of each of
    //! its nodes: see sideSize and sideNode
    //! \throws std::invalid_argument when an axis has fewer nodes than the
    //! halo is wide (mass would be lost)
    Halo( const NodeLayout<Dim>& layout,
          const Kokkos::Array<KindView, 2 * Dim>& kinds )
        : _layout( layout ), _kinds( kinds )
    {
        for ( int d = 0; d < Dim; ++d )
            if ( layout.owned[d] - ( layout.centred ? 0 : 1 ) <
                 layout.halo + 1 )
                throw std::invalid_argument(
                    "axis " + std::to_string( d ) +
                    " has too few cells for this basis: at least " +
                    std::to_string( layout.halo + 1 ) + " are needed" );
    }

    //! Number of nodes on a side with normal `axis`, halo included.
    static int sideSize( const NodeLayout<Dim>& layout, const int axis )
    {
        return layout.total / layout.extent[axis];
    }

    //! Coordinates of node t of a side; the normal coordinate is 0.
    KOKKOS_INLINE_FUNCTION static Indices<Dim>
    sideNode( const NodeLayout<Dim>& layout, const int axis, int t )
    {
        Indices<Dim> i{};
        for ( int d = 0; d < Dim; ++d )
            if ( d != axis )
            {
                i[d] = t % layout.extent[d] - layout.halo;
                t /= layout.extent[d];
            }
        return i;
    }

    //! Adds the halo's content to its images. Scalars add; vectors add with
    //! the sign of their reflection. \param field [nodes][N]
    template <std::size_t N>
    void fold( const NodeView& field,
               const NodeComponents<N>& components ) const
    {
        for ( int axis = 0; axis < Dim; ++axis )
            overSides( "Machpoint::fold", axis, field, components, FoldNode{} );
    }

    //! Copies images into the halo. \param field [nodes][N]
    template <std::size_t N>
    void fill( const NodeView& field,
               const NodeComponents<N>& components ) const
    {
        for ( int axis = 0; axis < Dim; ++axis )
            overSides( "Machpoint::fill", axis, field, components, FillNode{} );
    }

    //! Share of an owned node that belongs to this domain: 1/2 on a wall that
    //! runs through vertices (its own image counts too), 0 on the upper of
    //! two periodic vertices. Sums over owned nodes with this weight count
    //! everything once.
    KOKKOS_INLINE_FUNCTION Real weight( const Indices<Dim>& i ) const
    {
        Real share = 1;
        if ( _layout.centred )
            return share;
        for ( int d = 0; d < Dim; ++d )
        {
            const int last = _layout.owned[d] - 1;
            if ( i[d] != 0 && i[d] != last )
                continue;
            int t = 0;
            for ( int b = Dim - 1; b >= 0; --b )
                if ( b != d )
                    t = t * _layout.extent[b] + i[b] + _layout.halo;
            const auto kind = _kinds[2 * d + ( i[d] == 0 ? 0 : 1 )]( t );
            if ( kind != SideKind::periodic )
                share *= 0.5;
            else if ( i[d] == last )
                share = 0;
        }
        return share;
    }

    // Public only because nvcc wants the types and the parent function of a
    // device lambda to be accessible.
    struct FoldNode
    {
        static constexpr bool self_image = true;
        KOKKOS_INLINE_FUNCTION void operator()( const NodeView& field,
                                                const int node, const int image,
                                                const int c,
                                                const Real sign ) const
        {
            field( image, c ) += sign * field( node, c );
        }
    };
    struct FillNode
    {
        static constexpr bool self_image = false;
        KOKKOS_INLINE_FUNCTION void operator()( const NodeView& field,
                                                const int node, const int image,
                                                const int c,
                                                const Real sign ) const
        {
            field( node, c ) = sign * field( image, c );
        }
    };

    // One thread serves a line of nodes across the domain: both its ends.
    // Axes go one after the other over lines that include the halo of the
    // others, so edges and corners come out right.
    template <std::size_t N, class Operation>
    void overSides( const char* label, const int axis, const NodeView& field,
                    const NodeComponents<N>& components,
                    const Operation& apply ) const
    {
        const auto layout = _layout;
        const auto lower_kind = _kinds[2 * axis];
        const auto upper_kind = _kinds[2 * axis + 1];
        const int halo = layout.halo;
        const int vertex = layout.centred ? 0 : 1;
        const int cells = layout.owned[axis] - vertex;
        const int end = layout.owned[axis] + halo;
        if ( halo == 0 && vertex == 0 )
            return;
        Kokkos::parallel_for(
            label, Range( 0, sideSize( layout, axis ) ),
            KOKKOS_LAMBDA( const int t ) {
                const int origin = layout( sideNode( layout, axis, t ) );
                const int stride = layout.stride[axis];
                const auto lower = lower_kind( t );
                const auto upper = upper_kind( t );
                for ( int c = 0; c < static_cast<int>( N ); ++c )
                {
                    auto image =
                        [&]( const int i, const int of, const SideKind kind )
                    {
                        apply( field, origin + i * stride, origin + of * stride,
                               c, imageSign( kind, components[c], axis ) );
                    };
                    // Row i stands at (2 i + shift) h / 2 from the lower side.
                    const int shift =
                        1 - vertex + ( components[c].staggered >> axis & 1 );
                    const int first = -( shift / 2 ); // at or beyond the side
                    if ( lower == SideKind::periodic )
                    {
                        for ( int i = first + cells; i < end; ++i )
                            image( i, i - cells, lower );
                        for ( int i = -halo; i < first; ++i )
                            image( i, i + cells, lower );
                        continue;
                    }
                    // A row on the side is its own image.
                    const int on_side = shift % 2 == 0 ? 1 : 0;
                    for ( int i = -halo; i < first; ++i )
                        image( i, -i - shift, lower );
                    for ( int i = first + cells + on_side; i < end; ++i )
                        image( i, 2 * cells - i - shift, upper );
                    if ( on_side == 1 && Operation::self_image )
                    {
                        image( first, first, lower );
                        image( first + cells, first + cells, upper );
                    }
                }
            } );
    }

  private:
    NodeLayout<Dim> _layout;
    Kokkos::Array<KindView, 2 * Dim> _kinds;
};

} // namespace Machpoint

#endif
