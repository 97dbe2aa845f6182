/*!
  \file obstacle.hpp
  \brief A solid of any shape in the gas, by mirror images of particles or by
  projection of node velocities.
*/
#ifndef MACHPOINT_OBSTACLE_HPP
#define MACHPOINT_OBSTACLE_HPP

#include <core/module.hpp>
#include <core/node_list.hpp>
#include <core/shape_input.hpp>

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace Machpoint
{

/*!
  \brief Obstacle, by one of two treatments.

  `images`: each particle within `image_reach` of the surface has a mirror
  image beyond it, with mirrored velocity and the same mass, volume and
  pressure. Nodes beside space that no image can fill, behind acute corners,
  rest (docs/conservative.md, section 6).

  `projection` (eq. 7 of Baioni et al. 2023): nodes inside the solid, or within
  `reach` of it, lose the velocity along its surface normal.

  Bilateral projection, the default, removes the normal component whatever its
  sign; it does no work, so `apic` keeps its energy balance. The unilateral
  one removes it only where gas runs into the solid. A particle that got
  inside is put on the surface, its velocity untouched. Reports the force on
  the solid and the mean of the pressure that exerts force, artificial viscosity
  included, within one cell of its surface, per step.
*/
template <int Dim>
class Obstacle : public Module<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "obstacle";
    using KeepsUniformGas = Obstacle;

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "a solid body in the gas", dimension );
        p.text( "name", "what its force and pressure are reported under" )
            .nonEmpty()
            .defaultsTo( "obstacle" );
        p.oneOf( "shape", shapeFamily(), "the solid" );
        p.choice( "treatment", { "images", "projection" },
                  "mirror images of particles (conservative alone, its "
                  "default) or projection of node velocities" )
            .optional();
        p.number( "image_reach", "particles this near have an image" )
            .unit( "cells along the normal" )
            .above( 0 )
            .atMost( farthest_image )
            .optional( fmt::format( "{} of images", usual_image ) )
            .source( "docs/conservative.md, section 6" );
        p.choice( "projection", { "bilateral", "unilateral" },
                  "remove the normal velocity always, or only into the solid" )
            .optional( "\"bilateral\" of projection" )
            .source( "eq. 7, Baioni et al. 2023" );
        p.number( "reach", "nodes up to this far outside are projected too" )
            .unit( "cells along the normal" )
            .atLeast( -1 )
            .atMost( 1 )
            .optional( fmt::format( "{} of projection", usual_reach ) )
            .source( "measured: docs/method.md, section 8" );
        return p;
    }

    //! `treatment`, where it is left out: images if the method has them; and
    //! what that one wants to know.
    static void complete( Json& entry, const MethodFacts& method )
    {
        auto fill = [&]( const char* key, const Json& value )
        {
            if ( !entry.contains( key ) )
                entry[key] = value;
        };
        fill( "treatment", method.has_images ? "images" : "projection" );
        if ( entry.at( "treatment" ) == "images" )
        {
            fill( "image_reach", usual_image );
        }
        else
        {
            fill( "projection", "bilateral" );
            fill( "reach", usual_reach );
        }
    }
    //! Images in a method that has none, or a key of the other treatment.
    static std::string fault( const Json& entry, const MethodFacts& method )
    {
        const std::string treatment = entry.at( "treatment" );
        if ( treatment == "images" && !method.has_images )
            return "/treatment: " + method.name +
                   " has no mirror images; leave it out";
        for ( const auto& [key, owner] :
              { std::pair( "image_reach", "images" ),
                std::pair( "projection", "projection" ),
                std::pair( "reach", "projection" ) } )
            if ( entry.contains( key ) && treatment != owner )
                return fmt::format( "/{}: is of the treatment \"{}\", and this "
                                    "body has \"{}\"; leave it out, or say "
                                    "\"treatment\": \"{}\"",
                                    key, owner, treatment, owner );
        return "";
    }
    static Json solid( const Json& entry ) { return entry.at( "shape" ); }
    //! The force on the solid, along each axis [Dim], and the mean pressure at
    //! its surface.
    static std::vector<std::string> columns()
    {
        std::vector<std::string> names;
        for ( int d = 0; d < Dim; ++d )
            names.push_back( std::string( "force_" ) + "xyz"[d] );
        names.push_back( "mean_surface_pressure" );
        return names;
    }

    explicit Obstacle( const Json& json )
        : _shape( makeShape<Dim, MemorySpace>( json.at( "shape" ) ) ),
          _has_images( json.at( "treatment" ) == "images" ),
          _image_reach( json.value( "image_reach", Real( 0 ) ) ),
          _bilateral( json.value( "projection", "bilateral" ) == "bilateral" ),
          _reach( json.value( "reach", Real( 0 ) ) )
    {
        _series.name = json.at( "name" );
        _series.columns = columns();
        _series.columns.insert( _series.columns.begin(), "time" );
    }
    //! @}

    //! Lists the solid nodes, or those that stand for the wall where images
    //! leave gaps; each belongs to the nearest body alone, these to the nearest
    //! that has images.
    void layOut( State<Dim>& state ) override
    {
        const auto bodies = state.bodies;
        const int own = this->body;
        if ( !_has_images )
        {
            const auto shape = _shape;
            const auto grid = state.grid;
            const Real reach = _reach;
            // A wall along the grid has nodes exactly that far away: they are
            // all within, not by the last digit of where the wall stands.
            const Real seam = nudge * grid.minSpacing();
            _nodes = listNodes(
                "Machpoint::solidNodes", state.layout,
                MACHPOINT_LAMBDA( const Vector<Dim>& x ) {
                    const auto nearest = shape.nearest( x );
                    return nearest.distance <=
                               imageDistance<Dim>( grid, reach,
                                                   nearest.normal ) +
                                   seam &&
                           bodies.nearestBody( x ) == own;
                } );
            return;
        }
        const auto gaps = state.image_gaps;
        const auto layout = state.layout;
        const int count = gaps.nodes.extent_int( 0 );
        _held = collect(
            "Machpoint::heldNodes", count, MACHPOINT_LAMBDA( const int k ) {
                const auto x = layout.position(
                    layout.home( layout.indices( gaps.nodes( k ) ) ) );
                return gaps.held_axes( k ) != 0 &&
                       bodies.nearestBody( x, true ) == own;
            } );
    }

    Real imageReach() const override
    {
        return _has_images ? _image_reach : 0.0_rt;
    }

    void mirrorParticles( State<Dim>& state ) override
    {
        if ( !_has_images )
            return;
        const auto x = state.particles.template slice<Position>();
        const auto shape = _shape;
        const auto grid = state.grid;
        const auto bodies = state.bodies;
        const auto period = state.layout.period;
        const int own = this->body;
        const Real seam = nudge * grid.minSpacing();
        const Real cells = _image_reach;
        findNear( state, cells * grid.maxSpacing() );
        const auto rows = _near;
        const int near = rows.extent_int( 0 );
        auto& images = state.images;
        images.reserve( near );
        _first_image = images.count;
        const auto list = images;
        images.count += scanEach(
            "Machpoint::mirrorParticles", near, few_particles,
            MACHPOINT_LAMBDA( const int i, int& k, const bool final ) {
                const int p = rows( i );
                const auto y = loadVector<Dim>( x, p );
                const auto nearest = shape.nearest( y );
                if ( nearest.distance >
                         imageDistance<Dim>( grid, cells, nearest.normal ) ||
                     bodies.covers( y, nearest, own, seam ) )
                    return;
                const Mirror<Dim> mirror{ nearest.normal, nearest.distance };
                const auto image = mirror.point( y );
                if ( isBeyondMirrors<Dim>( image, y, grid, period ) ||
                     ( nearest.distance > 0 &&
                       bodies.depth( image, seam, grid, period ) <
                           same_surface * nearest.distance ) )
                    return;
                if ( final )
                {
                    const int row = list.count + k;
                    list.particle( row ) = p;
                    for ( int d = 0; d < Dim; ++d )
                        list.mirrors( row, d ) = mirror.normal[d];
                    list.mirrors( row, Dim ) = mirror.distance;
                }
                ++k;
            } );
        _last_image = images.count;
    }

    void applyToGrid( State<Dim>& state, const GridVelocity& velocity ) override
    {
        if ( _has_images )
            return hold( state, velocity );
        const auto nodes = _nodes;
        const auto shape = _shape;
        const auto layout = state.layout;
        const auto weights = state.halo.weights();
        const auto moments = state.nodes.moments;
        const auto field = velocity.field;
        const int first = velocity.first;
        const bool bilateral = _bilateral;
        Impulse impulse;
        reduceEach(
            "Machpoint::obstacle", nodes.extent_int( 0 ), few_particles,
            MACHPOINT_LAMBDA( const int k, Impulse& sum ) {
                const int row = nodes( k );
                const auto i = layout.indices( row );
                const auto n =
                    shape.normal( layout.position( layout.home( i ) ) );
                Real normal_velocity = 0;
                for ( int d = 0; d < Dim; ++d )
                    normal_velocity += field( row, first + d ) * n[d];
                if ( !bilateral && normal_velocity > 0 )
                    return;
                const Real share = weights( i );
                for ( int d = 0; d < Dim; ++d )
                {
                    field( row, first + d ) -= normal_velocity * n[d];
                    if ( share > 0 )
                        sum.value[d] += share * moments( row, 0 ) *
                                        velocity.takenUp( row ) *
                                        normal_velocity * n[d];
                }
            },
            impulse );
        if ( velocity.acts )
            _impulse += impulse;
    }

    //! Nodes that stand for the wall rest along their axes.
    void hold( const State<Dim>& state, const GridVelocity& velocity )
    {
        if ( _held.extent( 0 ) == 0 )
            return;
        const auto held = _held;
        const auto gaps = state.image_gaps;
        const auto layout = state.layout;
        const auto weights = state.halo.weights();
        const auto moments = state.nodes.moments;
        const auto field = velocity.field;
        const int first = velocity.first;
        Impulse impulse;
        reduceEach(
            "Machpoint::holdNodes", held.extent_int( 0 ), few_particles,
            MACHPOINT_LAMBDA( const int k, Impulse& sum ) {
                const int row = gaps.nodes( held( k ) );
                const int axes = gaps.held_axes( held( k ) );
                const Real share = weights( layout.indices( row ) );
                const Real taken = velocity.takenUp( row );
                for ( int d = 0; d < Dim; ++d )
                {
                    if ( ( axes & ( 1 << d ) ) == 0 )
                        continue;
                    Real& v = field( row, first + d );
                    if ( share > 0 )
                        sum.value[d] += share * moments( row, 0 ) * taken * v;
                    v = 0;
                }
            },
            impulse );
        if ( velocity.acts )
            _impulse += impulse;
    }

    void applyToParticles( State<Dim>& state ) override
    {
        const auto x = state.particles.template slice<Position>();
        const auto shape = _shape;
        const Real h = state.grid.minSpacing();
        // What is within a cell now was within 1 + CFL before its last move, as
        // none should go further; one that did is found in the next step.
        if ( !_has_images || _image_reach < 1 + state.cfl )
            findNear( state, h );
        const auto V = state.particles.template slice<Volume>();
        const auto C = state.particles.template slice<VelocityGradient>();
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const auto pressure = state.particles.template slice<Pressure>();
        const auto grid = state.grid;
        const auto moment_of = state.affine_moment;
        const bool has_rates = state.rates;
        const auto working = sliceOfRates<WorkingPressure>( state );
        const auto noted = state.noted;
        const auto rows = _near;
        const Real cell_volume = state.grid.cellVolume();
        ReproducibleSum force, volume;
        reduceEach(
            "Machpoint::pushOut", rows.extent_int( 0 ), few_particles,
            MACHPOINT_LAMBDA( const int k, ReproducibleSum& pV,
                              ReproducibleSum& sum ) {
                const int p = rows( k );
                const auto before = loadVector<Dim>( x, p );
                auto y = before;
                Real distance = shape.distance( y );
                if ( distance > h )
                    return;
                // One particle of a thin wake must not outweigh all others.
                const Real weight = Kokkos::min( V( p ), cell_volume );
                pV += ( has_rates ? working( p ) : pressure( p ) ) * weight;
                sum += weight;
                if ( distance < 0 )
                    noted.note( p );
                // Leaving one part of a union may lead into another.
                for ( int attempt = 0; distance < 0 && attempt < 8; ++attempt )
                {
                    const auto normal = shape.normal( y );
                    for ( int d = 0; d < Dim; ++d )
                        y[d] += ( nudge * h - distance ) * normal[d];
                    distance = shape.distance( y );
                    for ( int d = 0; d < Dim; ++d )
                        x( p, d ) = y[d];
                }
                if ( moment_of.varies )
                    for ( int d = 0; d < Dim; ++d )
                        if ( y[d] != before[d] )
                            moment_of.carry( grid, C, e, p, d, before[d],
                                             y[d] );
            },
            force, volume );
        if ( _has_images )
            sumImpulses( state );
        std::vector<ReproducibleSum> sums = { force, volume };
        for ( int d = 0; d < Dim; ++d )
            sums.push_back( _impulse.value[d] );
        sums = sumOfRanks( state.decomposition.comm(), sums );
        std::vector<double> row = { state.time + state.dt };
        for ( int d = 0; d < Dim; ++d )
            row.push_back( sums[2 + d].value() / state.dt );
        const Real around = sums[1].value();
        row.push_back( around > 0 ? sums[0].value() / around : 0 );
        _series.rows.push_back( std::move( row ) );
        _impulse = Impulse{};
    }

    //! A boundary that breaks the gas takes back a step that has its row.
    void rejectStep( State<Dim>& state ) override
    {
        _impulse = Impulse{};
        auto& rows = _series.rows;
        if ( !rows.empty() && rows.back()[0] > state.time + 0.5 * state.dt )
            rows.pop_back();
    }

    bool exertsForce( int ) const override { return true; }
    const Series* series() const override { return &_series; }
    void checkpoint( Archive& archive ) override
    {
        _series.checkpoint( archive );
    }

    //! Lists the particles within a distance of the surface, and those inside.
    //! \param reach length
    void findNear( const State<Dim>& state, const Real reach )
    {
        const auto x = state.particles.template slice<Position>();
        const auto shape = _shape;
        const int n = state.particles.size();
        auto isNear = MACHPOINT_LAMBDA( const int p )
        {
            const auto y = loadVector<Dim>( x, p );
            return shape.distanceBound( y ) <= reach &&
                   shape.distance( y ) <= reach;
        };
        _noted.clear( n );
        const auto noted = _noted;
        forEachPack(
            "Machpoint::noteNear", n,
            MACHPOINT_LAMBDA( const Pack pack ) MACHPOINT_INLINE {
                const auto y = loadVector<Dim>( x, pack );
                if ( any( shape.distanceBound( y ) <= Lanes( reach ) ) )
                    forEachOf( pack,
                               [&]( const int p )
                               {
                                   if ( isNear( p ) )
                                       noted.note( p );
                               } );
            } );
        _near = _noted.rows( n, isNear );
    }

    //! What the images gained, and not from a side, the gas has given to the
    //! solid.
    void sumImpulses( const State<Dim>& state )
    {
        const auto impulses = state.images.impulses;
        const int first = _first_image;
        Impulse gained;
        reduceEach(
            "Machpoint::imageImpulse", _last_image - first, few_particles,
            MACHPOINT_LAMBDA( const int k, Impulse& sum ) {
                for ( int d = 0; d < Dim; ++d )
                    sum.value[d] += impulses( first + k, d );
            },
            gained );
        _impulse += gained;
        for ( int d = 0; d < Dim && !state.side_impulses.empty(); ++d )
            _impulse.value[d] -= state.side_impulses[this->body * Dim + d];
    }

    //! A vector that can be summed over nodes.
    struct Impulse
    {
        ReproducibleSum value[Dim]; //!< mass length/time
        KOKKOS_INLINE_FUNCTION Impulse& operator+=( const Impulse& other )
        {
            for ( int d = 0; d < Dim; ++d )
                value[d] += other.value[d];
            return *this;
        }
    };

  private:
    static constexpr double usual_reach = 0.5; // cells along the normal

    Shape<Dim> _shape;
    bool _has_images;
    Real _image_reach;
    int _first_image = 0, _last_image = 0; // of this obstacle, in this step
    RowList _noted{ "Machpoint::nearObstacle" }; // scratch of findNear
    IndexList _near;                             // particles
    bool _bilateral;
    Real _reach;
    IndexList _nodes; // projected
    IndexList _held;  // of state.image_gaps, those that are this body's
    Impulse _impulse;
    Series _series;
};

} // namespace Machpoint

#endif
