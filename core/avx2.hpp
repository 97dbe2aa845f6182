/*!
  \file avx2.hpp
  \brief Layer 2: as core/avx512.hpp, in registers of AVX2: four doubles.
  (Floats are left to the compiler there.) AVX-512 takes the short rows from
  here, too.
*/
#ifndef MACHPOINT_AVX2_HPP
#define MACHPOINT_AVX2_HPP

#include <core/types.hpp>

#if defined( KOKKOS_ARCH_AVX512XEON ) || defined( KOKKOS_ARCH_AVX2 )
#ifndef MACHPOINT_PRECISION_SINGLE
//! Has the namespace Registers columns of nodes in registers of Lanes?
#define MACHPOINT_HAS_REGISTERS
//! Has it storePairs, choiceOf and joinedRow, too (of doubles alone)?
#define MACHPOINT_PAIRS_ARE_NEIGHBOURS
#endif
#include <immintrin.h>

#include <cstddef>

namespace Machpoint::Avx2
{

//! \name As many floats as a register has numbers
//! @{
KOKKOS_FORCEINLINE_FUNCTION __m256d loadFloats( const float* const place )
{
    return _mm256_cvtps_pd( _mm_loadu_ps( place ) );
}
KOKKOS_FORCEINLINE_FUNCTION void storeFloats( float* const place,
                                              const __m256d values )
{
    _mm_storeu_ps( place, _mm256_cvtpd_ps( values ) );
}
//! @}

//! Rows, moved on by whole numbers of rows that are `stride` apart.
//! \param[in,out] row [4]
KOKKOS_FORCEINLINE_FUNCTION void advance( int* const row, const __m256d steps,
                                          const int stride )
{
    auto* const rows = reinterpret_cast<__m128i*>( row );
    _mm_storeu_si128(
        rows, _mm_add_epi32( _mm_loadu_si128( rows ),
                             _mm_mullo_epi32( _mm256_cvttpd_epi32( steps ),
                                              _mm_set1_epi32( stride ) ) ) );
}

//! Which rows are below `first`, or not below `end`: a bit for each lane.
//! \param row [4]
KOKKOS_FORCEINLINE_FUNCTION unsigned outside( const int* const row,
                                              const int first, const int end )
{
    const __m128i rows =
        _mm_loadu_si128( reinterpret_cast<const __m128i*>( row ) );
    const __m128i below = _mm_cmplt_epi32( rows, _mm_set1_epi32( first ) );
    const __m128i before_end = _mm_cmplt_epi32( rows, _mm_set1_epi32( end ) );
    const __m128i is_outside = _mm_or_si128(
        below, _mm_xor_si128( before_end, _mm_set1_epi32( -1 ) ) );
    return static_cast<unsigned>(
        _mm_movemask_ps( _mm_castsi128_ps( is_outside ) ) );
}

/*!
  \name Two numbers of each lane, side by side
  In memory those of even lanes come first, then those of odd ones.
  @{
*/
KOKKOS_FORCEINLINE_FUNCTION void storePairs( const __m256d a, const __m256d b,
                                             double* const pairs )
{
    _mm256_store_pd( pairs, _mm256_unpacklo_pd( a, b ) );
    _mm256_store_pd( pairs + 4, _mm256_unpackhi_pd( a, b ) );
}

//! The first number of a pair, and the second in some places of a row. \tparam
//! Width of the row, 2 or 4 \tparam Seconds 1 << c for each place c of the
//! second
template <int Width, int Seconds>
KOKKOS_FORCEINLINE_FUNCTION auto choiceOf( const double* const pair )
{
    if constexpr ( Width == 2 )
        return _mm_permute_pd( _mm_load_pd( pair ), Seconds );
    else
        return _mm256_permute_pd(
            _mm256_broadcast_pd( reinterpret_cast<const __m128d*>( pair ) ),
            Seconds );
}

//! A row of pairs, and 0 behind them. \tparam Width of the row
template <int Width, std::size_t Pairs>
KOKKOS_FORCEINLINE_FUNCTION auto
joinedRow( const double* const ( &pair )[Pairs] )
{
    const __m128d first = _mm_load_pd( pair[0] );
    if constexpr ( Width == 2 )
        return first;
    else
    {
        __m256d row = _mm256_zextpd128_pd256( first );
        if constexpr ( Pairs > 1 )
            row = _mm256_insertf128_pd( row, _mm_load_pd( pair[1] ), 1 );
        return row;
    }
}
//! @}

//! One column. (By loads, as core/avx512.hpp does for Zens; gathers were not
//! tried.)
KOKKOS_FORCEINLINE_FUNCTION __m256d gather( const double* const first,
                                            const int* const row,
                                            const std::size_t columns )
{
    auto two = [&]( const int l )
    {
        return _mm_loadh_pd( _mm_load_sd( first + row[l] * columns ),
                             first + row[l + 1] * columns );
    };
    return _mm256_insertf128_pd( _mm256_castpd128_pd256( two( 0 ) ), two( 2 ),
                                 1 );
}

//! Two columns.
KOKKOS_FORCEINLINE_FUNCTION void loadColumns( const double* const first,
                                              const int* const row,
                                              const std::size_t columns,
                                              __m256d ( &values )[2] )
{
    // Of lanes l and l + 2.
    auto two = [&]( const int l )
    {
        return _mm256_insertf128_pd(
            _mm256_castpd128_pd256( _mm_loadu_pd( first + row[l] * columns ) ),
            _mm_loadu_pd( first + row[l + 2] * columns ), 1 );
    };
    const __m256d even = two( 0 ), odd = two( 1 );
    values[0] = _mm256_unpacklo_pd( even, odd );
    values[1] = _mm256_unpackhi_pd( even, odd );
}

//! Four columns.
KOKKOS_FORCEINLINE_FUNCTION void loadColumns( const double* const first,
                                              const int* const row,
                                              const std::size_t columns,
                                              __m256d ( &values )[4] )
{
    auto one = [&]( const int l )
    { return _mm256_loadu_pd( first + row[l] * columns ); };
    const __m256d a = one( 0 ), b = one( 1 ), c = one( 2 ), d = one( 3 );
    const __m256d ab_even = _mm256_unpacklo_pd( a, b );
    const __m256d ab_odd = _mm256_unpackhi_pd( a, b );
    const __m256d cd_even = _mm256_unpacklo_pd( c, d );
    const __m256d cd_odd = _mm256_unpackhi_pd( c, d );
    values[0] = _mm256_permute2f128_pd( ab_even, cd_even, 0x20 );
    values[1] = _mm256_permute2f128_pd( ab_odd, cd_odd, 0x20 );
    values[2] = _mm256_permute2f128_pd( ab_even, cd_even, 0x31 );
    values[3] = _mm256_permute2f128_pd( ab_odd, cd_odd, 0x31 );
}

} // namespace Machpoint::Avx2

#endif
#endif
