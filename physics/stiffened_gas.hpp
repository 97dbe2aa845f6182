/*!
  \file stiffened_gas.hpp
  \brief p = (gamma - 1) rho e - gamma p_inf: a liquid-like gas.
*/
#ifndef MACHPOINT_STIFFENED_GAS_HPP
#define MACHPOINT_STIFFENED_GAS_HPP

#include <physics/evaluate_gas.hpp>

namespace Machpoint
{

//! Stiffened gas (Harlow and Amsden 1971; Menikoff and Plohr 1989).
template <int Dim>
class StiffenedGas : public EquationOfState<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "stiffened_gas";

    static Parameters declare( const int dimension )
    {
        Parameters p( name,
                      "equation of state p = (gamma - 1) rho e - gamma p_inf",
                      dimension );
        p.number( "gamma", "ratio of specific heats" )
            .above( 1 )
            .defaultsTo( 4.4 )
            .source( "Harlow and Amsden 1971; 4.4 for water" );
        p.number( "reference_pressure", "p_inf, the gas's cohesion" )
            .unit( "pressure" )
            .atLeast( 0 )
            .defaultsTo( 0 )
            .source( "Menikoff and Plohr 1989" );
        return p;
    }

    explicit StiffenedGas( const Json& json )
        : _gamma( json.at( "gamma" ) ),
          _reference( json.at( "reference_pressure" ) )
    {
    }
    //! @}

    Real specificInternalEnergy( const Real density,
                                 const Real pressure ) const override
    {
        return ( pressure + _gamma * _reference ) /
               ( ( _gamma - 1 ) * density );
    }

    GasSurvey evaluate( State<Dim>& state, const bool surveys ) override
    {
        return evaluateGas( state, surveys, Formula{ _gamma, _reference } );
    }

    PressureResponse response() const override
    {
        return { _gamma, _gamma - 1, _reference };
    }

    //! For evaluateGas. Public only because nvcc wants the types of a kernel to
    //! be accessible.
    struct Formula
    {
        Real gamma, reference; //!< the latter is p_inf

        //! p = (gamma - 1) rho e - gamma p_inf and c^2 = gamma (p + p_inf) /
        //! rho, below 0 where torn apart.
        KOKKOS_FORCEINLINE_FUNCTION ThermodynamicState
        operator()( const Lanes& density, const Lanes& energy ) const
        {
            const Lanes pressure =
                ( gamma - 1 ) * density * energy - gamma * reference;
            return { pressure, gamma * ( pressure + reference ) / density };
        }
    };

  private:
    Real _gamma;
    Real _reference;
};

} // namespace Machpoint

#endif
