/*!
  \file image_gaps.hpp
  \brief Layer 3: where mirror images leave the inside of bodies empty, so that
  a node there has to stand for the wall (docs/conservative.md, section 6).
*/
#ifndef MACHPOINT_IMAGE_GAPS_HPP
#define MACHPOINT_IMAGE_GAPS_HPP

#include <core/collect.hpp>
#include <core/state.hpp>

namespace Machpoint
{

//! Part of what a face sees that images must fill, or its nodes rest.
inline constexpr Real least_cover = 0.5;

/*!
  \brief How much of the space that a face looks at is filled by gas, by its
  images in bodies and by those in the sides of the domain, wherever gas may be.

  A place in a body is filled if its mirror image is in the gas and has its own
  image there: not behind acute corners, cusps and notches, where that image is
  in another wall.
*/
template <int Dim>
struct ImageCover
{
    Bodies<Dim> bodies;
    Grid<Dim> grid;      //!< the whole domain
    Indices<Dim> period; //!< of the nodes; 0: the side mirrors
    int stencil_nodes;   //!< of the basis, along an axis

    //! How deep in a body particles see a node at most, length.
    KOKKOS_INLINE_FUNCTION Real sight() const
    {
        return Kokkos::sqrt( Real( Dim ) ) * 0.5_rt * stencil_nodes *
               grid.maxSpacing();
    }

    //! Is there gas, if it is everywhere but in bodies? \param x [Dim]
    KOKKOS_FUNCTION bool isGas( const Vector<Dim>& x ) const
    {
        for ( int d = 0; d < Dim; ++d )
            if ( x[d] < grid.lower[d] || x[d] > grid.upper[d] )
                return false;
        for ( int b = 0; b < bodies.count; ++b )
            if ( bodies.nearest( x, b ).distance <
                 -round_off * grid.minSpacing() )
                return false;
        return true;
    }

    //! Is there a body whose nodes are projected? \param x in the domain
    KOKKOS_FUNCTION bool isProjected( const Vector<Dim>& x ) const
    {
        const int body = bodies.nearestBody( x );
        return !( bodies.image_reach( body ) > 0 ) &&
               bodies.nearest( x, body ).distance < 0;
    }

    //! Is there an image of gas in a body? \param x in the domain or beyond
    KOKKOS_FUNCTION bool isImage( const Vector<Dim>& x ) const
    {
        // Of a particle in the domain, as its lower corner is.
        if ( isBeyondMirrors<Dim>( x, grid.lower, grid, period ) )
            return false;
        for ( int b = 0; b < bodies.count; ++b )
            if ( isImageIn( x, b ) )
                return true;
        return false;
    }

    //! The same for one body.
    KOKKOS_FUNCTION bool isImageIn( const Vector<Dim>& x, const int body ) const
    {
        if ( !( bodies.image_reach( body ) > 0 ) )
            return false;
        const auto nearest = bodies.nearest( x, body );
        if ( nearest.distance >= 0 )
            return false;
        // Shorter ones than usual are no gaps, but what the input asks for.
        const Real reach =
            Kokkos::max( bodies.image_reach( body ), Real( usual_image ) );
        const Real depth =
            bodies.depth( x, nudge * grid.minSpacing(), grid, period );
        auto isMirror = [&]( const Nearest<Dim>& part )
        {
            if ( part.distance >= 0 || depth < -same_surface * part.distance ||
                 part.distance <
                     -imageDistance<Dim>( grid, reach, part.normal ) )
                return false;
            auto gas = x;
            for ( int d = 0; d < Dim; ++d )
                gas[d] -= 2 * part.distance * part.normal[d];
            // Nearer to another part of the surface, that is what mirrors it.
            return isGas( gas ) &&
                   bodies.nearest( gas, body ).distance >
                       -same_surface * part.distance &&
                   !bodies.covers( gas, { -part.distance, part.normal }, body,
                                   nudge * grid.minSpacing() );
        };
        return isMirror( nearest ) ||
               bodies.shape.anyPart( x, bodies.first( body ),
                                     bodies.first( body + 1 ), isMirror );
    }

    //! A place's image beyond the sides of the axes in `axes`, a bit each.
    KOKKOS_FUNCTION Vector<Dim> beyond( Vector<Dim> x, const int axes ) const
    {
        for ( int d = 0; d < Dim; ++d )
            if ( axes & ( 1 << d ) )
            {
                const Real length = grid.upper[d] - grid.lower[d];
                const bool is_upper =
                    x[d] > 0.5_rt * ( grid.lower[d] + grid.upper[d] );
                x[d] = period[d] > 0
                           ? x[d] + ( is_upper ? -length : length )
                           : 2 * ( is_upper ? grid.upper[d] : grid.lower[d] ) -
                                 x[d];
            }
        return x;
    }

    //! A place in the domain, or the one that it is the image of.
    KOKKOS_FUNCTION Vector<Dim> home( const Vector<Dim>& x ) const
    {
        int outside = 0;
        for ( int d = 0; d < Dim; ++d )
            if ( x[d] < grid.lower[d] || x[d] > grid.upper[d] )
                outside |= 1 << d;
        return beyond( x, outside );
    }

    //! Is there gas or an image of it? \param x in the domain
    KOKKOS_FUNCTION bool isFilled( const Vector<Dim>& x ) const
    {
        if ( isGas( x ) )
            return true;
        int periodic = 0;
        for ( int d = 0; d < Dim; ++d )
            periodic |= period[d] > 0 ? 1 << d : 0;
        for ( int axes = 0; axes < 1 << Dim; ++axes )
            if ( ( axes & ~periodic ) == 0 && isImage( beyond( x, axes ) ) )
                return true;
        return false;
    }

