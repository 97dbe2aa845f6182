/*!
  \file ideal_gas.hpp
  \brief p = (gamma - 1) rho e.
*/
#ifndef MACHPOINT_IDEAL_GAS_HPP
#define MACHPOINT_IDEAL_GAS_HPP

#include <physics/evaluate_gas.hpp>

namespace Machpoint
{

//! Calorically perfect gas (Toro 2009, eq. 1.20).
template <int Dim>
class IdealGas : public EquationOfState<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "ideal_gas";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "equation of state p = (gamma - 1) rho e",
                      dimension );
        p.number( "gamma", "ratio of specific heats" )
            .above( 1 )
            .defaultsTo( 1.4 )
            .source( "Toro 2009, section 1.2" );
        return p;
    }

    explicit IdealGas( const Json& json ) : _gamma( json.at( "gamma" ) ) {}
    //! @}

    Real specificInternalEnergy( const Real density,
                                 const Real pressure ) const override
    {
        return pressure / ( ( _gamma - 1 ) * density );
    }

    GasSurvey evaluate( State<Dim>& state, const bool surveys ) override
    {
        return evaluateGas( state, surveys, Formula{ _gamma } );
    }

    PressureResponse response() const override
    {
        return { _gamma, _gamma - 1 };
    }

    //! For evaluateGas: p = (gamma - 1) rho e, c^2 = gamma (gamma - 1) e.
    //! Public only because nvcc wants the types of a kernel to be accessible.
    struct Formula
    {
        Real gamma;

        KOKKOS_FORCEINLINE_FUNCTION ThermodynamicState
        operator()( const Lanes& density, const Lanes& energy ) const
        {
            // The paper's energy update can lose all of a cold gas's energy:
            // c^2 is then below 0.
            const Lanes heat = ( gamma - 1 ) * energy;
            return { heat * density, gamma * heat };
        }
    };

  private:
    Real _gamma;
};

} // namespace Machpoint

#endif
