/*!
  \file power.hpp
  \brief Layer 2: exponentials and powers that kernels can take of several
  particles at once. The same operations, and so the same bits, for one.
*/
#ifndef MACHPOINT_POWER_HPP
#define MACHPOINT_POWER_HPP

#include <core/lanes.hpp>

namespace Machpoint
{

//! exp(x), to 1e-13 of it for |x| < 1 and to 1e-8 for |x| < 5; 1 for 0. Beyond,
//! that of -5 or 5.
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number exponential( const Number& x )
{
    // Taylor's polynomial of exp(x / 16), in pairs of terms, which need not
    // wait for each other, and its 16th power.
    const Number t = 0.0625_rt * clip( x, Number( -5.0 ), Number( 5.0 ) );
    const Number t2 = t * t;
    const Number t4 = t2 * t2;
    const Number low = 1 + t + t2 * ( 0.5_rt + 1.0_rt / 6 * t );
    const Number high = 1.0_rt / 24 + 1.0_rt / 120 * t +
                        t2 * ( 1.0_rt / 720 + 1.0_rt / 5040 * t ) +
                        1.0_rt / 40320 * t4;
    const Number sum = low + t4 * high;
    const Number second = sum * sum;
    const Number fourth = second * second;
    const Number eighth = fourth * fourth;
    return eighth * eighth;
}

//! log(x), to 1e-11 for 0.2 < x < 5; 0 for 1. \param x > 0
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number logarithm( const Number& x )
{
    // 2 log r = 4 artanh((r - 1) / (r + 1)) with r = x^(1/2).
    const Number r = Kokkos::sqrt( x );
    const Number s = ( r - 1 ) / ( r + 1 );
    const Number square = s * s;
    Number sum( 1.0_rt / 25 );
    for ( int k = 23; k > 0; k -= 2 )
        sum = 1.0_rt / k + square * sum;
    return 4 * s * sum;
}

//! x^y, to 1e-10 of it for 0.2 < x < 5 and |y| < 2; 1 for x = 1.
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number power( const Number& x, const Real y )
{
    return exponential( Number( y * logarithm( x ) ) );
}

} // namespace Machpoint

#endif
