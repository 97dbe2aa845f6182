/*!
  \file side.hpp
  \brief What boundaries of a side of the domain have in common: which side,
  and which part of it.
*/
#ifndef MACHPOINT_SIDE_HPP
#define MACHPOINT_SIDE_HPP

#include <core/module.hpp>
#include <core/shape_input.hpp>

namespace Machpoint
{

//! A side of the domain, or the part of it inside a region.
template <int Dim>
struct SidePart
{
    int side = 0;           //!< 2 * axis + (upper ? 1 : 0)
    bool everywhere = true; //!< no region: the whole side
    Shape<Dim> region;      //!< otherwise, the part inside this shape

    //! Of its normal, 0 to Dim - 1.
    KOKKOS_INLINE_FUNCTION int axis() const { return side / 2; }
    //! At the upper end of that axis?
    KOKKOS_INLINE_FUNCTION bool upper() const { return side % 2 == 1; }

    //! Position of the side along its normal, length.
    KOKKOS_INLINE_FUNCTION Real place( const Grid<Dim>& grid ) const
    {
        return upper() ? grid.upper[axis()] : grid.lower[axis()];
    }

    //! Distance of x from the side, length, positive inside the domain.
    //! \param x [Dim]
    KOKKOS_INLINE_FUNCTION Real depth( const Grid<Dim>& grid,
                                       const Vector<Dim>& x ) const
    {
        const Real d = x[axis()] - place( grid );
        return upper() ? -d : d;
    }

    //! The same of particles, or packs. \param x coordinate along its axis
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION Number depthOf( const Grid<Dim>& grid,
                                                const Number& x ) const
    {
        const Number d = x - place( grid );
        return upper() ? Number( -d ) : d;
    }

    //! Is the place of the side nearest to x part of it? \param x [Dim]
    KOKKOS_INLINE_FUNCTION bool contains( const Grid<Dim>& grid,
                                          Vector<Dim> x ) const
    {
        if ( everywhere )
            return true;
        // Along other axes x may be beyond the domain, too, and a region end at
        // its edge. A hair further, as claimSides: a seam belongs to one.
        const Real hair = nudge * grid.minSpacing();
        for ( int d = 0; d < Dim; ++d )
            x[d] = Kokkos::clamp( x[d] + hair, grid.lower[d] + hair,
                                  grid.upper[d] - hair );
        x[axis()] = place( grid );
        return region.distance( x ) < 0;
    }
};

//! Base of the boundaries that take a side.
template <int Dim>
class SideBoundary : public Module<Dim>
{
  public:
    //! Declares the keys `side` and `region`.
    static void declareSide( Parameters& p )
    {
        p.choice( "side", sideNames( p.dimension() ),
                  "side of the domain that this boundary takes" );
        p.oneOf( "region", shapeFamily(),
                 "take only the part of the side inside this shape" )
            .optional();
    }

    //! \param json resolved, with the keys of declareSide
    explicit SideBoundary( const Json& json )
    {
        _part.side = sideNumber( json.at( "side" ) );
        if ( json.contains( "region" ) )
        {
            _part.everywhere = false;
            _part.region = makeShape<Dim, MemorySpace>( json.at( "region" ) );
            _host_region =
                makeShape<Dim, Kokkos::HostSpace>( json.at( "region" ) );
        }
    }

    bool covers( const Vector<Dim>& x ) const override
    {
        return _part.everywhere || _host_region.distance( x ) < 0;
    }

  protected:
    //! For kernels.
    SidePart<Dim> _part;

  private:
    Shape<Dim, Kokkos::HostSpace> _host_region;
};

} // namespace Machpoint

#endif
