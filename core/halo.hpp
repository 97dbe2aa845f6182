/*!
  \file halo.hpp
  \brief Layer 3: the grid's edge. Walls, open sides, periodicity and
  neighbouring ranks are one mechanism: nodes beyond the owned box are images of
  nodes inside.

  `fold` adds what particles scattered beyond the edge to its image, `fill`
  copies the image back. A periodic side's image is shifted, a slip wall's is
  mirrored with the normal component negated, a no-slip wall's negated whole,
  an open side's mirrored as it is (zero gradient), a neighbouring rank's is
  the same node over there. See docs/method.md, section 3. Fold is the adjoint
  of fill, which keeps walls conservative.
*/
#ifndef MACHPOINT_HALO_HPP
#define MACHPOINT_HALO_HPP

#include <core/halo_exchange.hpp>
#include <core/lanes.hpp>

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

//! Kind of each node of a side, [nodes of the side, halo included]; empty where
//! the rank's box does not reach the side.
using KindView = Kokkos::View<SideKind*, MemorySpace>;

//! Share of an owned node that belongs to this domain: 1/2 on a wall that runs
//! through vertices (its own image counts too), 0 on the upper of two periodic
//! vertices. Sums over owned nodes with this weight count everything once.
template <int Dim>
struct NodeWeights
{
    NodeLayout<Dim> layout;
    Kokkos::Array<KindView, 2 * Dim> kinds;

    //! \param i an owned node [Dim]
    KOKKOS_INLINE_FUNCTION Real operator()( const Indices<Dim>& i ) const
    {
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
                share *= 0.5;
            else if ( i[d] == last )
                share = 0;
        }
        return share;
    }
};

//! Numbers of the packs that a kernel has put off.
struct PackList
{
    IndexList packs;
    Kokkos::View<int, MemorySpace> count;

    //! Forgets all. \param n packs that there are
    void clear( const int n )
    {
        if ( packs.extent_int( 0 ) < n )
            Kokkos::realloc( Kokkos::WithoutInitializing, packs, n + n / 4 );
        if ( !count.is_allocated() )
            count = Kokkos::View<int, MemorySpace>( "Machpoint::packsPutOff" );
        Kokkos::deep_copy( ExecutionSpace(), count, 0 );
    }
};

/*!
  \brief Which packs of particles a kernel serves: by default all.

  While messages are under way it serves the `inner` ones, whose stencils stay
  within a box that needs none of them, and lists those that it puts off; `rest`
  are these.
*/
template <int Dim>
class Part
{
  public:
    Part() = default;

    //! \param inner cells whose particles need no halo
    //! \param others cleared
    Part( const Grid<Dim>& grid, const CellBox<Dim>& inner,
          const PackList& others )
        : _kind( Kind::inner ), _grid( grid ), _inner( inner ),
          _others( others )
    {
    }

    //! The packs that a kernel has put off since.
    Part rest() const
    {
        Part part = *this;
        part._kind = Kind::rest;
        return part;
    }

    bool isInner() const { return _kind == Kind::inner; }
    bool isRest() const { return _kind == Kind::rest; }

    //! What a kernel runs over, for n particles.
    Range range( const int n ) const
    {
        if ( !isRest() )
            return packs( n );
        int count = 0;
        Kokkos::deep_copy( count, _others.count );
        return Range( 0, count );
    }
    //! Pack k of the range.
    KOKKOS_FORCEINLINE_FUNCTION Pack pack( const int k, const int n ) const
    {
        return Pack::of( _kind == Kind::rest ? _others.packs( k ) : k, n );
    }
    //! Is the pack to be left alone for now? Each may be asked once.
    //! \param x of its particles [Dim]
    KOKKOS_FORCEINLINE_FUNCTION bool
    putsOff( const Pack p, const VectorOf<Dim, Lanes>& x ) const
    {
        if ( _kind != Kind::inner ||
             !any( active( p ) && !_inner.surelyContains( _grid, x ) ) )
            return false;
        _others.packs( Kokkos::atomic_fetch_add( &_others.count(), 1 ) ) =
            p.first / lane_count;
        return true;
    }

  private:
    enum class Kind : int
    {
        all,
        inner,
        rest
    };

    Kind _kind = Kind::all;
    Grid<Dim> _grid = {};
    CellBox<Dim> _inner = {};
    PackList _others;
};

//! Images of nodes beyond the box of a rank.
template <int Dim>
class Halo
{
  public:
    Halo() = default;

