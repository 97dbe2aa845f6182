/*!
  \file outflow.hpp
  \brief Gas leaves; beyond the side the same gas goes on (zero gradient).
*/
#ifndef MACHPOINT_OUTFLOW_HPP
#define MACHPOINT_OUTFLOW_HPP

#include <boundary/side.hpp>

namespace Machpoint
{

namespace Impl
{
//! Marks the particles beyond part of a side for removal and adds their mass
//! to the ledger.
template <int Dim>
void markBeyond( State<Dim>& state, const SidePart<Dim>& part )
{
    const auto x = state.particles.template slice<Position>();
    const auto m = state.particles.template slice<Mass>();
    const auto id = state.particles.template slice<Id>();
    const auto grid = state.grid;
    ReproducibleSum mass;
    const auto rows = state.leavers;
    reduceEach(
        "Machpoint::outflow", rows.extent_int( 0 ), few_particles,
        MACHPOINT_LAMBDA( const int k, ReproducibleSum& mass_sum ) {
            const int p = rows( k );
            const auto y = loadVector<Dim>( x, p );
            const Real depth = part.depth( grid, y );
            // On the upper side itself is beyond: it has no cell.
            if ( depth > 0 || ( depth == 0 && !part.upper() ) || id( p ) < 0 ||
                 !part.contains( grid, y ) )
                return;
            mass_sum += m( p );
            id( p ) = -1;
        },
        mass );
    state.ledger.mass_out += mass;
}
} // namespace Impl

//! Outflow: exact for supersonic flow, weakly reflecting for subsonic.
template <int Dim>
class Outflow : public SideBoundary<Dim>
{
  public:
    static constexpr const char* name = "outflow";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "gas leaves; zero gradient beyond the side",
                      dimension );
        SideBoundary<Dim>::declareSide( p );
        return p;
    }

    explicit Outflow( const Json& json ) : SideBoundary<Dim>( json ) {}

    static std::vector<SideClaim> sides( const Json& entry )
    {
        return { { sideNumber( entry.at( "side" ) ), SideKind::open } };
    }
    static GasState beyond( const Json&, int, const GasState& gas )
    {
        return gas;
    }
    bool isOpen() const override { return true; }

    void applyToParticles( State<Dim>& state ) override
    {
        Impl::markBeyond( state, this->_part );
    }
};

} // namespace Machpoint

#endif
