/*!
  \file node_scatter.hpp
  \brief Layer 3: what many particles add to the nodes of a field. Each thread
  of a CPU has rows of its own; on a GPU they add at once.
*/
#ifndef MACHPOINT_NODE_SCATTER_HPP
#define MACHPOINT_NODE_SCATTER_HPP

#include <core/lane_rows.hpp>
#include <core/lanes.hpp>
#include <core/warp_run.hpp>

#include <cstring>
#include <limits>
#include <type_traits>

namespace Machpoint
{

/*!
  \brief Which rows of the node fields each thread of a CPU adds to alone: those
  from its own first row to the next thread's.

  Any ascending rows are right. Where they are those of the threads' own
  particles, nearly all sums go straight to the field (NodeScatter). As made,
  all belong to the last thread.
*/
class NodeSeams
{
  public:
    //! Are there threads, each with its rows?
    static constexpr bool has_threads = runs_on_host;
    //! Tells a thread's number in a kernel.
    using Token = Kokkos::Experimental::UniqueToken<
        ExecutionSpace, Kokkos::Experimental::UniqueTokenScope::Global>;

    //! Of a single thread.
    NodeSeams() = default;
    //! For the threads of this build, if there are several.
    static NodeSeams make()
    {
        NodeSeams seams;
        const int threads = has_threads ? Token().size() : 1;
        if ( threads == 1 )
            return seams;
        seams._first = Kokkos::View<int*, Kokkos::HostSpace>(
            "Machpoint::seams", threads + 1 );
        seams.set( threads, std::numeric_limits<int>::max() );
        return seams;
    }

    //! How many have rows of their own; 1 on a GPU.
    int threads() const
    {
        return _first.extent( 0 ) > 0 ? _first.extent_int( 0 ) - 1 : 1;
    }
    //! Thread 0 begins with row 0. \param thread from 1 on
    //! \param row at least that of the thread before
    void set( const int thread, const int row ) const
    {
        _first( thread ) = row;
    }

    //! First row of a thread; of `threads()`, one beyond all rows.
    KOKKOS_FORCEINLINE_FUNCTION int operator()( const int thread ) const
    {
        return _first( thread );
    }

  private:
    Kokkos::View<int*, Kokkos::HostSpace> _first;
};

//! The rows of a stencil of Dim axes, seen from its first row.
template <int Dim>
struct StencilRows
{
    int nodes;           //!< along each axis
    Indices<Dim> stride; //!< distance of neighbours in memory [Dim]

    //! From the first row to the last one.
    KOKKOS_FORCEINLINE_FUNCTION int last() const
    {
        int rows = 0;
        for ( int d = 0; d < Dim; ++d )
            rows += ( nodes - 1 ) * stride[d];
        return rows;
    }
    //! Calls visit( row ) with the first row of every line of nodes.
    template <class Visitor>
    void forEachLine( const Visitor& visit ) const
    {
        for ( int k = 0; k < ( Dim > 2 ? nodes : 1 ); ++k )
            for ( int j = 0; j < ( Dim > 1 ? nodes : 1 ); ++j )
            {
                int row = 0;
                if constexpr ( Dim > 1 )
                    row += j * stride[1];
                if constexpr ( Dim > 2 )
                    row += k * stride[2];
                visit( row );
            }
    }
};

/*!
  \brief Sums that many particles add to one node, atomic on a GPU.

  On a CPU a thread adds to the field itself where all that a particle, or pack,
  sees are rows that are the thread's own, and else to a copy of the nodes.
  Copies are made and added up block by block, where they are needed. It clears
  its rows as it comes to them, so that they are in the cache when they are
  added to: of particles in the order of their cells, a little ahead of them.
*/
class NodeScatter
{
    static constexpr bool has_copies = NodeSeams::has_threads;
    static constexpr int log2_block = 6;
    static constexpr int block_rows = 1 << log2_block;
    //! Bytes that a thread clears at once.
    static constexpr int bytes_ahead = 1024;
    //! First row that a thread has not cleared yet, in a line of the cache of
    //! its own. [threads][16]
    using Progress = Kokkos::View<int* [16], Kokkos::HostSpace>;
    //! A thread's copy of the nodes, [whole blocks of rows][columns]: addresses
    //! for all, memory where the thread has written. Each is an allocation of
    //! its own, as Linux refuses one that is larger than the machine's memory.
    using Copy = Kokkos::View<Real*, Kokkos::HostSpace>;
    //! Knows no neighbours that add along.
    struct Alone
    {
        template <class Base>
        KOKKOS_FORCEINLINE_FUNCTION explicit Alone( const Base& )
        {
        }
        template <std::size_t Rows, std::size_t K>
        KOKKOS_FORCEINLINE_FUNCTION void
        add( Real* sums, const int columns, const int row, const int first,
             const Real ( &values )[Rows][K] ) const
        {
            Real* sum =
                sums + static_cast<std::size_t>( row ) * columns + first;
            for ( std::size_t i = 0; i < Rows; ++i, sum += columns )
                for ( std::size_t k = 0; k < K; ++k )
                    sum[k] += values[i][k];
        }
    };
    using Neighbours = std::conditional_t<has_copies, Alone, WarpRun>;

