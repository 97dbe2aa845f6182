/*!
  \file product_rows.hpp
  \brief Layer 3: on a CPU, what the particles of a pack add to nodes, made
  ready in registers.
*/
#ifndef MACHPOINT_PRODUCT_ROWS_HPP
#define MACHPOINT_PRODUCT_ROWS_HPP

#include <core/column_rows.hpp>
#include <core/node_scatter.hpp>
#include <core/product_terms.hpp>
#include <core/stencil.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <type_traits>

namespace Machpoint
{

#ifdef MACHPOINT_HAS_LANES
namespace Impl
{

/*!
  \brief What the particles of a pack add to nodes, ready to be added, with a
  particle's columns in one register.

  Plane after plane of nodes. Within one a term grows from node to node and from
  line to line by slope times spacing, and the weights of an axis are multiplied
  on line by line, so that a node costs two operations.

  Registers hold the sums of the plane, where particles that share their nodes
  are added up first: to add a register to memory takes a processor longer than
  to make it, as it has to wait for what the last particle wrote.
*/
template <int Width, class Terms, class Basis, int Dim>
class [[nodiscard]] ProductRows
{
    using Row = typename ColumnRow<Width>::Row;
    static constexpr int n = Basis::nodes;
    static constexpr int plane_axes = Dim > 1 ? 2 : 1;
    static constexpr int ny = Dim > 1 ? n : 1;
    static constexpr int nz = Dim > 2 ? n : 1;
    static constexpr int first = Terms::column( 0 );
    static constexpr int slopes = placesWithSlope<Terms>();
    static constexpr bool grows = slopes != 0;
    //! Two columns a pair.
    static constexpr int pairs = ( Terms::count + 1 ) / 2;
    //! Up to the last slope's; an array has one at least.
    static constexpr int step_pairs = std::max(
        1,
        ( static_cast<int>( std::bit_width( unsigned( slopes ) ) ) + 1 ) / 2 );

  public:
    KOKKOS_FORCEINLINE_FUNCTION
    ProductRows( const NodeScatter::Access& nodes, const Pack p,
                 const Stencil<Basis, Dim, Lanes>& s,
                 const NodeLayout<Dim>& layout,
                 const Lanes ( &other )[Dim][Basis::nodes],
                 const Products<Terms, Dim, Lanes>& terms )
        : _start( nodes.sums + first ), _columns( nodes.columns ),
          _count( p.count )
    {
        std::memcpy( _row, s.base.row, sizeof( _row ) );
        for ( int d = 0; d < Dim; ++d )
            _stride[d] = layout.stride[d] * _columns;
        for ( int i = 0; i < n; ++i )
            _along[i].set( s.w[0][i], other[0][i] );
        for ( int j = 0; j < ny; ++j )
            _across[j].set( s.w[Dim > 1][j], other[Dim > 1][j] );
        MACHPOINT_KEEP_LOOP
        for ( int k = 0; k < nz; ++k )
        {
            // Terms at the plane's first node, and from there to the next one
            // along each axis.
            auto valueOf = [&]( const auto t ) MACHPOINT_INLINE
            {
                Lanes value( 0.0 );
                if constexpr ( t < Terms::count )
                {
                    static_assert( Terms::column( t ) == first + t,
                                   "terms must have columns side by side" );
                    value = terms.value[t];
                    if constexpr ( Terms::isAffine( t ) )
                        for ( int d = 0; d < Dim; ++d )
                            value += terms.slope[t][d] * s.dx[d][d < 2 ? 0 : k];
                    if constexpr ( Dim > 2 )
                        value *=
                            Terms::axis( t ) == 2 ? other[2][k] : s.w[2][k];
                }
                return value;
            };
            auto stepOf = [&]( const auto t, const int d ) MACHPOINT_INLINE
            {
                Lanes step( 0.0 );
                if constexpr ( Terms::isAffine( t ) )
                {
                    step = terms.slope[t][d] * layout.spacing[d];
                    if constexpr ( Dim > 2 )
                        step *= s.w[2][k];
                }
                return step;
            };
            forEachConstant<pairs>(
                [&]( const auto q ) MACHPOINT_INLINE
                {
                    const std::integral_constant<int, 2 * q> a;
                    const std::integral_constant<int, 2 * q + 1> b;
                    _values[k][q].set( valueOf( a ), valueOf( b ) );
                    if constexpr ( grows && q < step_pairs )
                        for ( int d = 0; d < plane_axes; ++d )
                            _steps[k][d][q].set( stepOf( a, d ),
                                                 stepOf( b, d ) );
                } );
        }
    }

