/*!
  \file output_times.hpp
  \brief Layer 7: the times at which a run's steps end exactly.
*/
#ifndef MACHPOINT_OUTPUT_TIMES_HPP
#define MACHPOINT_OUTPUT_TIMES_HPP

#include <core/parameters.hpp>
#include <core/types.hpp>

#include <cmath>
#include <cstdint>

namespace Machpoint
{

//! How many multiples of `every` are past at a time, 0 not counted. One that
//! rounding puts just behind the time is past.
inline double multiplesUpTo( const double time, const double every )
{
    return std::floor( time / every * ( 1 + 1e-12 ) );
}

//! The multiples of `output.every`, and the end. They are counted, not summed,
//! so that none drifts.
class OutputTimes
{
  public:
    //! \param input resolved \param time of the run: outputs up to then are
    //! past
    OutputTimes( const Json& input, const double time )
        : _end( input.at( "time" ).at( "end" ) ),
          _every( input.at( "output" ).value( "every", _end ) ),
          _number( 1 +
                   static_cast<std::int64_t>( multiplesUpTo( time, _every ) ) )
    {
    }

    //! A time that rounding puts just before the end is the end.
    double next() const
    {
        const double planned = _every * static_cast<double>( _number );
        return planned < _end * ( 1 - 1e-12 ) ? planned : _end;
    }
    //! The next one is reached.
    void pass() { ++_number; }

  private:
    double _end;
    double _every;
    std::int64_t _number; // of the next output
};

} // namespace Machpoint

#endif