  public:
    //! \param sums [nodes][columns] \param seams the threads' rows
    explicit NodeScatter( const NodeView& sums,
                          const NodeSeams& seams = NodeSeams::make() )
        : _sums( sums ), _seams( seams )
    {
        const int threads = seams.threads();
        if constexpr ( has_copies )
            _cleared = Progress( "Machpoint::cleared", threads );
        if ( threads == 1 )
            return;
        _copies = Kokkos::View<Copy*, Kokkos::HostSpace>(
            Kokkos::view_alloc( "Machpoint::copiesOfNodes",
                                Kokkos::SequentialHostInit ),
            threads );
        for ( int t = 0; t < threads; ++t )
            _copies( t ) =
                Copy( Kokkos::view_alloc( "Machpoint::copyOfNodes",
                                          Kokkos::WithoutInitializing ),
                      blocks() * block_rows * sums.extent( 1 ) );
        _used = Kokkos::View<unsigned char**, Kokkos::LayoutRight,
                             Kokkos::HostSpace>( "Machpoint::usedBlocks",
                                                 threads, blocks() );
    }

    //! One number, to be added to.
    struct Place
    {
        Real& sum; //!< of the field, or of a thread's copy
        KOKKOS_FORCEINLINE_FUNCTION void operator+=( const Real term ) const
        {
            if constexpr ( has_copies )
                sum += term;
            else
                Kokkos::atomic_add( &sum, term );
        }
    };
    //! The nodes that a particle, or pack, adds to.
    struct Access
    {
        Real* sums; //!< the field, or a thread's copy [rows][columns]
        int columns;
        //! On a GPU those of the warp that add along.
        [[no_unique_address]] Neighbours neighbours;

        //! The columns of row i.
        KOKKOS_FORCEINLINE_FUNCTION Real* row( const int i ) const
        {
            return sums + static_cast<std::size_t>( i ) * columns;
        }
        //! A column of row i, to be added to.
        KOKKOS_FORCEINLINE_FUNCTION Place operator()( const int i,
                                                      const int column ) const
        {
            return { row( i )[column] };
        }
        //! Adds values[i][k] to column first + k of row `row + i`; on a GPU
        //! with the neighbours, so see WarpRun.
        template <std::size_t Rows, std::size_t K>
        KOKKOS_FORCEINLINE_FUNCTION void
        add( const int row, const int first,
             const Real ( &values )[Rows][K] ) const
        {
            neighbours.add( sums, columns, row, first, values );
        }
    };
    //! What a thread needs to know, found out once for all that it adds.
    struct Thread
    {
        Real* sums; //!< the field [rows][columns]
        int columns;
        int first = 0, end = 0;        //!< its own rows
        int* cleared = nullptr;        //!< first of them that is not clear yet
        Real* copy = nullptr;          //!< [rows][columns]
        unsigned char* used = nullptr; //!< has the copy a block? [blocks]

