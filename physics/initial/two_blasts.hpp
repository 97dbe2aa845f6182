/*!
  \file two_blasts.hpp
  \brief Two blast waves that collide.
*/
#ifndef MACHPOINT_TWO_BLASTS_HPP
#define MACHPOINT_TWO_BLASTS_HPP

#include <physics/initial/initial_state.hpp>

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace Machpoint
{

//! Gas at rest of one density and three pressures, to be put between walls.
//! Source: P. Woodward and P. Colella, J. Comput. Phys. 54 (1984) 115.
class TwoBlasts : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "two_blasts";

    static Parameters declare( const int dimension )
    {
        const char* source = "Woodward and Colella 1984";
        Parameters p( name, "two blast waves that collide", dimension );
        declareDirection( p, "along which they run" );
        p.number( "left_end", "of the left gas, along the unit direction" )
            .unit( "length" )
            .defaultsTo( 0.1 )
            .source( source );
        p.number( "right_start", "of the right gas" )
            .unit( "length" )
            .defaultsTo( 0.9 )
            .source( source );
        p.number( "density", "of all gas" )
            .unit( "mass/length^Dim" )
            .above( 0 )
            .defaultsTo( 1 )
            .source( source );
        for ( const auto& [key, value] :
              { std::pair{ "left", 1000.0 }, std::pair{ "middle", 0.01 },
                std::pair{ "right", 100.0 } } )
            p.number( fmt::format( "{}_pressure", key ),
                      fmt::format( "of the {} gas", key ) )
                .unit( "pressure" )
                .above( 0 )
                .defaultsTo( value )
                .source( source );
        return p;
    }

    //! \throws std::invalid_argument where the right gas starts in the left one
    explicit TwoBlasts( const Json& json )
        : _direction( toDirection( json ) ), _left_end( json.at( "left_end" ) ),
          _right_start( json.at( "right_start" ) ),
          _density( json.at( "density" ) ), _left( json.at( "left_pressure" ) ),
          _middle( json.at( "middle_pressure" ) ),
          _right( json.at( "right_pressure" ) )
    {
        if ( !( _left_end < _right_start ) )
            throw std::invalid_argument(
                "right_start must be greater than left_end" );
    }
    //! @}

    GasState state( const Vector3& x ) const override
    {
        const double s = dot<3>( _direction, x );
        return { _density,
                 {},
                 s < _left_end      ? _left
                 : s < _right_start ? _middle
                                    : _right };
    }

  private:
    Vector3 _direction;
    double _left_end, _right_start;
    double _density;
    double _left, _middle, _right;
};

} // namespace Machpoint

#endif
