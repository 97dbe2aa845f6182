/*!
  \file shu_osher.hpp
  \brief A shock that runs into a density wave.
*/
#ifndef MACHPOINT_SHU_OSHER_HPP
#define MACHPOINT_SHU_OSHER_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

/*!
  \brief A shock that stands at a plane and runs into gas at rest of density
  1 + a sin( k x ) and pressure 1; behind it the state that the jump conditions
  give for density 1.

  Source: C.-W. Shu and S. Osher, J. Comput. Phys. 83 (1989) 32, example 8.
*/
class ShuOsher : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "shu_osher";

    static Parameters declare( const int dimension )
    {
        const char* source = "Shu and Osher 1989";
        Parameters p( name, "shock that runs into a density wave", dimension );
        declareDirection( p, "along which the shock runs" );
        p.number( "position", "of the shock along the unit direction" )
            .unit( "length" )
            .defaultsTo( -4 )
            .source( source );
        p.number( "mach", "Mach number of the shock" )
            .above( 1 )
            .defaultsTo( 3 )
            .source( source );
        p.number( "amplitude", "of the density wave, relative" )
            .atLeast( 0 )
            .below( 1 )
            .defaultsTo( 0.2 )
            .source( source );
        p.number( "wavenumber", "of the density wave" )
            .unit( "1/length" )
            .defaultsTo( 5 )
            .source( source );
        return p;
    }

    //! \throws std::invalid_argument without a known gas law
    ShuOsher( const Json& json, const SceneFacts& scene )
        : _direction( toDirection( json ) ), _position( json.at( "position" ) ),
          _amplitude( json.at( "amplitude" ) ),
          _wavenumber( json.at( "wavenumber" ) )
    {
        const double gamma = scene.gas().gamma;
        const double sound_speed =
            Kokkos::sqrt( gamma * ( 1 + scene.gas().pressure_offset ) );
        const double mach = json.at( "mach" );
        const double square = mach * mach;
        const double ratio =
            ( gamma + 1 ) * square / ( ( gamma - 1 ) * square + 2 );
        _behind.density = ratio;
        _behind.pressure =
            1 + mach * mach * sound_speed * sound_speed * ( 1 - 1 / ratio );
        for ( int d = 0; d < 3; ++d )
            _behind.velocity[d] =
                mach * sound_speed * ( 1 - 1 / ratio ) * _direction[d];
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        const double s = dot<3>( _direction, x );
        if ( s < _position )
            return _behind;
        return { 1 + _amplitude * Kokkos::sin( _wavenumber * s ), {}, 1 };
    }

  private:
    Vector3 _direction;
    double _position;
    double _amplitude;
    double _wavenumber;
    GasState _behind;
};

} // namespace Machpoint

#endif