        //! \param p a particle's row or a pack
        //! \param base first row of the stencil, or those of a pack
        //! \param rows of the stencil; no others may be added to
        template <class Particle, class Base, int Dim>
        KOKKOS_FORCEINLINE_FUNCTION Access
        access( const Particle p, const Base& base,
                const StencilRows<Dim>& rows ) const
        {
            if constexpr ( has_copies )
                if ( !areWithin( p, base, first, *cleared - rows.last() ) &&
                     !reach( p, base, rows ) )
                    return { copy, columns, Neighbours( base ) };
            return { sums, columns, Neighbours( base ) };
        }
        //! Clears its rows before `row`.
        KOKKOS_INLINE_FUNCTION void clearTo( const int row ) const
        {
            const int last = Kokkos::min( row, end );
            if ( last <= *cleared )
                return;
            std::memset( sums + static_cast<std::size_t>( *cleared ) * columns,
                         0,
                         static_cast<std::size_t>( last - *cleared ) * columns *
                             sizeof( Real ) );
            *cleared = last;
        }

      private:
        //! Makes ready what a particle, or pack, adds to; seldom. (It gets
        //! copies: what else is in a stencil would have to be in memory, too,
        //! if its base had to.) \return is it the field itself?
        template <class Particle, class Base, int Dim>
        [[gnu::noinline]] bool reach( const Particle p, const Base base,
                                      const StencilRows<Dim> rows ) const
        {
            const int last = rows.last();
            if ( copy && !areWithin( p, base, first, end - last ) )
            {
                prepareCopy( p, base, rows );
                return false;
            }
            int furthest = 0;
            forEachBase( p, base,
                         [&]( const int row )
                         { furthest = Kokkos::max( furthest, row + last ); } );
            const int row_bytes = columns * static_cast<int>( sizeof( Real ) );
            clearTo( furthest + 1 + bytes_ahead / row_bytes );
            // Those that come next, to be in the cache by then.
            const auto* const next = reinterpret_cast<const char*>(
                sums + static_cast<std::size_t>( *cleared ) * columns );
            for ( int byte = 0; byte < bytes_ahead; byte += 64 )
                __builtin_prefetch( next + byte, 1, 3 );
            return true;
        }
        //! Blocks for the stencils.
        template <class Particle, class Base, int Dim>
        void prepareCopy( const Particle p, const Base& base,
                          const StencilRows<Dim>& rows ) const
        {
            auto use = [&]( const int row )
            {
                const int b = row >> log2_block;
                if ( used[b] )
                    return;
                used[b] = 1;
                // All of it, as the copy has whole blocks.
                const std::size_t size =
                    static_cast<std::size_t>( block_rows ) * columns;
                std::memset( copy + b * size, 0, size * sizeof( Real ) );
            };
            auto use_stencil = [&]( const int first_row )
            {
                rows.forEachLine(
                    [&]( const int line )
                    {
                        use( first_row + line );
                        use( first_row + line + rows.nodes - 1 );
                    } );
            };
            forEachBase( p, base, use_stencil );
        }
    };
    //! In a kernel: the thread that runs it.
    KOKKOS_FORCEINLINE_FUNCTION Thread thread() const
    {
        if constexpr ( has_copies )
            if ( _copies.extent( 0 ) > 0 )
            {
                const int number = _token.acquire();
                _token.release( number );
                return thread( number );
            }
        return thread( 0 );
    }