    //! B-spline of a degree around 0, but for a factor; s within its support.
    //! (The time loop is compiled once for all bases, so it is a number here.)
    KOKKOS_FUNCTION static Real spline( const Real s, const int degree )
    {
        Real sum = 0, binomial = 1;
        for ( int j = 0; j <= degree + 1; ++j )
        {
            const Real t = s + 0.5_rt * ( degree + 1 ) - j;
            if ( t <= 0 )
                break;
            Real power = 1;
            for ( int n = 0; n < degree; ++n )
                power *= t;
            sum += binomial * power;
            binomial *= -( degree + 1 - j ) / Real( j + 1 );
        }
        return sum;
    }

    //! Of what a face sees.
    struct Part
    {
        Real no_gap = 1; //!< is filled or projected
        //! Is filled, of one that sees a gap: what is projected shows nothing,
        //! and presses on nothing.
        Real filled = 1;
    };

    //! What the face behind a node along an axis sees: of degree one less along
    //! it. \param node its position
    KOKKOS_FUNCTION Part behind( const Vector<Dim>& node, const int axis ) const
    {
        auto face = node;
        face[axis] += 0.5_rt * grid.spacing[axis];
        const Real far = sight() + 0.5_rt * grid.maxSpacing();
        if ( bodies.shape.distanceBound( face ) > far ||
             Kokkos::abs( bodies.shape.distance( face ) ) > far )
            return {}; // what nobody sees lacks nothing
        constexpr int samples = Dim == 3 ? 2 : 4; // along a cell's side
        Indices<Dim> count{};
        int all = 1;
        for ( int d = 0; d < Dim; ++d )
        {
            count[d] = samples * ( stencil_nodes - ( d == axis ? 1 : 0 ) );
            all *= count[d];
        }
        Real filled = 0, projected = 0, whole = 0;
        bool has_gap = false;
        for ( int k = 0; k < all; ++k )
        {
            auto x = face;
            Real weight = 1;
            int rest = k;
            for ( int d = 0; d < Dim; ++d )
            {
                const Real width = 0.5_rt * count[d] / samples;
                const Real s = ( rest % count[d] + 0.5_rt ) / samples - width;
                rest /= count[d];
                x[d] += s * grid.spacing[d];
                weight *= spline( s, count[d] / samples - 1 );
            }
            whole += weight;
            const auto place = home( x );
            if ( isFilled( place ) )
                filled += weight;
            else if ( isProjected( place ) )
                projected += weight;
            else
                has_gap = true;
        }
        if ( !has_gap )
            return {};
        return { ( filled + projected ) / whole, filled / whole };
    }
};

/*!
  \brief Finds the gaps of a rank's nodes, once for a layout.
  \param state bodies, layout and basis are known
*/
template <int Dim>
ImageGaps findImageGaps( const State<Dim>& state )
{
    ImageGaps gaps;
    if ( !state.bodies.have_images )
        return gaps;
    const auto layout = state.layout;
    const ImageCover<Dim> cover{ state.bodies, state.grid, layout.period,
                                 state.stencil_nodes };
    const NodeView no_gap( "Machpoint::imageCover", layout.total, Dim );
    const NodeView filled( "Machpoint::imageCover", layout.total, Dim );
    forEach(
        "Machpoint::imageCover", layout.total,
        MACHPOINT_LAMBDA( const int row ) {
            const auto x =
                layout.position( layout.home( layout.indices( row ) ) );
            for ( int a = 0; a < Dim; ++a )
            {
                const auto part = cover.behind( x, a );
                no_gap( row, a ) = part.no_gap;
                filled( row, a ) = part.filled;
            }
        } );
    // Of a node the part of each face behind it that is missing, and its axes
    // beside a face that lacks too much: it would see a vacuum there.
    const IndexList axes( "Machpoint::heldAxes", layout.total );
    forEach(
        "Machpoint::heldAxes", layout.total, MACHPOINT_LAMBDA( const int row ) {
            const auto i = layout.indices( row );
            const auto x = layout.position( layout.home( i ) );
            if ( cover.bodies.shape.distance( x ) < -cover.sight() )
                return; // no particle sees it
            for ( int a = 0; a < Dim; ++a )
            {
                auto before = i;
                --before[a];
                const Real least = Kokkos::min(
                    filled( row, a ),
                    i[a] > layout.lowest( a )
                        ? filled( row - layout.stride[a], a )
                        : cover
                              .behind( layout.position( layout.home( before ) ),
                                       a )
                              .filled );
                if ( least < least_cover )
                    axes( row ) |= 1 << a;
            }
        } );
    gaps.nodes = collect(
        "Machpoint::imageGaps", layout.total,
        MACHPOINT_LAMBDA( const int row ) {
            bool lacks = axes( row ) != 0;
            for ( int a = 0; a < Dim; ++a )
                lacks = lacks || no_gap( row, a ) < 1;
            return lacks;
        } );
    const int count = gaps.nodes.extent_int( 0 );
    gaps.missing = NodeView( "Machpoint::missingImages", count, Dim );
    gaps.held_axes = IndexList( "Machpoint::heldAxes", count );
    const auto list = gaps;
    forEach(
        "Machpoint::imageGaps", count, MACHPOINT_LAMBDA( const int k ) {
            const int row = list.nodes( k );
            list.held_axes( k ) = axes( row );
            for ( int a = 0; a < Dim; ++a )
                list.missing( k, a ) = 1 - no_gap( row, a );
        } );
    return gaps;
}

} // namespace Machpoint

#endif
