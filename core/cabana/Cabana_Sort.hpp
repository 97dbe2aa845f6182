/*!
  \file Cabana_Sort.hpp
  \brief Order particles by keys: by exact value, or by equal bins of it.

  Orders are stable: particles of one bin (of equal key, when sorting) keep the
  order they had. So the result is the same on any backend and on any number
  of threads.
*/
#ifndef CABANA_SORT_HPP
#define CABANA_SORT_HPP

#include <Cabana_AoSoA.hpp>
#include <Cabana_DeepCopy.hpp>
#include <Cabana_Slice.hpp>
#include <Cabana_Types.hpp>
#include <impl/Cabana_StableSort.hpp>

#include <Kokkos_Core.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace Cabana
{

/*!
  \brief An order of particles [begin, end) and the bins it consists of.
*/
template <class MemorySpace>
class BinningData
{
    static_assert( Kokkos::is_memory_space<MemorySpace>::value,
                   "Binning data live in a memory space" );

  public:
    //! Where the data live.
    using memory_space = MemorySpace;
    //! Where loops over them run by default.
    using execution_space = typename memory_space::execution_space;
    //! Type of sizes and indices.
    using size_type = typename memory_space::size_type;
    //! Sizes of the bins. Shape [bins].
    using CountView = Kokkos::View<const int*, memory_space>;
    //! Positions.
    using OffsetView = Kokkos::View<size_type*, memory_space>;
    //! Particle numbers. In half of Cabana's bytes, as no more can be sorted.
    using PermuteView = Kokkos::View<std::uint32_t*, memory_space>;

    //! No bins.
    BinningData() = default;

    /*!
      \brief Put given data together.
      \param begin, end Range of particles.
      \param counts Sizes of the bins. Shape [bins].
      \param offsets First position of each bin, counted from begin. [bins].
      \param permute_vector Which particle comes to each position.
      Shape [end - begin].
    */
    BinningData( const std::size_t begin, const std::size_t end,
                 CountView counts, OffsetView offsets,
                 PermuteView permute_vector )
        : _begin( begin ), _end( end ), _counts( counts ), _offsets( offsets ),
          _permute_vector( permute_vector )
    {
    }

    //! Number of bins.
    KOKKOS_INLINE_FUNCTION int numBin() const
    {
        return static_cast<int>( _counts.extent( 0 ) );
    }

    //! Number of particles in a bin.
    KOKKOS_INLINE_FUNCTION int binSize( const size_type bin ) const
    {
        return _counts( bin );
    }

    //! First position of a bin, counted from rangeBegin().
    KOKKOS_INLINE_FUNCTION size_type binOffset( const size_type bin ) const
    {
        return _offsets( bin );
    }

    //! Particle, in the old order, that comes to position rangeBegin() + n.
    KOKKOS_INLINE_FUNCTION size_type permutation( const size_type n ) const
    {
        return _permute_vector( n );
    }

    //! First particle of the range.
    KOKKOS_INLINE_FUNCTION std::size_t rangeBegin() const { return _begin; }

    //! One past the last particle of the range.
    KOKKOS_INLINE_FUNCTION std::size_t rangeEnd() const { return _end; }

  private:
    std::size_t _begin = 0;
    std::size_t _end = 0;
    CountView _counts;
    OffsetView _offsets;
    PermuteView _permute_vector;
};

//! True for any BinningData.
template <class T>
struct is_binning_data : std::false_type
{
};

template <typename MemorySpace>
struct is_binning_data<BinningData<MemorySpace>> : std::true_type
{
};

template <class T>
struct is_binning_data<const T> : is_binning_data<T>
{
};

namespace Impl
{

//! Any BinningData.
template <class T>
concept AnyBinning = is_binning_data<T>::value;

//! Any Kokkos::View.
template <class T>
concept AnyView = Kokkos::is_view<T>::value;

//! An unsigned integer in the order of the keys.
template <class Key>
KOKKOS_FORCEINLINE_FUNCTION std::uint64_t orderedBits( const Key key )
{
    constexpr std::uint64_t sign = std::uint64_t( 1 ) << 63;
    if constexpr ( std::is_floating_point_v<Key> )
    {
        static_assert( sizeof( Key ) <= sizeof( double ),
                       "Keys may have at most 64 bits" );
        // Adding zero turns -0.0 into 0.0, which compare equal.
        const auto bits =
            Kokkos::bit_cast<std::uint64_t>( static_cast<double>( key ) + 0. );
        // Negative numbers: larger magnitude comes first.
        return bits & sign ? ~bits : bits | sign;
    }
    else if constexpr ( std::is_signed_v<Key> )
        return static_cast<std::uint64_t>( static_cast<std::int64_t>( key ) ) ^
               sign;
    else
        return key;
}

/*!
  \brief Kokkos' and Cabana's rule from key to bin, without their rounding of
  whole numbers: the range from the smallest
  to the largest key is cut into nbin equal parts, and the largest key alone
  has one more bin. Whole numbers with a range up to nbin have bins of their
  own: bin = key - smallest key.
*/
template <class KeyView>
class KeyToBin
{
    using Key = typename KeyView::non_const_value_type;

  public:
    //! Bins of keys [begin, end) between min and max.
    KeyToBin( const KeyView& keys, const std::size_t begin, const Key min,
              const Key max, const int nbin )
        : _keys( keys ), _begin( begin ), _min( min ), _last( nbin )
    {
        const double range = distance( max );
        // Keys that are all equal share the first bin.
        _scale = range > 0 ? nbin / range : 0;
        _exact = std::is_integral_v<Key> && range <= nbin;
    }

    //! Bin of key begin + i.
    KOKKOS_FORCEINLINE_FUNCTION
    std::uint32_t operator()( const std::size_t i ) const
    {
        const Key key = _keys( _begin + i );
        if ( _exact )
            return static_cast<std::uint32_t>( key - _min );
        const double bin = _scale * distance( key );
        // Written so that a NaN ends in the first bin.
        return bin > 0
                   ? ( bin < _last ? static_cast<std::uint32_t>( bin ) : _last )
                   : 0;
    }

  private:
    KOKKOS_FORCEINLINE_FUNCTION double distance( const Key key ) const
    {
        // Large integers that differ may be the same double; their difference
        // in unsigned ones is exact.
        if constexpr ( std::is_integral_v<Key> )
            return static_cast<double>( static_cast<std::uint64_t>( key ) -
                                        static_cast<std::uint64_t>( _min ) );
        else
            return static_cast<double>( key ) - static_cast<double>( _min );
    }

    KeyView _keys;
    std::size_t _begin;
    Key _min;
    double _scale;
    std::uint32_t _last;
    bool _exact;
};

//! Order-preserving image of key begin + i, zero for the smallest key.
template <class KeyView>
struct KeyToImage
{
    KeyView keys;
    std::size_t begin;
    std::uint64_t smallest;

    KOKKOS_FORCEINLINE_FUNCTION
    std::uint64_t operator()( const std::size_t i ) const
    {
        return orderedBits( keys( begin + i ) ) - smallest;
    }
};

//! Smallest and largest key of [begin, end).
template <class ExecutionSpace, class KeyView>
CABANA_LAUNCHES auto keyMinMax( const KeyView& keys, const std::size_t begin,
                                const std::size_t end )
    -> Kokkos::MinMaxScalar<typename KeyView::non_const_value_type>
{
    using Key = typename KeyView::non_const_value_type;
    Kokkos::MinMaxScalar<Key> result;
    Kokkos::parallel_reduce(
        "Cabana::keyMinMax", Kokkos::RangePolicy<ExecutionSpace>( begin, end ),
        KOKKOS_LAMBDA( const std::size_t i,
                       Kokkos::MinMaxScalar<Key>& bounds ) {
            const Key key = keys( i );
            if ( key < bounds.min_val )
                bounds.min_val = key;
            if ( key > bounds.max_val )
                bounds.max_val = key;
        },
        Kokkos::MinMax<Key>( result ) );
    return result;
}

//! Entries of particles [begin, end) in the order of their bins.
template <class ExecutionSpace, class KeyView>
auto sortByBin( const KeyView& keys, const int nbin, const std::size_t begin,
                const std::size_t end )
{
    const auto bounds = keyMinMax<ExecutionSpace>( keys, begin, end );
    const KeyToBin<KeyView> bin_of( keys, begin, bounds.min_val, bounds.max_val,
                                    nbin );
    return stableSort<ExecutionSpace, typename KeyView::memory_space>(
        bin_of, end - begin, std::bit_width( static_cast<unsigned>( nbin ) ) );
}

/*!
  \brief Turn sorted entries into binning data.
  \param entries In the order of their bins. \param begin First particle.
  \param bins Number of bins. \param bin_of Bin of an entry.
  \throws std::length_error if a particle's number does not fit 32 bits.
*/
template <class ExecutionSpace, class Entries, class BinOf>
CABANA_LAUNCHES BinningData<typename Entries::memory_space>
makeBinningData( const Entries& entries, const std::size_t begin,
                 const int bins, const BinOf& bin_of )
{
    using Binning = BinningData<typename Entries::memory_space>;
    using Range = Kokkos::RangePolicy<ExecutionSpace>;
    const std::size_t n = entries.extent( 0 );
    if ( begin + n > std::numeric_limits<std::uint32_t>::max() )
        throw std::length_error( "Cabana: too many particles to sort" );
    typename Binning::PermuteView order(
        Kokkos::view_alloc( "Cabana::permutation",
                            Kokkos::WithoutInitializing ),
        n );
    // Without particles all bins start at zero.
    typename Binning::OffsetView offsets( "Cabana::bin_offsets", bins );
    Kokkos::View<int*, typename Entries::memory_space> counts(
        "Cabana::bin_counts", bins );

    Kokkos::parallel_for(
        "Cabana::binOffsets", Range( 0, n ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            order( i ) =
                static_cast<std::uint32_t>( begin + entries( i ).index );
            // Bins start where the bin changes, empty ones at the next
            // particle; those after the last particle start at the end.
            const int bin = bin_of( entries( i ) );
            for ( int b = i == 0 ? 0 : bin_of( entries( i - 1 ) ) + 1; b <= bin;
                  ++b )
                offsets( b ) = i;
            if ( i + 1 == n )
                for ( int b = bin + 1; b < bins; ++b )
                    offsets( b ) = n;
        } );
    Kokkos::parallel_for(
        "Cabana::binCounts", Range( 0, bins ), KOKKOS_LAMBDA( const int b ) {
            counts( b ) = static_cast<int>(
                ( b + 1 < bins ? offsets( b + 1 ) : n ) - offsets( b ) );
        } );
    return Binning( begin, begin + n, counts, offsets, order );
}

//! Bin of an entry that was sorted by bin.
struct ImageIsBin
{
    template <class Entry>
    KOKKOS_FORCEINLINE_FUNCTION int operator()( const Entry& entry ) const
    {
        return static_cast<int>( entry.image );
    }
};

//! Bin of an entry that was sorted by key.
template <class KeyView>
struct BinOfIndex
{
    KeyToBin<KeyView> key_to_bin;

    template <class Entry>
    KOKKOS_FORCEINLINE_FUNCTION int operator()( const Entry& entry ) const
    {
        return static_cast<int>( key_to_bin( entry.index ) );
    }
};

//! A slice of keys as a contiguous view.
template <class ExecutionSpace, class Slice_t>
CABANA_LAUNCHES auto copyOfKeys( const Slice_t& slice )
    -> Kokkos::View<typename Slice_t::value_type*,
                    typename Slice_t::memory_space>
{
    Kokkos::View<typename Slice_t::value_type*, typename Slice_t::memory_space>
        keys( Kokkos::view_alloc( "Cabana::keys", Kokkos::WithoutInitializing ),
              slice.size() );
    Kokkos::parallel_for(
        "Cabana::copyOfKeys",
        Kokkos::RangePolicy<ExecutionSpace>( 0, slice.size() ),
        KOKKOS_LAMBDA( const std::size_t i ) { keys( i ) = slice( i ); } );
    return keys;
}

/*!
  \brief Permute whole structs into a scratch array, then copy it back. Member
  by member would need less scratch, but then every pass jumps from struct to
  struct, which took twice as long on a host.
*/
template <class ExecutionSpace, class Binning, class AoSoA_t>
CABANA_LAUNCHES void permuteTuples( const Binning& binning,
                                    const AoSoA_t& aosoa )
{
    using index = typename AoSoA_t::index_type;
    using Structs = Kokkos::View<typename AoSoA_t::soa_type*,
                                 typename AoSoA_t::memory_space>;
    const std::size_t begin = binning.rangeBegin();
    const std::size_t end = binning.rangeEnd();
    if ( begin == end )
        return;
    // The structs at either end may hold particles outside the range, which
    // stay where they are.
    const std::size_t first = index::s( begin );
    const std::size_t last = index::numStruct( end );
    const std::size_t stop =
        std::min<std::size_t>( index::i( last, 0 ), aosoa.size() );
    const Structs scratch(
        Kokkos::view_alloc( "Cabana::permute", Kokkos::WithoutInitializing ),
        last - first );
    Kokkos::parallel_for(
        "Cabana::permute",
        Kokkos::RangePolicy<ExecutionSpace>( index::i( first, 0 ), stop ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            const std::size_t from =
                begin <= i && i < end ? binning.permutation( i - begin ) : i;
            tupleCopy( scratch( index::s( i ) - first ), index::a( i ),
                       aosoa.access( index::s( from ) ), index::a( from ) );
        } );
    Kokkos::deep_copy( bytesOf<typename AoSoA_t::memory_space>(
                           aosoa.data() + first, last - first ),
                       bytesOf<typename AoSoA_t::memory_space>(
                           scratch.data(), last - first ) );
}

//! Permute one member into a scratch array, then copy it back.
template <class ExecutionSpace, class Binning, class Slice_t>
CABANA_LAUNCHES void permuteMember( const Binning& binning,
                                    const Slice_t& slice )
{
    using Range = Kokkos::RangePolicy<ExecutionSpace>;
    constexpr std::size_t components = num_components<Slice_t>;
    const std::size_t begin = binning.rangeBegin();
    const std::size_t end = binning.rangeEnd();
    const Kokkos::View<typename Slice_t::value_type* [components],
                       typename Slice_t::memory_space>
        scratch( Kokkos::view_alloc( "Cabana::permute",
                                     Kokkos::WithoutInitializing ),
                 end - begin );
    Kokkos::parallel_for(
        "Cabana::permute", Range( begin, end ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            const auto from =
                firstComponent( slice, binning.permutation( i - begin ) );
            for ( std::size_t n = 0; n < components; ++n )
                scratch( i - begin, n ) = from[n * Slice_t::array_stride];
        } );
    Kokkos::parallel_for(
        "Cabana::permute::copyBack", Range( begin, end ),
        KOKKOS_LAMBDA( const std::size_t i ) {
            const auto to = firstComponent( slice, i );
            for ( std::size_t n = 0; n < components; ++n )
                to[n * Slice_t::array_stride] = scratch( i - begin, n );
        } );
    Kokkos::fence( "Cabana::permute" );
}

} // namespace Impl

/*!
  \brief Order of particles [begin, end) by bins of their keys.

  The range of the keys is cut into nbin equal parts and the largest key gets
  one more, so there are nbin + 1 bins. For whole-number keys that span at most
  nbin, bin b holds the particles of key b + (smallest key).

  \param keys One key per particle of the container. Shape [particles].
  \param nbin Number of parts.
  \param begin, end Range of particles to order.
  \return Which particle comes where (see permute) and the bins.
*/
template <Impl::AnyView KeyViewType,
          class ExecutionSpace = typename KeyViewType::execution_space>
auto binByKey( KeyViewType keys, const int nbin, const std::size_t begin,
               const std::size_t end )
{
    const auto entries =
        Impl::sortByBin<ExecutionSpace>( keys, nbin, begin, end );
    keys = {}; // Memory for the permutation, if nobody else has them.
    return Impl::makeBinningData<ExecutionSpace>( entries, begin, nbin + 1,
                                                  Impl::ImageIsBin{} );
}

//! Order of all particles by bins of their keys.
template <Impl::AnyView KeyViewType,
          class ExecutionSpace = typename KeyViewType::execution_space>
auto binByKey( KeyViewType keys, const int nbin )
{
    const std::size_t n = keys.extent( 0 );
    return binByKey<KeyViewType, ExecutionSpace>( std::move( keys ), nbin, 0,
                                                  n );
}

/*!
  \brief Order of particles [begin, end) by their keys, the smallest first.
  \param keys One key per particle of the container. Shape [particles].
  \param begin, end Range of particles to order.
  \return Which particle comes where, and (end - begin) / 2 + 1 equal bins.
*/
template <Impl::AnyView KeyViewType,
          class ExecutionSpace = typename KeyViewType::execution_space>
auto sortByKey( KeyViewType keys, const std::size_t begin,
                const std::size_t end )
{
    const int nbin = static_cast<int>( ( end - begin ) / 2 );
    const auto bounds = Impl::keyMinMax<ExecutionSpace>( keys, begin, end );
    const std::uint64_t smallest = Impl::orderedBits( bounds.min_val );
    const std::uint64_t largest = Impl::orderedBits( bounds.max_val );
    const auto entries =
        Impl::stableSort<ExecutionSpace, typename KeyViewType::memory_space>(
            Impl::KeyToImage<KeyViewType>{ keys, begin, smallest }, end - begin,
            largest > smallest ? std::bit_width( largest - smallest ) : 1 );
    const Impl::KeyToBin<KeyViewType> bin_of( keys, begin, bounds.min_val,
                                              bounds.max_val, nbin );
    return Impl::makeBinningData<ExecutionSpace>(
        entries, begin, nbin + 1, Impl::BinOfIndex<KeyViewType>{ bin_of } );
}

//! Order of all particles by their keys, the smallest first.
template <Impl::AnyView KeyViewType,
          class ExecutionSpace = typename KeyViewType::execution_space>
auto sortByKey( KeyViewType keys )
{
    return sortByKey<KeyViewType, ExecutionSpace>( keys, 0, keys.extent( 0 ) );
}

//! Order of particles [begin, end) by bins of a member (see above).
template <Impl::AnySlice SliceType,
          class ExecutionSpace = typename SliceType::execution_space>
auto binByKey( SliceType slice, const int nbin, const std::size_t begin,
               const std::size_t end )
{
    auto keys = Impl::copyOfKeys<ExecutionSpace>( slice );
    return binByKey<decltype( keys ), ExecutionSpace>( std::move( keys ), nbin,
                                                       begin, end );
}

//! Order of all particles by bins of a member.
template <Impl::AnySlice SliceType,
          class ExecutionSpace = typename SliceType::execution_space>
auto binByKey( SliceType slice, const int nbin )
{
    return binByKey<SliceType, ExecutionSpace>( slice, nbin, 0, slice.size() );
}

//! Order of particles [begin, end) by a member, the smallest first.
template <Impl::AnySlice SliceType,
          class ExecutionSpace = typename SliceType::execution_space>
auto sortByKey( SliceType slice, const std::size_t begin,
                const std::size_t end )
{
    const auto keys = Impl::copyOfKeys<ExecutionSpace>( slice );
    return sortByKey<std::remove_const_t<decltype( keys )>, ExecutionSpace>(
        keys, begin, end );
}

//! Order of all particles by a member, the smallest first.
template <Impl::AnySlice SliceType,
          class ExecutionSpace = typename SliceType::execution_space>
auto sortByKey( SliceType slice )
{
    return sortByKey<SliceType, ExecutionSpace>( slice, 0, slice.size() );
}

/*!
  \brief Bring particles into an order. Slices stay valid. Needs one temporary
  copy of the range.
  \param binning_data The order, of this container's particles.
  \param[in,out] aosoa The particles. Those outside the range stay.
*/
template <Impl::AnyBinning BinningDataType, Impl::AnyAoSoA AoSoA_t,
          class ExecutionSpace = typename BinningDataType::execution_space>
void permute( const BinningDataType& binning_data, AoSoA_t& aosoa )
{
    Impl::permuteTuples<ExecutionSpace>( binning_data, aosoa );
}

/*!
  \brief Bring one member of the particles into an order. Needs one temporary
  copy of that member.
  \param binning_data The order, of this container's particles.
  \param[in,out] slice The member. Particles outside the range stay.
*/
template <Impl::AnyBinning BinningDataType, Impl::AnySlice SliceType,
          class ExecutionSpace = typename BinningDataType::execution_space>
void permute( const BinningDataType& binning_data, SliceType& slice )
{
    Impl::permuteMember<ExecutionSpace>( binning_data, slice );
}

} // namespace Cabana

#endif
