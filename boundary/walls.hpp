/*!
  \file walls.hpp
  \brief Slip and no-slip walls: the grid mirrors the gas (core/halo.hpp); a
  particle that a long step carried beyond is reflected, its affine field, too.
*/
#ifndef MACHPOINT_WALLS_HPP
#define MACHPOINT_WALLS_HPP

#include <boundary/side.hpp>

#include <vector>

namespace Machpoint
{

//! A wall on a side. \tparam Kind SideKind::slip or SideKind::no_slip
template <int Dim, SideKind Kind>
class Wall : public SideBoundary<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name =
        Kind == SideKind::slip ? "slip_wall" : "no_slip_wall";
    using KeepsUniformGas = Wall;

    static Parameters declare( const int dimension )
    {
        Parameters p( name,
                      Kind == SideKind::slip
                          ? "wall without friction, or plane of symmetry"
                          : "wall to which the gas sticks",
                      dimension );
        SideBoundary<Dim>::declareSide( p );
        return p;
    }

    explicit Wall( const Json& json ) : SideBoundary<Dim>( json ) {}

    static std::vector<SideClaim> sides( const Json& entry )
    {
        return { { sideNumber( entry.at( "side" ) ), Kind } };
    }
    //! The mirrored gas: what meets a wall meets itself.
    static GasState beyond( const Json&, const int side, GasState gas )
    {
        for ( int d = 0; d < Dim; ++d )
            if ( Kind == SideKind::no_slip || d == side / 2 )
                gas.velocity[d] = -gas.velocity[d];
        return gas;
    }
    //! @}

    void applyToParticles( State<Dim>& state ) override
    {
        const auto x = state.particles.template slice<Position>();
        const auto v = state.particles.template slice<Velocity>();
        const auto C = state.particles.template slice<VelocityGradient>();
        const bool drifts = state.drift;
        const auto extra = sliceOfDrift<ExtraVelocity>( state );
        const auto part = this->_part;
        const auto grid = state.grid;
        const int axis = part.axis();
        const Real lower = grid.lower[axis];
        const Real inside = justInside( lower, grid.upper[axis] );
        const auto rows = state.leavers;
        forEach(
            "Machpoint::wall", rows.extent_int( 0 ),
            MACHPOINT_LAMBDA( const int k ) {
                const int p = rows( k );
                const auto y = loadVector<Dim>( x, p );
                const Real depth = part.depth( grid, y );
                // What is beyond the other side is that one's.
                if ( ( part.upper() ? y[axis] <= inside : depth >= 0 ) ||
                     !part.contains( grid, y ) )
                    return;
                if ( depth < 0 )
                {
                    x( p, axis ) += part.upper() ? 2 * depth : -2 * depth;
                    v( p, axis ) = -v( p, axis );
                    if ( drifts )
                        extra( p, axis ) = -extra( p, axis );
                    for ( int d = 0; d < Dim; ++d )
                        if ( d != axis )
                        {
                            C( p, axis, d ) = -C( p, axis, d );
                            C( p, d, axis ) = -C( p, d, axis );
                        }
                }
                // A position on the upper side would have no cell.
                x( p, axis ) = Kokkos::clamp( x( p, axis ), lower, inside );
            } );
    }
};

//! Wall without friction, or plane of symmetry.
template <int Dim>
using SlipWall = Wall<Dim, SideKind::slip>;

//! Wall to which the gas sticks.
template <int Dim>
using NoSlipWall = Wall<Dim, SideKind::no_slip>;

} // namespace Machpoint

#endif
