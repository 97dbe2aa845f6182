/*!
  \file Cabana_StableSort.hpp
  \brief Stable parallel radix sort of particle numbers by unsigned integers; on
  CUDA the toolkit's own (CUB).
*/
#ifndef CABANA_STABLESORT_HPP
#define CABANA_STABLESORT_HPP

#include <Cabana_Types.hpp>

#include <Kokkos_Core.hpp>
#ifdef KOKKOS_ENABLE_CUDA
#include <cub/device/device_radix_sort.cuh>
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace Cabana
{
namespace Impl
{

//! A particle on its way through the sort: what it is sorted by, and which.
template <class Image>
struct SortEntry
{
    Image image;
    std::uint32_t index;
};

//! The unsorted entries, computed as they are read.
template <class ImageOf>
struct UnsortedEntries
{
    ImageOf image_of;

    KOKKOS_FORCEINLINE_FUNCTION auto operator()( const std::size_t i ) const
    {
        using Image = decltype( image_of( i ) );
        return SortEntry<Image>{ image_of( i ),
                                 static_cast<std::uint32_t>( i ) };
    }
};

/*!
  \brief How the entries are cut into chunks, one per thread, and the images
  into digits. Each chunk counts its digits in a table of its own, so that
  nothing is atomic and equal digits keep their order.
*/
struct RadixPlan
{
    std::size_t chunks; //!< Chunks of consecutive entries.
    int passes;         //!< Number of digits, the lowest first.
    int width;          //!< Bits of a digit.
};

/*!
  \brief Few wide digits on a host, where a thread has a cache of its own;
  narrow ones on a device, where there are many threads.
  \param n Number of entries.
  \param bits Bits of the largest image.
*/
template <class ExecutionSpace>
RadixPlan planRadixSort( const std::size_t n, const int bits )
{
    RadixPlan plan;
    int widest;
    if constexpr ( is_accessible_from<Kokkos::HostSpace,
                                      ExecutionSpace>::value )
    {
        // A chunk must be worth the start of a thread.
        plan.chunks = std::clamp<std::size_t>( n / 4096, 1,
                                               ExecutionSpace().concurrency() );
        // All tables together no larger than the data: near-sorted entries,
        // as particles are, then need one pass whatever the number of cells.
        widest = std::max( 11, int( std::bit_width( n / plan.chunks ) ) );
    }
    else
    {
        plan.chunks = std::max<std::size_t>( n / 256, 1 );
        widest = 8;
    }
    plan.passes = std::max( 1, ( bits + widest - 1 ) / widest );
    plan.width = std::max( 1, ( bits + plan.passes - 1 ) / plan.passes );
    return plan;
}

/*!
  \brief One pass: entries of `from` to `to`, ordered by the digit at `shift`.
*/
template <class ExecutionSpace, class From, class Entries>
CABANA_LAUNCHES void radixPass( const From& from, const Entries& to,
                                const RadixPlan& plan, const int shift )
{
    using Range = Kokkos::RangePolicy<ExecutionSpace>;
    const std::size_t n = to.extent( 0 );
    const std::size_t chunks = plan.chunks;
    const std::size_t digits = std::size_t( 1 ) << plan.width;

    // [chunks][digits]: first how many, then where the next one goes.
    Kokkos::View<std::uint32_t*, typename Entries::memory_space> table(
        "Cabana::radixSort::table", chunks * digits );

    Kokkos::parallel_for(
        "Cabana::radixSort::count", Range( 0, chunks ),
        KOKKOS_LAMBDA( const std::size_t c ) {
            std::uint32_t* const count = table.data() + c * digits;
            const std::size_t end = n * ( c + 1 ) / chunks;
            for ( std::size_t i = n * c / chunks; i < end; ++i )
                ++count[( from( i ).image >> shift ) & ( digits - 1 )];
        } );

    // A digit's place: after all smaller digits, then after the chunks before.
    Kokkos::parallel_scan(
        "Cabana::radixSort::scan", Range( 0, chunks * digits ),
        KOKKOS_LAMBDA( const std::size_t k, std::uint32_t& place,
                       const bool final ) {
            std::uint32_t& entry =
                table( ( k % chunks ) * digits + k / chunks );
            const std::uint32_t count = entry;
            if ( final )
                entry = place;
            place += count;
        } );

    Kokkos::parallel_for(
        "Cabana::radixSort::scatter", Range( 0, chunks ),
        KOKKOS_LAMBDA( const std::size_t c ) {
            std::uint32_t* const place = table.data() + c * digits;
            const std::size_t end = n * ( c + 1 ) / chunks;
            for ( std::size_t i = n * c / chunks; i < end; ++i )
            {
                const auto entry = from( i );
                to( place[( entry.image >> shift ) & ( digits - 1 )]++ ) =
                    entry;
            }
        } );
}

//! The sorted entries of stableSort, pass by pass.
template <class ExecutionSpace, class Entries, class ImageOf>
Entries sortByDigits( const ImageOf& image_of, const std::size_t n,
                      const int bits )
{
    const auto allocate = [n]( const std::string& label )
    {
        return Entries(
            Kokkos::view_alloc( label, Kokkos::WithoutInitializing ), n );
    };
    const RadixPlan plan = planRadixSort<ExecutionSpace>( n, bits );
    Entries sorted = allocate( "Cabana::radixSort::entries" );
    Entries spare =
        plan.passes > 1 ? allocate( "Cabana::radixSort::entries" ) : Entries();
    radixPass<ExecutionSpace>( UnsortedEntries<ImageOf>{ image_of }, sorted,
                               plan, 0 );
    for ( int pass = 1; pass < plan.passes; ++pass )
    {
        std::swap( sorted, spare );
        radixPass<ExecutionSpace>( spare, sorted, plan, pass * plan.width );
    }
    return sorted;
}

#ifdef KOKKOS_ENABLE_CUDA
//! The same by CUB. \throws std::runtime_error if CUDA
//! fails
template <class Entries, class ImageOf>
CABANA_LAUNCHES Entries sortOnCuda( const ImageOf& image_of,
                                    const std::size_t n, const int bits )
{
    using Image = decltype( image_of( 0 ) );
    using Memory = typename Entries::memory_space;
    using Range = Kokkos::RangePolicy<Kokkos::Cuda>;
    // Unsorted in row 0, sorted in row 1.
    const Kokkos::View<Image**, Kokkos::LayoutRight, Memory> images(
        Kokkos::view_alloc( "Cabana::radixSort::images",
                            Kokkos::WithoutInitializing ),
        2, n );
    const Kokkos::View<std::uint32_t**, Kokkos::LayoutRight, Memory> indices(
        Kokkos::view_alloc( "Cabana::radixSort::indices",
                            Kokkos::WithoutInitializing ),
        2, n );
    Kokkos::parallel_for(
        "Cabana::radixSort::unsorted", Range( 0, n ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            images( 0, i ) = image_of( i );
            indices( 0, i ) = static_cast<std::uint32_t>( i );
        } );
    const auto check = []( const cudaError_t error )
    {
        if ( error != cudaSuccess )
            throw std::runtime_error( std::string( "Cabana: sort: " ) +
                                      cudaGetErrorString( error ) );
    };
    const auto sort = [&]( void* const scratch, std::size_t& bytes )
    {
        check( cub::DeviceRadixSort::SortPairs(
            scratch, bytes, images.data(), images.data() + n, indices.data(),
            indices.data() + n, n, 0, bits, Kokkos::Cuda().cuda_stream() ) );
    };
    std::size_t bytes = 0;
    sort( nullptr, bytes ); // asks how many
    const Kokkos::View<char*, Memory> scratch(
        Kokkos::view_alloc( "Cabana::radixSort::scratch",
                            Kokkos::WithoutInitializing ),
        std::max<std::size_t>( bytes, 1 ) );
    sort( scratch.data(), bytes );
    const Entries sorted( Kokkos::view_alloc( "Cabana::radixSort::entries",
                                              Kokkos::WithoutInitializing ),
                          n );
    Kokkos::parallel_for(
        "Cabana::radixSort::sorted", Range( 0, n ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            sorted( i ) = { images( 1, i ), indices( 1, i ) };
        } );
    // Before others take the memory.
    Kokkos::Cuda().fence( "Cabana::radixSort" );
    return sorted;
}
#endif

/*!
  \brief Sort the numbers 0..n-1 by image_of(i), smaller numbers first among
  equals. The result depends on nothing but the images.
  \param image_of Returns an unsigned integer; callable on the device.
  \param n How many. \param bits Bits of the largest image.
  \return The sorted entries. Shape [n].
  \throws std::length_error if n does not fit 32 bits.
*/
template <class ExecutionSpace, class MemorySpace, class ImageOf>
auto stableSort( const ImageOf& image_of, const std::size_t n, const int bits )
{
    using Image = decltype( image_of( 0 ) );
    using Entries = Kokkos::View<SortEntry<Image>*, MemorySpace>;
    if ( n > std::numeric_limits<std::uint32_t>::max() )
        throw std::length_error( "Cabana: too many particles to sort" );

#ifdef KOKKOS_ENABLE_CUDA
    if constexpr ( std::is_same_v<ExecutionSpace, Kokkos::Cuda> )
        return sortOnCuda<Entries>( image_of, n, bits );
    else
#endif
        return sortByDigits<ExecutionSpace, Entries>( image_of, n, bits );
}

} // namespace Impl
} // namespace Cabana

#endif
