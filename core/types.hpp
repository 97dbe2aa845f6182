/*!
  \file types.hpp
  \brief Layer 1: the number type, the execution and memory space, and small
  fixed-size vectors. Everything else builds on these names.
*/
#ifndef MACHPOINT_TYPES_HPP
#define MACHPOINT_TYPES_HPP

#include <Kokkos_Core.hpp>

#include <cstdint>
#include <type_traits>

namespace Machpoint
{

//! Floating-point type of particles and fields (nondimensional unless
//! labelled), one per build (Machpoint_PRECISION). Times and totals are double
//! in any.
#if defined( MACHPOINT_PRECISION_SINGLE )
using Real = float;
#else
using Real = double;
#endif

/*!
  \brief What a particle keeps of how its gas differs from a uniform one:
  velocity gradients, rates, and parts in [0, 1].

  Where precision is mixed, a float, which takes half the memory. It is 0 in
  uniform flow, so that rounding it disturbs none; kernels compute with a Real.
  docs/method.md, section 9, says what stays exact.
*/
#if defined( MACHPOINT_PRECISION_MIXED )
using Deviation = float;
#else
using Deviation = Real;
#endif

//! Is a Real a float?
inline constexpr bool is_single = std::is_same_v<Real, float>;
//! Is a Deviation another type?
inline constexpr bool is_mixed = !std::is_same_v<Deviation, Real>;
//! What Machpoint_PRECISION calls them.
inline constexpr const char* precision_name = is_single  ? "single"
                                              : is_mixed ? "mixed"
                                                         : "double";

//! \name What a Real can tell
//! @{
//! No quantity of a gas is as large.
inline constexpr Real largest_quantity = is_single ? 1e37 : 1e300;
//! Nor any speed, so that its square is a Real.
inline constexpr Real largest_speed = is_single ? 1e18 : 1e150;
//! Values that differ by less than this part of them may be the same.
inline constexpr Real round_off = is_single ? 1e-5 : 1e-9;
//! A way, in cells, that is far beyond the rounding of a position and far
//! below anything that the gas resolves.
inline constexpr Real nudge = is_single ? 1e-2 : 1e-6;
//! @}

//! A literal of that type, 0.5_rt: as a double it would make doubles of all
//! that a kernel multiplies it by.
consteval Real operator""_rt( const long double value )
{
    return static_cast<Real>( value );
}

//! Where kernels run. One backend per build (Machpoint_BACKEND); without a
//! choice, Kokkos' own.
#if defined( MACHPOINT_BACKEND_CUDA )
using ExecutionSpace = Kokkos::Cuda;
#elif defined( MACHPOINT_BACKEND_OPENMP )
using ExecutionSpace = Kokkos::OpenMP;
#elif defined( MACHPOINT_BACKEND_SERIAL )
using ExecutionSpace = Kokkos::Serial;
#else
using ExecutionSpace = Kokkos::DefaultExecutionSpace;
#endif
//! What kernels read and write.
using MemorySpace = typename ExecutionSpace::memory_space;
//! Do kernels run on the host's processor? (It may reach a GPU's memory, too.)
inline constexpr bool runs_on_host =
    std::is_same_v<MemorySpace, Kokkos::HostSpace>;

//! Is this built for a Zen of AMD's, where some instructions are better
//! avoided?
#if defined( __znver1__ ) || defined( __znver2__ ) || defined( __znver3__ ) || \
    defined( __znver4__ ) || defined( __znver5__ )
inline constexpr bool is_zen = true;
#else
inline constexpr bool is_zen = false;
#endif

//! Zen 5? (Compilers that do not know it yet take it for an older one with
//! these instructions, which no other Zen has.)
#if defined( __znver5__ ) || defined( __AVX512VP2INTERSECT__ )
inline constexpr bool is_zen5 = is_zen;
#else
inline constexpr bool is_zen5 = false;
#endif

//! Most threads of a block on a GPU.
inline constexpr int most_threads = 128;

//! Has a multiprocessor shared memory for several blocks of any kernel? P2G
//! takes up to 47 KB a block (core/warp_run.hpp), and GPUs of workstations have
//! 100 KB and less. Kokkos would find no size of a block for more.
#if defined( KOKKOS_ARCH_AMPERE80 ) || defined( KOKKOS_ARCH_HOPPER90 ) ||      \
    defined( KOKKOS_ARCH_BLACKWELL100 )
inline constexpr bool holds_many_blocks = true;
#else
inline constexpr bool holds_many_blocks = false;
#endif

/*!
  \brief Range of particles or nodes on the build's backend.

  On CUDA a kernel gets what it captures as its parameters: Kokkos puts more
  than 512 bytes of them into constant memory otherwise, and before that waits
  for the last kernel that it did so for to end.

  \tparam Blocks how many a multiprocessor of a GPU is to hold at least, which
  bounds the registers of a thread: 128 for 4 blocks, 168 for 3, 255 for fewer
*/
template <int Blocks>
using RangeOf = Kokkos::RangePolicy<
    ExecutionSpace, Kokkos::LaunchBounds<most_threads, Blocks>,
    Kokkos::Experimental::WorkItemProperty::HintLightWeight_t>;
//! That of kernels that may take all registers.
using Range = RangeOf<1>;

//! Position, velocity or other vector. Shape [Dim].
template <int Dim>
using Vector = Kokkos::Array<Real, Dim>;

//! Vector of initial states and exact solutions, which the host computes in
//! double precision, whatever the fields have. Shape [3].
using Vector3 = Kokkos::Array<double, 3>;

//! Cell or node coordinates. Shape [Dim].
template <int Dim>
using Indices = Kokkos::Array<int, Dim>;

//! Node data, one row per node, one column per component:
//! [nodes][components]. A node's components are neighbours in memory, so that
//! a row of the stencil is a few cache lines.
using NodeView = Kokkos::View<Real**, Kokkos::LayoutRight,
                              typename ExecutionSpace::device_type>;

//! Rows of nodes, or particles, by number.
using IndexList = Kokkos::View<int*, MemorySpace>;

//! Behind the parameters of a lambda that a kernel calls for every node: it
//! must become part of the kernel.
#if defined( KOKKOS_ENABLE_CUDA ) || defined( KOKKOS_ENABLE_HIP )
#define MACHPOINT_INLINE
#else
#define MACHPOINT_INLINE __attribute__( ( always_inline ) )
#endif

//! \name Ahead of loops with few, constant turns
//! UNROLL writes a loop out on a GPU and KEEP_LOOP does not; on a CPU
//! UNROLL_LINES writes out the lines of a stencil and KEEP_LINES does not. The
//! others leave it to the compiler there. On a GPU arrays that a loop indexes
//! stay in registers only where it is written out, and what is written out
//! three times over (the nodes of a 3D stencil) takes more registers than there
//! are. On a CPU it is the lines of a stencil that are worth writing out where
//! little is done on each, as a loop over them has its weights in memory; a
//! long kernel is faster the less code it has (docs/performance_tried.md).
//! @{
#if defined( KOKKOS_ENABLE_CUDA ) || defined( KOKKOS_ENABLE_HIP )
#define MACHPOINT_UNROLL _Pragma( "unroll" )
#define MACHPOINT_UNROLL_LINES MACHPOINT_UNROLL
#define MACHPOINT_KEEP_LINES
#define MACHPOINT_KEEP_LOOP _Pragma( "unroll 1" )
#else
#define MACHPOINT_UNROLL
#define MACHPOINT_UNROLL_LINES _Pragma( "GCC unroll 4" )
#define MACHPOINT_KEEP_LINES _Pragma( "GCC unroll 1" )
#define MACHPOINT_KEEP_LOOP
#endif
//! @}

/*!
  \brief Begins a kernel, as KOKKOS_LAMBDA does; on CUDA of the device alone,
  and of the host alone in a build for a host on a Kokkos that has CUDA, too.

  What belongs to both nvcc gives pointers to functions that are set where the
  kernel is made, and that each translation unit has for itself. A template's
  kernel may be made in one unit and launched by the function that the linker
  has kept of another, where nobody has set them (nvcc 13.0).
*/
#if defined( MACHPOINT_BACKEND_OPENMP ) || defined( MACHPOINT_BACKEND_SERIAL )
#define MACHPOINT_LAMBDA [=]
#elif defined( KOKKOS_ENABLE_CUDA )
#define MACHPOINT_LAMBDA [=] __device__
#else
#define MACHPOINT_LAMBDA KOKKOS_LAMBDA
#endif

//! Scalar product. \param a, b [Dim].
template <int Dim, class Number>
KOKKOS_INLINE_FUNCTION Number dot( const Kokkos::Array<Number, Dim>& a,
                                   const Kokkos::Array<Number, Dim>& b )
{
    Number sum( 0.0 );
    for ( int d = 0; d < Dim; ++d )
        sum += a[d] * b[d];
    return sum;
}

} // namespace Machpoint

#endif
