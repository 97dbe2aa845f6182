/*!
  \file products.hpp
  \brief Layer 3: what a particle adds to the nodes of its stencil, as products
  of one-dimensional weights.

  Term t of a particle adds to a column of node i, at dx from it,

    ( value[t] + slope[t] . dx ) prod_d W_td(i_d),

  where W_td are the stencil's weights, or along one axis others: derivatives,
  or weights of faces. A struct says what the terms are:

    static constexpr int count;              // terms
    static constexpr int column( int t );    // of the nodes; increasing
    static constexpr bool isAffine( int t ); // has it a slope?
    static constexpr int axis( int t );      // of the other weights, or -1
*/
#ifndef MACHPOINT_PRODUCTS_HPP
#define MACHPOINT_PRODUCTS_HPP

#include <core/basis.hpp>
#include <core/node_sum.hpp>

namespace Machpoint
{

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

//! The values of terms, and their slopes along each axis.
template <class Terms, int Dim, class Number>
struct Products
{
    //! Columns from the first term's to the last one's.
    static constexpr int width =
        Terms::column( Terms::count - 1 ) - Terms::column( 0 ) + 1;

    Number value[Terms::count];
    Number slope[Terms::count][Dim]; //!< of those that are affine
};

//! Weights of the face between a node and the next along each axis; none behind
//! the last node.
template <class Basis, int Dim, class Number>
struct FaceWeights
{
    Number w[Dim][Basis::nodes];

    KOKKOS_FORCEINLINE_FUNCTION
    FaceWeights( const Grid<Dim>& grid, const Stencil<Basis, Dim, Number>& s )
    {
        const HalfwayWeights<Basis, Dim, Number> halfway( grid, s );
        for ( int d = 0; d < Dim; ++d )
        {
            for ( int i = 0; i < Basis::nodes - 1; ++i )
                w[d][i] = halfway.c[d][i];
            w[d][Basis::nodes - 1] = Number( 0.0 );
        }
    }
};

#ifdef MACHPOINT_HAS_LANES
namespace Impl
{

//! Lanes in memory, where a kernel reads one after the other: out of a register
//! it takes two shuffles. (Not the Lanes themselves: to read any one of these,
//! the compiler would write all that they are a part of.)
struct LanesInMemory
{
    alignas( Lanes ) Real lane[lane_count];

