/*!
  \file exact.hpp
  \brief Exact solutions that computed results are measured against; host only.
*/
#ifndef MACHPOINT_EXACT_HPP
#define MACHPOINT_EXACT_HPP

#include <core/gas_state.hpp>
#include <core/viscous_shock.hpp>

#include <array>
#include <memory>
#include <optional>
#include <utility>

namespace Machpoint
{

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
    RiemannSolution( GasState left, GasState right, double gamma,
                     double pressure_offset = 0 );

    /*!
      \brief The state on the ray x / t; infinite values are welcome.

      Within vacuum the density is 0, the pressure that of a cold gas, and the
      normal velocity x / t, which continues the fan beside it.
    */
    GasState sample( double x_over_t ) const;

    //! Pressure between the two waves; that of a cold gas, -p_inf, beside
    //! vacuum.
    double starPressure() const { return _star_pressure - _offset; }

    //! Velocity of the contact; beside vacuum that of the gas' front, and the
    //! mean of both fronts where vacuum opens between them.
    double starVelocity() const { return _star_velocity; }

    //! Is there vacuum, given or generated?
    bool hasVacuum() const { return _has_vacuum; }

    /*!
      \brief Speeds of the left wave's head and tail, the contact, and the
      right wave's tail and head, in ascending order.

      The solution is smooth in between. Head and tail of a shock are equal;
      where vacuum opens the tails are its fronts; a side that is vacuum itself
      has the front of the other one for both.
    */
    std::array<double, 5> waveSpeeds() const;

  private:
    //! One side's wave as seen by someone to whom that side lies on the left:
    //! velocities and speeds of the right side change their sign.
    struct Side
    {
        GasState gas; // with the shifted pressure
        double velocity;
        double sound_speed;
        // Density and velocity behind the wave, speeds of the wave.
        double star_density;
        double star_velocity;
        double head;
        double tail;
    };

    Side makeSide( const GasState& gas, double sign ) const;
    double jump( const Side& side, double pressure ) const;
    double jumpDerivative( const Side& side, double pressure ) const;
    double solvePressure() const;
    void closeSide( Side& side ) const;
    GasState sampleSide( const Side& side, double speed, double sign ) const;

    double _gamma;
    double _offset;
    Side _left;
    Side _right;
    double _star_pressure; // shifted
    double _star_velocity;
    bool _has_vacuum;
};

//! Ratio of specific heats and \f$ p_\infty \f$ of a stiffened gas; the latter
//! is 0 for an ideal gas.
struct GasLaw
{
    double gamma;           //!< > 1
    double pressure_offset; //!< p_inf >= 0, pressure
};

//! The lengths [3] after which the gas of a resolved input repeats along the
//! axes, 0 along those that are not periodic.
Vector3 periodsOf( const Json& resolved_input );

//! From a place to the nearest of its periodic images. \param offset [3] to one
Vector3 toNearestImage( Vector3 offset, const Vector3& periods );

//! The law of the equation of state in `physics` of a resolved input; none
//! where that is neither ideal_gas nor stiffened_gas.
std::optional<GasLaw> findGasLaw( const Json& resolved_input );

//! The same where it has to be known. \throws std::invalid_argument
GasLaw gasLaw( const Json& resolved_input );

/*!
  \brief A sine wave of finite amplitude that runs along a line, up to the
  time at which it breaks.

  At t = 0 the velocity is \f$ v_0 + A c_0 n \sin( 2 \pi ( n \cdot x - s_0 ) /
  \lambda ) \f$ with one Riemann invariant and the entropy constant; each value
  then travels with its own speed v + c.

  Source: L. D. Landau and E. M. Lifshitz, Fluid Mechanics, 2nd ed., 1987,
  sections 101 and 102 (simple waves).
*/
class AcousticWave
{
  public:
    //! \param background state that the wave runs into
    //! \param direction n, a unit vector
    //! \param position s_0, where a node of the sine stands
    //! \param amplitude A, velocity over sound speed, 0 to 2 / (gamma - 1)
    //! \param wavelength lambda > 0
    //! \throws std::invalid_argument for other amplitudes
    AcousticWave( const GasState& background, const Vector3& direction,
                  double position, double amplitude, double wavelength,
                  const GasLaw& law );

    //! \param x position [3], length \param t from 0 to breakingTime()
    GasState state( const Vector3& x, double t ) const;

    //! d/ds of the velocity along the direction at t = 0, s = n . x. 1/time
    double initialSlope( const Vector3& x ) const;

    //! When characteristics first meet; infinite without amplitude.
    double breakingTime() const;

    //! The unit vector along which it runs.
    const Vector3& direction() const { return _direction; }

  private:
    GasState _background;
    Vector3 _direction;
    double _position;
    double _amplitude;
    double _wave_number;
    GasLaw _law;
    double _sound_speed; // of the background
};

