/*!
  \file warp_run.hpp
  \brief Layer 2: neighbours in a warp of a GPU that add to the same nodes.
*/
#ifndef MACHPOINT_WARP_RUN_HPP
#define MACHPOINT_WARP_RUN_HPP

#include <core/types.hpp>

#include <algorithm>
#include <cstddef>

namespace Machpoint
{

/*!
  \brief The runs of lanes of a warp that have the same stencil: what a run adds
  to a node is summed before it is added.

  Sorted particles of a cell sit side by side. If each added for itself, the
  cache would take their atomic adds one after the other, and each column of a
  node as a transaction of its own. So lanes hand their terms over in shared
  memory; then a lane has a column of a node and goes through the particles,
  beside it the lanes with the columns and nodes beside, and adds at the end of
  each run. (Gao et al. 2018, GPU Optimization of Material Point Methods, sum
  runs by shuffles; that took twice the time here.)

  Lanes of a warp that are not all here together add one by one. All that made
  the runs have to call `add`, at the same places. A kernel makes them once: a
  block's memory is one, whatever object asks for it.
*/
class WarpRun
{
  public:
    //! In a kernel. \param base first row of the lane's stencil
    KOKKOS_FORCEINLINE_FUNCTION explicit WarpRun(
        [[maybe_unused]] const int base )
    {
#ifdef __CUDA_ARCH__
        const int thread = threadIdx.x + blockDim.x * threadIdx.y;
        _lane = thread % lanes;
        _warp = thread / lanes;
        if ( _warp >= most_warps || __activemask() != everyone )
            return;
        _base = base;
        bases()[_lane] = base;
        const int next = __shfl_down_sync( everyone, base, 1 );
        _ends = __ballot_sync( everyone, _lane == lanes - 1 || next != base );
#endif
    }

    /*!
      \brief Adds values[i][k] of every lane to sums( row + i, first + k ), in
      parts where there are more than lanes.
      \param sums [rows][columns]
      \param row the base, and what is the same for all lanes
    */
    template <std::size_t Rows, std::size_t K>
    KOKKOS_FORCEINLINE_FUNCTION void
    add( Real* sums, const int columns, const int row, const int first,
         const Real ( &values )[Rows][K] ) const
    {
        if constexpr ( Rows * K <= lanes )
            addPart( sums, columns, row, first, values );
        else
        {
            constexpr std::size_t half = ( K + 1 ) / 2;
            Real some[Rows][half], others[Rows][K - half];
            MACHPOINT_UNROLL
            for ( std::size_t i = 0; i < Rows; ++i )
            {
                MACHPOINT_UNROLL
                for ( std::size_t k = 0; k < half; ++k )
                    some[i][k] = values[i][k];
                MACHPOINT_UNROLL
                for ( std::size_t k = half; k < K; ++k )
                    others[i][k - half] = values[i][k];
            }
            add( sums, columns, row, first, some );
            add( sums, columns, row, first + static_cast<int>( half ), others );
        }
    }

  private:
    template <std::size_t Rows, std::size_t K>
    KOKKOS_FORCEINLINE_FUNCTION void
    addPart( Real* sums, const int columns, const int row, const int first,
             const Real ( &values )[Rows][K] ) const
    {
#ifdef __CUDA_ARCH__
        if ( _ends != 0 )
        {
            constexpr int items = Rows * K;
            static_assert( items <= lanes );
            constexpr int groups = lanes / items; // with particles of their own
            constexpr int share = ( lanes + groups - 1 ) / groups;
            constexpr int stride = items | 1; // odd: lanes use all banks
            __shared__ Real all[most_warps * lanes * stride];
            Real* const terms = all + _warp * lanes * stride;
            MACHPOINT_UNROLL
            for ( int t = 0; t < items; ++t )
                terms[_lane * stride + t] = values[t / K][t % K];
            __syncwarp();
            const int item = _lane % items;
            const int begin = _lane / items * share;
            const int end = begin + share < lanes ? begin + share : lanes;
            if ( _lane < groups * items )
            {
                const int shift = row - _base;
                Real* const to = sums + item / static_cast<int>( K ) * columns +
                                 first + item % static_cast<int>( K );
                const unsigned ends = _ends | 1u << ( end - 1 );
                Real sum = 0;
                for ( int l = begin; l < end; ++l )
                {
                    sum += terms[l * stride + item];
                    if ( ends >> l & 1 )
                    {
                        const auto at =
                            static_cast<std::ptrdiff_t>( bases()[l] + shift );
                        Kokkos::atomic_add( to + at * columns, sum );
                        sum = 0;
                    }
                }
            }
            __syncwarp();
            return;
        }
#endif
        for ( std::size_t i = 0; i < Rows; ++i )
            for ( std::size_t k = 0; k < K; ++k )
                Kokkos::atomic_add(
                    sums +
                        ( row + static_cast<std::ptrdiff_t>( i ) ) * columns +
                        first + static_cast<int>( k ),
                    values[i][k] );
    }

    static constexpr int lanes = 32;
    static constexpr int most_warps = most_threads / lanes;
    static constexpr unsigned everyone = 0xffffffff;

#ifdef __CUDA_ARCH__
    //! Of the lanes of this warp.
    __device__ int* bases() const
    {
        __shared__ int all[most_warps * lanes];
        return all + _warp * lanes;
    }
#endif
    int _lane = 0, _warp = 0;
    int _base = 0;
    unsigned _ends = 0; //!< last lanes of runs; none: everyone adds alone
};

} // namespace Machpoint

#endif
