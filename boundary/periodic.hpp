/*!
  \file periodic.hpp
  \brief What leaves through one side comes back through the opposite one.
*/
#ifndef MACHPOINT_PERIODIC_HPP
#define MACHPOINT_PERIODIC_HPP

#include <boundary/side.hpp>

namespace Machpoint
{

//! One of two opposite periodic sides; the input names both.
template <int Dim>
class Periodic : public Module<Dim>
{
  public:
    static constexpr const char* name = "periodic";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "the opposite side continues the domain",
                      dimension );
        p.choice( "side", sideNames( dimension ),
                  "side of the domain; the opposite one must be periodic too" );
        return p;
    }

    explicit Periodic( const Json& json )
        : _side( sideNumber( json.at( "side" ) ) )
    {
    }

    std::vector<SideClaim> sides() const override
    {
        return { { _side, SideKind::periodic } };
    }

    int applyToParticles( State<Dim>& state ) override
    {
        const auto x = state.particles.template slice<Position>();
        const int axis = _side / 2;
        const bool upper = _side % 2 == 1;
        const Real lower = state.grid.lower[axis];
        const Real length = state.grid.upper[axis] - lower;
        Kokkos::parallel_for(
            "Machpoint::periodic", Range( 0, state.particles.size() ),
            KOKKOS_LAMBDA( const int p ) {
                Real s = x( p, axis ) - lower;
                if ( upper ? s >= length : s < 0 )
                {
                    s += upper ? -length : length;
                    // -1e-17 + length rounds to length, which has no cell.
                    x( p, axis ) = s < length ? lower + s : lower;
                }
            } );
        return 0;
    }

  private:
    int _side;
};

} // namespace Machpoint

#endif
