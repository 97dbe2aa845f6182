/*!
  \file sedov.hpp
  \brief Self-similar solution of a point explosion; host only.
*/
#ifndef MACHPOINT_SEDOV_HPP
#define MACHPOINT_SEDOV_HPP

#include <core/types.hpp>

namespace Machpoint
{

/*!
  \brief Energy set free at t = 0 on a plane, a line or at a point of an ideal
  gas of uniform density and no pressure.

  Density, velocity and pressure over their values behind the shock are known
  functions of one parameter; the energy integral, which fixes where the shock
  is, is taken numerically (to 1e-9 where gamma is 1.2 or more, 4e-6 at 1.01).

  Source: L. I. Sedov, Similarity and Dimensional Methods in Mechanics, Academic
  Press, 1959, chapter IV, in the form of J. R. Kamm and F. X. Timmes, Los
  Alamos report LA-UR-07-2849 (2007), section 2, for uniform density.
*/
class SedovSolution
{
  public:
    //! \param dimension j: 1 planar, 2 cylindrical, 3 spherical
    //! \param energy in all space, per area or length for j = 1 or 2
    //! \param density of the undisturbed gas, mass/length^Dim
    //! \param gamma > 1, which is not looked at; not 2; below 7 if j = 3
    //! \throws std::invalid_argument for a gamma of 2, or of 7 and more if
    //! j = 3, or no energy
    SedovSolution( int dimension, double energy, double density, double gamma );

    //! Radius of the shock at t >= 0, length.
    double shockRadius( double t ) const;

    //! Radial motion of the gas.
    struct Radial
    {
        double density;  //!< mass/length^Dim
        double velocity; //!< away from the centre, length/time
        double pressure;
    };

    //! The gas inside the shock. \param r from 0 to shockRadius( t ), t > 0
    Radial inside( double r, double t ) const;

  private:
    //! Fractions of the values behind the shock, and of its radius.
    struct Profile
    {
        double radius, velocity, density, pressure;
    };
    Profile profile( double w ) const;
    Profile profileAt( double radius ) const;

    int _dimension;
    double _density;
    double _gamma;
    double _shock_parameter; // w at the shock; it is 0 at the centre
    double _scale;           // shock radius at t = 1
};

} // namespace Machpoint

#endif
