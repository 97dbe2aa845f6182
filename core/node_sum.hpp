/*!
  \file node_sum.hpp
  \brief Layer 3: what many particles add to the nodes of a field, and on
  request so that the order of adding does not matter to the last bit.
*/
#ifndef MACHPOINT_NODE_SUM_HPP
#define MACHPOINT_NODE_SUM_HPP

#include <core/halo.hpp>

#include <Kokkos_ScatterView.hpp>

#include <cmath>
#include <optional>

namespace Machpoint
{

//! Sums that many particles add to one node: duplicated per thread on OpenMP,
//! atomic on CUDA, plain on Serial.
using NodeScatter = decltype( Kokkos::Experimental::create_scatter_view(
    std::declval<NodeView>() ) );

/*!
  \brief Terms that are rounded before they are added, so that adding is exact
  (Demmel and Nguyen 2015; docs/ranks.md). Stands in for a NodeScatter in
  kernels.

  A term x of column c becomes hi = x rounded to a multiple of a unit u_c, in
  column c, and lo = x - hi rounded to one of a finer unit, in column
  columns + c. The units follow from the largest term of the column, which a
  first run of the same kernels finds.
*/
struct RoundedTerms
{
    //! log2 of how many terms of a node sum up without rounding.
    static constexpr int log2_terms = 16;

    NodeScatter parts; //!< [nodes][2 columns]
    int columns = 0;
    bool measuring = false; //!< look for the largest term, and add nothing
    Kokkos::View<Real*, MemorySpace> largest; //!< magnitude [columns]
    //! A term x is rounded to (r + x) - r: r of hi and of lo.
    Kokkos::View<Real* [2], MemorySpace> rounding; //!< [columns][2]

    RoundedTerms() = default;
    RoundedTerms( const NodeScatter& scatter, const int field_columns )
        : parts( scatter ), columns( field_columns ),
          largest( "Machpoint::largestTerms", columns ),
          rounding( "Machpoint::rounding", columns )
    {
    }

    struct Access;
    //! One place of the sum; takes `+=`.
    struct Place
    {
        const Access& access;
        int row, column;

        KOKKOS_FORCEINLINE_FUNCTION void operator+=( const Real term ) const
        {
            const auto& sum = access.sum;
            if ( sum.measuring )
            {
                Real& most = sum.largest( column );
                const Real size = Kokkos::abs( term );
                // Rarely true, so threads seldom meet here.
                if ( size > most )
                    Kokkos::atomic_max( &most, size );
                return;
            }
            const Real r = sum.rounding( column, 0 );
            const Real s = sum.rounding( column, 1 );
            const Real hi = ( r + term ) - r;
            const Real lo = ( s + ( term - hi ) ) - s;
            access.nodes( row, column ) += hi;
            access.nodes( row, sum.columns + column ) += lo;
        }
    };
    struct Access
    {
        const RoundedTerms& sum;
        decltype( std::declval<const NodeScatter&>().access() ) nodes;

        KOKKOS_FORCEINLINE_FUNCTION Place operator()( const int row,
                                                      const int column ) const
        {
            return { *this, row, column };
        }
    };
    KOKKOS_FORCEINLINE_FUNCTION Access access() const
    {
        return { *this, parts.access() };
    }

    /*!
      \brief Sets the roundings from the largest terms, where |x| < 2^(E + 1).

      With n = log2_terms, r = 1.5 2^(E+n) leaves multiples of 2^(E+n-52), so
      2^n terms sum up to at most 2^53 units; |lo| is at most half a unit, and
      its r is 1.5 2^(E+2n-53). What is lost of a term is at most
      2^(E+2n-106).
    */
    void setRounding() const
    {
        const auto host = Kokkos::create_mirror_view( rounding );
        const auto sizes =
            Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), largest );
        for ( int c = 0; c < columns; ++c )
        {
            const Real size = sizes( c );
            // Terms that are not finite stay what they are.
            const bool rounds = size > 0 && std::isfinite( size );
            const int E = rounds ? std::ilogb( size ) : 0;
            host( c, 0 ) = rounds ? std::ldexp( 1.5, E + log2_terms ) : 0;
            host( c, 1 ) =
                rounds ? std::ldexp( 1.5, E + 2 * log2_terms - 53 ) : 0;
        }
        Kokkos::deep_copy( rounding, host );
    }
};

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
        const auto columns = field.extent( 1 );
        if ( reproducible )
            _sums =
                NodeView( "Machpoint::parts", field.extent( 0 ), 2 * columns );
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
            makeScatter();
        Kokkos::deep_copy( ExecutionSpace(), _sums, 0.0 );
        _scatter->reset_except( _sums );
        if ( _reproducible )
        {
            measure( kernels );
            kernels( _terms );
        }
        else
            kernels( *_scatter );
        Kokkos::Experimental::contribute( _sums, *_scatter );
    }

    //! Adds images and what neighbours have. \param components of the field
    template <int Dim, std::size_t N>
    void fold( const Halo<Dim>& halo, const NodeComponents<N>& components )
    {
        if ( !_reproducible )
        {
            halo.fold( _field, components );
            return;
        }
        NodeComponents<2 * N> both{};
        for ( std::size_t c = 0; c < 2 * N; ++c )
            both[c] = components[c % N];
        halo.fold( _sums, both );
        joinParts();
    }

    //! Becomes, in every column, what is deposited in one column of another
    //! sum that is not folded yet.
    void copyDeposit( const NodeSum& other, const int column )
    {
        const auto from = other._sums;
        const auto to = _sums;
        const int columns = static_cast<int>( _field.extent( 1 ) );
        const int other_columns = static_cast<int>( other._field.extent( 1 ) );
        Kokkos::parallel_for(
            "Machpoint::copyDeposit",
            Range( 0, static_cast<int>( to.extent( 0 ) ) ),
            KOKKOS_LAMBDA( const int i ) {
                for ( int c = 0; c < static_cast<int>( to.extent( 1 ) ); ++c )
                    to( i, c ) =
                        from( i, column + c / columns * other_columns );
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
                    field( i, c ) = parts( i, c ) + parts( i, columns + c );
            } );
    }

  private:
    void makeScatter()
    {
        _scatter = Kokkos::Experimental::create_scatter_view( _sums );
        if ( _reproducible )
            _terms = RoundedTerms( *_scatter,
                                   static_cast<int>( _field.extent( 1 ) ) );
    }

    //! Finds the largest term of each column on all ranks.
    template <class Kernels>
    void measure( const Kernels& kernels )
    {
        Kokkos::deep_copy( ExecutionSpace(), _terms.largest, 0.0 );
        _terms.measuring = true;
        kernels( _terms );
        _terms.measuring = false;
        const auto host = Kokkos::create_mirror_view_and_copy(
            Kokkos::HostSpace(), _terms.largest );
        const auto most =
            _comm.max( std::vector( host.data(), host.data() + host.size() ) );
        for ( std::size_t c = 0; c < most.size(); ++c )
            host( c ) = most[c];
        Kokkos::deep_copy( _terms.largest, host );
        _terms.setRounding();
    }

    NodeView _field;
    NodeView _sums; // the field itself, or [nodes][hi of columns, lo of them]
    std::optional<NodeScatter> _scatter;
    RoundedTerms _terms;
    Communicator _comm;
    bool _reproducible = false;
};

} // namespace Machpoint

#endif