    KOKKOS_FORCEINLINE_FUNCTION void add() const
    {
        // Here, as the compiler would read them again after whatever is
        // written.
        const std::ptrdiff_t columns = _columns;
        const std::ptrdiff_t line_stride = _stride[plane_axes - 1];
        const int count = _count;
        MACHPOINT_KEEP_LOOP
        for ( int k = 0; k < nz; ++k )
        {
            Real* const start = _start + ( Dim > 2 ? k * _stride[Dim - 1] : 0 );
            Row sums[ny][n]{};
            auto flush = [&]( const int row ) MACHPOINT_INLINE
            {
                for ( int j = 0; j < ny; ++j )
                {
                    Real* const line = start + row * columns + j * line_stride;
                    for ( int i = 0; i < n; ++i )
                    {
                        Row sum;
                        std::memcpy( &sum, line + i * columns, sizeof( Row ) );
                        sum += sums[j][i];
                        std::memcpy( line + i * columns, &sum, sizeof( Row ) );
                        sums[j][i] = Row{};
                    }
                }
            };
            int current = _row[0];
            forEachLane(
                count,
                [&]( const int l ) MACHPOINT_INLINE
                {
                    Row value = joinedRow<Width, ( 1 << Terms::count ) - 1>(
                        _values[k], l );
                    Row step[2]{};
                    if constexpr ( grows )
                        for ( int d = 0; d < plane_axes; ++d )
                            step[d] =
                                joinedRow<Width, slopes>( _steps[k][d], l );
                    Row along[n], across[ny];
                    for ( int i = 0; i < n; ++i )
                        along[i] = choiceOf<Width, placesAlong<Terms>( 0 )>(
                            _along[i], l );
                    for ( int j = 0; j < ny; ++j )
                        across[j] = choiceOf<Width, placesAlong<Terms>( 1 )>(
                            _across[j], l );
                    const int row = _row[l];
                    if ( row != current )
                    {
                        flush( current );
                        current = row;
                    }
                    for ( int j = 0; j < ny; ++j )
                    {
                        Row term = value;
                        Row step_on = step[0];
                        if constexpr ( Dim > 1 )
                        {
                            term *= across[j];
                            if constexpr ( grows )
                            {
                                step_on *= across[j];
                                value += step[1];
                            }
                        }
                        for ( int i = 0; i < n; ++i )
                        {
                            sums[j][i] += term * along[i];
                            if constexpr ( grows )
                                term += step_on;
                        }
                    }
                } );
            flush( current );
        }
    }

  private:
    //! Weights along an axis, and the others where terms ask for them.
    template <int Axis>
    using Weights = std::conditional_t<placesAlong<Terms>( Axis ) == 0,
                                       NumberInMemory, PairsInMemory>;
    Weights<0> _along[n];   //!< a line
    Weights<1> _across[ny]; //!< lines
    PairsInMemory _values[nz][pairs];
    PairsInMemory _steps[nz][plane_axes][step_pairs];
    Real* _start;
    std::ptrdiff_t _columns;
    std::ptrdiff_t _stride[Dim];
    int _count;
    int _row[lane_count];
};

/*!
  \brief The same of a single term without slope: the nodes of a line in one
  register, which takes as many fewer operations.
*/
template <class Terms, class Basis, int Dim>
class [[nodiscard]] ProductLines
{
    static constexpr int n = Basis::nodes;
    static constexpr int width = rowWidth( n );
    using Line = typename ColumnRow<width>::Row;
    static constexpr int ny = Dim > 1 ? n : 1;
    static constexpr int nz = Dim > 2 ? n : 1;

  public:
    //! Is it for these terms?
    static constexpr bool serves =
        Terms::count == 1 && !Terms::isAffine( 0 ) && n <= width;

