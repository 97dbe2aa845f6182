/*!
  \file reproducible_sum.hpp
  \brief Layer 1: a sum whose bits do not depend on the order of its terms, nor
  on how they are split among threads and ranks.
*/
#ifndef MACHPOINT_REPRODUCIBLE_SUM_HPP
#define MACHPOINT_REPRODUCIBLE_SUM_HPP

#include <core/archive.hpp>
#include <core/communicator.hpp>
#include <core/types.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief A sum in digits of 24 bits, each added up on its own as an integer.

  A double has at most four digits; digit j counts units of 2^(24 j), whatever
  the number. The sum keeps six: from the first of the largest term down to two
  below its last, so a term loses less than 2^-48 of the largest term's last
  bit. Integers add up exactly, and what is cut off a term in the end depends
  on the largest term alone, so order does not matter (after Demmel and Nguyen
  2015). Holds 2^39 terms.
*/
class ReproducibleSum
{
  public:
    ReproducibleSum() = default;
    //! Of one term.
    ReproducibleSum( const double term ) { *this += term; }

    //! \name Exact in any order
    //! A term that is not finite makes the sum so, too.
    //! @{
    KOKKOS_INLINE_FUNCTION void operator+=( const double term )
    {
        add( term, 1 );
    }
    KOKKOS_INLINE_FUNCTION void operator-=( const double term )
    {
        add( -term, 1 );
    }
    KOKKOS_INLINE_FUNCTION void operator+=( const ReproducibleSum& other )
    {
        raise( other._top );
        for ( int k = 0; k < digits; ++k )
            if ( const int j = _top - other._top + k; j < digits )
                _digits[j] += other._digits[k];
        _not_finite += other._not_finite;
    }

    KOKKOS_INLINE_FUNCTION void operator-=( const ReproducibleSum& other )
    {
        ReproducibleSum negative = other;
        for ( int k = 0; k < digits; ++k )
            negative._digits[k] = -other._digits[k];
        negative._not_finite = -other._not_finite;
        *this += negative;
    }
    //! @}

    //! Adds a term `times` times.
    KOKKOS_INLINE_FUNCTION void add( const double term,
                                     const std::int64_t times )
    {
        const auto bits = Kokkos::bit_cast<std::uint64_t>( term );
        const int exponent = static_cast<int>( bits >> 52 & 0x7ff );
        if ( exponent == 0x7ff )
        {
            _not_finite += term;
            return;
        }
        // |term| = mantissa 2^(place - 1074)
        std::uint64_t mantissa = bits & ( ( std::uint64_t( 1 ) << 52 ) - 1 );
        if ( exponent > 0 )
            mantissa |= std::uint64_t( 1 ) << 52;
        const int place = exponent > 0 ? exponent - 1 : 0;
        if ( mantissa == 0 )
            return;
        const int last = place / width; // its last digit
        const std::int64_t sign = bits >> 63 ? -times : times;
        raise( last + 3 );
        // 24 + 53 bits do not fit into one word.
        std::uint64_t rest = mantissa >> ( width - place % width );
        std::uint64_t digit = mantissa << place % width & mask;
        for ( int j = last; j < last + 4; ++j )
        {
            if ( _top - j < digits )
                _digits[_top - j] += sign * static_cast<std::int64_t>( digit );
            digit = rest & mask;
            rest >>= width;
        }
    }

    //! The sum, rounded; infinite or not a number where a term was.
    double value() const
    {
        if ( _not_finite != 0 ) // or not a number
            return _not_finite;
        // Digits of one sign and below 2^24, behind what is carried out.
        std::int64_t d[digits + 2] = {};
        for ( int k = 0; k < digits; ++k )
            d[k + 2] = _digits[k];
        carry( d );
        const double sign = d[0] < 0 ? -1 : 1;
        if ( sign < 0 )
        {
            for ( auto& digit : d )
                digit = -digit;
            carry( d );
        }
        double sum = 0;
        for ( int k = digits + 1; k >= 0; --k )
            sum += std::ldexp( static_cast<double>( d[k] ),
                               width * ( _top + 2 - k ) - 1074 );
        return sign * sum;
    }

    //! Writes all digits, or reads them. \throws ArchiveError
    void checkpoint( Archive& archive, const std::string& name )
    {
        std::vector<std::int64_t> list( _digits, _digits + digits );
        list.push_back( _top );
        list.push_back( Kokkos::bit_cast<std::int64_t>( _not_finite ) );
        archive.table( name, list, list.size() );
        if ( list.size() != digits + 2 )
            throw ArchiveError( name + " has another shape" );
        std::copy( list.begin(), list.begin() + digits, _digits );
        _top = static_cast<int>( list[digits] );
        _not_finite = Kokkos::bit_cast<double>( list[digits + 1] );
    }

  private:
    static constexpr int width = 24; // bits of a digit
    static constexpr int digits = 6;
    static constexpr std::uint64_t mask = ( std::uint64_t( 1 ) << width ) - 1;

    //! Moves the digits so that the first is no lower than digit `top`.
    KOKKOS_INLINE_FUNCTION void raise( const int top )
    {
        const int by = top - _top;
        if ( by <= 0 )
            return;
        for ( int k = digits - 1; k >= 0; --k )
            _digits[k] = k >= by ? _digits[k - by] : 0;
        _top = top;
    }

    //! Carries what a digit has beyond 24 bits; the first keeps it, sign
    //! included.
    static void carry( std::int64_t ( &d )[digits + 2] )
    {
        for ( int k = digits + 1; k > 0; --k )
        {
            const std::int64_t over = d[k] >> width; // rounds down
            d[k] -= over * ( std::int64_t( 1 ) << width );
            d[k - 1] += over;
        }
    }

    int _top = 0; // number of the first digit; digit 0 counts 2^-1074
    double _not_finite = 0;
    std::int64_t _digits[digits] = {};
};

//! The sums of all ranks, element by element. Collective.
//! \param own as many on all ranks
inline std::vector<ReproducibleSum>
sumOfRanks( const Communicator& comm, const std::vector<ReproducibleSum>& own )
{
    const auto all = comm.gatherAll( own );
    std::vector<ReproducibleSum> sums( own.size() );
    for ( std::size_t k = 0; k < all.size(); ++k )
        sums[k % sums.size()] += all[k];
    return sums;
}

//! A sum of which each rank has its part: written is the whole, which when it
//! is read back is the root's part. Collective. \throws ArchiveError
inline void checkpointOfRanks( Archive& archive, const Communicator& comm,
                               const std::string& name, ReproducibleSum& own )
{
    auto whole = sumOfRanks( comm, { own } )[0];
    whole.checkpoint( archive, name );
    if ( archive.isReading() )
        own = comm.isRoot() ? whole : ReproducibleSum{};
}

} // namespace Machpoint

namespace Kokkos
{
//! Lets several of them be reduced in one kernel.
template <>
struct reduction_identity<Machpoint::ReproducibleSum>
{
    KOKKOS_FORCEINLINE_FUNCTION static Machpoint::ReproducibleSum sum()
    {
        return {};
    }
};
} // namespace Kokkos

#endif
