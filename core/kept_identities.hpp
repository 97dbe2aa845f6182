/*!
  \file kept_identities.hpp
  \brief Layer 2: masses and ids of particles as they were before a step.
*/
#ifndef MACHPOINT_KEPT_IDENTITIES_HPP
#define MACHPOINT_KEPT_IDENTITIES_HPP

#include <core/for_each.hpp>

#include <cstdint>
#include <vector>

namespace Machpoint
{

/*!
  \brief Masses and ids of some particles as they were.

  A step leaves them alone, so that the state to return to has no copy of them.
  The few that are changed after it, as particles leave, split or merge, are
  kept here, by their rows.
*/
class KeptIdentities
{
  public:
    //! Forgets all.
    void clear() { _ends.clear(); }

    //! Keeps those of some rows, of which each stands there once; what is kept
    //! already stays. \param m, id slices of all particles
    template <class Masses, class Ids>
    void keep( const IndexList& rows, const Masses& m, const Ids& id )
    {
        const int count = rows.extent_int( 0 );
        if ( count == 0 )
            return;
        const int first = size();
        makeRoom( first + count );
        _ends.push_back( first + count );
        const auto kept_rows = _rows;
        const auto kept_m = _m;
        const auto kept_id = _id;
        forEach(
            "Machpoint::keepIdentities", count,
            MACHPOINT_LAMBDA( const int k ) {
                const int p = rows( k );
                kept_rows( first + k ) = p;
                kept_m( first + k ) = m( p );
                kept_id( first + k ) = id( p );
            } );
    }

    //! Writes all back and forgets them. \param[out] m, id slices of all
    //! particles \param n how many there were; rows from there on came later
    template <class Masses, class Ids>
    void giveBack( const Masses& m, const Ids& id, const int n )
    {
        const auto kept_rows = _rows;
        const auto kept_m = _m;
        const auto kept_id = _id;
        // The first kept of a row is the oldest, so it is given back last.
        while ( !_ends.empty() )
        {
            const int end = size();
            _ends.pop_back();
            Kokkos::parallel_for(
                "Machpoint::giveBackIdentities", Range( size(), end ),
                MACHPOINT_LAMBDA( const int k ) {
                    const int p = kept_rows( k );
                    if ( p >= n )
                        return;
                    m( p ) = kept_m( k );
                    id( p ) = kept_id( k );
                } );
        }
    }

  private:
    //! How many rows are kept.
    int size() const { return _ends.empty() ? 0 : _ends.back(); }

    //! For n rows; those that are kept stay.
    void makeRoom( const int n )
    {
        if ( _rows.extent_int( 0 ) >= n )
            return;
        const int room = n + n / 4;
        Kokkos::resize( Kokkos::WithoutInitializing, _rows, room );
        Kokkos::resize( Kokkos::WithoutInitializing, _m, room );
        Kokkos::resize( Kokkos::WithoutInitializing, _id, room );
    }

    // In the order in which they were kept.
    IndexList _rows{ "Machpoint::keptRows", 0 };
    Kokkos::View<Real*, MemorySpace> _m{ "Machpoint::keptMasses", 0 };
    Kokkos::View<std::int64_t*, MemorySpace> _id{ "Machpoint::keptIds", 0 };
    std::vector<int> _ends; // of what each call has kept
};

} // namespace Machpoint

#endif
