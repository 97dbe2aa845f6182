/*!
  \file Cabana_Distributor.hpp
  \brief Sends particles to the ranks that shall have them.
*/
#ifndef CABANA_DISTRIBUTOR_HPP
#define CABANA_DISTRIBUTOR_HPP

#include <Cabana_AoSoA.hpp>

#include <Kokkos_Core.hpp>

#include <mpi.h>

#include <numeric>
#include <stdexcept>
#include <vector>

namespace Cabana
{

/*!
  \brief A plan by which particles move between ranks.

  Element k goes to the rank that element_export_ranks names, which may be this
  one; those with a negative rank go nowhere. Elements arrive in the order of
  the ranks that sent them, and of each in the order they had there. The
  constructor is collective.
*/
template <class MemorySpace>
class Distributor
{
  public:
    using memory_space = MemorySpace;

    //! \param comm the ranks \param element_export_ranks [elements], on the
    //! device
    template <class RankView>
    Distributor( MPI_Comm comm, const RankView& element_export_ranks )
        : _comm( comm ), _num_export_element( element_export_ranks.size() )
    {
        int size = 0;
        MPI_Comm_size( comm, &size );
        const auto ranks = Kokkos::create_mirror_view_and_copy(
            Kokkos::HostSpace(), element_export_ranks );
        _num_export.assign( size, 0 );
        for ( std::size_t k = 0; k < _num_export_element; ++k )
            if ( ranks( k ) >= 0 )
                ++_num_export.at( ranks( k ) );
        _num_import.resize( size );
        MPI_Alltoall( _num_export.data(), 1, MPI_INT, _num_import.data(), 1,
                      MPI_INT, comm );
        std::vector<int> next( size );
        std::exclusive_scan( _num_export.begin(), _num_export.end(),
                             next.begin(), 0 );
        const auto total =
            std::reduce( _num_export.begin(), _num_export.end() );
        _steering =
            Kokkos::View<int*, MemorySpace>( "Cabana::steering", total );
        const auto steering = Kokkos::create_mirror_view( _steering );
        for ( std::size_t k = 0; k < _num_export_element; ++k )
            if ( ranks( k ) >= 0 )
                steering( next[ranks( k )]++ ) = static_cast<int>( k );
        Kokkos::deep_copy( _steering, steering );
    }

    //! The ranks.
    MPI_Comm comm() const { return _comm; }
    //! Elements that the export ranks were given for.
    std::size_t exportSize() const { return _num_export_element; }
    //! Elements that leave for some rank, this one included.
    std::size_t totalNumExport() const { return _steering.size(); }
    //! Elements that arrive.
    std::size_t totalNumImport() const
    {
        return std::reduce( _num_import.begin(), _num_import.end(),
                            std::size_t( 0 ) );
    }
    //! Elements for each rank, [ranks].
    const std::vector<int>& numExport() const { return _num_export; }
    //! Elements from each rank, [ranks].
    const std::vector<int>& numImport() const { return _num_import; }
    //! The elements to send, rank after rank.
    const Kokkos::View<int*, MemorySpace>& getExportSteering() const
    {
        return _steering;
    }

  private:
    MPI_Comm _comm;
    std::size_t _num_export_element;
    std::vector<int> _num_export, _num_import;
    Kokkos::View<int*, MemorySpace> _steering;
};

/*!
  \brief Sends the elements of `src` as planned and puts what arrives into
  `dst`. Collective. MPI must reach the memory of the plan.
  \param dst of size totalNumImport \throws std::runtime_error of another
*/
template <class MemorySpace, class AoSoA_t>
void migrate( const Distributor<MemorySpace>& distributor, const AoSoA_t& src,
              AoSoA_t& dst )
{
    using tuple_type = typename AoSoA_t::tuple_type;
    using Space = typename AoSoA_t::execution_space;
    if ( src.size() != distributor.exportSize() )
        throw std::runtime_error(
            "Cabana::migrate: the source has another size than the plan" );
    if ( dst.size() != distributor.totalNumImport() )
        throw std::runtime_error(
            "Cabana::migrate: the destination has another size than the plan" );

    const int sent = static_cast<int>( distributor.totalNumExport() );
    const int received = static_cast<int>( distributor.totalNumImport() );
    Kokkos::View<tuple_type*, MemorySpace> out(
        Kokkos::view_alloc( "Cabana::sent", Kokkos::WithoutInitializing ),
        sent );
    Kokkos::View<tuple_type*, MemorySpace> in(
        Kokkos::view_alloc( "Cabana::received", Kokkos::WithoutInitializing ),
        received );
    const auto steering = distributor.getExportSteering();
    Kokkos::parallel_for(
        "Cabana::pack", Kokkos::RangePolicy<Space>( 0, sent ),
        KOKKOS_LAMBDA( const int k ) {
            out( k ) = src.getTuple( steering( k ) );
        } );
    Space().fence( "Cabana: packed" );

    MPI_Datatype element;
    MPI_Type_contiguous( sizeof( tuple_type ), MPI_BYTE, &element );
    MPI_Type_commit( &element );
    std::vector<MPI_Request> requests;
    const int tag = 7777;
    std::size_t first = 0;
    for ( std::size_t rank = 0; rank < distributor.numImport().size(); ++rank )
        if ( const int n = distributor.numImport()[rank]; n > 0 )
        {
            requests.emplace_back();
            MPI_Irecv( in.data() + first, n, element, static_cast<int>( rank ),
                       tag, distributor.comm(), &requests.back() );
            first += n;
        }
    first = 0;
    for ( std::size_t rank = 0; rank < distributor.numExport().size(); ++rank )
        if ( const int n = distributor.numExport()[rank]; n > 0 )
        {
            requests.emplace_back();
            MPI_Isend( out.data() + first, n, element, static_cast<int>( rank ),
                       tag, distributor.comm(), &requests.back() );
            first += n;
        }
    MPI_Waitall( static_cast<int>( requests.size() ), requests.data(),
                 MPI_STATUSES_IGNORE );
    MPI_Type_free( &element );

    Kokkos::parallel_for(
        "Cabana::unpack", Kokkos::RangePolicy<Space>( 0, received ),
        KOKKOS_LAMBDA( const int k ) { dst.setTuple( k, in( k ) ); } );
}

} // namespace Cabana

#endif
