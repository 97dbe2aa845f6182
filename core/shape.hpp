/*!
  \file shape.hpp
  \brief Signed-distance shapes for obstacles and regions.

  A shape is a flat list of solids (sphere, box, half space, polygon); a union,
  however deeply nested, is only a longer list. Lengths carry the unit of the
  grid.
*/
#ifndef MACHPOINT_SHAPE_HPP
#define MACHPOINT_SHAPE_HPP

#include <core/types.hpp>

#include <Kokkos_Core.hpp>

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

//! Where a point stands with respect to the surface of a shape.
template <int Dim>
struct Nearest
{
    //! Signed distance: positive in the gas, negative in the shape.
    Real distance;
    //! Gradient of the distance: a unit vector that points into the gas.
    Vector<Dim> normal;
};

//---------------------------------------------------------------------------//
// On the device
//---------------------------------------------------------------------------//
/*!
  \brief A signed-distance shape; copy it into a kernel like a View.

  The distance is exact everywhere for a single solid. For a union it is the
  least of the members' distances: exact in the gas, and a bound of the depth
  where members overlap. A shape without solids is infinitely far away.

  \tparam Dim 1, 2 or 3.
  \tparam Memory Where the data lie; pass Kokkos::HostSpace to makeShape() for
  a shape that host code evaluates whatever the backend is.
*/
template <int Dim, class Memory = MemorySpace>
class Shape
{
  public:
    //! The kinds of solid that a shape is made of.
    enum class Kind
    {
        sphere,
        box,
        half_space,
        polygon
    };

    //! One solid; which members count depends on its kind.
    struct Solid
    {
        Kind kind;
        //! Centre (sphere; polygon: of the bounding circle), lower corner
        //! (box), or a point of the surface (half space).
        Vector<Dim> a;
        //! Upper corner (box) or outward unit normal (half space).
        Vector<Dim> b;
        //! Radius (sphere; polygon: of the bounding circle).
        Real radius;
        //! A polygon's range of arcs, begin to end - 1.
        int begin, end;
    };

    /*!
      \brief Some consecutive edges of a polygon and a circle around them.

      Edge v runs from vertex v to v + 1, for first <= v < last; a polygon's
      first vertex is repeated after its last one. Most queries touch the
      edges of one or two arcs only.
    */
    struct Arc
    {
        Vector<Dim> center; //!< of the circle
        Real radius;        //!< of the circle
        int first, last;    //!< vertices
    };

    //! The empty shape.
    Shape() = default;

    //! From host lists; makeShape() is the usual way. \see outlineArcs
    Shape( const std::vector<Solid>& solids, const std::vector<Arc>& arcs,
           const std::vector<Vector<Dim>>& vertices )
        : _solids( copy( solids, "Machpoint::shape_solids" ) ),
          _arcs( copy( arcs, "Machpoint::shape_arcs" ) ),
          _vertices( copy( vertices, "Machpoint::shape_vertices" ) )
    {
    }

    //! Number of solids; the members of a union follow each other.
    KOKKOS_FUNCTION int size() const
    {
        return static_cast<int>( _solids.extent( 0 ) );
    }

    //! Signed distance and normal at x [Dim] in one search.
    KOKKOS_FUNCTION Nearest<Dim> nearest( const Vector<Dim>& x ) const
    {
        return nearest( x, 0, size() );
    }
    //! The same of solids begin to end - 1 alone.
    KOKKOS_FUNCTION Nearest<Dim> nearest( const Vector<Dim>& x, const int begin,
                                          const int end ) const
    {
        Nearest<Dim> result = { Kokkos::Experimental::finite_max_v<Real>,
                                unitVector() };
        for ( int s = begin; s < end; ++s )
        {
            const Solid& solid = _solids( s );
            // Polygons are the one costly kind, so pass by the farther ones.
            if ( solid.kind == Kind::polygon &&
                 bound( solid, x ) >= result.distance )
                continue;
            const Nearest<Dim> candidate = nearest( solid, x );
            if ( candidate.distance < result.distance )
                result = candidate;
        }
        return result;
    }

