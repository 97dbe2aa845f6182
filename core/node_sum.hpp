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
#include <stdexcept>
#include <string>

namespace Machpoint
{

//! Sums that many particles add to one node: duplicated per thread on OpenMP,
//! atomic on CUDA, plain on Serial.
using NodeScatter = decltype( Kokkos::Experimental::create_scatter_view(
    std::declval<NodeView>() ) );

//! Most columns that a reproducible sum can have.
inline constexpr std::size_t most_columns = 10;

//! A number for each column; in a kernel, in registers.
using PerColumn = Kokkos::Array<Real, most_columns>;

//! Finds the largest term of each column, and adds nothing. Stands in for a
//! NodeScatter in kernels.
struct LargestTerms
{
    Kokkos::View<Real*, MemorySpace> largest; //!< magnitude [most_columns]

    struct Place
    {
        Real& most;
        KOKKOS_FORCEINLINE_FUNCTION void operator+=( const Real term ) const
        {
            most = Kokkos::max( most, Kokkos::abs( term ) );
        }
    };
    struct Access
    {
        Real* largest;
        mutable PerColumn own{};

        KOKKOS_FORCEINLINE_FUNCTION Place operator()( const int,
                                                      const int column ) const
        {
            return { own[column] };
        }
        KOKKOS_FORCEINLINE_FUNCTION ~Access()
        {
            // Rarely larger, so threads seldom meet here.
            for ( std::size_t c = 0; c < most_columns; ++c )
                if ( own[c] > Kokkos::atomic_load( largest + c ) )
                    Kokkos::atomic_max( largest + c, own[c] );
        }
    };
    KOKKOS_FORCEINLINE_FUNCTION Access access() const
    {
        return { largest.data() };
    }
};

/*!
  \brief Terms that are rounded before they are added, so that adding is exact
  (Demmel and Nguyen 2015; docs/ranks.md). Stands in for a NodeScatter in
  kernels.

  A term x of column c becomes hi = x rounded to a multiple of a unit u_c, in
  column 2 c, and lo = x - hi rounded to one of a finer unit, in column 2 c + 1.
  The units follow from the largest term of the column.
*/
struct RoundedTerms
{
    //! log2 of how many terms of a node sum up without rounding.
    static constexpr int log2_terms = 16;

    NodeScatter parts;    //!< [nodes][2 columns]
    PerColumn hi{}, lo{}; //!< r, which rounds x to (r + x) - r

    using PartAccess = decltype( std::declval<const NodeScatter&>().access() );
    struct Place
    {
        const PartAccess& parts;
        int row, column;
        Real r, s;

        KOKKOS_FORCEINLINE_FUNCTION void operator+=( const Real term ) const
        {
            const Real hi = ( r + term ) - r;
            const Real lo = ( s + ( term - hi ) ) - s;
            parts( row, 2 * column ) += hi;
            parts( row, 2 * column + 1 ) += lo;
        }
    };
    struct Access
    {
        PartAccess parts;
        PerColumn hi, lo;

        KOKKOS_FORCEINLINE_FUNCTION Place operator()( const int row,
                                                      const int column ) const
        {
            return { parts, row, column, hi[column], lo[column] };
        }
    };
    KOKKOS_FORCEINLINE_FUNCTION Access access() const
    {
        return { parts.access(), hi, lo };
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
            _scatter = Kokkos::Experimental::create_scatter_view( _sums );
        Kokkos::deep_copy( ExecutionSpace(), _sums, 0.0 );
        _scatter->reset_except( _sums );
        if ( _reproducible )
            kernels( roundedTerms( kernels ) );
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
            both[c] = components[c / 2];
        halo.fold( _sums, both );
        joinParts();
    }

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
    //! The terms that the kernels will add, knowing the largest of each column
    //! on all ranks.
    template <class Kernels>
    RoundedTerms roundedTerms( const Kernels& kernels ) const
    {
        const LargestTerms terms{ Kokkos::View<Real*, MemorySpace>(
            "Machpoint::largestTerms", most_columns ) };
        kernels( terms );
        const auto host = Kokkos::create_mirror_view_and_copy(
            Kokkos::HostSpace(), terms.largest );
        const auto most =
            _comm.max( std::vector( host.data(), host.data() + host.size() ) );
        RoundedTerms rounded{ *_scatter };
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
