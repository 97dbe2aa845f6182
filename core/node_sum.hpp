/*!
  \file node_sum.hpp
  \brief Layer 3: what many particles add to the nodes of a field, and on
  request so that the order of adding does not matter to the last bit.
*/
#ifndef MACHPOINT_NODE_SUM_HPP
#define MACHPOINT_NODE_SUM_HPP

#include <core/halo.hpp>
#include <core/lanes.hpp>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

namespace Machpoint
{

/*!
  \brief Sums that many particles add to one node: in a copy of the nodes for
  each thread of a CPU, atomic on a GPU.
*/
class NodeScatter
{
    using Token = Kokkos::Experimental::UniqueToken<
        ExecutionSpace, Kokkos::Experimental::UniqueTokenScope::Global>;
    static constexpr bool has_copies =
        Kokkos::SpaceAccessibility<Kokkos::HostSpace, MemorySpace>::accessible;

  public:
    //! \param sums [nodes][columns], which the first thread adds to itself
    explicit NodeScatter( const NodeView& sums ) : _sums( sums )
    {
        const int threads = has_copies ? Token().size() : 1;
        if ( threads > 1 )
            _copies = Kokkos::View<Real***, Kokkos::LayoutRight, MemorySpace>(
                "Machpoint::copiesOfNodes", threads - 1, sums.extent( 0 ),
                sums.extent( 1 ) );
    }

    //! One number, to be added to.
    struct Place
    {
        Real& sum;
        KOKKOS_FORCEINLINE_FUNCTION void operator+=( const Real term ) const
        {
            if constexpr ( has_copies )
                sum += term;
            else
                Kokkos::atomic_add( &sum, term );
        }
    };
    //! The nodes of one thread.
    struct Access
    {
        Real* sums;
        int columns;

        KOKKOS_FORCEINLINE_FUNCTION Real* row( const int i ) const
        {
            return sums + static_cast<std::size_t>( i ) * columns;
        }
        KOKKOS_FORCEINLINE_FUNCTION Place operator()( const int i,
                                                      const int column ) const
        {
            return { row( i )[column] };
        }
    };
    KOKKOS_FORCEINLINE_FUNCTION Access access() const
    {
        const int columns = static_cast<int>( _sums.extent( 1 ) );
        if constexpr ( has_copies )
            if ( _copies.extent( 0 ) > 0 )
            {
                const int thread = _token.acquire();
                _token.release( thread );
                if ( thread > 0 )
                    return { &_copies( thread - 1, 0, 0 ), columns };
            }
        return { _sums.data(), columns };
    }

    //! Sets all sums to zero.
    void clear() const { Kokkos::deep_copy( ExecutionSpace(), _sums, 0.0 ); }

    //! Adds up what the threads have, and leaves their copies at zero.
    //! Particles in order keep a thread to a part of the nodes, so most of a
    //! copy is.
    void contribute() const
    {
        const int threads = static_cast<int>( _copies.extent( 0 ) );
        if ( threads == 0 )
            return;
        constexpr std::size_t block = 8; // a line of the cache
        const std::size_t n = _sums.size();
        Real* const copies = _copies.data();
        Real* const sums = _sums.data();
        Kokkos::parallel_for(
            "Machpoint::sumOfThreads",
            Range( 0, static_cast<int>( ( n + block - 1 ) / block ) ),
            KOKKOS_LAMBDA( const int b ) {
                const std::size_t first = b * block;
                const std::size_t count = Kokkos::min( block, n - first );
                for ( int t = 0; t < threads; ++t )
                {
                    Real* const copy = copies + t * n + first;
                    bool is_used = false;
                    for ( std::size_t k = 0; k < count; ++k )
                        is_used |= copy[k] != 0;
                    if ( !is_used )
                        continue;
                    for ( std::size_t k = 0; k < count; ++k )
                    {
                        sums[first + k] += copy[k];
                        copy[k] = 0;
                    }
                }
            } );
    }

  private:
    NodeView _sums;
    Kokkos::View<Real***, Kokkos::LayoutRight, MemorySpace> _copies;
    Token _token;
};

//! Most columns that a reproducible sum can have.
inline constexpr std::size_t most_columns = 10;

//! A number for each column; in a kernel, in registers.
using PerColumn = Kokkos::Array<Real, most_columns>;

/*!
  \brief Terms that are rounded before they are added, so that adding is exact
  (Demmel and Nguyen 2015; docs/ranks.md). Stands in for a NodeScatter in
  kernels.

  A term x of column c becomes hi = x rounded to a multiple of a unit u_c, in
  column 2 c, and lo = x - hi rounded to one of a finer unit, in column 2 c + 1.
  The units follow from the largest term of the column, which a first pass of
  the same kernels finds: then nothing is added. (One type for both passes, as
  each type compiles all these kernels once more.)
*/
struct RoundedTerms
{
    //! log2 of how many terms of a node sum up without rounding.
    static constexpr int log2_terms = 16;