    KOKKOS_FORCEINLINE_FUNCTION void operator=( const Lanes& lanes )
    {
        std::memcpy( lane, static_cast<const void*>( &lanes ), sizeof( lane ) );
    }
    KOKKOS_FORCEINLINE_FUNCTION Real operator[]( const int l ) const
    {
        return lane[l];
    }
};

//! A row of a field of nodes in one register, a column in each place, and masks
//! of places. (One by one, as GCC 12 takes a register whose size depends on a
//! parameter for a number.)
template <int Width>
struct ColumnRow;
template <>
struct ColumnRow<2>
{
    using Row __attribute__( ( vector_size( 2 * sizeof( Real ) ) ) ) = Real;
    using Places __attribute__( ( vector_size( 2 * sizeof( Real ) ) ) ) =
        LaneInteger;
};
template <>
struct ColumnRow<4>
{
    using Row __attribute__( ( vector_size( 4 * sizeof( Real ) ) ) ) = Real;
    using Places __attribute__( ( vector_size( 4 * sizeof( Real ) ) ) ) =
        LaneInteger;
};
template <>
struct ColumnRow<8>
{
    using Row __attribute__( ( vector_size( 8 * sizeof( Real ) ) ) ) = Real;
    using Places __attribute__( ( vector_size( 8 * sizeof( Real ) ) ) ) =
        LaneInteger;
};

//! x in all places.
template <int Width>
KOKKOS_FORCEINLINE_FUNCTION auto rowOf( const Real x )
{
    using Row = typename ColumnRow<Width>::Row;
    if constexpr ( Width == 2 )
        return Row{ x, x };
    else if constexpr ( Width == 4 )
        return Row{ x, x, x, x };
    else
        return Row{ x, x, x, x, x, x, x, x };
}

//! Puts x into some places of a row. \tparam Bits 1 << c for each place c
template <int Width, int Bits>
KOKKOS_FORCEINLINE_FUNCTION auto
replace( const typename ColumnRow<Width>::Row& row, const Real x )
{
    using Places = typename ColumnRow<Width>::Places;
    // -1 where the bit is set.
    constexpr auto at = []( const int c ) -> LaneInteger
    { return -( Bits >> c & 1 ); };
    if constexpr ( Width == 2 )
        return Places{ at( 0 ), at( 1 ) } ? rowOf<2>( x ) : row;
    else if constexpr ( Width == 4 )
        return Places{ at( 0 ), at( 1 ), at( 2 ), at( 3 ) } ? rowOf<4>( x )
                                                            : row;
    else
        return Places{ at( 0 ), at( 1 ), at( 2 ), at( 3 ),
                       at( 4 ), at( 5 ), at( 6 ), at( 7 ) }
                   ? rowOf<8>( x )
                   : row;
}

//! The places, as bits, whose weights along an axis are others.
template <class Terms>
constexpr int placesAlong( const int axis )
{
    int bits = 0;
    for ( int t = 0; t < Terms::count; ++t )
        if ( Terms::axis( t ) == axis )
            bits |= 1 << ( Terms::column( t ) - Terms::column( 0 ) );
    return bits;
}

//! Has any term a slope?
template <class Terms>
constexpr bool anyAffine()
{
    for ( int t = 0; t < Terms::count; ++t )
        if ( Terms::isAffine( t ) )
            return true;
    return false;
}

//! Calls visit with the constants 0 to N - 1.
template <int N, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void forEachConstant( const Visitor& visit )
{
    [&]<int... I>( std::integer_sequence<int, I...> )
    {
        ( visit( std::integral_constant<int, I>() ), ... );
    }
    ( std::make_integer_sequence<int, N>() );
}

/*!
  \brief addProducts with a particle's columns in one register.

  Node after node and line after line a term grows by slope times spacing, and
  the weights of an axis are multiplied on line by line, so that a node costs
  two operations.

  Where registers hold the sums of all nodes, particles that share their nodes
  are added up there first: to add a register to memory takes a processor longer
  than to make it, as it has to wait for what the last particle wrote.
*/
template <int Width, class Terms, class Basis, int Dim>
KOKKOS_FORCEINLINE_FUNCTION void
addProductRows( const NodeScatter::Access& nodes, const Pack p,
                const Stencil<Basis, Dim, Lanes>& s,
                const NodeLayout<Dim>& layout,
                const Lanes ( &other )[Dim][Basis::nodes],
                const Products<Terms, Dim, Lanes>& terms )
{
    using Row = typename ColumnRow<Width>::Row;
    constexpr int n = Basis::nodes;
    constexpr int ny = Dim > 1 ? n : 1;
    constexpr int nz = Dim > 2 ? n : 1;
    constexpr int first = Terms::column( 0 );
    constexpr bool grows = anyAffine<Terms>();
    constexpr bool keeps = n * ny * nz <= 16;
    // Of each particle: terms at the first node, and from there to the next.
    LanesInMemory values[Terms::count], steps[Terms::count][Dim];
    for ( int t = 0; t < Terms::count; ++t )
    {
        Lanes value = terms.value[t];
        if ( Terms::isAffine( t ) )
            for ( int d = 0; d < Dim; ++d )
            {
                value += terms.slope[t][d] * s.dx[d][0];
                steps[t][d] = terms.slope[t][d] * layout.spacing[d];
            }
        values[t] = value;
    }
    LanesInMemory weights[Dim][n], others[Dim][n];
    for ( int d = 0; d < Dim; ++d )
        for ( int i = 0; i < n; ++i )
        {
            weights[d][i] = s.w[d][i];
            others[d][i] = other[d][i];
        }
    // Here, as the compiler would read them again after whatever is written.
    const std::ptrdiff_t columns = nodes.columns;
    std::ptrdiff_t stride[3]{};
    for ( int d = 0; d < Dim; ++d )
        stride[d] = layout.stride[d] * columns;
    Real* const start = nodes.sums + first;
    Row sums[keeps ? nz : 1][keeps ? ny : 1][keeps ? n : 1]{};
    auto add = []( Real* const node, const Row& term ) MACHPOINT_INLINE
    {
        Row sum;
        std::memcpy( &sum, node, sizeof( Row ) );
        sum += term;
        std::memcpy( node, &sum, sizeof( Row ) );
    };
    auto flush = [&]( const int row ) MACHPOINT_INLINE
    {
        Real* const base = start + row * columns;
        for ( int k = 0; k < nz; ++k )
            for ( int j = 0; j < ny; ++j )
                for ( int i = 0; i < n; ++i )
                {
                    add( base + i * columns + j * stride[1] + k * stride[2],
                         sums[k][j][i] );
                    sums[k][j][i] = Row{};
                }
    };
    int current = s.base.row[0];
    for ( int l = 0; l < p.count; ++l )
    {
        Row value{};
        Row step[3]{};
        forEachConstant<Terms::count>(
            [&]( const auto t )
            {
                constexpr int bit = 1 << ( Terms::column( t ) - first );
                value = replace<Width, bit>( value, values[t][l] );
                if constexpr ( Terms::isAffine( t ) )
                    for ( int d = 0; d < Dim; ++d )
                        step[d] =
                            replace<Width, bit>( step[d], steps[t][d][l] );
            } );
        Row w[Dim][n];
        forEachConstant<Dim>(
            [&]( const auto d )
            {
                constexpr int bits = placesAlong<Terms>( d );
                for ( int i = 0; i < n; ++i )
                    w[d][i] = replace<Width, bits>(
                        rowOf<Width>( weights[d][i][l] ), others[d][i][l] );
            } );
        const int row = s.base.row[l];
        if constexpr ( keeps )
            if ( row != current )
            {
                flush( current );
                current = row;
            }
        Real* const base = start + row * columns;
        for ( int k = 0; k < nz; ++k )
        {
            Row plane = value;
            Row step_x = step[0];
            Row step_y = step[1];
            if constexpr ( Dim > 2 )
            {
                plane *= w[2][k];
                if constexpr ( grows )
                {
                    step_x *= w[2][k];
                    step_y *= w[2][k];
                    value += step[2];
                }
            }
            for ( int j = 0; j < ny; ++j )
            {
                Row term = plane;
                Row step_on = step_x;
                if constexpr ( Dim > 1 )
                {
                    term *= w[1][j];
                    if constexpr ( grows )
                    {
                        step_on *= w[1][j];
                        plane += step_y;
                    }
                }
                Real* const line = base + j * stride[1] + k * stride[2];
                for ( int i = 0; i < n; ++i )
                {
                    if constexpr ( keeps )
                        sums[k][j][i] += term * w[0][i];
                    else
                        add( line + i * columns, term * w[0][i] );
                    if constexpr ( grows )
                        term += step_on;
                }
            }
        }
    }
    if constexpr ( keeps )
        flush( current );
}

} // namespace Impl
#endif

/*!
  \brief Adds the terms of a particle, or of each of a pack, to the nodes of its
  stencil.
  \param p a particle's row or a pack
  \param other the other weights [Dim][nodes]
*/
template <class Terms, class Basis, int Dim, class Number, class Access,
          class Particle>
KOKKOS_FORCEINLINE_FUNCTION void addProducts(
    const Access& nodes, const Particle p, const Stencil<Basis, Dim, Number>& s,
    const NodeLayout<Dim>& layout, const Number ( &other )[Dim][Basis::nodes],
    const Products<Terms, Dim, Number>& terms )
{
    constexpr int width = Products<Terms, Dim, Number>::width;
    constexpr int first = Terms::column( 0 );
#ifdef MACHPOINT_HAS_LANES
    if constexpr ( std::is_same_v<Access, NodeScatter::Access> &&
                   std::is_same_v<Particle, Pack> )
        if constexpr ( Impl::rowWidth( width ) > 1 )
        {
            Impl::addProductRows<Impl::rowWidth( width )>( nodes, p, s, layout,
                                                           other, terms );
            return;
        }
#endif
    constexpr int n = Basis::nodes;
    MACHPOINT_KEEP_LOOP
    for ( int k = 0; k < ( Dim > 2 ? n : 1 ); ++k )
    {
        MACHPOINT_UNROLL
        for ( int j = 0; j < ( Dim > 1 ? n : 1 ); ++j )
        {
            MACHPOINT_UNROLL
            for ( int i = 0; i < n; ++i )
            {
                const int at[3] = { i, j, k };
                Number sums[width]{};
                int row = 0;
                for ( int d = 0; d < Dim; ++d )
                    row += at[d] * layout.stride[d];
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
                    sums[Terms::column( t ) - first] = term;
                }
                addColumns( nodes, p, rowAt( s.base, row ), first, sums );
            }
        }
    }
}

} // namespace Machpoint

#endif
