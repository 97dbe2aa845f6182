/*!
  \file obstacle.hpp
  \brief A solid of any shape in the gas, by projection of node velocities.
*/
#ifndef MACHPOINT_OBSTACLE_HPP
#define MACHPOINT_OBSTACLE_HPP

#include <boundary/shape.hpp>
#include <core/module.hpp>
#include <core/node_list.hpp>

namespace Machpoint
{

/*!
  \brief Obstacle (eq. 7 of Baioni et al. 2023): nodes inside the solid, or
  within `reach` of it, lose the velocity along its surface normal.

  Bilateral projection, the default, removes the normal component whatever its
  sign; it does no work, so `apic` keeps its energy balance. The unilateral
  one removes it only where gas runs into the solid. A particle that got
  inside is put on the surface, its velocity untouched. Reports the force on
  the solid and the mean pressure within one cell of its surface, per step.
*/
template <int Dim>
class Obstacle : public Module<Dim>
{
  public:
    static constexpr const char* name = "obstacle";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "a solid body in the gas", dimension );
        p.text( "name", "what its force and pressure are reported under" )
            .nonEmpty()
            .defaultsTo( "obstacle" );
        p.oneOf( "shape", shapeFamily(), "the solid" );
        p.choice( "projection", { "bilateral", "unilateral" },
                  "remove the normal velocity always, or only into the solid" )
            .defaultsTo( "bilateral" )
            .source( "eq. 7, Baioni et al. 2023" );
        p.number( "reach", "nodes up to this far outside are projected too" )
            .unit( "cells" )
            .atLeast( -1 )
            .atMost( 1 )
            .defaultsTo( 0.5 )
            .source( "measured: docs/method.md, section 8" );
        return p;
    }

    explicit Obstacle( const Json& json )
        : _shape( makeShape<Dim, MemorySpace>( json.at( "shape" ) ) ),
          _host_shape(
              makeShape<Dim, Kokkos::HostSpace>( json.at( "shape" ) ) ),
          _bilateral( json.at( "projection" ) == "bilateral" ),
          _reach( json.at( "reach" ) )
    {
        _series.name = json.at( "name" );
        _series.columns = { "time" };
        for ( int d = 0; d < Dim; ++d )
            _series.columns.push_back( std::string( "force_" ) + "xyz"[d] );
        _series.columns.push_back( "mean_surface_pressure" );
    }

    bool isSolid( const Vector<Dim>& x ) const override
    {
        return _host_shape.distance( x ) < 0;
    }

    //! Lists the solid nodes, which never change.
    void initialize( State<Dim>& state ) override
    {
        const auto shape = _shape;
        const Real reach = _reach * state.grid.minSpacing();
        _nodes = listNodes(
            "Machpoint::solidNodes", state.layout,
            KOKKOS_LAMBDA( const Vector<Dim>& x ) {
                return shape.distance( x ) < reach;
            } );
    }

    void applyToGrid( State<Dim>& state, const GridVelocity& velocity ) override
    {
        const auto nodes = _nodes;
        const auto shape = _shape;
        const auto layout = state.layout;
        const auto halo = state.halo;
        const auto moments = state.nodes.moments;
        const auto field = velocity.field;
        const int first = velocity.first;
        const bool bilateral = _bilateral;
        Impulse impulse;
        Kokkos::parallel_reduce(
            "Machpoint::obstacle",
            Range( 0, static_cast<int>( nodes.extent( 0 ) ) ),
            KOKKOS_LAMBDA( const int k, Impulse& sum ) {
                const int row = nodes( k );
                const auto i = layout.indices( row );
                const auto n = shape.normal( layout.position( i ) );
                Real normal_velocity = 0;
                for ( int d = 0; d < Dim; ++d )
                    normal_velocity += field( row, first + d ) * n[d];
                if ( !bilateral && normal_velocity > 0 )
                    return;
                const Real m = halo.weight( i ) * moments( row, 0 );
                for ( int d = 0; d < Dim; ++d )
                {
                    field( row, first + d ) -= normal_velocity * n[d];
                    sum.value[d] += m * normal_velocity * n[d];
                }
            },
            impulse );
        if ( velocity.acts )
            for ( int d = 0; d < Dim; ++d )
                _impulse.value[d] += impulse.value[d];
    }

    int applyToParticles( State<Dim>& state ) override
    {
        const auto x = state.particles.template slice<Position>();
        const auto V = state.particles.template slice<Volume>();
        const auto pressure = state.particles.template slice<Pressure>();
        const auto shape = _shape;
        const Real h = state.grid.minSpacing();
        const Real cell_volume = state.grid.cellVolume();
        Real force = 0;
        Real volume = 0;
        Kokkos::parallel_reduce(
            "Machpoint::pushOut", Range( 0, state.particles.size() ),
            KOKKOS_LAMBDA( const int p, Real& pV, Real& sum ) {
                Vector<Dim> y = get<Dim>( x, p );
                Real distance = shape.distance( y );
                if ( distance > h )
                    return;
                // One particle of a thin wake must not outweigh all others.
                const Real weight = Kokkos::min( V( p ), cell_volume );
                pV += pressure( p ) * weight;
                sum += weight;
                // Leaving one part of a union may lead into another.
                for ( int attempt = 0; distance < 0 && attempt < 8; ++attempt )
                {
                    const auto n = shape.normal( y );
                    for ( int d = 0; d < Dim; ++d )
                        y[d] += ( 1e-6 * h - distance ) * n[d];
                    distance = shape.distance( y );
                    for ( int d = 0; d < Dim; ++d )
                        x( p, d ) = y[d];
                }
            },
            force, volume );
        std::vector<Real> row = { state.time + state.dt };
        for ( int d = 0; d < Dim; ++d )
            row.push_back( _impulse.value[d] / state.dt );
        row.push_back( volume > 0 ? force / volume : 0 );
        _series.rows.push_back( std::move( row ) );
        _impulse = Impulse{};
        return 0;
    }

    bool exertsForce() const override { return true; }
    const Series* series() const override { return &_series; }

    //! A vector that can be summed over nodes.
    struct Impulse
    {
        Vector<Dim> value{};
        KOKKOS_INLINE_FUNCTION Impulse& operator+=( const Impulse& other )
        {
            for ( int d = 0; d < Dim; ++d )
                value[d] += other.value[d];
            return *this;
        }
    };

  private:
    Shape<Dim> _shape;
    Shape<Dim, Kokkos::HostSpace> _host_shape;
    bool _bilateral;
    Real _reach;
    IndexList _nodes;
    Impulse _impulse;
    Series _series;
};

} // namespace Machpoint

#endif
