/*!
  \file body_doubts.cpp
  \brief What is odd about the bodies of an input.
*/
#include <drivers/body_doubts.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace Machpoint
{

namespace
{

//! Of a body with images, cells (docs/method.md, section 11).
constexpr int least_thickness = 5;
//! Angle with a wall below which a body that rises from it starts late,
//! degrees (docs/conservative.md, section 6).
constexpr double least_slope = 25;
//! From an inflow's buffer to a body, cells (docs/method.md, section 8): at 1.5
//! the force on one grows by 20 % with a quarter of the step, at 4 by 6 %.
constexpr double buffer_margin = 2;
//! From a body with images to one that is projected, cells, below which they
//! stir gas at rest (docs/conservative.md, section 6).
constexpr double mixed_margin = 4;
//! Part of a stream's speed that meets a body's surface, not only rounding.
constexpr double oblique = 0.01;

//! Looks at the bodies one by one.
template <int Dim>
class BodyDoubts
{
  public:
    using Body = SampledBody<Dim>;

    BodyDoubts( const Json& input, const SampleGrid<Dim>& samples,
                const std::vector<Body>& bodies )
        : _input( input ), _samples( samples ), _grid( samples.grid() ),
          _bodies( bodies )
    {
    }

    std::vector<std::string> find() const
    {
        std::vector<std::string> odd;
        // From the centre of a sample to a body that might yet act on it.
        double reach = farthest_image * makeGrid<Dim>( _input ).maxSpacing();
        for ( int d = 0; d < Dim; ++d )
            reach += 0.5 * _grid.spacing[d];
        for ( const auto& body : _bodies )
            if ( body.nearest_sample > reach )
                odd.push_back( body.place +
                               ": the body is outside the domain, where no "
                               "gas meets it; move it or leave it out" );
        for ( const auto& body : _bodies )
            if ( body.has_images )
            {
                tellIfThin( body, odd );
                tellIfSlender( body, odd );
            }
        for ( const auto& body : _bodies )
            tellIfInBuffer( body, odd );
        for ( const auto& body : _bodies )
            for ( const auto& other : _bodies )
                if ( body.has_images && !other.has_images )
                    tellIfMixed( body, other, odd );
        return odd;
    }

  private:
    //! From the deepest sample of a body to the deepest place nearby.
    Vector<Dim> deepest( const Body& body ) const
    {
        auto x = body.sample;
        Real least = body.shape.distance( x );
        for ( Real step = _grid.maxSpacing();
              step > 1e-3_rt * _grid.minSpacing(); )
        {
            bool is_deeper = false;
            for ( int d = 0; d < Dim; ++d )
                for ( const Real way : { -step, step } )
                {
                    auto y = x;
                    y[d] += way;
                    const Real distance = body.shape.distance( y );
                    if ( distance >= least )
                        continue;
                    least = distance;
                    x = y;
                    is_deeper = true;
                }
            if ( !is_deeper )
                step *= 0.5_rt;
            else if ( -least > 100 * _grid.maxSpacing() )
                break; // a half space has no end
        }
        return x;
    }

    /*!
      \brief Tells of a body that is nowhere thick enough to part the gas on
      its two sides: the stencil of a particle before it and that of an image
      within it reach across (docs/method.md, section 11).
    */
    void tellIfThin( const Body& body, std::vector<std::string>& odd ) const
    {
        const auto grid = makeGrid<Dim>( _input );
        const auto x = deepest( body );
        const auto middle = body.shape.nearest( x );
        const Real thickness = -2 * middle.distance / grid.minSpacing();
        if ( thickness <= 0 || thickness > least_thickness - 0.01_rt )
            return;
        // Below an edge the normal is between those of its faces.
        Real straight = 0;
        for ( int d = 0; d < Dim; ++d )
            straight = Kokkos::max( straight, Kokkos::abs( middle.normal[d] ) );
        for ( const Real way : { -1.01_rt, 1.01_rt } ) // to both of its sides
        {
            auto beside = x;
            for ( int d = 0; d < Dim; ++d )
            {
                beside[d] -=
                    way * middle.distance / straight * middle.normal[d];
                if ( beside[d] < grid.lower[d] || beside[d] > grid.upper[d] )
                    return;
            }
            if ( isInBody<Dim>( _bodies, beside ) )
                return;
        }
        odd.push_back( fmt::format(
            "{}: the body is {:.2g} cells thick, and with images less than {} "
            "cells do not part the gas on its two sides; refine the grid, make "
            "it thicker, or give it the treatment \"projection\", which needs "
            "2",
            body.place, thickness, least_thickness ) );
    }

    //! Tells of the first place where a body rises from a wall so little that
    //! its tip is lost in what the wall mirrors.
    void tellIfSlender( const Body& body, std::vector<std::string>& odd ) const
    {
        for ( const auto& entry : _input.at( "boundary" ) )
            for ( const auto& claim : sidesOf( entry, Dim ) )
            {
                if ( claim.kind != SideKind::slip &&
                     claim.kind != SideKind::no_slip )
                    continue;
                const int axis = claim.side / 2;
                const int layer = claim.side % 2 ? _grid.cells[axis] - 1 : 0;
                bool is_told = false;
                _samples.forEach(
                    [&]( const Indices<Dim>& i, int )
                    {
                        if ( is_told || i[axis] != layer )
                            return;
                        auto x = _samples.center( i );
                        x[axis] = claim.side % 2 ? _grid.upper[axis]
                                                 : _grid.lower[axis];
                        const double slope = slopeAt( body, x, claim.side );
                        is_told = slope < least_slope;
                        if ( is_told )
                            odd.push_back( fmt::format(
                                "{}: the body rises from {} at {:.2g} degrees "
                                "near {}, where what that wall mirrors hides "
                                "its tip, so shocks start late; begin the grid "
                                "two cells or more beyond the wall, and make "
                                "the wall a body, too",
                                body.place, sideNames( Dim )[claim.side], slope,
                                placeText<Dim>( x ) ) );
                    } );
            }
    }

    //! Angle between a side and a body's surface that rises from it between a
    //! place and the next samples; infinite where none does. Degrees.
    double slopeAt( const Body& body, const Vector<Dim>& a,
                    const int side ) const
    {
        const int axis = side / 2;
        for ( int d = 0; d < Dim; ++d )
        {
            auto b = a;
            b[d] += _grid.spacing[d];
            if ( d == axis || b[d] > _grid.upper[d] ||
                 isInBody<Dim>( _bodies, a ) == isInBody<Dim>( _bodies, b ) ||
                 ( body.shape.distance( a ) < 0 ) ==
                     ( body.shape.distance( b ) < 0 ) )
                continue;
            const auto normal =
                body.shape.nearest( isInBody<Dim>( _bodies, a ) ? b : a )
                    .normal;
            const double upright = side % 2 ? -normal[axis] : normal[axis];
            if ( upright > 0 )
                return std::acos( std::min( upright, 1.0 ) ) * 180 /
                       std::numbers::pi;
        }
        return Kokkos::Experimental::infinity_v<double>;
    }

    //! Tells of the first side whose buffer holds a surface of the body that
    //! the stream does not pass along: each step the body takes from gas what
    //! the buffer gives back, whatever the step (docs/method.md, section 8).
    void tellIfInBuffer( const Body& body, std::vector<std::string>& odd ) const
    {
        const auto grid = makeGrid<Dim>( _input );
        for ( const auto& entry : _input.at( "boundary" ) )
        {
            const auto& hooks = boundaryHooks( entry, Dim );
            const auto sides = sidesOf( entry, Dim );
            if ( !hooks.imposedCells || !hooks.beyond || sides.empty() )
                continue;
            const int side = sides.front().side;
            const int buffer = hooks.imposedCells( entry );
            const auto velocity = hooks.beyond( entry, side, {} ).velocity;
            const double slow =
                oblique * std::sqrt( dot<3>( velocity, velocity ) );
            std::optional<Shape<Dim, Kokkos::HostSpace>> part;
            if ( entry.contains( "region" ) )
                part =
                    makeShape<Dim, Kokkos::HostSpace>( entry.at( "region" ) );
            double depth = buffer + buffer_margin; // cells
            std::optional<Vector<Dim>> found;
            _samples.forEach(
                [&]( const Indices<Dim>& i, int )
                {
                    const auto x = _samples.center( i );
                    if ( isInBody<Dim>( _bodies, x ) )
                        return;
                    const auto nearest = body.shape.nearest( x );
                    if ( nearest.distance > 2 * _grid.maxSpacing() )
                        return;
                    double approach = 0;
                    auto surface = x;
                    for ( int d = 0; d < Dim; ++d )
                    {
                        surface[d] -= nearest.distance * nearest.normal[d];
                        if ( surface[d] < grid.lower[d] ||
                             surface[d] > grid.upper[d] )
                            return;
                        approach += velocity[d] * nearest.normal[d];
                    }
                    auto foot = surface;
                    foot[side / 2] =
                        side % 2 ? grid.upper[side / 2] : grid.lower[side / 2];
                    const double cells =
                        std::abs( surface[side / 2] - foot[side / 2] ) /
                        grid.spacing[side / 2];
                    if ( cells >= depth || std::abs( approach ) <= slow ||
                         ( part && part->distance( foot ) >= 0 ) )
                        return;
                    depth = cells;
                    found = surface;
                } );
            if ( !found )
                continue;
            odd.push_back( fmt::format(
                "{}: the body is {:.2g} cells from {} near {}, and {} cells "
                "there keep the stream's state, so the force on it hangs on "
                "the time step; move that side away{}",
                body.place, depth, sideNames( Dim )[side],
                placeText<Dim>( *found ), buffer,
                buffer > 1 ? " or take a smaller buffer" : "" ) );
            return;
        }
    }

    //! The part of a body's surface that is nearest to a place in the gas, if
    //! gas touches it there: its distance, else infinity.
    Real distanceInGas( const Body& body, const Vector<Dim>& x,
                        const Grid<Dim>& grid ) const
    {
        const auto nearest = body.shape.nearest( x );
        auto outside = x;
        for ( int d = 0; d < Dim; ++d )
        {
            outside[d] -= ( nearest.distance - nudge * grid.minSpacing() ) *
                          nearest.normal[d];
            if ( outside[d] < grid.lower[d] || outside[d] > grid.upper[d] )
                return Kokkos::Experimental::infinity_v<Real>;
        }
        return isInBody<Dim>( _bodies, outside )
                   ? Kokkos::Experimental::infinity_v<Real>
                   : nearest.distance;
    }

    //! Tells where a body with images and one that is projected are so near
    //! to each other that gas at rest between them is stirred.
    void tellIfMixed( const Body& body, const Body& other,
                      std::vector<std::string>& odd ) const
    {
        const auto grid = makeGrid<Dim>( _input );
        const Real cell = grid.maxSpacing();
        // A sample need not be on the shortest way.
        Real least = mixed_margin * cell + _grid.maxSpacing();
        std::optional<Vector<Dim>> found;
        _samples.forEach(
            [&]( const Indices<Dim>& i, int )
            {
                const auto x = _samples.center( i );
                if ( body.shape.distanceBound( x ) >= least ||
                     other.shape.distanceBound( x ) >= least ||
                     isInBody<Dim>( _bodies, x ) )
                    return;
                const Real way = distanceInGas( body, x, grid ) +
                                 distanceInGas( other, x, grid );
                if ( way >= least )
                    return;
                least = way;
                found = x;
            } );
        if ( found )
            odd.push_back( fmt::format(
                "{}: the body has images, and {}, which is projected, is less "
                "than {} cells away near {}, where gas at rest is stirred; "
                "give both the treatment \"images\"",
                body.place, other.place, mixed_margin,
                placeText<Dim>( *found ) ) );
    }

    const Json& _input;
    const SampleGrid<Dim>& _samples;
    const Grid<Dim>& _grid; // theirs
    const std::vector<Body>& _bodies;
};

} // namespace

template <int Dim>
std::vector<std::string>
findBodyDoubts( const Json& input, const SampleGrid<Dim>& samples,
                const std::vector<SampledBody<Dim>>& bodies )
{
    return BodyDoubts<Dim>( input, samples, bodies ).find();
}

template std::vector<std::string>
findBodyDoubts( const Json&, const SampleGrid<1>&,
                const std::vector<SampledBody<1>>& );
template std::vector<std::string>
findBodyDoubts( const Json&, const SampleGrid<2>&,
                const std::vector<SampledBody<2>>& );
template std::vector<std::string>
findBodyDoubts( const Json&, const SampleGrid<3>&,
                const std::vector<SampledBody<3>>& );

} // namespace Machpoint
