/*!
  \file avx2.hpp
  \brief Included ahead of all else: makes a Kokkos for AVX-512 one for AVX2, so
  that a machine that has both tests both (tools/test).
*/
#ifndef MACHPOINT_TEST_AVX2_HPP
#define MACHPOINT_TEST_AVX2_HPP

#ifdef __AVX512F__
#error "compiled for AVX-512: -march=haswell has to come last"
#endif

#include <Kokkos_Macros.hpp>

#undef KOKKOS_ARCH_AVX512XEON
#define KOKKOS_ARCH_AVX2

#endif
