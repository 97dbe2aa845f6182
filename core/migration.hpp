/*!
  \file migration.hpp
  \brief Layer 2: particles on their way to other ranks.
*/
#ifndef MACHPOINT_MIGRATION_HPP
#define MACHPOINT_MIGRATION_HPP

#include <core/communicator.hpp>
#include <core/for_each.hpp>
#include <core/traffic.hpp>
#include <core/types.hpp>

#include <Cabana_Core.hpp>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

namespace Machpoint
{

//! What records are made of: as much as an id, of 8 bytes.
using Word = std::int64_t;

//! Words that a particle's members in an AoSoA take.
template <class AoSoA>
constexpr int words_of = ( sizeof( typename AoSoA::tuple_type ) +
                           sizeof( Word ) - 1 ) /
                         sizeof( Word );

#ifdef MACHPOINT_ENABLE_MPI
/*!
  \brief Takes particles to the ranks of a plan (Cabana::Distributor).

  A particle travels as one record, in which its members of all AoSoAs follow
  one another, so that a rank has one message for each other. `pack` every
  AoSoA, `exchange`, and `unpack` every AoSoA in the same order.
*/
class Migration
{
  public:
    //! Collective. \param ranks [leavers] target of each; negative: none
    //! \param words of a record, of all AoSoAs
    Migration( const Communicator& comm, const IndexList& ranks,
               const int words )
        : _plan( comm.handle(), ranks ), _words( words ),
          _sent( makeRecords( "Machpoint::sent", _plan.totalNumExport() ) ),
          _received(
              makeRecords( "Machpoint::received", _plan.totalNumImport() ) )
    {
        ++Traffic::own().collectives;
    }

    //! Number of particles that arrive.
    int arriving() const { return static_cast<int>( _plan.totalNumImport() ); }

    //! Puts the members of an AoSoA into the records.
    //! \param rows [leavers] in the order of the ranks given
    template <class AoSoA>
    void pack( const AoSoA& aosoa, const IndexList& rows )
    {
        const auto leaving = _plan.getExportSteering();
        const auto to = next<AoSoA>( _sent );
        forEach(
            "Machpoint::packParticles",
            static_cast<int>( _plan.totalNumExport() ),
            MACHPOINT_LAMBDA( const int k ) {
                to( k ) = aosoa.getTuple( rows( leaving( k ) ) );
            },
            few_particles );
    }

    //! Sends and receives; waits for both.
    void exchange()
    {
        _packed = 0;
        ExecutionSpace().fence( "Machpoint::particlesPacked" );
        if ( mpiReachesMemory() )
        {
            send( _sent.data(), _received.data() );
            return;
        }
        const auto out =
            Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), _sent );
        const auto in = Kokkos::create_mirror_view( _received );
        send( out.data(), in.data() );
        Kokkos::deep_copy( _received, in );
    }

    //! Puts what has arrived at row `first` and after.
    template <class AoSoA>
    void unpack( const AoSoA& aosoa, const int first )
    {
        const auto from = next<AoSoA>( _received );
        forEach(
            "Machpoint::unpackParticles", arriving(),
            MACHPOINT_LAMBDA( const int k ) {
                aosoa.setTuple( first + k, from( k ) );
            },
            few_particles );
    }

    //! \name Parts of pack and unpack
    //! Public only because nvcc wants the types of a device lambda to be
    //! accessible.
    //! @{
    //! One after the other, [particles * words of a record].
    using Records = Kokkos::View<Word*, MemorySpace>;

    //! The members of one AoSoA in all records.
    template <class Tuple>
    struct Part
    {
        Records records;
        //! Word of a record at which they begin, and words of a record.
        int first, words;

        //! Those of record k.
        KOKKOS_INLINE_FUNCTION Tuple& operator()( const int k ) const
        {
            void* const place =
                records.data() + static_cast<std::size_t>( k ) * words + first;
            return *static_cast<Tuple*>( place );
        }
    };
    //! @}

  private:
    Records makeRecords( const std::string& label,
                         const std::size_t particles ) const
    {
        return Records(
            Kokkos::view_alloc( label, Kokkos::WithoutInitializing ),
            particles * _words );
    }

    template <class AoSoA>
    auto next( const Records& records )
    {
        static_assert( alignof( typename AoSoA::tuple_type ) <=
                       alignof( Word ) );
        const int first = _packed;
        _packed += words_of<AoSoA>;
        return Part<typename AoSoA::tuple_type>{ records, first, _words };
    }

    void send( const Word* out, Word* in ) const
    {
        MPI_Datatype record;
        MPI_Type_contiguous( _words, MPI_INT64_T, &record );
        MPI_Type_commit( &record );
        // Arrivals stand in the order of the ranks they come from, whatever
        // that of the plan is (an installed Cabana's depends on whose message
        // was first), so that a run repeats exactly.
        std::vector<int> by_rank( _plan.numNeighbor() );
        std::iota( by_rank.begin(), by_rank.end(), 0 );
        std::sort( by_rank.begin(), by_rank.end(),
                   [&]( const int a, const int b ) {
                       return _plan.neighborRank( a ) < _plan.neighborRank( b );
                   } );
        std::vector<MPI_Request> requests;
        const int tag = 2; // 0 and 1 are those of the halo
        for ( const int k : by_rank )
            if ( const auto n = _plan.numImport( k ); n > 0 )
            {
                MPI_Irecv( in, static_cast<int>( n ), record,
                           _plan.neighborRank( k ), tag, _plan.comm(),
                           &requests.emplace_back() );
                in += n * _words;
            }
        for ( int k = 0; k < _plan.numNeighbor(); ++k )
            if ( const auto n = _plan.numExport( k ); n > 0 )
            {
                MPI_Isend( out, static_cast<int>( n ), record,
                           _plan.neighborRank( k ), tag, _plan.comm(),
                           &requests.emplace_back() );
                out += n * _words;
            }
        MPI_Waitall( static_cast<int>( requests.size() ), requests.data(),
                     MPI_STATUSES_IGNORE );
        MPI_Type_free( &record );
        Traffic::own().migrated_bytes += static_cast<std::int64_t>(
            _plan.totalNumExport() * _words * sizeof( Word ) );
    }

    Cabana::Distributor<MemorySpace> _plan;
    int _words;
    Records _sent, _received;
    int _packed = 0; // words of a record that are packed, or unpacked
};
#endif

} // namespace Machpoint

#endif
