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
  \brief Force m_i g on every node, before the halo is folded, so that walls
  reflect it as they reflect pressure.

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
        _force = NodeView( "Machpoint::gravity", state.layout.total, Dim );
    }

    void gridForce( State<Dim>& state ) override
    {
        const auto moments = state.nodes.moments;
        const auto force = _force;
        const auto g = _g;
        Kokkos::parallel_for(
            "Machpoint::gravity", Range( 0, state.layout.total ),
            KOKKOS_LAMBDA( const int i ) {
                for ( int d = 0; d < Dim; ++d )
                {
                    force( i, d ) = moments( i, 0 ) * g[d];
                    moments( i, 1 + Dim + d ) += force( i, d );
                }
            } );
    }

    void gridWork( State<Dim>& state ) override
    {
        // The same fold that the stepper gave the sum of all forces.
        state.halo.fold( _force, vectorComponents<Dim, 1>( Parity::force ) );
        const auto velocities = state.nodes.velocities;
        const auto force = _force;
        const auto layout = state.layout;
        const auto weights = state.halo.weights();
        Real power = 0;
        Kokkos::parallel_reduce(
            "Machpoint::gravityWork", Range( 0, layout.total ),
            KOKKOS_LAMBDA( const int row, Real& sum ) {
                const auto i = layout.indices( row );
                if ( !layout.isOwned( i ) )
                    return;
                for ( int d = 0; d < Dim; ++d )
                    sum +=
                        weights( i ) * force( row, d ) * 0.5 *
                        ( velocities( row, d ) + velocities( row, Dim + d ) );
            },
            power );
        state.ledger.energy_in += state.dt * power;
    }

  private:
    Vector<Dim> _g;
    NodeView _force;
};

} // namespace Machpoint

#endif
