/*!
  \file periodic.hpp
  \brief What leaves through one side comes back through the opposite one.
*/
#ifndef MACHPOINT_PERIODIC_HPP
#define MACHPOINT_PERIODIC_HPP

#include <boundary/side.hpp>

#include <vector>

namespace Machpoint
{

//! One of two opposite periodic sides; the input names both.
template <int Dim>
class Periodic : public Module<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "periodic";
    using KeepsUniformGas = Periodic;

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

    static std::vector<SideClaim> sides( const Json& entry )
    {
        return { { sideNumber( entry.at( "side" ) ), SideKind::periodic } };
    }
    static GasState beyond( const Json&, int, const GasState& gas )
    {
        return gas;
    }
    //! @}

    //! The upper side acts for both.
    void applyToParticles( State<Dim>& state ) override
    {
        const int axis = _side / 2;
        if ( _side % 2 == 0 )
            return;
        const auto x = state.particles.template slice<Position>();
        const Real lower = state.grid.lower[axis];
        const Real upper = state.grid.upper[axis];
        const Real length = upper - lower;
        const auto rows = state.leavers;
        forEach(
            "Machpoint::periodic", rows.extent_int( 0 ),
            MACHPOINT_LAMBDA( const int k ) {
                Real& place = x( rows( k ), axis );
                if ( place >= lower && place < upper )
                    return;
                const Real s = place - lower;
                const Real moved = place < lower ? s + length : s - length;
                // -1e-17 + length rounds to length, which has no cell.
                place = moved < length ? lower + moved : lower;
            } );
    }

  private:
    int _side;
};

} // namespace Machpoint

#endif