    NodeScatter parts;    //!< [nodes][2 columns]
    PerColumn hi{}, lo{}; //!< r, which rounds x to (r + x) - r
    //! Magnitude [most_columns], of the first pass; else null.
    Kokkos::View<Real*, MemorySpace> largest{};

    using PartAccess = decltype( std::declval<const NodeScatter&>().access() );
    struct Access
    {
        PartAccess parts;
        PerColumn hi, lo;
        Real* largest;
        mutable PerColumn own{};

        struct Place
        {
            const Access& access;
            int row, column;

            KOKKOS_FORCEINLINE_FUNCTION void operator+=( const Real term ) const
            {
                if ( access.largest )
                {
                    Real& most = access.own[column];
                    most = Kokkos::max( most, Kokkos::abs( term ) );
                    return;
                }
                const Real r = access.hi[column];
                const Real s = access.lo[column];
                const Real hi = ( r + term ) - r;
                const Real lo = ( s + ( term - hi ) ) - s;
                access.parts( row, 2 * column ) += hi;
                access.parts( row, 2 * column + 1 ) += lo;
            }
        };
        KOKKOS_FORCEINLINE_FUNCTION Place operator()( const int row,
                                                      const int column ) const
        {
            return { *this, row, column };
        }
        KOKKOS_FORCEINLINE_FUNCTION ~Access()
        {
            if ( !largest )
                return;
            // Rarely larger, so threads seldom meet here.
            for ( std::size_t c = 0; c < most_columns; ++c )
                if ( own[c] > Kokkos::atomic_load( largest + c ) )
                    Kokkos::atomic_max( largest + c, own[c] );
        }
    };
    KOKKOS_FORCEINLINE_FUNCTION Access access() const
    {
        return { parts.access(), hi, lo, largest.data() };
    }

