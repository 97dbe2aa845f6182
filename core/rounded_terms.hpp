/*!
  \file rounded_terms.hpp
  \brief Layer 3: terms of sums on nodes, rounded so that the order of adding
  does not matter to the last bit.
*/
#ifndef MACHPOINT_ROUNDED_TERMS_HPP
#define MACHPOINT_ROUNDED_TERMS_HPP

#include <core/node_scatter.hpp>

#include <cmath>

namespace Machpoint
{

//! Most columns that a reproducible sum can have.
inline constexpr std::size_t most_columns = 11;

//! A number for each column; in a kernel, in registers.
using PerColumn = Kokkos::Array<Real, most_columns>;

/*!
  \brief Terms that are rounded before they are added, so that adding is exact
  (Demmel and Nguyen 2015; docs/ranks.md). Stands in for a NodeScatter in
  kernels.

  A term x of column c becomes hi = x rounded to a multiple of a unit u_c, in
  column 2 c, and lo = x - hi rounded to one of a finer unit, in column 2 c + 1.
  The units follow from the largest term of the column, which a first pass of
  the same kernels finds: then nothing is added. (One type for both passes, as
  each type compiles all these kernels once more.)
*/
struct RoundedTerms
{
    //! log2 of how many terms of a node sum up without rounding.
    static constexpr int log2_terms = 16;

    NodeScatter parts; //!< [nodes][2 columns]
    //! \name r of each column, which rounds x to (r + x) - r
    //! @{
    PerColumn hi{}, lo{};
    //! @}
    //! Magnitude [most_columns], of the first pass; else null.
    Kokkos::View<Real*, MemorySpace> largest{};

    //! As NodeScatter::Access. In the first pass it tells of its largest terms
    //! when it goes.
    struct Access
    {
        NodeScatter::Access parts;
        PerColumn hi, lo;
        Real* largest;           //!< as above
        mutable PerColumn own{}; //!< largest of its terms

        //! One number, to be added to.
        struct Place
        {
            const Access& access;
            int row, column; //!< of the sum, not of its parts

            //! Adds both parts of a term, or in the first pass looks at it.
            KOKKOS_FORCEINLINE_FUNCTION void operator+=( const Real term ) const
            {
                if ( access.largest )
                {
                    Real& most = access.own[column];
                    most = Kokkos::max( most, Kokkos::abs( term ) );
                    return;
                }
                const Real r = access.hi[column];
                const Real s = access.lo[column];
                const Real hi = ( r + term ) - r;
                const Real lo = ( s + ( term - hi ) ) - s;
                access.parts( row, 2 * column ) += hi;
                access.parts( row, 2 * column + 1 ) += lo;
            }
        };
        //! A column of a row, to be added to.
        KOKKOS_FORCEINLINE_FUNCTION Place operator()( const int row,
                                                      const int column ) const
        {
            return { *this, row, column };
        }
        KOKKOS_FORCEINLINE_FUNCTION ~Access()
        {
            if ( !largest )
                return;
            // Rarely larger, so threads seldom meet here.
            for ( std::size_t c = 0; c < most_columns; ++c )
                if ( own[c] > Kokkos::atomic_load( largest + c ) )
                    Kokkos::atomic_max( largest + c, own[c] );
        }
    };
    //! As NodeScatter::Thread.
    struct Thread
    {
        NodeScatter::Thread parts;
        PerColumn hi, lo;
        Real* largest; //!< as above

        //! See NodeScatter::Thread::access.
        template <class Particle, class Base, int Dim>
        KOKKOS_FORCEINLINE_FUNCTION Access
        access( const Particle p, const Base& base,
                const StencilRows<Dim>& rows ) const
        {
            return { parts.access( p, base, rows ), hi, lo, largest };
        }
    };
    //! In a kernel: the thread that runs it.
    KOKKOS_FORCEINLINE_FUNCTION Thread thread() const
    {
        return { parts.thread(), hi, lo, largest.data() };
    }

    /*!
      \brief Sets the rounding of a column from its largest term.

      With n = log2_terms and |x| < 2^(E+1), r = 1.5 2^(E+n) leaves multiples of
      2^(E+n-52), so 2^n terms sum up to at most 2^53 units; |lo| is at most
      half a unit, and its r is 1.5 2^(E+2n-53). What is lost of a term is at
      most 2^(E+2n-106).
      \param largest magnitude on all ranks; 0 or not finite: terms stay as they
      are
    */
    void setRounding( const std::size_t column, const Real largest )
    {
        // Terms that are not finite stay what they are.
        const bool rounds = largest > 0 && std::isfinite( largest );
        const int E = rounds ? std::ilogb( largest ) : 0;
        hi[column] = rounds ? std::ldexp( 1.5, E + log2_terms ) : 0;
        lo[column] = rounds ? std::ldexp( 1.5, E + 2 * log2_terms - 53 ) : 0;
    }
};

} // namespace Machpoint

#endif
