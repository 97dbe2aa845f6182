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

#include <core/rounded_terms.hpp>
#include <core/stencil.hpp>

#include <algorithm>
#include <bit>
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

//! The values of terms, and their slopes along each axis.
template <class Terms, int Dim, class Number>
struct Products
{
    //! Says what they are.
    using terms_type = Terms;
    //! Columns from the first term's to the last one's.
    static constexpr int width =
        Terms::column( Terms::count - 1 ) - Terms::column( 0 ) + 1;

    Number value[Terms::count];      //!< at the particle
    Number slope[Terms::count][Dim]; //!< of those that are affine
};

//! Terms without slopes that all take the stencil's weights.
template <int Count>
struct ValueTerms
{
    //! \name As this file's comment asks
    //! @{
    static constexpr int count = Count;
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int column( const int t )
    {
        return t;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr bool isAffine( int )
    {
        return false;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int axis( int ) { return -1; }
    //! @}
};

//! Weights of the face between a node and the next along each axis; none behind
//! the last node.
template <class Basis, int Dim, class Number>
struct FaceWeights
{
    //! [d][i]: of the face behind node i along axis d.
    Number w[Dim][Basis::nodes];

    //! \param s of the particle, or pack
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

//! An integer as long as a Real.
using LaneInteger = std::conditional_t<is_single, std::int32_t, std::int64_t>;

//! Places of a register for so many columns.
constexpr int rowWidth( const int columns )
{
    const int width = columns < 3 ? 2 : columns < 5 ? 4 : 8;
    return std::min( width, lane_count );
}

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

#ifndef MACHPOINT_PAIRS_ARE_NEIGHBOURS
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
#endif

//! Calls visit with the constants 0 to N - 1.
template <int N, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void forEachConstant( const Visitor& visit )
{
    [&]<int... I>( std::integer_sequence<int, I...> ) MACHPOINT_INLINE
    {
        ( visit( std::integral_constant<int, I>() ), ... );
    }
    ( std::make_integer_sequence<int, N>() );
}

//! Calls visit with the first `count` lanes. Where there are four the compiler
//! knows them: it takes longer to find a lane's numbers than to add them.
template <class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void forEachLane( const int count,
                                              const Visitor& visit )
{
    if constexpr ( lane_count <= 4 )
        forEachConstant<lane_count>(
            [&]( const auto l ) MACHPOINT_INLINE
            {
                if ( l < count )
                    visit( l );
            } );
    else
        for ( int l = 0; l < count; ++l )
            visit( l );
}

//! Some of the terms: Count of them from First on.
template <class Terms, int First, int Count>
struct SomeTerms
{
    static constexpr int count = Count;
    static constexpr int column( const int t )
    {
        return Terms::column( First + t );
    }
    static constexpr bool isAffine( const int t )
    {
        return Terms::isAffine( First + t );
    }
    static constexpr int axis( const int t )
    {
        return Terms::axis( First + t );
    }
};

//! Terms that go to a node at once: as many as a register has lanes.
inline constexpr int most_terms = std::min( lane_count, 8 );

//! So many of the terms, or the last ones, from First on.
template <int First, class Terms, int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION decltype( auto )
partOf( const Products<Terms, Dim, Number>& terms )
{
    constexpr int count = std::min( Terms::count - First, most_terms );
    if constexpr ( count == Terms::count )
        return ( terms );
    else
    {
        Products<SomeTerms<Terms, First, count>, Dim, Number> part;
        for ( int t = 0; t < count; ++t )
        {
            part.value[t] = terms.value[First + t];
            if ( Terms::isAffine( First + t ) )
                for ( int d = 0; d < Dim; ++d )
                    part.slope[t][d] = terms.slope[First + t][d];
        }
        return part;
    }
}

/*!
  \brief Two numbers of every lane in memory, where a kernel takes those of one
  lane after the other to rows: out of registers it takes more shuffles.

  (Not the Lanes themselves: to read any one of these, the compiler would write
  all that they are a part of.)
*/
struct PairsInMemory
{
#ifdef MACHPOINT_PAIRS_ARE_NEIGHBOURS
    alignas( Lanes ) Real pairs[lane_count][2]; // of even lanes, then of odd

    KOKKOS_FORCEINLINE_FUNCTION void set( const Lanes& a, const Lanes& b )
    {
        Registers::storePairs( static_cast<LaneRegister>( a ),
                               static_cast<LaneRegister>( b ), pairs[0] );
    }
    KOKKOS_FORCEINLINE_FUNCTION const Real* of( const int l ) const
    {
        return pairs[( l & 1 ) * ( lane_count / 2 ) + ( l >> 1 )];
    }
#else
    alignas( Lanes ) Real first[lane_count];
    alignas( Lanes ) Real second[lane_count];

    KOKKOS_FORCEINLINE_FUNCTION void set( const Lanes& a, const Lanes& b )
    {
        std::memcpy( first, static_cast<const void*>( &a ), sizeof( first ) );
        std::memcpy( second, static_cast<const void*>( &b ), sizeof( second ) );
    }
#endif
};

//! A row of the first number of lane l, and of the second in some places.
//! \tparam Seconds 1 << c for each place c of the second
template <int Width, int Seconds>
KOKKOS_FORCEINLINE_FUNCTION auto choiceOf( const PairsInMemory& pairs,
                                           const int l )
{
#ifdef MACHPOINT_PAIRS_ARE_NEIGHBOURS
    return Registers::choiceOf<Width, Seconds>( pairs.of( l ) );
#else
    return replace<Width, Seconds>( rowOf<Width>( pairs.first[l] ),
                                    pairs.second[l] );
#endif
}

//! A row of the pairs of lane l, side by side, and 0 behind them.
//! \tparam Used 1 << c for each place c; the others have 0 in memory, too
template <int Width, int Used, std::size_t Pairs>
KOKKOS_FORCEINLINE_FUNCTION auto
joinedRow( const PairsInMemory ( &pairs )[Pairs], const int l )
{
#ifdef MACHPOINT_PAIRS_ARE_NEIGHBOURS
    const Real* numbers[Pairs];
    for ( std::size_t k = 0; k < Pairs; ++k )
        numbers[k] = pairs[k].of( l );
    return Registers::joinedRow<Width>( numbers );
#else
    typename ColumnRow<Width>::Row row{};
    forEachConstant<static_cast<int>( Pairs )>(
        [&]( const auto k ) MACHPOINT_INLINE
        {
            constexpr int first = Used & 1 << 2 * k;
            constexpr int second = Used & 2 << 2 * k;
            if constexpr ( first )
                row = replace<Width, first>( row, pairs[k].first[l] );
            if constexpr ( second )
                row = replace<Width, second>( row, pairs[k].second[l] );
        } );
    return row;
#endif
}

//! A number of every lane in memory, where nothing asks for a second one.
struct NumberInMemory
{
    alignas( Lanes ) Real number[lane_count];

    KOKKOS_FORCEINLINE_FUNCTION void set( const Lanes& a, const Lanes& )
    {
        std::memcpy( number, static_cast<const void*>( &a ), sizeof( number ) );
    }
};
template <int Width, int>
KOKKOS_FORCEINLINE_FUNCTION auto choiceOf( const NumberInMemory& numbers,
                                           const int l )
{
    return rowOf<Width>( numbers.number[l] );
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

//! The places, as bits, of the terms that have a slope.
template <class Terms>
constexpr int placesWithSlope()
{
    int bits = 0;
    for ( int t = 0; t < Terms::count; ++t )
        if ( Terms::isAffine( t ) )
            bits |= 1 << ( Terms::column( t ) - Terms::column( 0 ) );
    return bits;
}

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