    //! Starts all sums anew: they are whole after `contribute`.
    void clear() const
    {
        if constexpr ( has_copies )
            for ( int t = 0; t < _seams.threads(); ++t )
                _cleared( t, 0 ) = t > 0 ? _seams( t ) : 0;
        else
            Kokkos::deep_copy( ExecutionSpace(), _sums, 0.0 );
    }

    //! All is added: clears what no thread came to, and adds up what the
    //! threads have in their copies.
    void contribute() const
    {
        if constexpr ( has_copies )
            clearRest();
        const int threads = static_cast<int>( _copies.extent( 0 ) );
        if ( threads == 0 )
            return;
        const auto sums = _sums;
        const auto copies = _copies;
        const auto used = _used;
        forEach(
            "Machpoint::sumOfThreads", static_cast<int>( blocks() ),
            MACHPOINT_LAMBDA( const int b ) {
                for ( int t = 0; t < threads; ++t )
                {
                    if ( !used( t, b ) )
                        continue;
                    used( t, b ) = 0;
                    const std::size_t count = numbersOf( sums, b );
                    Real* const sum = &sums( b * block_rows, 0 );
                    const Real* const copy =
                        &copies( t )( b * block_rows * sums.extent( 1 ) );
                    for ( std::size_t k = 0; k < count; ++k )
                        sum[k] += copy[k];
                }
            },
            few_particles );
    }

    //! Public because nvcc wants the parent function of a device lambda to be
    //! accessible.
    void clearRest() const
    {
        const NodeScatter scatter = *this;
        const int threads = _seams.threads();
        forEach(
            "Machpoint::clearSums", threads,
            MACHPOINT_LAMBDA( const int t ) {
                const auto own = scatter.thread( t );
                own.clearTo( own.end );
            },
            _sums.extent_int( 0 ) <= few_rows ? threads : 0 );
    }

  private:
    std::size_t blocks() const
    {
        return ( _sums.extent( 0 ) + block_rows - 1 ) / block_rows;
    }
    //! Numbers in block b of a field.
    KOKKOS_FORCEINLINE_FUNCTION static std::size_t
    numbersOf( const NodeView& sums, const int b )
    {
        const std::size_t first = static_cast<std::size_t>( b ) * block_rows;
        const std::size_t rest = sums.extent( 0 ) - first;
        return ( rest < block_rows ? rest : block_rows ) * sums.extent( 1 );
    }
    KOKKOS_FORCEINLINE_FUNCTION Thread thread( const int number ) const
    {
        Thread own{ _sums.data(), static_cast<int>( _sums.extent( 1 ) ) };
        if constexpr ( has_copies )
        {
            const int rows = static_cast<int>( _sums.extent( 0 ) );
            own.end = rows;
            own.cleared = &_cleared( number, 0 );
            if ( _copies.extent( 0 ) > 0 )
            {
                own.first = _seams( number );
                own.end = Kokkos::min( _seams( number + 1 ), rows );
                own.copy = _copies( number ).data();
                own.used = &_used( number, 0 );
            }
        }
        return own;
    }

    //! Calls visit with the first row of each particle's stencil.
    template <class Visitor>
    KOKKOS_FORCEINLINE_FUNCTION static void
    forEachBase( const int, const int base, const Visitor& visit )
    {
        visit( base );
    }
    template <class Visitor>
    KOKKOS_FORCEINLINE_FUNCTION static void
    forEachBase( const Pack p, const Bases<Lanes>& bases, const Visitor& visit )
    {
        for ( int l = 0; l < p.count; ++l ) // idle lanes hold anything
            visit( lane( bases, l ) );
    }

    NodeView _sums;
    NodeSeams _seams;
    Progress _cleared;
    Kokkos::View<Copy*, Kokkos::HostSpace> _copies; // [threads]
    Kokkos::View<unsigned char**, Kokkos::LayoutRight, Kokkos::HostSpace> _used;
    NodeSeams::Token _token;
};

} // namespace Machpoint

#endif