    //! Signed distance: positive in the gas, negative in the shape.
    KOKKOS_FUNCTION Real distance( const Vector<Dim>& x ) const
    {
        return nearest( x ).distance;
    }

    /*!
      \brief Outward unit normal: the gradient of the distance.

      Where the gradient is not unique it is, at an edge of a box or below it
      and at a polygon's vertex, the mean of the faces' normals, elsewhere (the
      centre of a sphere, the ridges inside a polygon) one of the candidates.
    */
    KOKKOS_FUNCTION Vector<Dim> normal( const Vector<Dim>& x ) const
    {
        return nearest( x ).normal;
    }

    /*!
      \brief Does `visit( Nearest )` say true for a part of the surface of
      solids begin to end - 1?

      For each sphere and half space, the plane of each face of a box and the
      line of each edge of a polygon: also those that others cover, or that are
      not the nearest.
    */
    template <class Visit>
    KOKKOS_FUNCTION bool anyPart( const Vector<Dim>& x, const int begin,
                                  const int end, const Visit& visit ) const
    {
        for ( int s = begin; s < end; ++s )
        {
            const Solid& solid = _solids( s );
            if ( solid.kind == Kind::box )
            {
                for ( int d = 0; d < Dim; ++d )
                {
                    Vector<Dim> normal{};
                    normal[d] = 1;
                    if ( visit( { x[d] - solid.b[d], normal } ) )
                        return true;
                    normal[d] = -1;
                    if ( visit( { solid.a[d] - x[d], normal } ) )
                        return true;
                }
            }
            else if ( solid.kind != Kind::polygon )
            {
                if ( visit( nearest( solid, x ) ) )
                    return true;
            }
            else if constexpr ( Dim == 2 )
            {
                for ( int a = solid.begin; a < solid.end; ++a )
                    for ( int v = _arcs( a ).first; v < _arcs( a ).last; ++v )
                    {
                        const auto normal = edgeNormal( v );
                        const auto r = difference( x, _vertices( v ) );
                        if ( visit( { dot<Dim>( r, normal ), normal } ) )
                            return true;
                    }
            }
        }
        return false;
    }

    /*!
      \brief A cheap lower bound of distance( x ), of particles or packs.

      Where it exceeds the reach of interest nothing else need be computed. A
      polygon answers with its bounding circle, a box with the largest of its
      axes' distances, the other solids with their distance.
    */
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION Number
    distanceBound( const Kokkos::Array<Number, Dim>& x ) const
    {
        Number result( Kokkos::Experimental::finite_max_v<Real> );
        for ( int s = 0; s < size(); ++s )
            result = Kokkos::min( result, bound( _solids( s ), x ) );
        return result;
    }

  private:
    Kokkos::View<const Solid*, Memory> _solids;
    Kokkos::View<const Arc*, Memory> _arcs;
    Kokkos::View<const Vector<Dim>*, Memory> _vertices;

    template <class T>
    static Kokkos::View<const T*, Memory> copy( const std::vector<T>& list,
                                                const std::string& label )
    {
        if ( list.empty() )
            return {};
        Kokkos::View<T*, Memory> view(
            Kokkos::view_alloc( label, Kokkos::WithoutInitializing ),
            list.size() );
        Kokkos::deep_copy(
            view, Kokkos::View<const T*, Kokkos::HostSpace,
                               Kokkos::MemoryTraits<Kokkos::Unmanaged>>(
                      list.data(), list.size() ) );
        return view;
    }

    KOKKOS_FUNCTION static Vector<Dim> difference( const Vector<Dim>& a,
                                                   const Vector<Dim>& b )
    {
        Vector<Dim> result;
        for ( int d = 0; d < Dim; ++d )
            result[d] = a[d] - b[d];
        return result;
    }

    KOKKOS_FUNCTION static Vector<Dim> scaled( Real factor,
                                               const Vector<Dim>& a )
    {
        Vector<Dim> result;
        for ( int d = 0; d < Dim; ++d )
            result[d] = factor * a[d];
        return result;
    }

