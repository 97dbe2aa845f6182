/*!
  \file halo_exchange.hpp
  \brief Layer 3: layers of nodes that neighbouring ranks send each other.
*/
#ifndef MACHPOINT_HALO_EXCHANGE_HPP
#define MACHPOINT_HALO_EXCHANGE_HPP

#include <core/decomposition.hpp>
#include <core/traffic.hpp>

namespace Machpoint
{

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
        int first; //!< as nodes are numbered along the axis
        int count;
    };
    //! What goes to and comes from the neighbour on one side; rank < 0: none.
    struct Side
    {
        int rank = -1;
        Layers send{}, receive{};
    };

    HaloExchange() = default;
    //! \param layout of all fields that are to be sent
    HaloExchange( const NodeLayout<Dim>& layout, const Communicator& comm )
        : _layout( layout ), _comm( comm )
    {
    }

    //! Packs and sends; waits for the kernels before.
    //! \param field [nodes][>= columns] \param columns that are sent
    //! \param sides lower and upper
    void start( const NodeView& field, const int axis, const int columns,
                const Side ( &sides )[2] )
    {
#ifdef MACHPOINT_ENABLE_MPI
        _requests.clear();
        if ( sides[0].rank < 0 && sides[1].rank < 0 )
            return;
        const Traffic::Timer timer( Activity::halo );
        for ( int s = 0; s < 2; ++s )
            if ( sides[s].rank >= 0 )
            {
                _received[s].reserve( size( axis, columns, sides[s].receive ) );
                pack( field, axis, columns, sides[s].send, _sent[s] );
            }
        // Also so that no kernel reads what the next message overwrites.
        ExecutionSpace().fence( "Machpoint::haloPacked" );
        for ( int s = 0; s < 2; ++s )
            if ( sides[s].rank >= 0 )
                // A message carries the side from which it left.
                post( MPI_Irecv, _received[s],
                      size( axis, columns, sides[s].receive ), sides[s].rank,
                      1 - s );
        auto& traffic = Traffic::own();
        for ( int s = 0; s < 2; ++s )
            if ( sides[s].rank >= 0 )
            {
                const int n = size( axis, columns, sides[s].send );
                _sent[s].toHost( n );
                post( MPI_Isend, _sent[s], n, sides[s].rank, s );
                traffic.halo_bytes +=
                    n * static_cast<std::int64_t>( sizeof( Real ) );
                ++traffic.halo_messages;
            }
#else
        static_cast<void>( field );
        static_cast<void>( axis );
        static_cast<void>( columns );
        static_cast<void>( sides );
#endif
    }

    //! Waits for what `start` was called for with the same arguments, and takes
    //! it up. \param apply callable on the device with a number of the field
    //! and the one received for it
    template <class Operation>
    void finish( const NodeView& field, const int axis, const int columns,
                 const Side ( &sides )[2], const Operation& apply )
    {
#ifdef MACHPOINT_ENABLE_MPI
        if ( _requests.empty() )
            return;
        {
            const Traffic::Timer timer( Activity::halo_wait );
            MPI_Waitall( static_cast<int>( _requests.size() ), _requests.data(),
                         MPI_STATUSES_IGNORE );
        }
        const Traffic::Timer timer( Activity::halo );
        for ( int s = 0; s < 2; ++s )
            if ( sides[s].rank >= 0 )
            {
                _received[s].toDevice(
                    size( axis, columns, sides[s].receive ) );
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

    //! \name Parts of start and finish
    //! Public only because nvcc wants the types and the parent function of a
    //! device lambda to be accessible.
    //! @{
    //! Memory of a message, and where MPI does not reach it a copy on the host.
    struct Buffer
    {
        Kokkos::View<Real*, MemorySpace> device; //!< [>= numbers of a message]
        Kokkos::View<Real*, Kokkos::HostSpace> host; //!< the same, or empty

        //! Makes room for n numbers; former ones may be lost.
        void reserve( const int n )
        {
            if ( static_cast<int>( device.extent( 0 ) ) >= n )
                return;
            Kokkos::realloc( Kokkos::WithoutInitializing, device, n );
            if ( !mpiReachesMemory() )
                Kokkos::realloc( Kokkos::WithoutInitializing, host, n );
        }
        //! What MPI reads and writes.
        Real* data() const
        {
            return mpiReachesMemory() ? device.data() : host.data();
        }
        //! Brings the first n numbers to where MPI reads them; waits.
        void toHost( const int n ) const
        {
            if ( !mpiReachesMemory() )
                Kokkos::deep_copy(
                    Kokkos::subview( host, Kokkos::make_pair( 0, n ) ),
                    Kokkos::subview( device, Kokkos::make_pair( 0, n ) ) );
        }
        //! Brings them back from where MPI has written them; waits.
        void toDevice( const int n ) const
        {
            if ( !mpiReachesMemory() )
                Kokkos::deep_copy(
                    Kokkos::subview( device, Kokkos::make_pair( 0, n ) ),
                    Kokkos::subview( host, Kokkos::make_pair( 0, n ) ) );
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

    //! Copies layers of a field to a buffer, [layers][nodes of a
    //! layer][columns].
    void pack( const NodeView& field, const int axis, const int columns,
               const Layers& layers, Buffer& buffer ) const
    {
        const auto layout = _layout;
        const int across = layout.total / layout.extent[axis];
        buffer.reserve( size( axis, columns, layers ) );
        const auto values = buffer.device;
        const int first = layers.first;
        forEach(
            "Machpoint::packHalo", layers.count * across,
            MACHPOINT_LAMBDA( const int k ) {
                const int row =
                    rowInLayer( layout, axis, first + k / across, k % across );
                for ( int c = 0; c < columns; ++c )
                    values( k * columns + c ) = field( row, c );
            } );
    }

    //! Hands what a buffer has to the layers of a field. \param apply see
    //! finish
    template <class Operation>
    void unpack( const NodeView& field, const int axis, const int columns,
                 const Layers& layers, const Buffer& buffer,
                 const Operation& apply ) const
    {
        const auto layout = _layout;
        const int across = layout.total / layout.extent[axis];
        const auto values = buffer.device;
        const int first = layers.first;
        forEach(
            "Machpoint::unpackHalo", layers.count * across,
            MACHPOINT_LAMBDA( const int k ) {
                const int row =
                    rowInLayer( layout, axis, first + k / across, k % across );
                for ( int c = 0; c < columns; ++c )
                    apply( field( row, c ), values( k * columns + c ) );
            } );
    }
    //! @}

  private:
    //! Values in some layers.
    int size( const int axis, const int columns, const Layers& layers ) const
    {
        return layers.count * ( _layout.total / _layout.extent[axis] ) *
               columns;
    }

#ifdef MACHPOINT_ENABLE_MPI
    template <class Call>
    void post( const Call& call, const Buffer& buffer, const int n,
               const int rank, const int tag )
    {
        _requests.emplace_back();
        call( buffer.data(), n, is_single ? MPI_FLOAT : MPI_DOUBLE, rank, tag,
              _comm.handle(), &_requests.back() );
    }

    std::vector<MPI_Request> _requests;
#endif
    NodeLayout<Dim> _layout;
    Communicator _comm;
    Buffer _sent[2], _received[2];
};

} // namespace Machpoint

#endif
