/*!
  \file recycle.hpp
  \brief The paper's inflow: what leaves is put back at a random place of the
  inflow side, undisturbed.
*/
#ifndef MACHPOINT_RECYCLE_HPP
#define MACHPOINT_RECYCLE_HPP

#include <boundary/side.hpp>
#include <boundary/stream.hpp>
#include <core/random.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief Takes an outflow side and the opposite side, through which the gas
  comes back: a particle beyond either is moved into the first layer of cells
  of the inflow side, at a random place, with the stream's state. Mass and
  the number of particles stay (Baioni et al. 2023).
*/
template <int Dim>
class Recycle : public Module<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "recycle";
    using KeepsUniformGas = Recycle;

    static Parameters declare( const int dimension )
    {
        Parameters p( name,
                      "what leaves here re-enters through the opposite side",
                      dimension );
        p.choice( "side", sideNames( dimension ),
                  "outflow side; the opposite side becomes the inflow" );
        Stream<Dim>::declareState( p );
        return p;
    }

    //! \param gas gives the stream its energy and speed of sound
    Recycle( const Json& json, const EquationOfState<Dim>& gas )
        : _side( sideNumber( json.at( "side" ) ) ), _stream( json, gas )
    {
    }

    //! Its `side` and the opposite one.
    static std::vector<SideClaim> sides( const Json& entry )
    {
        const int side = sideNumber( entry.at( "side" ) );
        return { { side, SideKind::open }, { side ^ 1, SideKind::open } };
    }
    //! The same gas at `side`, the stream at the opposite one.
    static GasState beyond( const Json& entry, const int side,
                            const GasState& gas )
    {
        return side == sideNumber( entry.at( "side" ) ) ? gas
                                                        : toGasState( entry );
    }
    //! A stream that does not point out of the domain at `side`.
    static std::string fault( const Json& entry, const MethodFacts& )
    {
        return Stream<Dim>::velocityInto( entry ) < 0
                   ? ""
                   : "/velocity: must point out of the domain at " +
                         entry.at( "side" ).get<std::string>() +
                         ", where the gas leaves";
    }
    //! @}

    void applyToParticles( State<Dim>& state ) override
    {
        const auto x = state.particles.template slice<Position>();
        const auto v = state.particles.template slice<Velocity>();
        const auto L = state.particles.template slice<VelocityGradient>();
        const auto m = state.particles.template slice<Mass>();
        const auto V = state.particles.template slice<Volume>();
        const auto e = state.particles.template slice<SpecificInternalEnergy>();
        const auto id = state.particles.template slice<Id>();
        const auto grid = state.grid;
        const auto stream = _stream;
        const auto bodies = state.bodies;
        const auto seed = state.seed;
        const auto step = static_cast<std::uint64_t>( state.step );
        const int axis = _side / 2;
        const bool enters_low = _side % 2 == 1;
        const auto rows = state.leavers;
        const auto recycled = _recycled.take( rows.extent_int( 0 ) );
        forEach(
            "Machpoint::recycle", rows.extent_int( 0 ),
            MACHPOINT_LAMBDA( const int k ) {
                const int p = rows( k );
                recycled( k ) = -1;
                if ( x( p, axis ) >= grid.lower[axis] &&
                     x( p, axis ) < grid.upper[axis] )
                    return;
                // Draws again what a body holds; it pushes out what it still
                // holds after the last.
                Vector<Dim> y{};
                for ( int draw = 0; draw < most_draws; ++draw )
                {
                    for ( int d = 0; d < Dim; ++d )
                    {
                        const Real f = uniformRandom(
                            seed ^ mixBits( step + 1 ),
                            static_cast<std::uint64_t>( id( p ) ),
                            draw * Dim + d );
                        const Real length = d == axis
                                                ? grid.spacing[d]
                                                : grid.upper[d] - grid.lower[d];
                        y[d] = d == axis && !enters_low
                                   ? grid.upper[d] - ( 1 - f ) * length
                                   : grid.lower[d] + f * length;
                    }
                    if ( !bodies.contain( y ) )
                        break;
                }
                for ( int d = 0; d < Dim; ++d )
                    x( p, d ) = y[d];
                stream.impose( p, v, L, m, V, e );
                recycled( k ) = p;
            } );
        state.particles.forget( recycled );
    }

  private:
    //! Of a place for one particle.
    static constexpr int most_draws = 64;

    int _side;
    Stream<Dim> _stream;
    Reused<int> _recycled{ "Machpoint::recycled" };
};

} // namespace Machpoint

#endif