    KOKKOS_FUNCTION static Real squaredDistance( const Vector<Dim>& a,
                                                 const Vector<Dim>& b )
    {
        const Vector<Dim> r = difference( a, b );
        return dot<Dim>( r, r );
    }

    KOKKOS_FUNCTION static Real length( const Vector<Dim>& a )
    {
        return Kokkos::sqrt( dot<Dim>( a, a ) );
    }

    //! The normal where every direction is as good as another.
    KOKKOS_FUNCTION static Vector<Dim> unitVector()
    {
        Vector<Dim> result;
        for ( int d = 0; d < Dim; ++d )
            result[d] = d == 0 ? 1 : 0;
        return result;
    }

    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static Number
    bound( const Solid& solid, const Kokkos::Array<Number, Dim>& x )
    {
        Number along( 0.0 ), square( 0.0 );
        Number across( -Kokkos::Experimental::finite_max_v<Real> );
        for ( int d = 0; d < Dim; ++d )
        {
            const Number r = x[d] - solid.a[d];
            along += solid.b[d] * r;
            square += r * r;
            across = Kokkos::max(
                across, Number( Kokkos::max( Number( -r ),
                                             Number( x[d] - solid.b[d] ) ) ) );
        }
        if ( solid.kind == Kind::half_space )
            return along;
        if ( solid.kind == Kind::box )
            return across;
        // The circle holds the polygon, so this also bounds negative distances.
        return Kokkos::sqrt( square ) - solid.radius;
    }

    KOKKOS_FUNCTION Nearest<Dim> nearest( const Solid& solid,
                                          const Vector<Dim>& x ) const
    {
        switch ( solid.kind )
        {
        case Kind::sphere:
            return nearestOnSphere( solid, x );
        case Kind::box:
            return nearestOnBox( solid, x );
        case Kind::half_space:
            return { dot<Dim>( solid.b, difference( x, solid.a ) ), solid.b };
        default:
            // Only makeShape<2> brings polygons.
            if constexpr ( Dim == 2 )
                return nearestOnPolygon( solid, x );
            else
                return { Kokkos::Experimental::finite_max_v<Real>,
                         unitVector() };
        }
    }

    KOKKOS_FUNCTION static Nearest<Dim> nearestOnSphere( const Solid& solid,
                                                         const Vector<Dim>& x )
    {
        const Vector<Dim> r = difference( x, solid.a );
        const Real l = length( r );
        return { l - solid.radius, l > 0 ? scaled( 1 / l, r ) : unitVector() };
    }

    KOKKOS_FUNCTION static Nearest<Dim> nearestOnBox( const Solid& solid,
                                                      const Vector<Dim>& x )
    {
        Vector<Dim> outside; // from the closest point of the box to x
        Vector<Dim> depth;   // below the closer of an axis's two faces
        Vector<Dim> side;
        Real least = Kokkos::Experimental::finite_max_v<Real>;
        Real far = 0;
        for ( int d = 0; d < Dim; ++d )
        {
            const Real below = solid.a[d] - x[d];
            const Real above = x[d] - solid.b[d];
            outside[d] = above > 0 ? above : ( below > 0 ? -below : 0 );
            depth[d] = -Kokkos::max( below, above );
            side[d] = above > below ? 1 : -1;
            least = Kokkos::min( least, depth[d] );
            far = Kokkos::max( far, Kokkos::abs( x[d] ) );
        }
        const Real l = length( outside );
        // Inside or on the surface the closest face decides; at an edge and
        // below it several do, whatever rounding makes of their distances.
        const Real rounding = round_off * ( far + Kokkos::abs( least ) );
        if ( !( l > rounding ) )
        {
            Vector<Dim> normal;
            for ( int d = 0; d < Dim; ++d )
                normal[d] = depth[d] - least <= rounding ? side[d] : 0;
            return { l > 0 ? l : -least,
                     scaled( 1 / length( normal ), normal ) };
        }
        return { l, scaled( 1 / l, outside ) };
    }

