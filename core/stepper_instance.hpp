/*!
  \file stepper_instance.hpp
  \brief Included by the generated units of a dimension.
*/
#ifndef MACHPOINT_STEPPER_INSTANCE_HPP
#define MACHPOINT_STEPPER_INSTANCE_HPP

#include <core/stepper.hpp>

namespace Machpoint
{

// One of these units has the loop.
extern template class SceneRun<1>;
extern template class SceneRun<2>;
extern template class SceneRun<3>;
extern template class TimeLoop<1>;
extern template class TimeLoop<2>;
extern template class TimeLoop<3>;

template <int Dim, class Basis, class Method>
std::unique_ptr<Simulation> makeSimulation( const Json& input )
{
    return std::make_unique<Stepper<Dim, Basis, Method>>( input );
}

} // namespace Machpoint

#endif
