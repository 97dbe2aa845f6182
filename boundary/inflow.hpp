/*!
  \file inflow.hpp
  \brief A stream of undisturbed gas enters.
*/
#ifndef MACHPOINT_INFLOW_HPP
#define MACHPOINT_INFLOW_HPP

#include <boundary/outflow.hpp>
#include <boundary/stream.hpp>
#include <core/node_list.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief Inflow: the gas upstream is a frozen pattern of particles, laid as in
  the domain, that moves in with the stream's normal velocity.

  A particle enters when its place in the pattern crosses the side; so a
  lattice continues as a lattice, and random places depend on the seed and on
  the pattern's cell alone. Particles and nodes within `buffer` cells of the
  side keep the stream's state: the mirror image beyond the side does not fit a
  lattice that moves, and its noise must not reach the gas. Particles that leave
  through the side are removed, and none enters inside a body.
*/
template <int Dim>
class Inflow : public SideBoundary<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "inflow";
    using KeepsUniformGas = Inflow;

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "a uniform stream enters", dimension );
        SideBoundary<Dim>::declareSide( p );
        Stream<Dim>::declareState( p );
        p.integer( "buffer", "cells next to the side that keep the "
                             "stream's state" )
            .atLeast( 1 )
            .atMost( 1e8 )
            .defaultsTo( 2 );
        return p;
    }

    //! \param gas gives the stream its energy and speed of sound
    Inflow( const Json& json, const EquationOfState<Dim>& gas )
        : SideBoundary<Dim>( json ), _stream( json, gas ),
          _buffer( json.at( "buffer" ) )
    {
    }

    static std::vector<SideClaim> sides( const Json& entry )
    {
        return { { sideNumber( entry.at( "side" ) ), SideKind::open } };
    }
    //! The stream, whatever gas is before the side.
    static GasState beyond( const Json& entry, int, const GasState& )
    {
        return toGasState( entry );
    }
    static int imposedCells( const Json& entry )
    {
        return entry.at( "buffer" );
    }
    //! A stream that does not point into the domain.
    static std::string fault( const Json& entry, const MethodFacts& )
    {
        return Stream<Dim>::velocityInto( entry ) > 0
                   ? ""
                   : "/velocity: must point into the domain at " +
                         entry.at( "side" ).get<std::string>();
    }
    //! @}
    void checkpoint( Archive& archive ) override
    {
        archive( "advanced", _advanced );
    }

    void initialize( State<Dim>& state ) override
    {
        imposeStream( state, true );
    }

    void layOut( State<Dim>& state ) override
    {
        const auto part = this->_part;
        const auto grid = state.grid;
        const Real width = bufferWidth( grid );
        _nodes = listNodes(
            "Machpoint::inflowNodes", state.layout,
            MACHPOINT_LAMBDA( const Vector<Dim>& x ) {
                return part.depth( grid, x ) < width &&
                       part.contains( grid, x );
            } );
    }

    //! Nodes that stand where it ends are in it. length
    Real bufferWidth( const Grid<Dim>& grid ) const
    {
        return ( _buffer + nudge ) * grid.spacing[this->_part.axis()];
    }

    //! What enters must not go further than the gas that is there. (A hair
    //! more, as gas of the stream's own speed limits the step by itself.)
    Real limitTimeStep( State<Dim>& state ) override
    {
        return 1.000001_rt * static_cast<Real>( state.cfl ) *
               state.grid.minSpacing() / _stream.fastest;
    }

    void applyToGrid( State<Dim>&, const GridVelocity& velocity ) override
    {
        const auto nodes = _nodes;
        const auto field = velocity.field;
        const int first = velocity.first;
        const auto stream = _stream;
        forEach(
            "Machpoint::inflowNodes", nodes.extent_int( 0 ),
            MACHPOINT_LAMBDA( const int k ) {
                for ( int d = 0; d < Dim; ++d )
                    field( nodes( k ), first + d ) = stream.velocity[d];
            } );
    }

    void applyToParticles( State<Dim>& state ) override
    {
        Impl::markBeyond( state, this->_part );
        imposeStream( state, false );
    }

    void inject( State<Dim>& state ) override
    {
        const int axis = this->_part.axis();
        const Real h = state.grid.spacing[axis];
        const Real speed = this->_part.upper() ? -_stream.velocity[axis]
                                               : _stream.velocity[axis];
        const double before = _advanced;
        _advanced += speed * state.dt;
        const double after = _advanced;
        const auto first = static_cast<std::int64_t>( before / h );
        const auto last = static_cast<std::int64_t>( after / h );
        const int slabs = static_cast<int>( last - first + 1 );
        const auto box = state.layout.box;
        const bool is_near =
            this->_part.upper() ? box.end[axis] > state.grid.cells[axis] - slabs
                                : box.begin[axis] < slabs;
        if ( !is_near )
            return; // what enters is another rank's
        const Pattern pattern( state, this->_part, _stream.velocity, first,
                               after - before );
        const int candidates = slabs * pattern.own_cells * state.per_cell;
        const auto entering = _entering.take( candidates );
        const auto bodies = state.bodies;
        const int count = scanEach(
            "Machpoint::findEntering", candidates, few_particles,
            MACHPOINT_LAMBDA( const int k, int& n, const bool final ) {
                const double depth = pattern.depth( k );
                if ( depth < before || depth >= after ||
                     !pattern.part.contains( pattern.grid,
                                             pattern.place( k, depth ) ) )
                    return;
                const auto y = pattern.place( k, after );
                if ( !box.contains( pattern.grid, y ) || bodies.contain( y ) )
                    return;
                if ( final )
                    entering( n ) = k;
                ++n;
            } );
        if ( count == 0 )
            return;

        const int old = state.particles.size();
        state.particles.resize( static_cast<std::size_t>( old ) + count );
        const auto x = state.particles.template slice<Position>();
        const auto v = state.particles.template slice<Velocity>();
        const auto L = state.particles.template slice<VelocityGradient>();
        const auto m = state.particles.template slice<Mass>();
        const auto V = state.particles.template slice<Volume>();
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const auto id = state.particles.template slice<Id>();
        const auto pressure = state.particles.template slice<Pressure>();
        const auto sound_speed = state.particles.template slice<SoundSpeed>();
        const auto stream = _stream;
        const Real mass =
            stream.density * state.grid.cellVolume() / state.per_cell;
        forEach(
            "Machpoint::inflow", count,
            MACHPOINT_LAMBDA( const int n ) {
                const int k = entering( n );
                const int p = old + n;
                const auto y = pattern.place( k, after );
                for ( int d = 0; d < Dim; ++d )
                    x( p, d ) = y[d];
                m( p ) = mass;
                pressure( p ) = 0; // until the next step finds them
                sound_speed( p ) = 0;
                id( p ) = pattern.id( k );
                stream.impose( p, v, L, m, V, e );
            },
            few_particles );
        state.ledger.mass_in.add( mass, count );
    }

    //! The frozen gas upstream, cell by cell. Candidate k is particle
    //! k % per_cell of cell k / per_cell, slab after slab; of a slab each rank
    //! counts the cells whose particles may enter its box.
    struct Pattern
    {
        Grid<Dim> grid; //!< the whole domain
        Placement placement;
        int q;              //!< particles along an axis of a cell; placeInCell
        int per_cell;       //!< particles of a cell
        std::uint64_t seed; //!< of the random places
        SidePart<Dim> part; //!< where they enter
        std::int64_t first_slab;     //!< that of candidate 0
        std::int64_t side_cells = 1; //!< of the whole side
        int own_cells = 1;           //!< those of a slab that count here
        Indices<Dim> begin{};        //!< the first of them
        Indices<Dim> count{};        //!< how many, along each axis
        Indices<Dim> period;         //!< cells, where axes are periodic; or 0
        Vector<Dim> slope{}; //!< way along the side for way into the domain

        //! \param velocity of the stream \param way into the domain, in the
        //! step
        Pattern( const State<Dim>& state, const SidePart<Dim>& side_part,
                 const Vector<Dim>& velocity, const std::int64_t first,
                 const double way )
            : grid( state.grid ), placement( state.placement ),
              q( latticeSize( state.per_cell, Dim ) ),
              per_cell( state.per_cell ), seed( state.seed ), part( side_part ),
              first_slab( first ), period( state.layout.period )
        {
            const auto& box = state.layout.box;
            for ( int d = 0; d < Dim; ++d )
            {
                if ( d == part.axis() )
                    continue;
                slope[d] = velocity[d] / Kokkos::abs( velocity[part.axis()] );
                // One more, lest any be lost by rounding.
                const int margin =
                    1 + static_cast<int>( std::ceil( std::abs( slope[d] ) *
                                                     way / grid.spacing[d] ) );
                begin[d] = box.begin[d] - margin;
                int end = box.end[d] + margin;
                if ( period[d] == 0 || end - begin[d] > grid.cells[d] )
                {
                    begin[d] = std::max( begin[d], 0 );
                    end = std::min( end, grid.cells[d] );
                }
                count[d] = end - begin[d];
                side_cells *= grid.cells[d];
                own_cells *= count[d];
            }
        }

        //! Layer of cells, counted upstream from the side as the run starts.
        KOKKOS_INLINE_FUNCTION std::int64_t slab( const int k ) const
        {
            return first_slab + k / ( per_cell * own_cells );
        }
        //! Its cell in the slab; 0 along the axis.
        KOKKOS_INLINE_FUNCTION Indices<Dim> cell( const int k ) const
        {
            int t = ( k / per_cell ) % own_cells;
            Indices<Dim> i{};
            for ( int d = 0; d < Dim; ++d )
                if ( d != part.axis() )
                {
                    i[d] = begin[d] + t % count[d];
                    if ( i[d] < 0 )
                        i[d] += period[d];
                    else if ( i[d] >= grid.cells[d] )
                        i[d] -= period[d];
                    t /= count[d];
                }
            return i;
        }
        //! What ids and random places count: slabs are numbered away from the
        //! side, sides apart from each other and from the domain's own cells.
        KOKKOS_INLINE_FUNCTION std::int64_t cellNumber( const int k ) const
        {
            const auto i = cell( k );
            std::int64_t number = 0;
            for ( int d = Dim - 1; d >= 0; --d )
                if ( d != part.axis() )
                    number = number * grid.cells[d] + i[d];
            return ( ( part.side + 1ll ) << 44 ) + slab( k ) * side_cells +
                   number;
        }
        //! The same whenever, and on whatever rank, the particle enters.
        KOKKOS_INLINE_FUNCTION std::int64_t id( const int k ) const
        {
            return cellNumber( k ) * per_cell + k % per_cell;
        }
        //! Place in its cell [Dim], 0 to 1.
        KOKKOS_INLINE_FUNCTION Vector<Dim> fraction( const int k ) const
        {
            return placeInCell<Dim>( placement, q, seed, cellNumber( k ),
                                     k % per_cell );
        }
        //! How far upstream of the side it began, length: soon farther than the
        //! domain is long.
        KOKKOS_INLINE_FUNCTION double depth( const int k ) const
        {
            const int axis = part.axis();
            return ( static_cast<double>( slab( k ) ) + fraction( k )[axis] ) *
                   grid.spacing[axis];
        }
        //! Where it is when the pattern has moved by `advanced`: from where it
        //! crossed the side the stream takes it along. [Dim], length
        KOKKOS_INLINE_FUNCTION Vector<Dim> place( const int k,
                                                  const double advanced ) const
        {
            const auto f = fraction( k );
            const int axis = part.axis();
            const auto i = cell( k );
            const Real inside = static_cast<Real>( advanced - depth( k ) );
            Vector<Dim> x{};
            for ( int d = 0; d < Dim; ++d )
            {
                if ( d == axis )
                    continue;
                const Real lower = grid.lower[d];
                const Real upper = grid.upper[d];
                x[d] = lower + ( i[d] + f[d] ) * grid.spacing[d] +
                       slope[d] * inside;
                if ( period[d] > 0 && x[d] < lower )
                    x[d] += upper - lower;
                else if ( period[d] > 0 && x[d] >= upper )
                    x[d] -= upper - lower;
                x[d] = Kokkos::clamp( x[d], lower, justInside( lower, upper ) );
            }
            x[axis] = part.upper()
                          ? Kokkos::min( grid.upper[axis] - inside,
                                         justInside( grid.lower[axis],
                                                     grid.upper[axis] ) )
                          : grid.lower[axis] + inside;
            return x;
        }
    };

    //! Particles in the buffer keep the stream's state.
    //! \param fills do they take its mass, too, and keep the volume that they
    //! were laid with? Else they keep their mass.
    void imposeStream( State<Dim>& state, const bool fills )
    {
        const auto x = state.particles.template slice<Position>();
        const auto v = state.particles.template slice<Velocity>();
        const auto L = state.particles.template slice<VelocityGradient>();
        const auto m = state.particles.template slice<Mass>();
        const auto V = state.particles.template slice<Volume>();
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const auto part = this->_part;
        const auto grid = state.grid;
        const auto stream = _stream;
        const Real width = bufferWidth( grid );
        const int n = state.particles.size();
        forEachPack(
            "Machpoint::imposeStream", n,
            MACHPOINT_LAMBDA( const Pack pack ) MACHPOINT_INLINE {
                const Lanes s = load( x, pack, part.axis() );
                if ( !any( part.depthOf( grid, s ) < Lanes( width ) ) )
                    return;
                forEachOf( pack,
                           [&]( const int p )
                           {
                               const auto y = loadVector<Dim>( x, p );
                               if ( part.depth( grid, y ) >= width ||
                                    !part.contains( grid, y ) )
                                   return;
                               if ( fills )
                                   m( p ) = stream.density * V( p );
                               stream.impose( p, v, L, m, V, e );
                           } );
            } );
    }

  private:
    Stream<Dim> _stream;
    int _buffer;
    IndexList _nodes; // those in the buffer
    Reused<int> _entering{ "Machpoint::entering" };
    double _advanced = 0; // how far the pattern has moved in
};

} // namespace Machpoint

#endif