    KOKKOS_FUNCTION Vector<Dim> edge( int v ) const
    {
        return difference( _vertices( v + 1 ), _vertices( v ) );
    }

    //! The gas lies to the right of an edge, since the order is
    //! counter-clockwise.
    KOKKOS_FUNCTION Vector<Dim> edgeNormal( int v ) const
    {
        const Vector<Dim> e = edge( v );
        return scaled( 1 / length( e ), { e[1], -e[0] } );
    }

    /*!
      The sign comes from the closest edge or vertex: on an edge from the side
      of the point, at a vertex from the sum of the two edges' normals, which
      has a positive product with every outward and a negative one with every
      inward direction that the vertex is closest for (J. A. Baerentzen and
      H. Aanaes, 2005). Unlike a crossing count this needs no other edges.
    */
    KOKKOS_FUNCTION Nearest<Dim> nearestOnPolygon( const Solid& solid,
                                                   const Vector<Dim>& x ) const
    {
        // Any vertex bounds the distance; one of the arc with the closest
        // centre does so tightly. The margin keeps round-off from losing the
        // closest edge itself.
        int closest = _arcs( solid.begin ).first;
        Real least = Kokkos::Experimental::finite_max_v<Real>;
        for ( int a = solid.begin; a < solid.end; ++a )
        {
            const Real square = squaredDistance( x, _arcs( a ).center );
            if ( square < least )
            {
                least = square;
                closest = ( _arcs( a ).first + _arcs( a ).last ) / 2;
            }
        }
        least = squaredDistance( x, _vertices( closest ) ) * ( 1 + round_off );

        bool at_vertex = true;
        for ( int a = solid.begin; a < solid.end; ++a )
        {
            const Arc& arc = _arcs( a );
            const Real reach = Kokkos::sqrt( least ) + arc.radius;
            if ( squaredDistance( x, arc.center ) > reach * reach )
                continue;
            for ( int v = arc.first; v < arc.last; ++v )
            {
                const Vector<Dim> r = difference( x, _vertices( v ) );
                const Vector<Dim> e = edge( v );
                const Real along = dot<Dim>( r, e );
                const Real square = dot<Dim>( e, e );
                // Past its end the next edge is closer, or owns that vertex.
                if ( along >= square )
                    continue;
                const Real across = r[0] * e[1] - r[1] * e[0];
                if ( along > 0 && across * across < least * square )
                {
                    least = across * across / square;
                    closest = v;
                    at_vertex = false;
                }
                else if ( along <= 0 && dot<Dim>( r, r ) < least )
                {
                    least = dot<Dim>( r, r );
                    closest = v;
                    at_vertex = true;
                }
            }
        }

        const Vector<Dim> r = difference( x, _vertices( closest ) );
        Vector<Dim> normal = edgeNormal( closest );
        if ( !at_vertex )
            return { dot<Dim>( r, normal ), normal };

        const bool is_first = closest == _arcs( solid.begin ).first;
        const Vector<Dim> previous = edgeNormal(
            is_first ? _arcs( solid.end - 1 ).last - 1 : closest - 1 );
        for ( int d = 0; d < Dim; ++d )
            normal[d] += previous[d];
        const Real l = length( r );
        if ( !( l > 0 ) )
            return { 0, scaled( 1 / length( normal ), normal ) };
        const Real sign = dot<Dim>( r, normal ) < 0 ? -1 : 1;
        return { sign * l, scaled( sign / l, r ) };
    }
};

#if !defined( KOKKOS_ENABLE_CUDA ) && !defined( DOXYGEN )
// On a host, compiled once and as kernels are (cmake/modules.cpp.in), whoever
// else asks. A kernel of a GPU needs it in its own unit.
extern template Nearest<1>
Shape<1, Kokkos::HostSpace>::nearest( const Vector<1>&, int, int ) const;
extern template Nearest<2>
Shape<2, Kokkos::HostSpace>::nearest( const Vector<2>&, int, int ) const;
extern template Nearest<3>
Shape<3, Kokkos::HostSpace>::nearest( const Vector<3>&, int, int ) const;
#endif

} // namespace Machpoint

#endif
