/*!
  \file shape_input.hpp
  \brief Shapes as an input has them: declared, checked and made, on the host.
*/
#ifndef MACHPOINT_SHAPE_INPUT_HPP
#define MACHPOINT_SHAPE_INPUT_HPP

#include <core/gas_state.hpp>
#include <core/parameters.hpp>
#include <core/shape.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief The outline of a NACA 4-digit aerofoil, counter-clockwise from the
  trailing edge over the upper side.

  The last thickness coefficient is -0.1036 in place of -0.1015, which closes
  the trailing edge. Stations are spaced by the cosine rule, 200 a side.

  \param resolved `digits` (camber in % of the chord, its position in tenths,
  thickness in %), `chord`, `leading_edge` [2], and `angle`: degrees, positive
  with the nose up in a stream along +x, turning about the leading edge.
  \return [400][2] vertices.
  Source: E. N. Jacobs, K. E. Ward and R. M. Pinkerton, NACA Report 460, 1933.
*/
inline std::vector<Vector<2>> naca4Outline( const Json& resolved )
{
    const std::string digits = resolved.at( "digits" ).get<std::string>();
    const Real camber = 0.01 * ( digits.at( 0 ) - '0' );
    const Real position = 0.1 * ( digits.at( 1 ) - '0' );
    const Real thickness = 0.01 * std::stoi( digits.substr( 2 ) );
    const Real chord = resolved.at( "chord" ).get<Real>();
    const Real angle =
        resolved.at( "angle" ).get<Real>() * std::numbers::pi / 180;
    const auto nose = toVector<2>( resolved.at( "leading_edge" ) );

    // side: 1 above the camber line, -1 below it
    const auto vertex = [&]( Real x, int side ) -> Vector<2>
    {
        Real line = 0, slope = 0;
        if ( camber > 0 )
        {
            // Two parabolas meet where the camber is greatest.
            const Real run = x < position ? position : 1 - position;
            line = camber * ( 1 - std::pow( ( x - position ) / run, 2 ) );
            slope = 2 * camber * ( position - x ) / ( run * run );
        }
        const Real half =
            5 * thickness *
            ( 0.2969 * std::sqrt( x ) +
              x * ( -0.1260 + x * ( -0.3516 + x * ( 0.2843 - x * 0.1036 ) ) ) );
        const Real offset = side * half / std::sqrt( 1 + slope * slope );
        const Real px = chord * ( x - offset * slope );
        const Real py = chord * ( line + offset );
        return { nose[0] + std::cos( angle ) * px + std::sin( angle ) * py,
                 nose[1] - std::sin( angle ) * px + std::cos( angle ) * py };
    };

    const int stations = 200;
    std::vector<Vector<2>> outline;
    for ( int i = -stations; i < stations; ++i )
    {
        const Real x =
            0.5 * ( 1 - std::cos( std::numbers::pi * i / stations ) );
        outline.push_back( vertex( x, i < 0 ? 1 : -1 ) );
    }
    return outline;
}

/*!
  \brief The circle around some vertices' bounding box centre.
  \param vertices [n][Dim]
  \param first, last The range [first, last).
*/
template <int Dim, class Memory>
typename Shape<Dim, Memory>::Arc
makeArc( const std::vector<Vector<Dim>>& vertices, int first, int last )
{
    Vector<Dim> lower = vertices[first], upper = vertices[first];
    for ( int v = first; v < last; ++v )
        for ( int d = 0; d < Dim; ++d )
        {
            lower[d] = std::min( lower[d], vertices[v][d] );
            upper[d] = std::max( upper[d], vertices[v][d] );
        }
    typename Shape<Dim, Memory>::Arc arc = { {}, 0, first, last - 1 };
    for ( int d = 0; d < Dim; ++d )
        arc.center[d] = 0.5_rt * ( lower[d] + upper[d] );
    for ( int v = first; v < last; ++v )
    {
        Real square = 0;
        for ( int d = 0; d < Dim; ++d )
            square += std::pow( vertices[v][d] - arc.center[d], 2 );
        arc.radius = std::max( arc.radius, std::sqrt( square ) );
    }
    return arc;
}

