/*!
  \file Cabana_Parallel.hpp
  \brief Loops over particles that name struct and place.
*/
#ifndef CABANA_PARALLEL_HPP
#define CABANA_PARALLEL_HPP

#include <Cabana_ExecutionPolicy.hpp>
#include <Cabana_Types.hpp>
#include <impl/Cabana_Index.hpp>

#include <Kokkos_Core.hpp>

#include <string>
#include <type_traits>

namespace Cabana
{
namespace Impl
{

//! What Kokkos runs for simd_parallel_for.
template <class Policy, class Functor, int VectorLength>
struct SimdFor
{
    Policy policy;
    Functor functor;

    using index_type = typename Policy::index_type;
    using work_tag = typename Policy::work_tag;

    //! Host: a thread takes a struct, whose arrays the compiler vectorizes.
    struct ByStruct
    {
    };
    //! Device: a thread takes a particle, a warp a contiguous array.
    struct ByParticle
    {
    };

    KOKKOS_FUNCTION void operator()( ByStruct, const index_type s ) const
    {
        const index_type end = policy.arrayEnd( s );
        for ( index_type a = policy.arrayBegin( s ); a < end; ++a )
            call( s, a );
    }

    KOKKOS_FUNCTION void operator()( ByParticle, const index_type i ) const
    {
        call( Index<VectorLength>::s( i ), Index<VectorLength>::a( i ) );
    }

    KOKKOS_FORCEINLINE_FUNCTION void call( const index_type s,
                                           const index_type a ) const
    {
        if constexpr ( std::is_void_v<work_tag> )
            functor( s, a );
        else
            functor( work_tag{}, s, a );
    }
};

} // namespace Impl

/*!
  \brief Call functor(s, a), or functor(tag, s, a), for every particle of the
  policy.
  \param policy Range of particles.
  \param functor Callable on the device; s and a as in Impl::Index.
  \param label Name of the kernel.
*/
template <class Functor, int VectorLength, class... Properties>
void simd_parallel_for( const SimdPolicy<VectorLength, Properties...>& policy,
                        const Functor& functor, const std::string& label = "" )
{
    using Policy = SimdPolicy<VectorLength, Properties...>;
    using Loop = Impl::SimdFor<Policy, Functor, VectorLength>;
    using Space = typename Policy::execution_space;
    const Loop loop{ policy, functor };
    if constexpr ( is_accessible_from<Kokkos::HostSpace, Space>::value )
        Kokkos::parallel_for(
            label,
            Kokkos::RangePolicy<Space, typename Loop::ByStruct,
                                typename Policy::schedule_type,
                                Kokkos::IndexType<typename Loop::index_type>>(
                policy.structBegin(), policy.structEnd() ),
            loop );
    else
        Kokkos::parallel_for(
            label,
            Kokkos::RangePolicy<Space, typename Loop::ByParticle,
                                typename Policy::schedule_type,
                                Kokkos::IndexType<typename Loop::index_type>>(
                policy.begin(), policy.end() ),
            loop );
}

} // namespace Cabana

#endif
