/*!
  \file parameters_nearest.cpp
  \brief The word that a misspelt one probably meant.
*/
#include <core/parameters.hpp>

#include <algorithm>
#include <limits>

namespace Machpoint
{

namespace
{

//! Number of edits between two words; a swap of neighbours is one.
std::size_t editDistance( const std::string& a, const std::string& b )
{
    std::vector<std::vector<std::size_t>> edits(
        a.size() + 1, std::vector<std::size_t>( b.size() + 1 ) );
    for ( std::size_t i = 0; i <= a.size(); ++i )
        for ( std::size_t j = 0; j <= b.size(); ++j )
        {
            if ( i == 0 || j == 0 )
            {
                edits[i][j] = i + j;
                continue;
            }
            const std::size_t replaced = a[i - 1] == b[j - 1] ? 0 : 1;
            edits[i][j] = std::min( { edits[i - 1][j] + 1, edits[i][j - 1] + 1,
                                      edits[i - 1][j - 1] + replaced } );
            if ( i > 1 && j > 1 && a[i - 1] == b[j - 2] &&
                 a[i - 2] == b[j - 1] )
                edits[i][j] = std::min( edits[i][j], edits[i - 2][j - 2] + 1 );
        }
    return edits[a.size()][b.size()];
}

std::string lowerCase( std::string text )
{
    for ( char& c : text )
        if ( c >= 'A' && c <= 'Z' )
            c += 'a' - 'A';
    return text;
}

} // namespace

std::string nearest( const std::string& word,
                     const std::vector<std::string>& candidates )
{
    std::string best;
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for ( const auto& candidate : candidates )
    {
        const auto [shorter, longer] =
            std::minmax( { word.size(), candidate.size() } );
        // A third: one edit in "type", two in "gamma", none in "x".
        const std::size_t limit = ( longer + 1 ) / 3;
        // Every surplus character is an edit, so long junk costs nothing.
        if ( longer - shorter > limit )
            continue;
        const auto edits =
            editDistance( lowerCase( word ), lowerCase( candidate ) );
        if ( edits <= limit && edits < least )
        {
            best = candidate;
            least = edits;
        }
    }
    return best;
}

} // namespace Machpoint