/*!
  \brief Builds the device shape of a resolved input object.

  \param resolved A shape with all defaults filled in, that shapeFamily()
  accepts and checkShape() finds nothing wrong with.
  \throws std::invalid_argument for a type that the dimension does not have.
*/
template <int Dim, class Memory = MemorySpace>
Shape<Dim, Memory> makeShape( const Json& resolved )
{
    using Kind = typename Shape<Dim, Memory>::Kind;
    std::vector<typename Shape<Dim, Memory>::Solid> solids;
    std::vector<typename Shape<Dim, Memory>::Arc> arcs;
    std::vector<Vector<Dim>> vertices;

    // Sixteen edges an arc keeps both loops of a query short.
    constexpr int edges_per_arc = 16;
    [[maybe_unused]] const auto addPolygon =
        [&]( std::vector<Vector<Dim>> outline )
    {
        outline.push_back( outline.front() );
        const int begin = static_cast<int>( vertices.size() );
        vertices.insert( vertices.end(), outline.begin(), outline.end() );
        const int end = static_cast<int>( vertices.size() );

        const auto around = makeArc<Dim, Memory>( vertices, begin, end );
        const int first_arc = static_cast<int>( arcs.size() );
        for ( int v = begin; v < end - 1; v += edges_per_arc )
            arcs.push_back( makeArc<Dim, Memory>(
                vertices, v, std::min( v + edges_per_arc + 1, end ) ) );
        solids.push_back( { Kind::polygon,
                            around.center,
                            {},
                            around.radius,
                            first_arc,
                            static_cast<int>( arcs.size() ) } );
    };

    const std::function<void( const Json& )> add = [&]( const Json& shape )
    {
        const std::string type = shape.at( "type" ).get<std::string>();
        if ( type == "union" )
        {
            for ( const Json& member : shape.at( "shapes" ) )
                add( member );
            return;
        }
        if ( type == "sphere" )
        {
            solids.push_back( { Kind::sphere,
                                toVector<Dim>( shape.at( "center" ) ),
                                {},
                                shape.at( "radius" ).get<Real>(),
                                0,
                                0 } );
            return;
        }
        if ( type == "box" )
        {
            solids.push_back( { Kind::box, toVector<Dim>( shape.at( "lower" ) ),
                                toVector<Dim>( shape.at( "upper" ) ), 0, 0,
                                0 } );
            return;
        }
        if ( type == "half_space" )
        {
            auto normal = toVector<Dim>( shape.at( "normal" ) );
            Real square = 0;
            for ( int d = 0; d < Dim; ++d )
                square += normal[d] * normal[d];
            for ( int d = 0; d < Dim; ++d )
                normal[d] /= std::sqrt( square );
            solids.push_back( { Kind::half_space,
                                toVector<Dim>( shape.at( "point" ) ), normal, 0,
                                0, 0 } );
            return;
        }
        if constexpr ( Dim == 2 )
        {
            if ( type == "polygon" )
            {
                std::vector<Vector<2>> outline;
                for ( const Json& point : shape.at( "vertices" ) )
                    outline.push_back( toVector<2>( point ) );
                addPolygon( outline );
                return;
            }
            if ( type == "naca4" )
            {
                addPolygon( naca4Outline( shape ) );
                return;
            }
        }
        throw std::invalid_argument( "there is no shape \"" + type + "\" in " +
                                     std::to_string( Dim ) + "D" );
    };
    add( resolved );
    return { solids, arcs, vertices };
}