    KOKKOS_FORCEINLINE_FUNCTION
    ProductLines( const NodeScatter::Access& nodes, const Pack p,
                  const Stencil<Basis, Dim, Lanes>& s,
                  const NodeLayout<Dim>& layout,
                  const Lanes ( &other )[Dim][Basis::nodes],
                  const Products<Terms, Dim, Lanes>& terms )
        : _start( nodes.sums + Terms::column( 0 ) ), _columns( nodes.columns ),
          _count( p.count )
    {
        std::memcpy( _row, s.base.row, sizeof( _row ) );
        for ( int d = 0; d < Dim; ++d )
            _stride[d] = layout.stride[d] * _columns;
        auto weight = [&]( const int d, const int i ) MACHPOINT_INLINE
        {
            return i >= n                  ? Lanes( 0.0 )
                   : Terms::axis( 0 ) == d ? other[d][i]
                                           : s.w[d][i];
        };
        for ( int q = 0; q < pairs; ++q )
            _along[q].set( weight( 0, 2 * q ), weight( 0, 2 * q + 1 ) );
        for ( int k = 0; k < nz; ++k )
            for ( int j = 0; j < ny; ++j )
            {
                Lanes value = terms.value[0];
                if constexpr ( Dim > 1 )
                    value *= weight( 1, j );
                if constexpr ( Dim > 2 )
                    value *= weight( 2, k );
                std::memcpy( _values[k][j], static_cast<const void*>( &value ),
                             sizeof( Lanes ) );
            }
    }

    KOKKOS_FORCEINLINE_FUNCTION void add() const
    {
        const std::ptrdiff_t columns = _columns;
        const int count = _count;
        MACHPOINT_KEEP_LOOP
        for ( int k = 0; k < nz; ++k )
        {
            Real* const start = _start + ( Dim > 2 ? k * _stride[Dim - 1] : 0 );
            Line sums[ny]{};
            auto flush = [&]( const int row ) MACHPOINT_INLINE
            {
                for ( int j = 0; j < ny; ++j )
                {
                    Real* const line = start + row * columns +
                                       ( Dim > 1 ? j * _stride[1 % Dim] : 0 );
                    for ( int i = 0; i < n; ++i )
                        line[i * columns] += sums[j][i];
                    sums[j] = Line{};
                }
            };
            int current = _row[0];
            forEachLane( count,
                         [&]( const int l ) MACHPOINT_INLINE
                         {
                             const int row = _row[l];
                             if ( row != current )
                             {
                                 flush( current );
                                 current = row;
                             }
                             const Line along =
                                 joinedRow<width, ( 1 << n ) - 1>( _along, l );
                             for ( int j = 0; j < ny; ++j )
                                 sums[j] += along * _values[k][j][l];
                         } );
            flush( current );
        }
    }

  private:
    static constexpr int pairs = ( n + 1 ) / 2;
    PairsInMemory _along[pairs]; //!< weights along the line
    alignas( Lanes ) Real _values[nz][ny][lane_count]; //!< of a line
    Real* _start;
    std::ptrdiff_t _columns;
    std::ptrdiff_t _stride[Dim];
    int _count;
    int _row[lane_count];
};

//! Rows of some of the terms, and of the others.
template <class Some, class Others>
struct [[nodiscard]] BothRows
{
    Some some;
    Others others;

    KOKKOS_FORCEINLINE_FUNCTION void add() const
    {
        some.add();
        others.add();
    }
};

//! The rows of the terms from First on.
template <int First = 0, class Terms, class Basis, int Dim>
KOKKOS_FORCEINLINE_FUNCTION auto
rowsOf( const NodeScatter::Access& nodes, const Pack p,
        const Stencil<Basis, Dim, Lanes>& s, const NodeLayout<Dim>& layout,
        const Lanes ( &other )[Dim][Basis::nodes],
        const Products<Terms, Dim, Lanes>& terms )
{
    const auto& part = partOf<First>( terms );
    using Part = std::remove_cvref_t<decltype( part )>;
    using PartTerms = typename Part::terms_type;
    using Lines = ProductLines<PartTerms, Basis, Dim>;
    using Rows = std::conditional_t<
        Lines::serves, Lines,
        ProductRows<rowWidth( Part::width ), PartTerms, Basis, Dim>>;
    if constexpr ( First + most_terms < Terms::count )
    {
        using Others = decltype( rowsOf<First + most_terms>(
            nodes, p, s, layout, other, terms ) );
        return BothRows<Rows, Others>{
            Rows( nodes, p, s, layout, other, part ),
            rowsOf<First + most_terms>( nodes, p, s, layout, other, terms ) };
    }
    else
        return Rows( nodes, p, s, layout, other, part );
}

} // namespace Impl
#endif

} // namespace Machpoint

#endif
