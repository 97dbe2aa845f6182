/*!
  \file blast.hpp
  \brief Energy set free in a small part of a gas.
*/
#ifndef MACHPOINT_BLAST_HPP
#define MACHPOINT_BLAST_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

/*!
  \brief Adds internal energy to the gas: per volume
  \f$ E \exp( -r^2 / 2 R^2 ) / ( ( 2 \pi )^{D/2} R^D ) \f$, whose integral over
  all space of D dimensions is E (a blast on a symmetry plane has half of it in
  the domain).

  The gas is that of the entries before this one, except for what is given here;
  where there is none, its density is 1, its pressure 1e-5, and it is at rest.
  On a lattice of particles 2 R or less apart the sum over particles is E but
  for exp( -2 pi^2 R^2 / spacing^2 ), that is 1 percent at a spacing of 2 R,
  and round-off at R.

  Source: the point explosion of L. I. Sedov, Similarity and Dimensional Methods
  in Mechanics, Academic Press, 1959; the Gaussian keeps it isotropic.
*/
class Blast : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "blast";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "energy set free in a small part of a gas",
                      dimension );
        p.vector( "center", "of the blast" ).unit( "length" );
        p.number( "radius", "standard deviation of its Gaussian" )
            .unit( "length" )
            .above( 0 );
        p.number( "energy", "internal energy added, in all space" )
            .unit( "mass length^2/time^2" )
            .atLeast( 0 );
        p.number( "density", "of the gas around; by default that of the "
                             "entries before, or 1" )
            .unit( "mass/length^Dim" )
            .above( 0 )
            .optional();
        p.vector( "velocity", "of the gas around; by default that of the "
                              "entries before, or 0" )
            .unit( "length/time" )
            .optional();
        p.number( "pressure", "of the gas around; by default that of the "
                              "entries before, or 1e-5" )
            .unit( "pressure" )
            .above( 0 )
            .optional();
        return p;
    }

    //! \throws std::invalid_argument without a known gas law
    Blast( const Json& json, const SceneFacts& scene )
        : _json( json ), _center( toVector3( json.at( "center" ) ) ),
          _periods( periodsOf( scene.input ) ), _radius( json.at( "radius" ) )
    {
        const double energy = json.at( "energy" );
        _peak_pressure =
            ( scene.gas().gamma - 1 ) * energy /
            Kokkos::pow( Kokkos::sqrt( 2 * Kokkos::numbers::pi_v<double> ) *
                             _radius,
                         scene.dimension );
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        GasState gas{};
        Gradient gradient{};
        apply( x, gas, gradient );
        return gas;
    }

    void apply( const Vector3& x, GasState& gas,
                Gradient& gradient ) const override
    {
        if ( gas.density == 0 )
            gas = { 1, {}, 1e-5 };
        if ( _json.contains( "density" ) )
            gas.density = _json.at( "density" );
        if ( _json.contains( "pressure" ) )
            gas.pressure = _json.at( "pressure" );
        if ( _json.contains( "velocity" ) )
        {
            gas.velocity = toVector3( _json.at( "velocity" ) );
            gradient = {};
        }
        auto r = x; // from the nearest image of the centre
        for ( int d = 0; d < 3; ++d )
            r[d] -= _center[d];
        r = toNearestImage( r, _periods );
        gas.pressure += _peak_pressure * Kokkos::exp( -0.5 * dot<3>( r, r ) /
                                                      _radius / _radius );
    }

  private:
    Json _json;
    Vector3 _center;
    Vector3 _periods;
    double _radius;
    double _peak_pressure;
};

} // namespace Machpoint

#endif
