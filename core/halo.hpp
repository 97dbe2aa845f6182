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

#include <core/collect.hpp>
#include <core/halo_exchange.hpp>
#include <core/node_list.hpp>
#include <core/sides.hpp>

#include <stdexcept>
#include <vector>

namespace Machpoint
{

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
        requireWideBoxes( layout, decomposition );
        bool is_cut = false;
        for ( int d = 0; d < Dim; ++d )
        {
            if ( decomposition.ranks()[d] <= 1 ) // 0: none given
                continue;
            is_cut = true;
            connect( d, decomposition );
            if ( decomposition.fewestCells( d ) < 2 * ( layout.halo[d] + 1 ) )
                _is_thin = true;
        }
        _outer =
            is_cut ? NodeRows( listOuterRows() ) : NodeRows( layout.total );
    }

    //! \throws std::invalid_argument when a box is thinner than the halo
    static void requireWideBoxes( const NodeLayout<Dim>& layout,
                                  const Decomposition<Dim>& decomposition )
    {
        for ( int d = 0; d < Dim; ++d )
        {
            const int needed = layout.halo[d] + 1;
            const bool cut = decomposition.ranks()[d] > 1;
            const int cells =
                cut ? decomposition.fewestCells( d ) : layout.cells[d];
            if ( cells >= needed )
                continue;
            throw std::invalid_argument(
                "axis " + std::to_string( d ) +
                ( cut ? " is cut into boxes of " + std::to_string( cells ) +
                            " cells: at least " + std::to_string( needed ) +
                            " are needed; start fewer ranks, choose other "
                            "decomposition.ranks, or take more cells"
                      : " has too few cells: at least " +
                            std::to_string( needed ) + " are needed" ) );
        }
    }

    //! Number of nodes on a side with normal `axis`, halo included.
    static int sideSize( const NodeLayout<Dim>& layout, const int axis )
    {
        int size = 1;
        for ( int d = 0; d < Dim; ++d )
            if ( d != axis )
                size *= layout.extent[d];
        return size;
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

    /*!
      \brief Faces along the normal of a side that lie on its part of a kind, or
      next to it inside where nodes are on the side.
      \return rows of the nodes before these faces; none where this rank's box
      does not reach the side
    */
    IndexList facesOn( const int side, const SideKind kind ) const
    {
        const auto layout = _layout;
        const int axis = side / 2;
        const bool is_upper = side % 2 == 1;
        if ( is_upper ? layout.box.end[axis] != layout.cells[axis]
                      : layout.box.begin[axis] != 0 )
            return {};
        const int vertex = layout.centred ? 0 : 1;
        const int place = is_upper ? layout.cells[axis] - 1 : vertex - 1;
        const auto kinds = Kokkos::create_mirror_view_and_copy(
            Kokkos::HostSpace(), _kinds[side] );
        std::vector<int> rows;
        for ( int t = 0; t < kinds.extent_int( 0 ); ++t )
            if ( kinds( t ) == kind )
                rows.push_back( layout( sideNode( layout, axis, t ) ) +
                                place * layout.stride[axis] );
        if ( rows.empty() )
            return {};
        const IndexList list( "Machpoint::facesOn", rows.size() );
        Kokkos::deep_copy(
            list, Kokkos::View<const int*, Kokkos::HostSpace,
                               Kokkos::MemoryTraits<Kokkos::Unmanaged>>(
                      rows.data(), rows.size() ) );
        return list;
    }

    //! What each owned node counts for in sums; for kernels.
    NodeWeights<Dim> weights() const { return { _layout, _kinds }; }

    /*!
      \brief Adds the halo's content to its images, and serves what reads the
      field. Scalars add; vectors add with the sign of their reflection.

      Owned nodes then have their sums, and so have those that neighbours own:
      they send each other the layers on both sides of their cut, and both add
      what comes. Boxes so thin that a node may be shared by three of them along
      one axis fold first and fill then.
      \param field [nodes][N]
      \param kernels called with NodeRows, host; they may read the field in the
      row that they serve and in the next one below along each axis. While
      messages are under way they serve all rows, and after that once more those
      to which messages made a difference; without messages all, once.
    */
    template <std::size_t N, class Kernels>
    void fold( const NodeView& field, const NodeComponents<N>& components,
               const Kernels& kernels ) const
    {
        join( field, components, kernels, false );
    }
    //! The same where nothing is to be done meanwhile.
    template <std::size_t N>
    void fold( const NodeView& field,
               const NodeComponents<N>& components ) const
    {
        join( field, components, nothing, false );
    }
    //! fold, and fillSides before the kernels.
    template <std::size_t N, class Kernels>
    void foldAndFill( const NodeView& field,
                      const NodeComponents<N>& components,
                      const Kernels& kernels ) const
    {
        join( field, components, kernels, true );
    }

    //! Copies images into the halo: what lies beyond walls and open sides, and
    //! periodic images on this rank. What neighbours own a field has that was
    //! folded, or made of such. \param field [nodes][N]
    template <std::size_t N>
    void fillSides( const NodeView& field,
                    const NodeComponents<N>& components ) const
    {
        for ( int axis = 0; axis < Dim; ++axis )
            fillSides( field, components, axis );
    }

    //! Sets to 0 what nodes on a wall have that is its own mirror image's
    //! negative, as a sum has it once it is folded. \param field [nodes][N]
    template <std::size_t N>
    void restOnWalls( const NodeView& field,
                      const NodeComponents<N>& components ) const
    {
        if ( _layout.centred )
            return; // no node is on a wall
        for ( int axis = 0; axis < Dim; ++axis )
            overSides( "Machpoint::restOnWalls", axis, field, components,
                       RestNode{} );
    }

    //! fillSides, and what neighbours own. \param field [nodes][N]
    template <std::size_t N>
    void fill( const NodeView& field,
               const NodeComponents<N>& components ) const
    {
        constexpr int columns = static_cast<int>( N );
        for ( int axis = 0; axis < Dim; ++axis )
        {
            _exchange.start( field, axis, columns, _within[axis] );
            fillSides( field, components, axis );
            _exchange.finish( field, axis, columns, _within[axis], SetValue{} );
        }
    }

    //! For sums that no kernel reads meanwhile.
    static void nothing( const NodeRows& ) {}

    //! \name Parts of kernels
    //! Public only because nvcc wants the types and the parent function of a
    //! device lambda to be accessible. Those with a node take rows of a field,
    //! a column of it, and its imageSign.
    //! @{
    //! Adds what is on a node to its image.
    struct FoldNode
    {
        KOKKOS_INLINE_FUNCTION void operator()( const NodeView& field,
                                                const int node, const int image,
                                                const int c,
                                                const Real sign ) const
        {
            field( image, c ) += sign * field( node, c );
        }
    };
    //! Adds what a neighbour has sent.
    struct AddValue
    {
        KOKKOS_INLINE_FUNCTION void operator()( Real& value,
                                                const Real received ) const
        {
            value += received;
        }
    };
    //! Takes what a neighbour has sent.
    struct SetValue
    {
        KOKKOS_INLINE_FUNCTION void operator()( Real& value,
                                                const Real received ) const
        {
            value = received;
        }
    };
    //! Copies its image to a node, unless it is its own.
    struct FillNode
    {
        KOKKOS_INLINE_FUNCTION void operator()( const NodeView& field,
                                                const int node, const int image,
                                                const int c,
                                                const Real sign ) const
        {
            if ( node != image )
                field( node, c ) = sign * field( image, c );
        }
    };
    //! Sets to 0 what is its own negative image.
    struct RestNode
    {
        KOKKOS_INLINE_FUNCTION void operator()( const NodeView& field,
                                                const int node, const int image,
                                                const int c,
                                                const Real sign ) const
        {
            if ( node == image && sign < 0 )
                field( node, c ) = 0;
        }
    };

    //! Calls apply( field, row, row of the image, column, sign ) for all that
    //! lies on or beyond the sides of an axis. One thread serves a line of
    //! nodes across the box: both its ends. Axes go one after the other over
    //! lines that include the halo of the others, so edges and corners come out
    //! right.
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
        const int halo = layout.halo[axis];
        const int vertex = layout.centred ? 0 : 1;
        const int cells = layout.cells[axis];
        const int end = cells + vertex + halo;
        if ( ( halo == 0 && vertex == 0 ) || !( at_lower || at_upper ) )
            return;
        forEach(
            label, sideSize( layout, axis ), MACHPOINT_LAMBDA( const int t ) {
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
                        if ( on_side == 1 )
                            image( first, first, lower );
                    }
                    if ( upper != SideKind::periodic )
                    {
                        for ( int i = first + cells + on_side; i < end; ++i )
                            image( i, 2 * cells - i - shift, upper );
                        if ( on_side == 1 )
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

    //! The rows that messages change, and those above them.
    IndexList listOuterRows() const
    {
        const auto layout = _layout;
        Indices<Dim> begin = layout.box.begin, end = layout.box.end;
        for ( int d = 0; d < Dim; ++d )
        {
            begin[d] += layout.halo[d] + ( layout.centred ? 1 : 2 );
            end[d] -= layout.halo[d] + 1; // faces on a wall are their own image
            if ( isCut( d ) )
                continue;
            begin[d] = layout.lowest( d );
            end[d] = begin[d] + layout.extent[d];
        }
        const auto found = collect(
            "Machpoint::outerRows", layout.total,
            MACHPOINT_LAMBDA( const int row ) {
                const auto i = layout.indices( row );
                for ( int d = 0; d < Dim; ++d )
                    if ( i[d] < begin[d] || i[d] >= end[d] )
                        return true;
                return false;
            } );
        IndexList rows( "Machpoint::outerRows", found.extent( 0 ) );
        Kokkos::deep_copy( rows, found );
        return rows;
    }
    //! @}

  private:
    using Exchange = HaloExchange<Dim>;

    template <std::size_t N>
    void foldSides( const NodeView& field, const NodeComponents<N>& components,
                    const int axis ) const
    {
        overSides( "Machpoint::fold", axis, field, components, FoldNode{} );
    }
    template <std::size_t N>
    void fillSides( const NodeView& field, const NodeComponents<N>& components,
                    const int axis ) const
    {
        overSides( "Machpoint::fill", axis, field, components, FillNode{} );
    }

    //! \param fills are sides filled too?
    template <std::size_t N, class Kernels>
    void join( const NodeView& field, const NodeComponents<N>& components,
               const Kernels& kernels, const bool fills ) const
    {
        constexpr int columns = static_cast<int>( N );
        const NodeRows all( _layout.total );
        if ( _is_thin )
        {
            for ( int axis = 0; axis < Dim; ++axis )
            {
                _exchange.start( field, axis, columns, _beyond[axis] );
                foldSides( field, components, axis );
                _exchange.finish( field, axis, columns, _beyond[axis],
                                  AddValue{} );
            }
            fill( field, components );
            kernels( all );
            return;
        }
        for ( int axis = 0; axis < Dim; ++axis )
            if ( !isCut( axis ) )
                foldSides( field, components, axis );
        bool is_begun = false;
        for ( int axis = 0; axis < Dim; ++axis )
        {
            if ( !isCut( axis ) )
                continue;
            _exchange.start( field, axis, columns, _across[axis] );
            if ( !is_begun )
            {
                for ( int d = 0; d < Dim && fills; ++d )
                    if ( !isCut( d ) )
                        fillSides( field, components, d );
                kernels( all );
            }
            is_begun = true;
            foldSides( field, components, axis );
            _exchange.finish( field, axis, columns, _across[axis], AddValue{} );
        }
        if ( fills )
            fillSides( field, components );
        kernels( is_begun ? _outer : all );
    }

    //! Finds the neighbours along a cut axis, and which layers they share. The
    //! domain's ends are neighbours where they are periodic.
    void connect( const int axis, const Decomposition<Dim>& decomposition )
    {
        const auto& box = _layout.box;
        const int vertex = _layout.centred ? 0 : 1;
        const int halo = _layout.halo[axis];
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
    NodeRows _outer{ 0 }; // that messages change; without any all
};

} // namespace Machpoint

#endif
