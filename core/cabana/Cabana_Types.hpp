/*!
  \file Cabana_Types.hpp
  \brief Tags that say how a slice reads and writes its memory.
*/
#ifndef CABANA_TYPES_HPP
#define CABANA_TYPES_HPP

#include <Kokkos_Core.hpp>

#include <type_traits>

// Ahead of functions with kernels that are of the host, too. nvcc gives such a
// kernel pointers to functions, which are set where it is made, and each
// translation unit has its own; so what makes it must be the one function that
// the linker keeps of all units, and no copy that the compiler has made of it
// elsewhere (nvcc 13.0).
#if defined( KOKKOS_ENABLE_CUDA ) && defined( __GNUC__ ) &&                    \
    !defined( __clang__ )
#define CABANA_LAUNCHES __attribute__( ( noinline, noclone ) )
#else
#define CABANA_LAUNCHES
#endif

namespace Cabana
{

//! Plain reads and writes.
struct DefaultAccessMemory
{
    //! The tag itself.
    using memory_access_type = DefaultAccessMemory;
};

//! Reads only, from places that have little to do with each other.
struct RandomAccessMemory
{
    //! The tag itself.
    using memory_access_type = RandomAccessMemory;
};

//! Every read and write is atomic.
struct AtomicAccessMemory
{
    //! The tag itself.
    using memory_access_type = AtomicAccessMemory;
};

//! True for the three tags above.
template <class T>
struct is_memory_access_tag : std::false_type
{
};

template <>
struct is_memory_access_tag<DefaultAccessMemory> : std::true_type
{
};

template <>
struct is_memory_access_tag<RandomAccessMemory> : std::true_type
{
};

template <>
struct is_memory_access_tag<AtomicAccessMemory> : std::true_type
{
};

//! True when code that runs in ExecutionSpace may touch MemorySpace.
template <typename MemorySpace, typename ExecutionSpace>
struct is_accessible_from
    : std::bool_constant<
          Kokkos::SpaceAccessibility<ExecutionSpace, MemorySpace>::accessible>
{
};

} // namespace Cabana

#endif