    /*!
      \brief Sets the rounding of a column from its largest term.

      With n = log2_terms and |x| < 2^(E+1), r = 1.5 2^(E+n) leaves multiples of
      2^(E+n-52), so 2^n terms sum up to at most 2^53 units; |lo| is at most
      half a unit, and its r is 1.5 2^(E+2n-53). What is lost of a term is at
      most 2^(E+2n-106).
    */
    void setRounding( const std::size_t column, const Real largest )
    {
        // Terms that are not finite stay what they are.
        const bool rounds = largest > 0 && std::isfinite( largest );
        const int E = rounds ? std::ilogb( largest ) : 0;
        hi[column] = rounds ? std::ldexp( 1.5, E + log2_terms ) : 0;
        lo[column] = rounds ? std::ldexp( 1.5, E + 2 * log2_terms - 53 ) : 0;
    }
};

#ifdef MACHPOINT_HAS_LANES
namespace Impl
{
//! Registers as the compiler knows them.
using LaneVector __attribute__( ( vector_size( sizeof( Lanes ) ) ) ) = Real;
using LaneInteger = std::conditional_t<is_single, std::int32_t, std::int64_t>;
using LaneIndex __attribute__( ( vector_size( sizeof( Lanes ) ) ) ) =
    LaneInteger;

//! Numbers that addColumns adds to a node at once; 1: one by one.
constexpr int rowWidth( const std::size_t columns )
{
    const int width = columns < 3   ? static_cast<int>( columns )
                      : columns < 5 ? 4
                      : columns < 9 ? 8
                                    : 1;
    return lane_count % width == 0 ? width : 1;
}

//! Swaps blocks of Size numbers off the diagonal of two rows of a matrix.
template <int Size>
KOKKOS_FORCEINLINE_FUNCTION void swapBlocks( LaneVector& a, LaneVector& b )
{
    LaneIndex upper{}, lower{};
    for ( int l = 0; l < lane_count; ++l )
    {
        upper[l] = l & Size ? lane_count + l - Size : l;
        lower[l] = l & Size ? lane_count + l : l + Size;
    }
    const LaneVector above = __builtin_shuffle( a, b, upper );
    const LaneVector below = __builtin_shuffle( a, b, lower );
    a = above;
    b = below;
}

//! Adds rows of Width numbers, which start with the K values.
template <int Width, class Access, std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void addRows( const Access& nodes, const Pack p,
                                          const LaneRows& rows, const int first,
                                          const Lanes ( &values )[K] )
{
    LaneVector z[Width] = {};
    for ( std::size_t k = 0; k < K; ++k )
        std::memcpy( &z[k], static_cast<const void*>( &values[k] ),
                     sizeof( Lanes ) );
    for ( int r = 0; r < Width; r += 2 )
        swapBlocks<1>( z[r], z[r + 1] );
    if constexpr ( Width > 2 )
        for ( int r = 0; r < Width; ++r )
            if ( !( r & 2 ) )
                swapBlocks<2>( z[r], z[r + 2] );
    if constexpr ( Width == 8 )
        for ( int r = 0; r < 4; ++r )
            swapBlocks<4>( z[r], z[r + 4] );
    // z[r] now has the rows of particles r, r + Width, ...
    using Row __attribute__( ( vector_size( Width * sizeof( Real ) ) ) ) = Real;
    auto add = [&]( const int l )
    {
        Real* const node = nodes.row( rows.row[l] + rows.shift ) + first;
        Row part, sum;
        std::memcpy( &part,
                     reinterpret_cast<const Real*>( &z[l % Width] ) +
                         l / Width * Width,
                     sizeof( Row ) );
        std::memcpy( &sum, node, sizeof( Row ) );
        sum += part;
        std::memcpy( node, &sum, sizeof( Row ) );
    };
    if ( p.count == lane_count )
        for ( int l = 0; l < lane_count; ++l )
            add( l );
    else
        for ( int l = 0; l < p.count; ++l )
            add( l );
}
} // namespace Impl
#endif

//! Adds values[k] of a particle to columns first + k of a node.
template <class Access, std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void addColumns( const Access& nodes, const int,
                                             const int row, const int first,
                                             const Real ( &values )[K] )
{
    for ( std::size_t k = 0; k < K; ++k )
        nodes( row, first + static_cast<int>( k ) ) += values[k];
}
#ifndef MACHPOINT_HAS_LANES
template <class Access, std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void addColumns( const Access& nodes, const Pack,
                                             const int row, const int first,
                                             const Real ( &values )[K] )
{
    addColumns( nodes, 0, row, first, values );
}
#else
/*!
  \brief The same for every particle of a pack.

  Particle after particle, as neighbours add to the same nodes. Where the values
  fill registers, they are turned from one register a column into one register
  (or half of one) a particle, which then adds all its columns at once. That
  adds zeros to columns behind: see paddedColumns.
*/
template <class Access, std::size_t K>
KOKKOS_FORCEINLINE_FUNCTION void
addColumns( const Access& nodes, const Pack p, const LaneRows& rows,
            const int first, const Lanes ( &values )[K] )
{
    if constexpr ( std::is_same_v<Access, NodeScatter::Access> )
        if constexpr ( Impl::rowWidth( K ) > 1 )
        {
            Impl::addRows<Impl::rowWidth( K )>( nodes, p, rows, first, values );
            return;
        }
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

//! Columns of a field that addColumns adds to, at least `columns`: rows of
//! whole registers.
constexpr int paddedColumns( const int columns )
{
    return lane_count == 1 || columns < 3 ? columns : ( columns + 3 ) / 4 * 4;
}

/*!
  \brief A field of sums over particles.

  `deposit` adds up this rank's terms, `fold` adds images and neighbours, and
  only then the field has its values. Made once per simulation, since copies of
  the grid are too large to allocate in every step.
*/
class NodeSum
{
  public:
    NodeSum() = default;
    //! \param field [nodes][columns]
    //! \param comm the ranks that share the sum
    //! \param reproducible the same bits for any order of the terms
    NodeSum( const NodeView& field, const Communicator& comm,
             const bool reproducible )
        : _field( field ), _sums( field ), _comm( comm ),
          _reproducible( reproducible )
    {
        if ( !reproducible )
            return;
        const auto columns = field.extent( 1 );
        if ( columns > most_columns )
            throw std::logic_error( "a reproducible sum has at most " +
                                    std::to_string( most_columns ) +
                                    " columns: raise most_columns" );
        _sums = NodeView( "Machpoint::parts", field.extent( 0 ), 2 * columns );
    }

    //! Its values, once it is folded. [nodes][columns]
    const NodeView& field() const { return _field; }

    /*!
      \brief Clears the field and adds the terms of kernels to it.
      \param kernels called with a scatter whose access()( row, column ) takes
      `+=` on the device; launches kernels that do nothing else, as they may
      run twice. Collective where the sum is reproducible.
    */
    template <class Kernels>
    void deposit( const Kernels& kernels )
    {
        if ( !_scatter ) // not every sum is deposited in
            _scatter.emplace( _sums );
        _scatter->clear();
        if ( _reproducible )
            kernels( roundedTerms( kernels ) );
        else
            kernels( *_scatter );
        _scatter->contribute();
    }

    //! Adds images and what neighbours have: owned nodes, and those that
    //! neighbours own, then have their values. \param components of the field
    //! \param kernels see Halo::fold
    template <int Dim, std::size_t N, class Kernels>
    void fold( const Halo<Dim>& halo, const NodeComponents<N>& components,
               const Kernels& kernels )
    {
        if ( _reproducible )
        {
            halo.fold( _sums, twice( components ) );
            joinParts();
            kernels( NodeRows( _field.extent_int( 0 ) ) );
        }
        else
            halo.fold( _field, components, kernels );
    }
    //! The same for all nodes that are stored.
    template <int Dim, std::size_t N, class Kernels>
    void foldAndFill( const Halo<Dim>& halo,
                      const NodeComponents<N>& components,
                      const Kernels& kernels )
    {
        if ( _reproducible )
        {
            halo.foldAndFill( _sums, twice( components ), halo.nothing );
            joinParts();
            kernels( NodeRows( _field.extent_int( 0 ) ) );
        }
        else
            halo.foldAndFill( _field, components, kernels );
    }
    //! \name The same where nothing is to be done meanwhile
    //! @{
    template <int Dim, std::size_t N>
    void fold( const Halo<Dim>& halo, const NodeComponents<N>& components )
    {
        fold( halo, components, halo.nothing );
    }
    template <int Dim, std::size_t N>
    void foldAndFill( const Halo<Dim>& halo,
                      const NodeComponents<N>& components )
    {
        foldAndFill( halo, components, halo.nothing );
    }
    //! @}

    //! Becomes, in every column, what is deposited in one column of another
    //! sum that is not folded yet.
    void copyDeposit( const NodeSum& other, const int column )
    {
        const auto from = other._sums;
        const auto to = _sums;
        const int parts = _reproducible ? 2 : 1;
        const int columns = static_cast<int>( to.extent( 1 ) );
        Kokkos::parallel_for(
            "Machpoint::copyDeposit",
            Range( 0, static_cast<int>( to.extent( 0 ) ) ),
            KOKKOS_LAMBDA( const int i ) {
                for ( int c = 0; c < columns; ++c )
                    to( i, c ) = from( i, parts * column + c % parts );
            } );
    }

    // Public only because nvcc wants the parent function of a device lambda to
    // be accessible.
    void joinParts() const
    {
        const auto field = _field;
        const auto parts = _sums;
        const int columns = static_cast<int>( field.extent( 1 ) );
        Kokkos::parallel_for(
            "Machpoint::joinParts",
            Range( 0, static_cast<int>( field.extent( 0 ) ) ),
            KOKKOS_LAMBDA( const int i ) {
                for ( int c = 0; c < columns; ++c )
                    field( i, c ) = parts( i, 2 * c ) + parts( i, 2 * c + 1 );
            } );
    }

  private:
    //! Components of the columns of parts.
    template <std::size_t N>
    static NodeComponents<2 * N> twice( const NodeComponents<N>& components )
    {
        NodeComponents<2 * N> both{};
        for ( std::size_t c = 0; c < 2 * N; ++c )
            both[c] = components[c / 2];
        return both;
    }

    //! The terms that the kernels will add, knowing the largest of each column
    //! on all ranks.
    template <class Kernels>
    RoundedTerms roundedTerms( const Kernels& kernels ) const
    {
        RoundedTerms rounded{ *_scatter };
        rounded.largest = Kokkos::View<Real*, MemorySpace>(
            "Machpoint::largestTerms", most_columns );
        kernels( rounded );
        const auto host = Kokkos::create_mirror_view_and_copy(
            Kokkos::HostSpace(), rounded.largest );
        const auto most = _comm.max(
            std::vector<double>( host.data(), host.data() + host.size() ) );
        rounded.largest = {};
        for ( std::size_t c = 0; c < most_columns; ++c )
            rounded.setRounding( c, most[c] );
        return rounded;
    }

    NodeView _field;
    NodeView _sums; // the field itself, or [nodes][2 columns]
    std::optional<NodeScatter> _scatter;
    Communicator _comm;
    bool _reproducible = false;
};

} // namespace Machpoint

#endif
