/*!
  \file halo_exchange.hpp
  \brief Layer 3: layers of nodes that neighbouring ranks send each other.
*/
#ifndef MACHPOINT_HALO_EXCHANGE_HPP
#define MACHPOINT_HALO_EXCHANGE_HPP

#include <core/decomposition.hpp>

namespace Machpoint
{

//! Can MPI read and write this build's memory? Otherwise messages go through
//! copies on the host.
inline constexpr bool mpi_reaches_memory =
    Kokkos::SpaceAccessibility<Kokkos::HostSpace, MemorySpace>::accessible;

/*!
  \brief Sends layers of a node field to the two neighbours along an axis.

  `start` packs and sends, `finish` waits and calls apply( field value,
  received value ) for every value, so that other work fits in between.
*/
template <int Dim>
class HaloExchange
{
  public:
    //! Layers of nodes, by number of the first.
    struct Layers
    {
        int first;
        int count;
    };
    //! What goes to and comes from the neighbour on one side; rank < 0: none.
    struct Side
    {
        int rank = -1;
        Layers send{}, receive{};
    };

    HaloExchange() = default;
    HaloExchange( const NodeLayout<Dim>& layout, const Communicator& comm )
        : _layout( layout ), _comm( comm )
    {
    }

    //! \param sides lower and upper \param columns the first of the field
    void start( const NodeView& field, const int axis, const int columns,
                const Side ( &sides )[2] )
    {
#ifdef MACHPOINT_ENABLE_MPI
        _requests.clear();
        for ( int s = 0; s < 2; ++s )
        {
            if ( sides[s].rank < 0 )
                continue;
            const int across = _layout.total / _layout.extent[axis];
            const int n = sides[s].receive.count * across * columns;
            _received[s].reserve( n );
            // A message carries the side from which it left.
            post( MPI_Irecv, _received[s], n, sides[s].rank, 1 - s );
        }
        for ( int s = 0; s < 2; ++s )
            if ( sides[s].rank >= 0 )
                pack( field, axis, columns, sides[s].send, _sent[s] );
        if ( !_requests.empty() )
            ExecutionSpace().fence( "Machpoint: halo packed" );
        for ( int s = 0; s < 2; ++s )
            if ( sides[s].rank >= 0 )
            {
                const int across = _layout.total / _layout.extent[axis];
                const int n = sides[s].send.count * across * columns;
                _sent[s].toHost( n );
                post( MPI_Isend, _sent[s], n, sides[s].rank, s );
                bytes_sent += n * static_cast<std::int64_t>( sizeof( Real ) );
                ++messages_sent;
            }
#else
        static_cast<void>( field );
        static_cast<void>( axis );
        static_cast<void>( columns );
        static_cast<void>( sides );
#endif
    }

    template <class Operation>
    void finish( const NodeView& field, const int axis, const int columns,
                 const Side ( &sides )[2], const Operation& apply )
    {
#ifdef MACHPOINT_ENABLE_MPI
        if ( _requests.empty() )
            return;
        MPI_Waitall( static_cast<int>( _requests.size() ), _requests.data(),
                     MPI_STATUSES_IGNORE );
        for ( int s = 0; s < 2; ++s )
            if ( sides[s].rank >= 0 )
            {
                const int across = _layout.total / _layout.extent[axis];
                _received[s].toDevice( sides[s].receive.count * across *
                                       columns );
                unpack( field, axis, columns, sides[s].receive, _received[s],
                        apply );
            }
#else
        static_cast<void>( field );
        static_cast<void>( axis );
        static_cast<void>( columns );
        static_cast<void>( sides );
        static_cast<void>( apply );
#endif
    }

    std::int64_t bytes_sent = 0;
    std::int64_t messages_sent = 0;

    // Public only because nvcc wants the types and the parent function of a
    // device lambda to be accessible.

    //! Memory of a message, with its copy on the host where MPI needs one.
    struct Buffer
    {
        Kokkos::View<Real*, MemorySpace> device;
        Kokkos::View<Real*, Kokkos::HostSpace> host;

        void reserve( const int n )
        {
            if ( static_cast<int>( device.extent( 0 ) ) >= n )
                return;
            Kokkos::realloc( Kokkos::WithoutInitializing, device, n );
            if constexpr ( mpi_reaches_memory )
                host =
                    Kokkos::View<Real*, Kokkos::HostSpace>( device.data(), n );
            else
                Kokkos::realloc( Kokkos::WithoutInitializing, host, n );
        }
        void toHost( const int n ) const
        {
            if constexpr ( !mpi_reaches_memory )
                Kokkos::deep_copy(
                    Kokkos::subview( host, Kokkos::make_pair( 0, n ) ),
                    Kokkos::subview( device, Kokkos::make_pair( 0, n ) ) );
            static_cast<void>( n );
        }
        void toDevice( const int n ) const
        {
            if constexpr ( !mpi_reaches_memory )
                Kokkos::deep_copy(
                    Kokkos::subview( device, Kokkos::make_pair( 0, n ) ),
                    Kokkos::subview( host, Kokkos::make_pair( 0, n ) ) );
            static_cast<void>( n );
        }
    };

    //! Row of node t of a layer, t running over the other axes with their
    //! halos, x first.
    KOKKOS_INLINE_FUNCTION static int rowInLayer( const NodeLayout<Dim>& layout,
                                                  const int axis,
                                                  const int layer, int t )
    {
        Indices<Dim> i{};
        for ( int d = 0; d < Dim; ++d )
        {
            if ( d == axis )
                i[d] = layer;
            else
            {
                i[d] = t % layout.extent[d] + layout.lowest( d );
                t /= layout.extent[d];
            }
        }
        return layout( i );
    }

    void pack( const NodeView& field, const int axis, const int columns,
               const Layers& layers, Buffer& buffer ) const
    {
        const auto layout = _layout;
        const int across = layout.total / layout.extent[axis];
        buffer.reserve( layers.count * across * columns );
        const auto values = buffer.device;
        const int first = layers.first;
        Kokkos::parallel_for(
            "Machpoint::packHalo", Range( 0, layers.count * across ),
            KOKKOS_LAMBDA( const int k ) {
                const int row =
                    rowInLayer( layout, axis, first + k / across, k % across );
                for ( int c = 0; c < columns; ++c )
                    values( k * columns + c ) = field( row, c );
            } );
    }

    template <class Operation>
    void unpack( const NodeView& field, const int axis, const int columns,
                 const Layers& layers, const Buffer& buffer,
                 const Operation& apply ) const
    {
        const auto layout = _layout;
        const int across = layout.total / layout.extent[axis];
        const auto values = buffer.device;
        const int first = layers.first;
        Kokkos::parallel_for(
            "Machpoint::unpackHalo", Range( 0, layers.count * across ),
            KOKKOS_LAMBDA( const int k ) {
                const int row =
                    rowInLayer( layout, axis, first + k / across, k % across );
                for ( int c = 0; c < columns; ++c )
                    apply( field( row, c ), values( k * columns + c ) );
            } );
    }

  private:
#ifdef MACHPOINT_ENABLE_MPI
    template <class Call>
    void post( const Call& call, const Buffer& buffer, const int n,
               const int rank, const int tag )
    {
        _requests.emplace_back();
        call( buffer.host.data(), n, MPI_DOUBLE, rank, tag, _comm.handle(),
              &_requests.back() );
    }

    std::vector<MPI_Request> _requests;
#endif
    NodeLayout<Dim> _layout;
    Communicator _comm;
    Buffer _sent[2], _received[2];
};

} // namespace Machpoint

#endif