//---------------------------------------------------------------------------//
// Declaration and checks
//---------------------------------------------------------------------------//
/*!
  \brief What is wrong with a closed outline, or an empty string.

  Tested in this order: number of vertices, edges without a length, edges that
  meet where they should not, orientation.

  \param outline [n][2] vertices; the first is not repeated at the end.
*/
inline std::string outlineError( const std::vector<Vector<2>>& outline )
{
    using std::to_string;
    const int n = static_cast<int>( outline.size() );
    if ( n < 3 )
        return "a polygon needs at least 3 vertices, not " + to_string( n );

    const auto vertex = [&]( int v ) -> const Vector<2>&
    { return outline[v % n]; };
    // Twice the signed area of a triangle: positive counter-clockwise.
    const auto turn =
        []( const Vector<2>& a, const Vector<2>& b, const Vector<2>& c )
    {
        return ( b[0] - a[0] ) * ( c[1] - a[1] ) -
               ( b[1] - a[1] ) * ( c[0] - a[0] );
    };
    const auto distance = []( const Vector<2>& a, const Vector<2>& b )
    { return std::hypot( b[0] - a[0], b[1] - a[1] ); };

    for ( int v = 0; v < n; ++v )
        if ( !( distance( vertex( v ), vertex( v + 1 ) ) > 0 ) )
            return "vertices " + to_string( v ) + " and " +
                   to_string( ( v + 1 ) % n ) + " are the same point" +
                   ( v == n - 1 ? "; the polygon closes by itself" : "" );

    for ( int v = 0; v < n; ++v )
    {
        const auto &a = vertex( v ), &b = vertex( v + 1 ), &c = vertex( v + 2 );
        const Real size = distance( a, b ) * distance( b, c );
        const Real along = ( b[0] - a[0] ) * ( c[0] - b[0] ) +
                           ( b[1] - a[1] ) * ( c[1] - b[1] );
        // A spike this thin has no inside.
        if ( along < 0 && std::abs( turn( a, b, c ) ) <= round_off * size )
            return "the outline turns back on itself at vertex " +
                   to_string( ( v + 1 ) % n );
    }

    const auto overlap = []( const Vector<2>& a, const Vector<2>& b,
                             const Vector<2>& c, const Vector<2>& d )
    {
        for ( int k = 0; k < 2; ++k )
            if ( std::max( a[k], b[k] ) < std::min( c[k], d[k] ) ||
                 std::max( c[k], d[k] ) < std::min( a[k], b[k] ) )
                return false;
        return true;
    };
    for ( int v = 0; v < n; ++v )
        for ( int w = v + 2; w < n; ++w )
        {
            if ( v == 0 && w == n - 1 )
                continue; // these two are neighbours
            const auto &a = vertex( v ), &b = vertex( v + 1 );
            const auto &c = vertex( w ), &d = vertex( w + 1 );
            // They meet when neither lies on one side of the other's line.
            if ( overlap( a, b, c, d ) &&
                 turn( a, b, c ) * turn( a, b, d ) <= 0 &&
                 turn( c, d, a ) * turn( c, d, b ) <= 0 )
                return "edges " + to_string( v ) + "-" + to_string( v + 1 ) +
                       " and " + to_string( w ) + "-" +
                       to_string( ( w + 1 ) % n ) +
                       " meet; the outline may not cross or touch itself";
        }

    Real area = 0;
    for ( int v = 1; v + 1 < n; ++v )
        area += turn( vertex( 0 ), vertex( v ), vertex( v + 1 ) );
    if ( !( area > 0 ) )
        return "the vertices run clockwise; list them counter-clockwise";
    return "";
}