/*!
  \brief An isentropic vortex that a stream carries along.

  With R the radius, r the distance from the moving centre, S the strength:
  \f$ v_\theta = S r / (2 \pi R) \exp( ( 1 - r^2 / R^2 ) / 2 ) \f$ and
  \f$ \delta( p / \rho ) = -( \gamma - 1 ) S^2 / ( 8 \gamma \pi^2 )
  \exp( 1 - r^2 / R^2 ) \f$ at the stream's entropy. It turns about the z axis.

  Source: H. C. Yee, N. D. Sandham and M. J. Djomehri, J. Comput. Phys. 150
  (1999) 199, with units made explicit.
*/
class IsentropicVortex
{
  public:
    //! \param stream the gas far away
    //! \param center of the vortex at t = 0 [3]
    //! \param strength S, a velocity
    //! \param radius R > 0
    //! \throws std::invalid_argument if the centre would be colder than cold
    IsentropicVortex( const GasState& stream, const Vector3& center,
                      double strength, double radius, const GasLaw& law );

    //! \param offset x - x_c [3] from the centre at that time, length
    GasState stateAt( const Vector3& offset ) const;

    //! d v_a / d x_b [2][2] at an offset from the centre, 1/time.
    std::array<std::array<double, 2>, 2>
    gradientAt( const Vector3& offset ) const;

    //! The centre at t = 0.
    const Vector3& center() const { return _center; }
    //! The gas far away.
    const GasState& stream() const { return _stream; }

  private:
    GasState _stream;
    Vector3 _center;
    double _strength;
    double _radius;
    GasLaw _law;
};

/*!
  \brief Cold gas that falls onto a plane, a line or a point.

  A shock runs outwards with speed \f$ ( \gamma - 1 ) u / 2 \f$; within it the
  gas is at rest at density \f$ \rho_0 ( ( \gamma + 1 ) / ( \gamma - 1 ) )^D
  \f$, outside it has \f$ \rho_0 ( 1 + u t / r )^{D-1} \f$. Exact for zero
  initial pressure p0; outside the shock the pressure is taken to follow
  adiabatically, inside it is that of the cold gas, so that the error is of the
  order of p0 / (rho0 u^2).

  Source: W. F. Noh, J. Comput. Phys. 72 (1987) 78.
*/
class NohSolution
{
  public:
    //! \param dimension D: 1 planar, 2 cylindrical, 3 spherical
    //! \param center where the gas falls to [3]
    //! \param density, speed, pressure of the gas at t = 0
    NohSolution( int dimension, const Vector3& center, double density,
                 double speed, double pressure, double gamma );

    //! \param x position [3], components beyond D are ignored
    //! \param t time; up to 0 the gas as it begins
    GasState state( const Vector3& x, double t ) const;

    //! Unit vector away from the centre, 0 there, and the distance, length.
    std::pair<Vector3, double> radial( const Vector3& x ) const;

  private:
    int _dimension;
    Vector3 _center;
    double _density;
    double _speed;
    double _pressure;
    double _gamma;
};

//! \name The solutions that entries of `initial` describe
//! \param initial the resolved entry
//! \throws std::invalid_argument where there is no such gas
//!@{
AcousticWave makeAcousticWave( const Json& initial, const GasLaw& law );
IsentropicVortex makeIsentropicVortex( const Json& initial, const GasLaw& law );
NohSolution makeNoh( const Json& initial, const GasLaw& law );
//! \param resolved_input whose gas and effects it needs
ViscousShock makeViscousShock( const Json& initial,
                               const Json& resolved_input );
//!@}

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
    virtual GasState state( const Vector3& x, double t ) const = 0;

    //! Is there gas, \c state being no more than its continuation elsewhere?
    //! There is none behind a piston. (At a place [3], and a time >= 0.)
    virtual bool hasGas( const Vector3&, double ) const { return true; }

    //! Is its gas at t = 0 that of `initial`? A point explosion is spread
    //! there.
    virtual bool holdsAtStart() const { return true; }
};

/*!
  \brief The exact solution that an input names. Of several of
  the type named it is the last that fills the domain, or else the last.

  - `riemann`: the `riemann` of `initial`, in the gas of `physics`;
  - `uniform`: the `uniform` of `initial`, everywhere and for ever;
  - `hydrostatic`: the `hydrostatic` of `initial`, a column at rest;
  - `piston_shock`: the `uniform` of `initial`, into which a piston moves
    with constant velocity;
  - `acoustic_wave`: the `acoustic_wave` of `initial`, while it is smooth;
  - `isentropic_vortex`: the one of `initial`, carried along by its stream
    and through the sides that are periodic;
  - `noh`: the `noh` of `initial`, in infinite space;
  - `sedov`: the `blast` of `initial`, set free at a point of uniform gas
    without pressure; outside the shock that gas as it is;
  - `viscous_shock`: the one of `initial`, in infinite space.

  \param resolved_input A whole input, checked, with its defaults filled in.
  \return Null if the input has no `exact`.
  \throws std::invalid_argument naming the place where the input lacks what its
  `exact` needs, a gas whose law is known among it, or has no such solution.
*/
std::unique_ptr<ExactSolution> makeExact( const Json& resolved_input );

//! The exact solutions and their declared parameters.
Family exactFamily();

} // namespace Machpoint

#endif // MACHPOINT_EXACT_HPP
