/*!
  \file exact.hpp
  \brief Exact solutions that computed results are measured against; host only.
*/
#ifndef MACHPOINT_EXACT_HPP
#define MACHPOINT_EXACT_HPP

#include <core/parameters.hpp>
#include <core/types.hpp>

#include <array>
#include <memory>

namespace Machpoint
{

//! Primitive state of a gas.
struct GasState
{
    Real density;
    //! [3]; components beyond the dimension are 0.
    Vector<3> velocity;
    Real pressure;
};

/*!
  \brief Exact solution of the Riemann problem of a stiffened gas,
  \f$ p = (\gamma - 1) \rho e - \gamma p_\infty \f$.

  Velocity component 0 is normal to the interface; the others are carried along
  and jump at the contact. A state of zero density is vacuum, one of zero
  pressure (with the offset: \f$ p = -p_\infty \f$) a cold gas.

  In terms of \f$ p + p_\infty \f$ the equations are those of an ideal gas, so
  that the solution is the ideal gas' one with pressures shifted.

  Source: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics,
  3rd ed., Springer, 2009, chapter 4.
*/
class RiemannSolution
{
  public:
    /*!
      \param left, right The states at x < 0 and x > 0 for t = 0.
      \param gamma Ratio of specific heats, > 1.
      \param pressure_offset \f$ p_\infty \ge 0 \f$; 0 is an ideal gas.
      \throws std::invalid_argument for states that no such gas has, and if
      both sides are vacuum.
    */
    RiemannSolution( GasState left, GasState right, Real gamma,
                     Real pressure_offset = 0 );

    /*!
      \brief The state on the ray x / t; infinite values are welcome.

      Within vacuum the density is 0, the pressure that of a cold gas, and the
      normal velocity x / t, which continues the fan beside it.
    */
    GasState sample( Real x_over_t ) const;

    //! Pressure between the two waves; that of a cold gas beside vacuum.
    Real starPressure() const { return _star_pressure - _offset; }

    //! Velocity of the contact; beside vacuum that of the gas' front, and the
    //! mean of both fronts where vacuum opens between them.
    Real starVelocity() const { return _star_velocity; }

    //! Is there vacuum, given or generated?
    bool hasVacuum() const { return _has_vacuum; }

    /*!
      \brief Speeds of the left wave's head and tail, the contact, and the
      right wave's tail and head, in ascending order.

      The solution is smooth in between. Head and tail of a shock are equal;
      where vacuum opens the tails are its fronts; a side that is vacuum itself
      has the front of the other one for both.
    */
    std::array<Real, 5> waveSpeeds() const;

  private:
    //! One side's wave as seen by someone to whom that side lies on the left:
    //! velocities and speeds of the right side change their sign.
    struct Side
    {
        GasState gas; // with the shifted pressure
        Real velocity;
        Real sound_speed;
        // Density and velocity behind the wave, speeds of the wave.
        Real star_density;
        Real star_velocity;
        Real head;
        Real tail;
    };

    Side makeSide( const GasState& gas, Real sign ) const;
    Real jump( const Side& side, Real pressure ) const;
    Real jumpDerivative( const Side& side, Real pressure ) const;
    Real solvePressure() const;
    void closeSide( Side& side ) const;
    GasState sampleSide( const Side& side, Real speed, Real sign ) const;

    Real _gamma;
    Real _offset;
    Side _left;
    Side _right;
    Real _star_pressure; // shifted
    Real _star_velocity;
    bool _has_vacuum;
};

//! An exact solution in space and time.
class ExactSolution
{
  public:
    virtual ~ExactSolution();

    /*!
      \brief The state of the gas.
      \param x Position [3]; components beyond the dimension are ignored.
      \param t Time, >= 0.
    */
    virtual GasState state( const Vector<3>& x, Real t ) const = 0;
};

/*!
  \brief The exact solution that an input names.

  - `riemann`: the first `riemann` of `initial`, in the gas of `physics`;
  - `uniform`: the first `uniform` of `initial`, everywhere and for ever;
  - `hydrostatic`: the first `hydrostatic` of `initial`, an isothermal column;
  - `piston_shock`: the first `uniform` of `initial`, into which a piston moves
    with constant velocity.

  \param resolved_input A whole input, checked, with its defaults filled in.
  \return Null if the input has no `exact`.
  \throws std::invalid_argument naming the place where the input lacks what its
  `exact` needs, or has no such solution.
*/
std::unique_ptr<ExactSolution> makeExact( const Json& resolved_input );

//! The exact solutions and their declared parameters.
Family exactFamily();

} // namespace Machpoint

#endif // MACHPOINT_EXACT_HPP