/*!
  \brief Reports what the declared ranges cannot: reversed boxes, zero normals,
  broken outlines, impossible aerofoils.

  \param resolved A shape that shapeFamily() accepts, defaults filled in.
  \param where Its place in the input, for example "/boundary/4/shape".
  \param[in,out] errors One line is added for each finding: "place: what".
*/
inline void checkShape( const Json& resolved, const std::string& where,
                        std::vector<std::string>& errors )
{
    const std::string type = resolved.at( "type" ).get<std::string>();
    const auto report = [&]( const std::string& key, const std::string& what )
    {
        if ( !what.empty() )
            errors.push_back( where + "/" + key + ": " + what );
    };

    if ( type == "box" )
    {
        const Json& lower = resolved.at( "lower" );
        const Json& upper = resolved.at( "upper" );
        for ( std::size_t d = 0; d < lower.size(); ++d )
            if ( !( lower[d].get<Real>() < upper.at( d ).get<Real>() ) )
                report( "upper/" + std::to_string( d ),
                        "must be greater than lower (" + lower[d].dump() +
                            "), not " + upper[d].dump() );
    }
    else if ( type == "half_space" )
    {
        Real square = 0;
        for ( const Json& component : resolved.at( "normal" ) )
            square += std::pow( component.get<Real>(), 2 );
        if ( !( square > 0 && std::isfinite( square ) ) )
            report( "normal", "must have a direction, and neither be zero nor "
                              "too large to square" );
    }
    else if ( type == "polygon" )
    {
        std::vector<Vector<2>> outline;
        for ( const Json& point : resolved.at( "vertices" ) )
            outline.push_back( toVector<2>( point ) );
        report( "vertices", outlineError( outline ) );
    }
    else if ( type == "naca4" )
    {
        const std::string digits = resolved.at( "digits" ).get<std::string>();
        if ( digits.size() != 4 ||
             digits.find_first_not_of( "0123456789" ) != std::string::npos )
            report( "digits", "must be four digits, not \"" + digits + "\"" );
        else if ( digits.substr( 2 ) == "00" )
            report( "digits", "the last two are the thickness in % of the "
                              "chord and may not be 00" );
        else if ( digits[0] != '0' && digits[1] == '0' )
            report( "digits", "the second is the position of the camber and "
                              "may not be 0 where the first is not" );
        else
            report( "digits", outlineError( naca4Outline( resolved ) ) );
    }
    else if ( type == "union" )
    {
        const Json& members = resolved.at( "shapes" );
        for ( std::size_t s = 0; s < members.size(); ++s )
            checkShape( members[s], where + "/shapes/" + std::to_string( s ),
                        errors );
    }
}

//! Every shape and its declared parameters, for the input's `shape` and
//! `region`.
inline Family shapeFamily()
{
    const auto members = []( int dimension )
    {
        std::vector<Parameters> shapes;

        Parameters sphere( "sphere", "ball; a disc in 2D and an interval in 1D",
                           dimension );
        sphere.vector( "center", "centre" ).unit( "length" );
        sphere.number( "radius", "radius" ).unit( "length" ).above( 0 );
        shapes.push_back( sphere );

        Parameters box( "box", "box with its sides along the axes", dimension );
        box.vector( "lower", "lower corner" ).unit( "length" );
        box.vector( "upper", "upper corner" ).unit( "length" );
        shapes.push_back( box );

        Parameters half_space( "half_space",
                               "everything behind a point, line or plane",
                               dimension );
        half_space.vector( "point", "a point of the surface" ).unit( "length" );
        half_space.vector( "normal", "direction out of the solid, into the "
                                     "gas; of any length" );
        shapes.push_back( half_space );

        // Dimension 0 asks for the shapes of every dimension.
        if ( dimension == 0 || dimension == 2 )
        {
            Parameters polygon( "polygon", "closed polygon", 2 );
            polygon
                .points( "vertices", "corners, counter-clockwise; the first "
                                     "is not repeated" )
                .unit( "length" )
                .nonEmpty();
            shapes.push_back( polygon );

            Parameters naca4( "naca4", "NACA 4-digit aerofoil", 2 );
            naca4
                .text( "digits", "camber in % of the chord, its position in "
                                 "tenths, thickness in % (two digits)" )
                .source( "Jacobs, Ward and Pinkerton, NACA Report 460, 1933" );
            naca4.number( "chord", "length from nose to tail" )
                .unit( "length" )
                .above( 0 )
                .defaultsTo( 1 );
            naca4.vector( "leading_edge", "the nose, which it turns about" )
                .unit( "length" );
            naca4
                .number( "angle", "angle of attack in a stream along +x, "
                                  "positive with the nose up" )
                .unit( "degree" )
                .atLeast( -180 )
                .atMost( 180 )
                .defaultsTo( 0 );
            shapes.push_back( naca4 );
        }

        Parameters all( "union", "several shapes as one", dimension );
        all.listOf( "shapes", shapeFamily(), "the members" ).nonEmpty();
        shapes.push_back( all );
        return shapes;
    };
    return { "shape", members };
}

} // namespace Machpoint

#endif
