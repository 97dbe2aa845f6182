/*!
  \file gravity.hpp
  \brief A uniform acceleration.
*/
#ifndef MACHPOINT_GRAVITY_HPP
#define MACHPOINT_GRAVITY_HPP

#include <core/module.hpp>

namespace Machpoint
{

/*!
  \brief Force m_i g on every node, with the mass folded as a force along g, so
  that walls reflect it as they reflect pressure.

  The work done on the gas is exactly dt sum_i f_i . (v_i + v'_i) / 2 over
  owned nodes with the folded force, because fold is the adjoint of fill; it
  goes to the ledger.
*/
template <int Dim>
class Gravity : public Module<Dim>
{
  public:
    static constexpr const char* name = "gravity";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "uniform acceleration of all gas", dimension );
        p.vector( "acceleration", "g" ).unit( "length/time^2" );
        return p;
    }

    explicit Gravity( const Json& json )
        : _g( toVector<Dim>( json.at( "acceleration" ) ) )
    {
    }

    bool exertsForce() const override { return true; }

    void layOut( State<Dim>& state ) override
    {
        _force = makeNodeSum( "Machpoint::gravity", state, Dim );
    }

    void keepDeposit( State<Dim>& state ) override
    {
        _force.copyDeposit( state.nodes.moment_sum, 0 );
    }

    void gridForce( State<Dim>& state ) override
    {
        _force.fold( state.halo, vectorComponents<Dim, 1>( Parity::force ) );
        const auto moments = state.nodes.moments;
        const auto force = _force.field();
        const auto g = _g;
        Kokkos::parallel_for(
            "Machpoint::gravity", Range( 0, state.layout.total ),
            KOKKOS_LAMBDA( const int i ) {
                for ( int d = 0; d < Dim; ++d )
                {
                    force( i, d ) *= g[d]; // until here the mass
                    moments( i, 1 + Dim + d ) += force( i, d );
                }
            } );
    }

    void gridWork( State<Dim>& state ) override
    {
        const auto velocities = state.nodes.velocities;
        const auto force = _force.field();
        const auto layout = state.layout;
        const auto weights = state.halo.weights();
        const Real dt = state.dt;
        ReproducibleSum work;
        Kokkos::parallel_reduce(
            "Machpoint::gravityWork", Range( 0, layout.total ),
            KOKKOS_LAMBDA( const int row, ReproducibleSum& sum ) {
                const auto i = layout.indices( row );
                if ( !layout.isOwned( i ) )
                    return;
                for ( int d = 0; d < Dim; ++d )
                    sum +=
                        dt * weights( i ) * force( row, d ) * 0.5 *
                        ( velocities( row, d ) + velocities( row, Dim + d ) );
            },
            work );
        state.ledger.energy_in += work;
    }

  private:
    Vector<Dim> _g;
    NodeSum _force; // mass, then force [nodes][Dim]
};

} // namespace Machpoint

#endif
