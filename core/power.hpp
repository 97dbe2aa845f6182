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

/*!
  \brief (1 + a)^y, to .2 % of it for a >= -.6 and y = -1.4; 1 for a = 0.

  The square of Pade's approximant of (1 + a)^(y/2) with two powers of a above
  and below: to y (y^2 - 4) (y^2 - 16) / 11520 a^5 of it for small a. Less good
  the larger |y| is (docs/conservative.md, section 1), but positive.
*/
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number powerNearOne( const Number& a, const Real y )
{
    const Real m = 0.5_rt * y;
    const Number above =
        1 + a * ( ( 2 + m ) / 2 + ( 1 + m ) * ( 2 + m ) / 12 * a );
    const Number below =
        1 + a * ( ( 2 - m ) / 2 + ( 1 - m ) * ( 2 - m ) / 12 * a );
    const Number root = above / below;
    return root * root;
}

} // namespace Machpoint

#endif
