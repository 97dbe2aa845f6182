#include <core/balance.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace Machpoint
{

namespace
{

//! Where the boxes along one axis can end if none is heavier than a bound.
class Ends
{
  public:
    //! \param sums [slabs][cells + 1], loads before each cell
    Ends( const SlabLoads& sums, const int parts, const int fewest,
          const double bound )
        : _farthest( sums[0].size() ),
          _reached( parts + 1, std::vector<char>( sums[0].size() ) )
    {
        const int cells = static_cast<int>( sums[0].size() ) - 1;
        int end = 0;
        for ( int begin = 0; begin <= cells; ++begin )
        {
            end = std::max( end, begin );
            while ( end < cells && load( sums, begin, end + 1 ) <= bound )
                ++end;
            _farthest[begin] = end;
        }
        _reached[0][0] = 1;
        std::vector<int> change( cells + 2 ); // where a range starts or is over
        for ( int part = 0; part < parts; ++part )
        {
            std::fill( change.begin(), change.end(), 0 );
            for ( int begin = 0; begin + fewest <= cells; ++begin )
                if ( _reached[part][begin] &&
                     _farthest[begin] >= begin + fewest )
                {
                    ++change[begin + fewest];
                    --change[_farthest[begin] + 1];
                }
            int ranges = 0;
            for ( int c = 0; c <= cells; ++c )
            {
                ranges += change[c];
                _reached[part + 1][c] = ranges > 0 ? 1 : 0;
            }
        }
    }

    //! Can this many boxes fill the cells before `end`?
    bool reach( const int boxes, const int end ) const
    {
        return _reached[boxes][end] != 0;
    }
    //! Is a box light enough? It begins where it can be reached.
    bool fits( const int begin, const int end ) const
    {
        return _farthest[begin] >= end;
    }

    //! Of the heaviest slab.
    static double load( const SlabLoads& sums, const int begin, const int end )
    {
        double heaviest = 0;
        for ( const auto& sum : sums )
            heaviest = std::max( heaviest, sum[end] - sum[begin] );
        return heaviest;
    }

  private:
    std::vector<int> _farthest;              // end of a box, from its begin
    std::vector<std::vector<char>> _reached; // [boxes][end]
};

} // namespace

AxisCuts cutAxis( const SlabLoads& loads, const int parts, const int fewest )
{
    const int cells = static_cast<int>( loads.at( 0 ).size() );
    if ( parts < 1 || cells < parts * fewest )
        throw std::invalid_argument(
            std::to_string( parts ) + " boxes of at least " +
            std::to_string( fewest ) + " cells do not fit into " +
            std::to_string( cells ) + "; start fewer ranks" );
    SlabLoads sums;
    std::vector<double> whole( cells + 1 ); // of all slabs
    for ( const auto& slab : loads )
    {
        auto& sum = sums.emplace_back( cells + 1 );
        for ( int c = 0; c < cells; ++c )
            sum[c + 1] = sum[c] + slab[c];
        for ( int c = 0; c <= cells; ++c )
            whole[c] += sum[c];
    }

    // Between a bound that fails, or nothing, and one that is kept.
    double low = 0, high = Ends::load( sums, 0, cells );
    while ( high - low > 1e-6 * high )
    {
        const double middle = 0.5 * ( low + high );
        ( Ends( sums, parts, fewest, middle ).reach( parts, cells ) ? high
                                                                    : low ) =
            middle;
    }

    const Ends ends( sums, parts, fewest, high );
    AxisCuts chosen{ std::vector<int>( parts + 1 ), 0 };
    chosen.cuts[parts] = cells;
    for ( int part = parts - 1; part >= 0; --part )
    {
        const int end = chosen.cuts[part + 1];
        const double even = whole[cells] * part / parts;
        int best = -1;
        for ( int begin = 0; begin <= end - fewest; ++begin )
            if ( ends.reach( part, begin ) && ends.fits( begin, end ) &&
                 ( best < 0 || std::abs( whole[begin] - even ) <
                                   std::abs( whole[best] - even ) ) )
                best = begin;
        chosen.cuts[part] = best;
        chosen.heaviest =
            std::max( chosen.heaviest, Ends::load( sums, best, end ) );
    }
    return chosen;
}

} // namespace Machpoint
