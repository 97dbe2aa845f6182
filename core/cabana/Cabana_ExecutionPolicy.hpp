/*!
  \file Cabana_ExecutionPolicy.hpp
  \brief A range of particles, seen as structs and places in their arrays.
*/
#ifndef CABANA_EXECUTIONPOLICY_HPP
#define CABANA_EXECUTIONPOLICY_HPP

#include <impl/Cabana_Index.hpp>

#include <Kokkos_Core.hpp>

namespace Cabana
{

/*!
  \brief Particles [begin, end) as a range of (s, a).
  \tparam VectorLength Length of the arrays inside a struct.
  \tparam Properties What Kokkos::RangePolicy takes: execution space, work
  tag, schedule, index type.
*/
template <int VectorLength, class... Properties>
class SimdPolicy
{
    using traits = Kokkos::RangePolicy<Properties...>;
    using index = Impl::Index<VectorLength>;

  public:
    //! Where the loop runs.
    using execution_space = typename traits::execution_space;
    //! Tag passed to the functor first; void for none.
    using work_tag = typename traits::work_tag;
    //! Kokkos' loop schedule.
    using schedule_type = typename traits::schedule_type;
    //! Type of s and a.
    using index_type = typename traits::index_type;

    //! Particles [begin, end).
    SimdPolicy( const index_type begin, const index_type end )
        : _begin( begin ), _end( end )
    {
    }

    //! First particle.
    KOKKOS_FUNCTION index_type begin() const { return _begin; }

    //! One past the last particle.
    KOKKOS_FUNCTION index_type end() const { return _end; }

    //! First struct.
    KOKKOS_FUNCTION index_type structBegin() const
    {
        return index::s( _begin );
    }

    //! One past the last struct.
    KOKKOS_FUNCTION index_type structEnd() const
    {
        return index::numStruct( _end );
    }

    //! First place in the arrays of struct s.
    KOKKOS_FUNCTION index_type arrayBegin( const index_type s ) const
    {
        return s == structBegin() ? index::a( _begin ) : 0;
    }

    //! One past the last place in the arrays of struct s.
    KOKKOS_FUNCTION index_type arrayEnd( const index_type s ) const
    {
        const index_type before = index::i( s, 0 );
        return _end < before + VectorLength ? _end - before : VectorLength;
    }

  private:
    index_type _begin;
    index_type _end;
};

} // namespace Cabana

#endif
