/*!
  \file tolerance.hpp
  \brief How near results must be to what they should be but for round-off.
*/
#ifndef MACHPOINT_UNITTEST_TOLERANCE_HPP
#define MACHPOINT_UNITTEST_TOLERANCE_HPP

#include <core/types.hpp>

#include <algorithm>

namespace Test
{

//! As many roundings of the build's Real as `of_doubles` is of doubles; of
//! floats no more than 2e-4.
constexpr double tolerance( const double of_doubles )
{
    constexpr double float_to_double = 1 << 29; // of their roundings
    return Machpoint::is_single
               ? std::max( of_doubles,
                           std::min( float_to_double * of_doubles, 2e-4 ) )
               : of_doubles;
}

} // namespace Test

//! Equal but for the last digits of a Real.
#ifdef MACHPOINT_PRECISION_SINGLE
#define EXPECT_REAL_EQ EXPECT_FLOAT_EQ
#else
#define EXPECT_REAL_EQ EXPECT_DOUBLE_EQ
#endif

#endif
