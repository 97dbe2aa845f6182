/*!
  \file avx512.hpp
  \brief Layer 2: columns of nodes in registers of AVX-512, a lane for each
  particle of a pack, for core/lanes.hpp: its `Registers`, or those of
  core/avx2.hpp.

  Node row[l] starts row[l] * columns numbers behind `first`; lane l of a
  register gets its number. A `row` has as many entries as the register lanes.
  Rows are read whole and turned into registers of one column, which takes half
  as long as to collect the columns.
*/
#ifndef MACHPOINT_AVX512_HPP
#define MACHPOINT_AVX512_HPP

#include <core/avx2.hpp>

#ifdef KOKKOS_ARCH_AVX512XEON
//! Is a register as long as a line of the cache, so that stores may go past it
//! (Written)?
#define MACHPOINT_PACKS_FILL_LINES
#ifdef MACHPOINT_PRECISION_SINGLE
//! As in core/avx2.hpp, of floats, too.
#define MACHPOINT_HAS_REGISTERS
#endif

namespace Machpoint::Avx512
{

//! The even places of two registers in turn: a0 b0 a2 b2 ... (As integers, as
//! GCC 12 was seen to make a0 a0 a2 a2 ... of `_mm512_unpacklo_pd`.)
KOKKOS_FORCEINLINE_FUNCTION __m512d evenPlaces( const __m512d a,
                                                const __m512d b )
{
    return _mm512_castsi512_pd( _mm512_unpacklo_epi64(
        _mm512_castpd_si512( a ), _mm512_castpd_si512( b ) ) );
}

//! The odd ones: a1 b1 a3 b3 ...
KOKKOS_FORCEINLINE_FUNCTION __m512d oddPlaces( const __m512d a,
                                               const __m512d b )
{
    return _mm512_unpackhi_pd( a, b );
}

//! Where eight nodes start.
KOKKOS_FORCEINLINE_FUNCTION __m512i starts( const int* const row,
                                            const std::size_t columns )
{
    return _mm512_mullo_epi64(
        _mm512_cvtepi32_epi64(
            _mm256_loadu_si256( reinterpret_cast<const __m256i*>( row ) ) ),
        _mm512_set1_epi64( static_cast<long long>( columns ) ) );
}

//! \name Past the cache, to whole lines of memory
//! @{
KOKKOS_FORCEINLINE_FUNCTION void stream( double* const place,
                                         const __m512d values )
{
    _mm512_stream_pd( place, values );
}
KOKKOS_FORCEINLINE_FUNCTION void stream( float* const place,
                                         const __m512 values )
{
    _mm512_stream_ps( place, values );
}
//! @}

//! \name As many floats as a register has doubles
//! @{
KOKKOS_FORCEINLINE_FUNCTION __m512d loadFloats( const float* const place )
{
    return _mm512_cvtps_pd( _mm256_loadu_ps( place ) );
}
KOKKOS_FORCEINLINE_FUNCTION void storeFloats( float* const place,
                                              const __m512d values )
{
    _mm256_storeu_ps( place, _mm512_cvtpd_ps( values ) );
}
//! @}

//! \name Rows, moved on by whole numbers of rows that are `stride` apart
//! @{
KOKKOS_FORCEINLINE_FUNCTION void advance( int* const row, const __m512d steps,
                                          const int stride )
{
    auto* const rows = reinterpret_cast<__m256i*>( row );
    _mm256_storeu_si256(
        rows,
        _mm256_add_epi32( _mm256_loadu_si256( rows ),
                          _mm256_mullo_epi32( _mm512_cvttpd_epi32( steps ),
                                              _mm256_set1_epi32( stride ) ) ) );
}
KOKKOS_FORCEINLINE_FUNCTION void advance( int* const row, const __m512 steps,
                                          const int stride )
{
    _mm512_storeu_si512(
        row,
        _mm512_add_epi32( _mm512_loadu_si512( row ),
                          _mm512_mullo_epi32( _mm512_cvttps_epi32( steps ),
                                              _mm512_set1_epi32( stride ) ) ) );
}
//! @}

//! Which rows are below `first`, or not below `end`: a bit for each lane.
KOKKOS_FORCEINLINE_FUNCTION unsigned outside( const int* const row,
                                              const int first, const int end )
{
    if constexpr ( is_single )
    {
        const __m512i rows = _mm512_loadu_si512( row );
        return _mm512_cmplt_epi32_mask( rows, _mm512_set1_epi32( first ) ) |
               _mm512_cmpge_epi32_mask( rows, _mm512_set1_epi32( end ) );
    }
    const __m256i rows =
        _mm256_loadu_si256( reinterpret_cast<const __m256i*>( row ) );
    return _mm256_cmplt_epi32_mask( rows, _mm256_set1_epi32( first ) ) |
           _mm256_cmpge_epi32_mask( rows, _mm256_set1_epi32( end ) );
}

/*!
  \name Two numbers of each lane, side by side
  In memory those of even lanes come first, then those of odd ones.
  @{
*/
KOKKOS_FORCEINLINE_FUNCTION void storePairs( const __m512d a, const __m512d b,
                                             double* const pairs )
{
    _mm512_store_pd( pairs, evenPlaces( a, b ) );
    _mm512_store_pd( pairs + 8, oddPlaces( a, b ) );
}

//! The first number of a pair, and the second in some places of a row. \tparam
//! Width of the row \tparam Seconds 1 << c for each place c of the second
template <int Width, int Seconds>
KOKKOS_FORCEINLINE_FUNCTION auto choiceOf( const double* const pair )
{
    if constexpr ( Width < 8 )
        return Avx2::choiceOf<Width, Seconds>( pair );
    else
        return _mm512_permute_pd( _mm512_broadcast_f64x2( _mm_load_pd( pair ) ),
                                  Seconds );
}

//! A row of pairs, and 0 behind them. \tparam Width of the row
template <int Width, std::size_t Pairs>
KOKKOS_FORCEINLINE_FUNCTION auto
joinedRow( const double* const ( &pair )[Pairs] )
{
    if constexpr ( Width < 8 )
        return Avx2::joinedRow<Width>( pair );
    else
    {
        __m512d row = _mm512_zextpd256_pd512( Avx2::joinedRow<4>( pair ) );
        if constexpr ( Pairs > 2 )
            row = _mm512_insertf64x2( row, _mm_load_pd( pair[2] ), 2 );
        if constexpr ( Pairs > 3 )
            row = _mm512_insertf64x2( row, _mm_load_pd( pair[3] ), 3 );
        return row;
    }
}
//! @}

//! \name One column
//! @{
KOKKOS_FORCEINLINE_FUNCTION __m512d gather( const double* const first,
                                            const int* const row,
                                            const std::size_t columns )
{
    if constexpr ( is_zen ) // whose gathers are microcode
    {
        auto two = [&]( const int l )
        {
            return _mm_loadh_pd( _mm_load_sd( first + row[l] * columns ),
                                 first + row[l + 1] * columns );
        };
        auto four = [&]( const int l )
        {
            return _mm256_insertf128_pd( _mm256_castpd128_pd256( two( l ) ),
                                         two( l + 2 ), 1 );
        };
        return _mm512_insertf64x4( _mm512_castpd256_pd512( four( 0 ) ),
                                   four( 4 ), 1 );
    }
    return _mm512_i64gather_pd( starts( row, columns ), first,
                                sizeof( double ) );
}
KOKKOS_FORCEINLINE_FUNCTION __m512 gather( const float* const first,
                                           const int* const row,
                                           const std::size_t columns )
{
    auto half = [&]( const int l )
    {
        return _mm512_i64gather_ps( starts( row + l, columns ), first,
                                    sizeof( float ) );
    };
    return _mm512_insertf32x8( _mm512_castps256_ps512( half( 0 ) ), half( 8 ),
                               1 );
}
//! @}

//! \name Two columns
//! @{
KOKKOS_FORCEINLINE_FUNCTION void loadColumns( const double* const first,
                                              const int* const row,
                                              const std::size_t columns,
                                              __m512d ( &values )[2] )
{
    // Of lanes l and l + 2, and of l, l + 2, l + 4 and l + 6.
    auto two = [&]( const int l )
    {
        return _mm256_insertf128_pd(
            _mm256_castpd128_pd256( _mm_loadu_pd( first + row[l] * columns ) ),
            _mm_loadu_pd( first + row[l + 2] * columns ), 1 );
    };
    auto four = [&]( const int l )
    {
        return _mm512_insertf64x4( _mm512_castpd256_pd512( two( l ) ),
                                   two( l + 4 ), 1 );
    };
    const __m512d even = four( 0 ), odd = four( 1 );
    values[0] = evenPlaces( even, odd );
    values[1] = oddPlaces( even, odd );
}
KOKKOS_FORCEINLINE_FUNCTION void loadColumns( const float* const first,
                                              const int* const row,
                                              const std::size_t columns,
                                              __m512 ( &values )[2] )
{
    // Both of a node at once, as if they were one double.
    auto eight = [&]( const int l )
    {
        return _mm512_castpd_ps( _mm512_i64gather_pd(
            starts( row + l, columns ), first, sizeof( float ) ) );
    };
    const __m512 a = eight( 0 ), b = eight( 8 );
    const __m512i even = _mm512_setr_epi32( 0, 2, 4, 6, 8, 10, 12, 14, 16, 18,
                                            20, 22, 24, 26, 28, 30 );
    const __m512i odd = _mm512_setr_epi32( 1, 3, 5, 7, 9, 11, 13, 15, 17, 19,
                                           21, 23, 25, 27, 29, 31 );
    values[0] = _mm512_permutex2var_ps( a, even, b );
    values[1] = _mm512_permutex2var_ps( a, odd, b );
}
//! @}

//! \name Four columns
//! @{
KOKKOS_FORCEINLINE_FUNCTION void loadColumns( const double* const first,
                                              const int* const row,
                                              const std::size_t columns,
                                              __m512d ( &values )[4] )
{
    // Of lanes l and l + 4.
    auto two = [&]( const int l )
    {
        return _mm512_insertf64x4(
            _mm512_castpd256_pd512(
                _mm256_loadu_pd( first + row[l] * columns ) ),
            _mm256_loadu_pd( first + row[l + 4] * columns ), 1 );
    };
    const __m512d a = two( 0 ), b = two( 1 ), c = two( 2 ), d = two( 3 );
    const __m512d ab_even = evenPlaces( a, b );
    const __m512d ab_odd = oddPlaces( a, b );
    const __m512d cd_even = evenPlaces( c, d );
    const __m512d cd_odd = oddPlaces( c, d );
    const __m512i lower = _mm512_setr_epi64( 0, 1, 8, 9, 4, 5, 12, 13 );
    const __m512i upper = _mm512_setr_epi64( 2, 3, 10, 11, 6, 7, 14, 15 );
    values[0] = _mm512_permutex2var_pd( ab_even, lower, cd_even );
    values[1] = _mm512_permutex2var_pd( ab_odd, lower, cd_odd );
    values[2] = _mm512_permutex2var_pd( ab_even, upper, cd_even );
    values[3] = _mm512_permutex2var_pd( ab_odd, upper, cd_odd );
}
KOKKOS_FORCEINLINE_FUNCTION void loadColumns( const float* const first,
                                              const int* const row,
                                              const std::size_t columns,
                                              __m512 ( &values )[4] )
{
    // Of lanes l and l + 4, and of l, l + 4, l + 8 and l + 12.
    auto two = [&]( const int l )
    {
        return _mm256_set_m128( _mm_loadu_ps( first + row[l + 4] * columns ),
                                _mm_loadu_ps( first + row[l] * columns ) );
    };
    auto four = [&]( const int l )
    {
        return _mm512_insertf32x8( _mm512_castps256_ps512( two( l ) ),
                                   two( l + 8 ), 1 );
    };
    const __m512 a = four( 0 ), b = four( 1 ), c = four( 2 ), d = four( 3 );
    const __m512 ab_lower = _mm512_unpacklo_ps( a, b );
    const __m512 ab_upper = _mm512_unpackhi_ps( a, b );
    const __m512 cd_lower = _mm512_unpacklo_ps( c, d );
    const __m512 cd_upper = _mm512_unpackhi_ps( c, d );
    values[0] = _mm512_shuffle_ps( ab_lower, cd_lower, 0x44 );
    values[1] = _mm512_shuffle_ps( ab_lower, cd_lower, 0xee );
    values[2] = _mm512_shuffle_ps( ab_upper, cd_upper, 0x44 );
    values[3] = _mm512_shuffle_ps( ab_upper, cd_upper, 0xee );
}
//! @}

} // namespace Machpoint::Avx512

namespace Machpoint
{
namespace Registers = Avx512;
}
#elif defined( MACHPOINT_HAS_REGISTERS )
namespace Machpoint
{
namespace Registers = Avx2;
}
#endif
#endif
