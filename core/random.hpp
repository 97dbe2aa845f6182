/*!
  \file random.hpp
  \brief Random numbers as a hash of counters, so that a draw depends on what
  it is for (seed, particle, step) and on no thread, rank or order.
*/
#ifndef MACHPOINT_RANDOM_HPP
#define MACHPOINT_RANDOM_HPP

#include <core/types.hpp>

namespace Machpoint
{

//! Finaliser of SplitMix64 (Steele, Lea and Flood, 2014): every bit of the
//! result depends on every bit of the argument.
KOKKOS_INLINE_FUNCTION std::uint64_t mixBits( std::uint64_t z )
{
    z += 0x9e3779b97f4a7c15ull;
    z = ( z ^ ( z >> 30 ) ) * 0xbf58476d1ce4e5b9ull;
    z = ( z ^ ( z >> 27 ) ) * 0x94d049bb133111ebull;
    return z ^ ( z >> 31 );
}

/*!
  \brief A number in [0, 1), uniform, from three counters.
  \param seed the input's seed
  \param id who draws (a particle or cell number)
  \param draw which of its draws (a step, an axis)
*/
KOKKOS_INLINE_FUNCTION Real uniformRandom( const std::uint64_t seed,
                                           const std::uint64_t id,
                                           const std::uint64_t draw )
{
    const std::uint64_t bits =
        mixBits( mixBits( mixBits( seed ) ^ id ) ^ draw );
    constexpr int digits = Kokkos::Experimental::digits_v<Real>;
    return static_cast<Real>( bits >> ( 64 - digits ) ) *
           static_cast<Real>( 1.0 / ( std::uint64_t{ 1 } << digits ) );
}

} // namespace Machpoint

#endif
