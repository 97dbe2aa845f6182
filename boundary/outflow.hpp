/*!
  \file outflow.hpp
  \brief Gas leaves; beyond the side the same gas goes on (zero gradient).
*/
#ifndef MACHPOINT_OUTFLOW_HPP
#define MACHPOINT_OUTFLOW_HPP

#include <boundary/side.hpp>
#include <core/node_list.hpp>

#include <algorithm>
#include <string>
#include <vector>

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

/*!
  \brief Outflow: exact for supersonic flow, weakly reflecting for subsonic.

  Particles beyond the side are removed, and gas does not come back, as nobody
  knows which. The side is a valve: nodes next to it lose what velocity they
  have into the domain, v_n = min(v_n, 0) with n inwards, as on a wall. Without
  `valve` they are free, and a gap opens behind gas that moves in: so it must
  where this recedes faster than it can expand, 2 c / (gamma - 1).

  With a `pressure` the gas beyond is known. What leaves slower than sound, u
  outwards, then goes over to the velocity with which the wave that enters is
  that of the far gas, u' = u_far + (p - p_far) / (rho c) from 0 to c, within
  the time that sound takes through a cell (Thompson 1987, J. Comput. Phys. 68,
  1). Gas that rests or moves in takes the push that gas at rest has: no sign of
  a round-off decides.
*/
template <int Dim>
class Outflow : public SideBoundary<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "outflow";
    using KeepsUniformGas = Outflow;

    static Parameters declare( const int dimension )
    {
        Parameters p( name,
                      "gas leaves and does not come back; zero gradient "
                      "beyond the side",
                      dimension );
        SideBoundary<Dim>::declareSide( p );
        p.boolean( "valve", "does the side hold gas that would move in? false "
                            "where it recedes faster than it expands" )
            .defaultsTo( true );
        p.number( "pressure", "of the gas far beyond, which holds back what "
                              "leaves slower than sound" )
            .unit( "pressure" )
            .above( 0 )
            .optional();
        p.number( "velocity", "of the gas far beyond, out of the domain" )
            .unit( "length/time" )
            .defaultsTo( 0 );
        return p;
    }

    explicit Outflow( const Json& json )
        : SideBoundary<Dim>( json ), _is_valve( json.at( "valve" ) ),
          _far_velocity( json.at( "velocity" ) )
    {
        if ( json.contains( "pressure" ) )
            _far_pressure = json.at( "pressure" );
    }

    static std::vector<SideClaim> sides( const Json& entry )
    {
        return { { sideNumber( entry.at( "side" ) ), SideKind::open } };
    }
    //! The same gas, but with what is known of a far one, and behind a valve
    //! without a velocity into the domain.
    static GasState beyond( const Json& entry, int side, GasState gas )
    {
        auto& v = gas.velocity[side / 2];
        if ( entry.contains( "pressure" ) )
        {
            gas.pressure = entry.at( "pressure" );
            v = ( side % 2 ? 1 : -1 ) * entry.at( "velocity" ).get<double>();
        }
        if ( entry.at( "valve" ) )
            v = side % 2 ? std::max( v, 0.0 ) : std::min( v, 0.0 );
        return gas;
    }
    //! The velocity of a far gas without its pressure.
    static std::string fault( const Json& entry, const MethodFacts& )
    {
        return entry.at( "velocity" ) == 0 || entry.contains( "pressure" )
                   ? ""
                   : "/velocity: is that of gas far beyond, so it needs a "
                     "pressure, too";
    }
    //! @}

    //! Of the cells next to the side.
    bool particleSource( State<Dim>& state ) override
    {
        if ( _far_pressure == 0 )
            return false;
        const auto x = state.particles.template slice<Position>();
        const auto v = state.particles.template slice<Velocity>();
        const auto m = state.particles.template slice<Mass>();
        const auto V = state.particles.template slice<Volume>();
        const auto pressure = state.particles.template slice<Pressure>();
        const auto sound_speed = state.particles.template slice<SoundSpeed>();
        const auto grid = state.grid;
        const auto part = this->_part;
        const int axis = part.axis();
        const Real h = grid.spacing[axis];
        const Real outwards = part.upper() ? 1.0_rt : -1.0_rt;
        const Real far_pressure = _far_pressure;
        const Real far_velocity = _far_velocity;
        const Real dt = static_cast<Real>( state.dt );
        ReproducibleSum work;
        reduceEach(
            "Machpoint::farGas", state.particles.size(), few_particles,
            MACHPOINT_LAMBDA( const int p, ReproducibleSum& sum ) {
                const auto y = loadVector<Dim>( x, p );
                const Real depth = part.depth( grid, y );
                if ( depth < 0 || depth >= h || !part.contains( grid, y ) )
                    return;
                const Real u = outwards * v( p, axis );
                const Real c = sound_speed( p );
                if ( u >= c )
                    return;
                const Real impedance = m( p ) / V( p ) * c;
                const Real wanted = Kokkos::clamp(
                    far_velocity + ( pressure( p ) - far_pressure ) / impedance,
                    0.0_rt, c );
                const Real part_of_way = Kokkos::min( 1.0_rt, dt * c / h );
                const Real next =
                    u + part_of_way * ( wanted - Kokkos::max( u, 0.0_rt ) );
                v( p, axis ) = outwards * next;
                sum += 0.5_rt * m( p ) * ( next * next - u * u );
            },
            work );
        state.ledger.energy_in += work;
        return false; // slower than sound, so as sound as before
    }

    void applyToParticles( State<Dim>& state ) override
    {
        Impl::markBeyond( state, this->_part );
    }

    void layOut( State<Dim>& state ) override
    {
        if ( !_is_valve )
            return;
        const auto part = this->_part;
        const auto grid = state.grid;
        // On the side, or half a cell from it.
        const Real width = 0.75_rt * grid.spacing[part.axis()];
        _nodes = listNodes(
            "Machpoint::outflowNodes", state.layout,
            MACHPOINT_LAMBDA( const Vector<Dim>& x ) {
                return part.depth( grid, x ) < width &&
                       part.contains( grid, x );
            } );
    }

    void applyToGrid( State<Dim>&, const GridVelocity& velocity ) override
    {
        const auto nodes = _nodes;
        const auto field = velocity.field;
        const int column = velocity.first + this->_part.axis();
        const bool is_upper = this->_part.upper();
        forEach(
            "Machpoint::outflowNodes", nodes.extent_int( 0 ),
            MACHPOINT_LAMBDA( const int k ) {
                Real& v = field( nodes( k ), column );
                v = is_upper ? Kokkos::max( v, 0.0_rt )
                             : Kokkos::min( v, 0.0_rt );
            } );
    }

  private:
    bool _is_valve;
    Real _far_pressure = 0; // 0: not known
    Real _far_velocity;
    IndexList _nodes; // of a valve: next to the side, or beyond
};

} // namespace Machpoint

#endif
