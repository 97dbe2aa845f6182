/*!
  \file stream.hpp
  \brief The undisturbed gas that an inflow or a recycling boundary prescribes.
*/
#ifndef MACHPOINT_STREAM_HPP
#define MACHPOINT_STREAM_HPP

#include <core/module.hpp>

namespace Machpoint
{

//! A uniform gas state. The energy follows from the equation of state.
template <int Dim>
struct Stream
{
    Real density = 0;       //!< mass/length^Dim
    Vector<Dim> velocity{}; //!< [Dim], length/time
    Real pressure = 0;
    Real specific_internal_energy = 0; //!< energy/mass
    Real fastest = 0;                  //!< |v| + c, length/time

    //! Declares `density`, `velocity`, `pressure`.
    static void declareState( Parameters& p )
    {
        p.number( "density", "of the incoming gas" )
            .unit( "mass/length^Dim" )
            .above( 0 );
        p.vector( "velocity", "of the incoming gas" ).unit( "length/time" );
        p.number( "pressure", "of the incoming gas" )
            .unit( "pressure" )
            .above( 0 );
    }

    //! Velocity into the domain at the entry's `side`, length/time.
    static double velocityInto( const Json& entry )
    {
        const int side = sideNumber( entry.at( "side" ) );
        const double along = entry.at( "velocity" ).at( side / 2 );
        return side % 2 ? -along : along;
    }

    Stream() = default;
    //! \param json resolved, with the keys of declareState
    //! \param gas gives the energy, and c^2 = g (p + p_inf) / rho
    //! (PressureResponse)
    Stream( const Json& json, const EquationOfState<Dim>& gas )
        : density( json.at( "density" ) ),
          velocity( toVector<Dim>( json.at( "velocity" ) ) ),
          pressure( json.at( "pressure" ) ),
          specific_internal_energy(
              gas.specificInternalEnergy( density, pressure ) )
    {
        const auto response = gas.response();
        fastest = Kokkos::sqrt( dot<Dim>( velocity, velocity ) ) +
                  Kokkos::sqrt( response.exponent *
                                ( pressure + response.reference ) / density );
    }

    //! Gives particle p this state, without a gradient; its mass stays, so its
    //! volume is m / rho. \param v, L, m, volume, e slices
    template <class V, class C, class M, class Vol, class E>
    KOKKOS_INLINE_FUNCTION void impose( const int p, const V& v, const C& L,
                                        const M& m, const Vol& volume,
                                        const E& e ) const
    {
        for ( int a = 0; a < Dim; ++a )
        {
            v( p, a ) = velocity[a];
            for ( int b = 0; b < Dim; ++b )
                L( p, a, b ) = 0;
        }
        e( p ) = specific_internal_energy;
        volume( p ) = m( p ) / density;
    }
};

} // namespace Machpoint

#endif
