/*!
  \file node_sum.hpp
  \brief Layer 3: a field of sums over particles, and on request so that the
  order of adding does not matter to the last bit.
*/
#ifndef MACHPOINT_NODE_SUM_HPP
#define MACHPOINT_NODE_SUM_HPP

#include <core/halo.hpp>
#include <core/rounded_terms.hpp>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

//! Columns of a field that addProducts adds to, at least `columns`: rows of
//! whole registers, as it adds zeros behind them.
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
    //! \param seams the threads' rows
    //! \throws std::logic_error a reproducible one has more than most_columns
    NodeSum( const NodeView& field, const Communicator& comm,
             const bool reproducible,
             const NodeSeams& seams = NodeSeams::make() )
        : _field( field ), _sums( field ), _seams( seams ), _comm( comm ),
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
      \param kernels called with a scatter, for forEachDeposit or, on the
      device, accessTo; launches kernels that do nothing else, as they may run
      twice. Collective where the sum is reproducible.
    */
    template <class Kernels>
    void deposit( const Kernels& kernels )
    {
        if ( !_scatter ) // not every sum is deposited in
            _scatter.emplace( _sums, _seams );
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
    //! sum that is not folded yet. \param other of the same nodes, and as
    //! reproducible
    void copyDeposit( const NodeSum& other, const int column )
    {
        const auto from = other._sums;
        const auto to = _sums;
        const int parts = _reproducible ? 2 : 1;
        const int columns = static_cast<int>( to.extent( 1 ) );
        forEach(
            "Machpoint::copyDeposit", to.extent_int( 0 ),
            MACHPOINT_LAMBDA( const int i ) {
                for ( int c = 0; c < columns; ++c )
                    to( i, c ) = from( i, parts * column + c % parts );
            } );
    }

    //! Adds up the two parts of a reproducible sum. Public only because nvcc
    //! wants the parent function of a device lambda to be accessible.
    void joinParts() const
    {
        const auto field = _field;
        const auto parts = _sums;
        const int columns = static_cast<int>( field.extent( 1 ) );
        forEach(
            "Machpoint::joinParts", field.extent_int( 0 ),
            MACHPOINT_LAMBDA( const int i ) {
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
    NodeSeams _seams;
    std::optional<NodeScatter> _scatter;
    Communicator _comm;
    bool _reproducible = false;
};

} // namespace Machpoint

#endif