    //! \param layout the nodes
    //! \param kinds for side 2 * axis + (upper ? 1 : 0), the kind of each of
    //! its nodes: see sideSize and sideNode
    //! \param decomposition whose neighbours the rank has; by default none
    //! \throws std::invalid_argument when a box is thinner than the halo (mass
    //! would be lost)
    Halo( const NodeLayout<Dim>& layout,
          const Kokkos::Array<KindView, 2 * Dim>& kinds,
          const Decomposition<Dim>& decomposition = {} )
        : _layout( layout ), _kinds( kinds ),
          _exchange( layout, decomposition.comm() )
    {
        const int needed = layout.halo + 1;
        for ( int d = 0; d < Dim; ++d )
        {
            const bool cut = decomposition.ranks()[d] > 1;
            const int cells =
                cut ? decomposition.fewestCells( d ) : layout.cells[d];
            if ( cells < needed )
                throw std::invalid_argument(
                    "axis " + std::to_string( d ) +
                    ( cut ? " is cut into boxes of " + std::to_string( cells ) +
                                " cells: at least " + std::to_string( needed ) +
                                " are needed; start fewer ranks, choose other "
                                "decomposition.ranks, or take more cells"
                          : " has too few cells for this basis: at least " +
                                std::to_string( needed ) + " are needed" ) );
            if ( !cut )
                continue;
            connect( d, decomposition );
            if ( cells < 2 * needed )
                _is_thin = true;
        }
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
                i[d] = t % layout.extent[d] + layout.lowest( d );
                t /= layout.extent[d];
            }
        return i;
    }

    //! What each owned node counts for in sums; for kernels.
    NodeWeights<Dim> weights() const { return { _layout, _kinds }; }

    //! Adds the halo's content to its images. Scalars add; vectors add with
    //! the sign of their reflection. \param field [nodes][N]
    template <std::size_t N>
    void fold( const NodeView& field,
               const NodeComponents<N>& components ) const
    {
        constexpr int columns = static_cast<int>( N );
        for ( int axis = 0; axis < Dim; ++axis )
        {
            _exchange.start( field, axis, columns, _beyond[axis] );
            overSides( "Machpoint::fold", axis, field, components, FoldNode{} );
            _exchange.finish( field, axis, columns, _beyond[axis], AddValue{} );
        }
    }

    //! Copies images into the halo. \param field [nodes][N]
    template <std::size_t N>
    void fill( const NodeView& field,
               const NodeComponents<N>& components ) const
    {
        constexpr int columns = static_cast<int>( N );
        for ( int axis = 0; axis < Dim; ++axis )
        {
            _exchange.start( field, axis, columns, _within[axis] );
            overSides( "Machpoint::fill", axis, field, components, FillNode{} );
            _exchange.finish( field, axis, columns, _within[axis], SetValue{} );
        }
    }

    /*!
      \brief fold and fill with half the messages: neighbours send each other
      the layers on both sides of their cut, and both add what comes.

      Boxes so thin that a node may be shared by three of them along one axis
      do one after the other.
    */
    template <std::size_t N>
    void foldAndFill( const NodeView& field,
                      const NodeComponents<N>& components ) const
    {
        if ( _is_thin )
        {
            fold( field, components );
            fill( field, components );
            return;
        }
        constexpr int columns = static_cast<int>( N );
        for ( int axis = 0; axis < Dim; ++axis )
        {
            _exchange.start( field, axis, columns, _across[axis] );
            overSides( "Machpoint::fold", axis, field, components, FoldNode{} );
            _exchange.finish( field, axis, columns, _across[axis], AddValue{} );
        }
        for ( int axis = 0; axis < Dim; ++axis )
            overSides( "Machpoint::fill", axis, field, components, FillNode{} );
    }

    /*!
      \brief fill, and what reads the field while messages are under way.
      \param inner part that needs no halo, or all: then nothing is done
      meanwhile
      \param work called with a Part, host: where no axis is cut once, else
      first with the inner one, then with the rest
    */
    template <std::size_t N, class Work>
    void fill( const NodeView& field, const NodeComponents<N>& components,
               const Part<Dim>& inner, const Work& work ) const
    {
        constexpr int columns = static_cast<int>( N );
        bool worked = false;
        for ( int axis = 0; axis < Dim; ++axis )
        {
            _exchange.start( field, axis, columns, _within[axis] );
            if ( !worked && isCut( axis ) && inner.isInner() )
            {
                work( inner );
                worked = true;
            }
            overSides( "Machpoint::fill", axis, field, components, FillNode{} );
            _exchange.finish( field, axis, columns, _within[axis], SetValue{} );
        }
        work( worked ? inner.rest() : Part<Dim>{} );
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
    struct AddValue
    {
        KOKKOS_INLINE_FUNCTION void operator()( Real& value,
                                                const Real received ) const
        {
            value += received;
        }
    };
    struct SetValue
    {
        KOKKOS_INLINE_FUNCTION void operator()( Real& value,
                                                const Real received ) const
        {
            value = received;
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

    // One thread serves a line of nodes across the box: both its ends.
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
        const bool at_lower = layout.box.begin[axis] == 0;
        const bool at_upper = layout.box.end[axis] == layout.cells[axis];
        const int halo = layout.halo;
        const int vertex = layout.centred ? 0 : 1;
        const int cells = layout.cells[axis];
        const int end = cells + vertex + halo;
        if ( ( halo == 0 && vertex == 0 ) || !( at_lower || at_upper ) )
            return;
        Kokkos::parallel_for(
            label, Range( 0, sideSize( layout, axis ) ),
            KOKKOS_LAMBDA( const int t ) {
                // Of node 0, whether it is stored here or not.
                const int origin = layout( sideNode( layout, axis, t ) );
                const int stride = layout.stride[axis];
                const auto lower =
                    at_lower ? lower_kind( t ) : SideKind::periodic;
                const auto upper =
                    at_upper ? upper_kind( t ) : SideKind::periodic;
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
                    // A row on the side is its own image.
                    const int on_side = shift % 2 == 0 ? 1 : 0;
                    if ( lower != SideKind::periodic )
                    {
                        for ( int i = -halo; i < first; ++i )
                            image( i, -i - shift, lower );
                        if ( on_side == 1 && Operation::self_image )
                            image( first, first, lower );
                    }
                    if ( upper != SideKind::periodic )
                    {
                        for ( int i = first + cells + on_side; i < end; ++i )
                            image( i, 2 * cells - i - shift, upper );
                        if ( on_side == 1 && Operation::self_image )
                            image( first + cells, first + cells, upper );
                    }
                    // The other end may belong to another rank.
                    if ( at_lower && at_upper && lower == SideKind::periodic )
                    {
                        for ( int i = first + cells; i < end; ++i )
                            image( i, i - cells, lower );
                        for ( int i = -halo; i < first; ++i )
                            image( i, i + cells, lower );
                    }
                }
            } );
    }

  private:
    using Exchange = HaloExchange<Dim>;

    //! Finds the neighbours along a cut axis, and which layers they share. The
    //! domain's ends are neighbours where they are periodic.
    void connect( const int axis, const Decomposition<Dim>& decomposition )
    {
        const auto& box = _layout.box;
        const int vertex = _layout.centred ? 0 : 1;
        const int halo = _layout.halo;
        for ( const bool upper : { false, true } )
        {
            const int side = 2 * axis + ( upper ? 1 : 0 );
            const int end = upper ? box.end[axis] : box.begin[axis];
            if ( end == ( upper ? _layout.cells[axis] : 0 ) &&
                 !isPeriodic( side ) )
                continue;
            auto& outer = _beyond[axis][upper];
            outer.rank = decomposition.neighbour( axis, upper ? 1 : -1 );
            // Node `end` and what is above belong to the upper neighbour.
            const typename Exchange::Layers above{ end, halo + vertex };
            const typename Exchange::Layers below{ end - halo, halo };
            outer.send = upper ? above : below;
            outer.receive = upper ? below : above;
            _within[axis][upper] = { outer.rank, outer.receive, outer.send };
            const typename Exchange::Layers both{ end - halo,
                                                  2 * halo + vertex };
            _across[axis][upper] = { outer.rank, both, both };
        }
    }

    bool isCut( const int axis ) const
    {
        return _within[axis][0].rank >= 0 || _within[axis][1].rank >= 0;
    }

    bool isPeriodic( const int side ) const
    {
        SideKind kind{};
        Kokkos::deep_copy( kind, Kokkos::subview( _kinds[side], 0 ) );
        return kind == SideKind::periodic;
    }

    NodeLayout<Dim> _layout;
    Kokkos::Array<KindView, 2 * Dim> _kinds;
    mutable Exchange _exchange;              // buffers of messages
    typename Exchange::Side _beyond[Dim][2]; // for fold
    typename Exchange::Side _within[Dim][2]; // for fill
    typename Exchange::Side _across[Dim][2]; // for both
    bool _is_thin = false;                   // is a box?
};

} // namespace Machpoint

#endif
