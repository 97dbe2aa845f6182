/*!
  \file products.hpp
  \brief Layer 3: adds to nodes what particles have for them: columns of a node,
  lines of nodes, and products of one-dimensional weights.
*/
#ifndef MACHPOINT_PRODUCTS_HPP
#define MACHPOINT_PRODUCTS_HPP

#include <core/node_scatter.hpp>
#include <core/product_rows.hpp>
#include <core/product_terms.hpp>
#include <core/stencil.hpp>

#include <cstring>
#include <type_traits>

namespace Machpoint
{

//! Adds values[k] of a particle to columns first + k of a node.
template <class Access, std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void addColumns( const Access& nodes, const int,
                                             const int row, const int first,
                                             const Real ( &values )[K] )
{
    if constexpr ( std::is_same_v<Access, NodeScatter::Access> )
    {
        Real line[1][K];
        for ( std::size_t k = 0; k < K; ++k )
            line[0][k] = values[k];
        nodes.add( row, first, line );
    }
    else
        for ( std::size_t k = 0; k < K; ++k )
            nodes( row, first + static_cast<int>( k ) ) += values[k];
}
#ifndef MACHPOINT_HAS_LANES
//! The same of the only particle of a pack.
template <class Access, std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void addColumns( const Access& nodes, const Pack,
                                             const int row, const int first,
                                             const Real ( &values )[K] )
{
    addColumns( nodes, 0, row, first, values );
}
#else
//! The same for every particle of a pack, one after the other, as neighbours
//! add to the same nodes.
template <class Access, std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void
addColumns( const Access& nodes, const Pack p, const LaneRows& rows,
            const int first, const Lanes ( &values )[K] )
{
    for ( std::size_t k = 0; k < K; ++k )
    {
        Real terms[lane_count];
        std::memcpy( terms, static_cast<const void*>( &values[k] ),
                     sizeof( Lanes ) );
        for ( int l = 0; l < p.count; ++l )
            nodes( rows.row[l] + rows.shift, first + static_cast<int>( k ) ) +=
                terms[l];
    }
}
#endif

//! Adds values[i][k] of a particle, or of each of a pack, to columns first + k
//! of node i of a line. \param base first row of the stencil \param shift rows
//! from there to the line's first
template <class Access, class Particle, class Base, class Number,
          std::size_t Rows, std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void
addLine( const Access& nodes, const Particle p, const Base& base,
         const int shift, const int first, const Number ( &values )[Rows][K] )
{
    if constexpr ( std::is_same_v<Access, NodeScatter::Access> &&
                   std::is_same_v<Number, Real> )
        nodes.add( rowAt( base, shift ), first, values );
    else
        for ( std::size_t i = 0; i < Rows; ++i )
            addColumns( nodes, p, rowAt( base, shift + static_cast<int>( i ) ),
                        first, values[i] );
}

//! The nodes of a field that particles add to.
template <class Sums>
using NodesOf = typename Sums::Access;

//! They, for the particle or pack of a stencil, which may add to those of the
//! stencil alone. \param thread a scatter's \param p a particle's row or a pack
template <class Thread, class Particle, class Basis, int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION auto
accessTo( const Thread& thread, const Particle p,
          const Stencil<Basis, Dim, Number>& s, const NodeLayout<Dim>& layout )
{
    return thread.access( p, s.base,
                          StencilRows<Dim>{ Basis::nodes, layout.stride } );
}

/*!
  \brief Adds the terms of a particle, or of each of a pack, to the nodes of its
  stencil; or returns what the caller is to add(), which is so for packs on a
  CPU. A body of forEachDeposit hands that on.
  \param p a particle's row or a pack
  \param other the other weights [Dim][nodes]
*/
template <class Terms, class Basis, int Dim, class Number, class Access,
          class Particle>
KOKKOS_FORCEINLINE_FUNCTION auto addProductsLater(
    const Access& nodes, const Particle p, const Stencil<Basis, Dim, Number>& s,
    const NodeLayout<Dim>& layout, const Number ( &other )[Dim][Basis::nodes],
    const Products<Terms, Dim, Number>& terms )
{
#ifdef MACHPOINT_HAS_LANES
    if constexpr ( std::is_same_v<Access, NodeScatter::Access> &&
                   std::is_same_v<Particle, Pack> )
        if constexpr ( Terms::count > 1 && lane_count > 1 )
            return Impl::rowsOf( nodes, p, s, layout, other, terms );
#endif
    constexpr int width = Products<Terms, Dim, Number>::width;
    constexpr int first = Terms::column( 0 );
    constexpr int n = Basis::nodes;
    MACHPOINT_KEEP_LOOP
    for ( int k = 0; k < ( Dim > 2 ? n : 1 ); ++k )
    {
        MACHPOINT_KEEP_LOOP
        for ( int j = 0; j < ( Dim > 1 ? n : 1 ); ++j )
        {
            int row = 0;
            if constexpr ( Dim > 1 )
                row += j * layout.stride[1];
            if constexpr ( Dim > 2 )
                row += k * layout.stride[2];
            Number line[n][width]{};
            MACHPOINT_UNROLL
            for ( int i = 0; i < n; ++i )
            {
                const int at[3] = { i, j, k };
                MACHPOINT_UNROLL
                for ( int t = 0; t < Terms::count; ++t )
                {
                    Number term = terms.value[t];
                    if ( Terms::isAffine( t ) )
                        for ( int d = 0; d < Dim; ++d )
                            term += terms.slope[t][d] * pick( s.dx[d], at[d] );
                    for ( int d = 0; d < Dim; ++d )
                        term *= pick( Terms::axis( t ) == d ? other[d] : s.w[d],
                                      at[d] );
                    line[i][Terms::column( t ) - first] = term;
                }
            }
            addLine( nodes, p, s.base, row, first, line );
        }
    }
}

//! addProductsLater, at once.
template <class Terms, class Basis, int Dim, class Number, class Access,
          class Particle>
KOKKOS_FORCEINLINE_FUNCTION void addProducts(
    const Access& nodes, const Particle p, const Stencil<Basis, Dim, Number>& s,
    const NodeLayout<Dim>& layout, const Number ( &other )[Dim][Basis::nodes],
    const Products<Terms, Dim, Number>& terms )
{
    auto later = [&]() MACHPOINT_INLINE
    { return addProductsLater( nodes, p, s, layout, other, terms ); };
    if constexpr ( std::is_void_v<decltype( later() )> )
        later();
    else
        later().add();
}

} // namespace Machpoint

#endif
