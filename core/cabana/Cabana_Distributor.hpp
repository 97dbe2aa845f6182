/*!
  \file Cabana_Distributor.hpp
  \brief Which particles go to which rank.
*/
#ifndef CABANA_DISTRIBUTOR_HPP
#define CABANA_DISTRIBUTOR_HPP

#include <Kokkos_Core.hpp>

#include <mpi.h>

#include <cstddef>
#include <vector>

namespace Cabana
{

/*!
  \brief A plan by which elements move between ranks.

  Element k goes to the rank that element_export_ranks names, which may be this
  one; those with a negative rank go nowhere. Neighbours are the ranks to which
  an element goes, or from which one comes. The constructor is collective.
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
        std::vector<int> exports( size ), imports( size );
        for ( std::size_t k = 0; k < _num_export_element; ++k )
            if ( ranks( k ) >= 0 )
                ++exports.at( ranks( k ) );
        MPI_Alltoall( exports.data(), 1, MPI_INT, imports.data(), 1, MPI_INT,
                      comm );
        std::vector<std::size_t> next( size );
        for ( int rank = 0; rank < size; ++rank )
        {
            next[rank] = _total_num_export;
            if ( exports[rank] + imports[rank] == 0 )
                continue;
            _neighbors.push_back( rank );
            _num_export.push_back( exports[rank] );
            _num_import.push_back( imports[rank] );
            _total_num_export += exports[rank];
            _total_num_import += imports[rank];
        }
        _steering = Kokkos::View<std::size_t*, MemorySpace>(
            Kokkos::view_alloc( "Cabana::steering",
                                Kokkos::WithoutInitializing ),
            _total_num_export );
        const auto steering = Kokkos::create_mirror_view( _steering );
        for ( std::size_t k = 0; k < _num_export_element; ++k )
            if ( ranks( k ) >= 0 )
                steering( next[ranks( k )]++ ) = k;
        Kokkos::deep_copy( _steering, steering );
    }

    //! The ranks.
    MPI_Comm comm() const { return _comm; }
    //! Elements that the export ranks were given for.
    std::size_t exportSize() const { return _num_export_element; }
    //! Ranks that elements go to or come from.
    int numNeighbor() const { return static_cast<int>( _neighbors.size() ); }
    //! One of them.
    int neighborRank( const int neighbor ) const
    {
        return _neighbors[neighbor];
    }
    //! Elements that go there.
    std::size_t numExport( const int neighbor ) const
    {
        return _num_export[neighbor];
    }
    //! Elements that come from there.
    std::size_t numImport( const int neighbor ) const
    {
        return _num_import[neighbor];
    }
    //! Elements that leave for some rank, this one included.
    std::size_t totalNumExport() const { return _total_num_export; }
    //! Elements that arrive.
    std::size_t totalNumImport() const { return _total_num_import; }
    //! The elements to send, neighbour after neighbour.
    const Kokkos::View<std::size_t*, MemorySpace>& getExportSteering() const
    {
        return _steering;
    }

  private:
    MPI_Comm _comm;
    std::size_t _num_export_element;
    std::size_t _total_num_export = 0, _total_num_import = 0;
    std::vector<int> _neighbors;
    std::vector<std::size_t> _num_export, _num_import; // of each neighbour
    Kokkos::View<std::size_t*, MemorySpace> _steering;
};

} // namespace Cabana

#endif
