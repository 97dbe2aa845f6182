/*!
  \file body_doubts.hpp
  \brief Layer 7: what is odd about the bodies of an input.
*/
#ifndef MACHPOINT_BODY_DOUBTS_HPP
#define MACHPOINT_BODY_DOUBTS_HPP

#include <drivers/sample_grid.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace Machpoint
{

//! A solid body, as it stands in the input.
template <int Dim>
struct SampledBody
{
    std::string place; //!< in the input, as "/boundary/1"
    Shape<Dim, Kokkos::HostSpace> shape;
    bool has_images = false; //!< of particles near its surface
    //! Distance of the sample nearest to it, length; < 0 inside.
    double nearest_sample = Kokkos::Experimental::infinity_v<double>;
    Vector<Dim> sample{}; //!< that one: the deepest, if it is inside
};

//! Is a place in one of the bodies? \param x [Dim]
template <int Dim>
bool isInBody( const std::vector<SampledBody<Dim>>& bodies,
               const Vector<Dim>& x )
{
    return std::any_of( bodies.begin(), bodies.end(),
                        [&]( const SampledBody<Dim>& body )
                        { return body.shape.distance( x ) < 0; } );
}

/*!
  \brief Says which bodies no gas meets, which of those with images are too thin
  to part the gas on their two sides, which rise from a wall so little that
  their tip is lost in what the wall mirrors, which meet a stream where an
  inflow's buffer keeps it, and which of them stand beside one that is
  projected. \param input resolved \param bodies all of the input, their nearest
  samples found \return a line each, as "/boundary/1: ..."
*/
template <int Dim>
std::vector<std::string>
findBodyDoubts( const Json& input, const SampleGrid<Dim>& samples,
                const std::vector<SampledBody<Dim>>& bodies );

} // namespace Machpoint

#endif
