#include <drivers/study_fit.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace Machpoint
{

std::vector<Json> expandMatrix( const Json& blocks )
{
    std::vector<Json> all;
    for ( const auto& block : blocks )
    {
        std::vector<Json> rows = { Json::object() };
        for ( const auto& item : block.items() )
        {
            std::vector<Json> longer;
            for ( const auto& row : rows )
                for ( const auto& value : item.value() )
                {
                    longer.push_back( row );
                    longer.back()[item.key()] = value;
                }
            rows = std::move( longer );
        }
        for ( const auto& row : rows )
            if ( std::find( all.begin(), all.end(), row ) == all.end() )
                all.push_back( row );
    }
    return all;
}

namespace
{

bool hasLogarithm( const Point& point )
{
    return point.x > 0 && point.y > 0 && std::isfinite( point.x ) &&
           std::isfinite( point.y );
}

} // namespace

std::optional<PowerLaw> fitPowerLaw( const std::vector<Point>& points )
{
    std::vector<Point> logs;
    for ( const auto& point : points )
        if ( hasLogarithm( point ) )
            logs.push_back( { std::log( point.x ), std::log( point.y ) } );
    const double n = static_cast<double>( logs.size() );
    Point mean;
    for ( const auto& point : logs )
        mean = { mean.x + point.x / n, mean.y + point.y / n };
    double xx = 0, xy = 0;
    for ( const auto& point : logs )
    {
        xx += ( point.x - mean.x ) * ( point.x - mean.x );
        xy += ( point.x - mean.x ) * ( point.y - mean.y );
    }
    // Equal x leave round-off of their mean, which is no spread.
    if ( logs.size() < 2 || xx <= 1e-20 * n * ( 1 + mean.x * mean.x ) )
        return std::nullopt;
    PowerLaw law;
    law.exponent = xy / xx;
    const double offset = mean.y - law.exponent * mean.x;
    law.factor = std::exp( offset );
    double square = 0;
    for ( const auto& point : logs )
        square += std::pow( point.y - offset - law.exponent * point.x, 2 ) / n;
    law.scatter = std::exp( std::sqrt( square ) );
    return law;
}

double predict( const std::vector<Point>& points, const double x )
{
    if ( points.size() == 1 )
        return points.front().y;
    const auto right =
        std::upper_bound( points.begin() + 1, points.end() - 1, x,
                          []( const double value, const Point& point )
                          { return value < point.x; } );
    const auto left = right - 1;
    const double part =
        std::log( x / left->x ) / std::log( right->x / left->x );
    return left->y * std::pow( right->y / left->y, part );
}

std::vector<std::size_t> paretoFront( const std::vector<Point>& points )
{
    std::vector<std::size_t> order( points.size() );
    std::iota( order.begin(), order.end(), 0 );
    std::erase_if(
        order, [&]( const std::size_t k )
        { return std::isnan( points[k].x ) || std::isnan( points[k].y ); } );
    std::sort( order.begin(), order.end(),
               [&]( const std::size_t a, const std::size_t b )
               {
                   return points[a].x != points[b].x
                              ? points[a].x < points[b].x
                              : points[a].y < points[b].y;
               } );
    std::vector<std::size_t> front;
    for ( const auto k : order )
        if ( front.empty() || points[k].y < points[front.back()].y )
            front.push_back( k );
    return front;
}

double cellCount( const std::vector<std::int64_t>& cells )
{
    double count = 1;
    for ( const auto n : cells )
        count *= static_cast<double>( n );
    return count;
}

namespace
{

//! Cells against a measured quantity, where that is known; of grids with the
//! same number of cells the largest, so that nothing is promised that one did
//! not hold.
std::vector<Point> overCells( const Line& line, const std::vector<double>& y )
{
    std::vector<Point> points;
    for ( std::size_t k = 0; k < line.cells.size(); ++k )
        if ( const Point point{ cellCount( line.cells[k] ), y[k] };
             hasLogarithm( point ) )
        {
            if ( points.empty() || points.back().x != point.x )
                points.push_back( point );
            else
                points.back().y = std::max( points.back().y, point.y );
        }
    return points;
}

std::optional<PowerLaw> fitFinest( std::vector<Point> points )
{
    if ( points.size() > fitted_runs )
        points.erase( points.begin(),
                      points.end() - static_cast<int>( fitted_runs ) );
    return fitPowerLaw( points );
}

} // namespace

std::optional<double> unbelievedOrder( const Line& line )
{
    const auto errors = overCells( line, line.errors );
    if ( errors.size() < 2 )
        return std::nullopt;
    const auto law = fitPowerLaw( { errors.end() - 2, errors.end() } );
    const double order = law ? -law->exponent * line.dimension : 0;
    return order > too_fast ? std::optional( order ) : std::nullopt;
}

Laws fitLaws( const Line& line )
{
    Laws laws;
    laws.cost = fitFinest( overCells( line, line.seconds ) );
    laws.error = fitFinest( overCells( line, line.errors ) );
    if ( laws.error )
        laws.order = -laws.error->exponent * line.dimension;
    laws.is_too_fast =
        unbelievedOrder( line ) || ( laws.order && *laws.order > too_fast );
    if ( laws.cost && laws.order && *laws.order > 0 && !laws.is_too_fast )
        laws.halving =
            std::pow( 2, laws.cost->exponent * line.dimension / *laws.order );
    return laws;
}

std::vector<Candidate> candidates( const Line& line, const std::size_t number )
{
    const auto seconds = overCells( line, line.seconds );
    const auto errors = overCells( line, line.errors );
    // One error tells nothing of other grids.
    if ( errors.size() < 2 )
    {
        for ( std::size_t k = 0; k < line.cells.size(); ++k )
            if ( line.errors[k] > 0 )
                return { { number, line.cells[k], line.seconds[k],
                           line.errors[k] } };
        return {};
    }
    const auto& finest = line.cells.back();
    const double believed = unbelievedOrder( line )
                                ? errors.back().x
                                : std::numeric_limits<double>::infinity();
    const auto& coarsest = line.cells.front();
    auto varies = [&]( const std::size_t axis )
    {
        return std::any_of( line.cells.begin(), line.cells.end(),
                            [&]( const auto& cells )
                            { return cells[axis] != finest[axis]; } );
    };
    std::size_t first = 0; // that varies: of two errors one does
    while ( !varies( first ) )
        ++first;
    std::int64_t step = 0;
    for ( const auto& cells : line.cells )
        step = std::gcd( step, cells[first] );
    std::vector<Candidate> all;
    for ( auto n = coarsest[first]; n <= farthest_refinement * finest[first];
          n += step )
    {
        Candidate candidate;
        candidate.line = number;
        // An axis that stays does so, and none has fewer cells than were tried:
        // a scene may not allow them.
        for ( std::size_t axis = 0; axis < finest.size(); ++axis )
            candidate.cells.push_back(
                varies( axis )
                    ? std::max<std::int64_t>(
                          coarsest[axis],
                          std::llround( static_cast<double>( finest[axis] ) *
                                        static_cast<double>( n ) /
                                        static_cast<double>( finest[first] ) ) )
                    : finest[axis] );
        const double count = cellCount( candidate.cells );
        candidate.seconds = predict( seconds, count );
        candidate.error = predict( errors, std::min( count, believed ) );
        all.push_back( std::move( candidate ) );
    }
    return all;
}

namespace
{

//! The best of all lines' candidates that are admitted.
template <class Admits, class IsBetter>
std::optional<Candidate> best( const std::vector<Line>& lines,
                               const Admits& admits, const IsBetter& isBetter )
{
    std::optional<Candidate> found;
    for ( std::size_t k = 0; k < lines.size(); ++k )
        for ( auto& candidate : candidates( lines[k], k ) )
            if ( admits( candidate ) &&
                 ( !found || isBetter( candidate, *found ) ) )
                found = std::move( candidate );
    return found;
}

bool isFaster( const Candidate& a, const Candidate& b )
{
    return a.seconds < b.seconds;
}

bool isMoreAccurate( const Candidate& a, const Candidate& b )
{
    return a.error < b.error;
}

} // namespace

std::optional<Candidate> cheapest( const std::vector<Line>& lines,
                                   const double target )
{
    return best(
        lines, [&]( const Candidate& c ) { return c.error <= target; },
        isFaster );
}

std::optional<Candidate> mostAccurate( const std::vector<Line>& lines,
                                       const double budget )
{
    return best(
        lines, [&]( const Candidate& c ) { return c.seconds <= budget; },
        isMoreAccurate );
}

} // namespace Machpoint
