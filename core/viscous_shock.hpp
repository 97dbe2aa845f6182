/*!
  \file viscous_shock.hpp
  \brief A shock of viscous, heat-conducting gas, within its width; host only.
*/
#ifndef MACHPOINT_VISCOUS_SHOCK_HPP
#define MACHPOINT_VISCOUS_SHOCK_HPP

#include <core/gas_state.hpp>

namespace Machpoint
{

/*!
  \brief A plane shock that runs into uniform gas, where viscosity and heat
  conduction balance: k = gamma mu with mu = 4/3 shear + bulk, which is a
  Prandtl number of 3/4 without bulk viscosity.

  Seen from the shock the total enthalpy is then the same everywhere, and with
  u from u_1 ahead to u_2 behind, j = rho u and s along the stream
  \f$ \mu u' = j ( \gamma + 1 ) / ( 2 \gamma ) ( u - u_1 ) ( u - u_2 ) / u \f$.

  Source: R. Becker, Z. Phys. 8 (1922) 321; in this form
  M. Morduchow and P. A. Libby, J. Aeronaut. Sci. 16 (1949) 674.
*/
class ViscousShock
{
  public:
    //! \param ahead the gas that it runs into
    //! \param direction in which it runs, a unit vector
    //! \param position of the steepest velocity at t = 0, along the direction
    //! \param mach its speed through that gas, in sound speeds, > 1
    //! \param viscosity mu > 0, mass length^(2-Dim)/time
    //! \param gamma > 1 \param pressure_offset p_inf of a stiffened gas
    //! \throws std::invalid_argument for other Mach numbers and viscosities
    ViscousShock( const GasState& ahead, const Vector3& direction,
                  double position, double mach, double viscosity, double gamma,
                  double pressure_offset = 0 );

    //! \param x position [3], length \param t time, of either sign
    GasState state( const Vector3& x, double t ) const;

    //! Slope of the velocity along the direction at t = 0, 1/time.
    double initialSlope( const Vector3& x ) const;

    //! The unit vector in which it runs.
    const Vector3& direction() const { return _direction; }

  private:
    //! \param s along the direction, from the middle of the shock
    //! \return velocity that it has over the gas there
    double speedAt( double s ) const;

    GasState _ahead;
    Vector3 _direction;
    double _position;
    double _gamma;
    double _offset;
    double _velocity;       // of the shock, along the direction
    double _before, _after; // u_1, u_2
    double _length;         // 2 gamma mu / ((gamma + 1) j)
};

} // namespace Machpoint

#endif
