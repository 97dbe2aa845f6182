/*!
  \file uniform.hpp
  \brief The same gas everywhere.
*/
#ifndef MACHPOINT_UNIFORM_HPP
#define MACHPOINT_UNIFORM_HPP

#include <physics/initial/initial_state.hpp>

namespace Machpoint
{

//! Uniform gas.
class Uniform : public InitialState
{
  public:
    //! \name What InitialState asks of its type
    //! @{
    static constexpr const char* name = "uniform";

    static Parameters declare( const int dimension )
    {
        return declareGasState( name, "the same gas everywhere", dimension );
    }

    explicit Uniform( const Json& json ) : _state( toGasState( json ) ) {}
    //! @}
    GasState state( const Vector3& ) const override { return _state; }

  private:
    GasState _state;
};

} // namespace Machpoint

#endif
