/*!
  \file Cabana_PerformanceTraits.hpp
  \brief Default vector length of each execution space.
*/
#ifndef CABANA_PERFORMANCETRAITS_HPP
#define CABANA_PERFORMANCETRAITS_HPP

#include <Kokkos_Core.hpp>

namespace Cabana
{
namespace Impl
{

//! Host threads: a cache line of doubles, and of AVX-512 a register, for each
//! component.
template <class ExecutionSpace>
struct PerformanceTraits
{
    //! Default length of the arrays inside a struct.
    static constexpr int vector_length = 8;
};

#if defined( KOKKOS_ENABLE_CUDA )
//! CUDA: one warp reads one array.
template <>
struct PerformanceTraits<Kokkos::Cuda>
{
    //! Default length of the arrays inside a struct.
    static constexpr int vector_length = 32;
};
#endif

#if defined( KOKKOS_ENABLE_HIP )
//! HIP: one wavefront reads one array.
template <>
struct PerformanceTraits<Kokkos::HIP>
{
    //! Default length of the arrays inside a struct.
    static constexpr int vector_length = 64;
};
#endif

} // namespace Impl
} // namespace Cabana

#endif
