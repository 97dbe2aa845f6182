/*!
  \file gravity.hpp
  \brief A uniform acceleration.
*/
#ifndef MACHPOINT_GRAVITY_HPP
#define MACHPOINT_GRAVITY_HPP

#include <core/flow_facts.hpp>
#include <core/module.hpp>
#include <core/node_force.hpp>

#include <fmt/format.h>

#include <cmath>

namespace Machpoint
{

/*!
  \brief Force m_i g on every node, with the mass folded as a force along g, so
  that walls reflect it as they reflect pressure.

  The work done on the gas is known exactly (workOnNodes); it goes to the
  ledger.
*/
template <int Dim>
class Gravity : public Module<Dim>
{
  public:
    //! \name What an input says of it: see ModuleFactory and InputHooks
    //! @{
    static constexpr const char* name = "gravity";

    static Parameters declare( const int dimension )
    {
        Parameters p( name, "uniform acceleration of all gas", dimension );
        p.vector( "acceleration", "g" ).unit( "length/time^2" );
        return p;
    }

    //! Is it that in which the initial gas is in balance, and can it be felt?
    static std::string remark( const Json* entry, const FlowFacts& flow )
    {
        const Json none = Json::array();
        const Json& g = entry ? entry->at( "acceleration" ) : none;
        for ( const auto& state : flow.input.at( "initial" ) )
            if ( state.contains( "gravity" ) )
            {
                const auto axis = state.at( "axis" ).get<std::string>();
                const double whole = state.at( "gravity" );
                for ( int d = 0; d < Dim; ++d )
                {
                    const double due = d == axis[0] - 'x' ? whole : 0;
                    const double real = entry ? g[d].get<double>() : 0.0;
                    if ( std::abs( real - due ) > 1e-6 * std::abs( whole ) )
                        return fmt::format(
                            "the gas of {} is in balance with a gravity of {} "
                            "along {}, and the scene has {}; give both the "
                            "same",
                            state.at( "type" ).get<std::string>(), due,
                            "xyz"[d], real );
                }
            }
        // Weight changes the pressure by the order of (1 / Fr)^2 of itself and
        // the velocity by |g| T / U. Round-off, 1e-16 a step (6e-8 in single
        // precision), sums up to this in some thousand steps.
        constexpr double vanishing = is_single ? 1e-4 : 1e-12;
        double square = 0, depth = 0;
        for ( std::size_t d = 0; d < g.size(); ++d )
        {
            square += g[d].get<double>() * g[d].get<double>();
            depth += std::abs( g[d].get<double>() ) *
                     flow.extent[static_cast<int>( d )];
        }
        const double U = flow.least_speed;
        const double T = flow.input.at( "time" ).at( "end" );
        if ( !entry || depth > vanishing * U * U ||
             std::sqrt( square ) * T > vanishing * U )
            return "";
        return fmt::format(
            "with a Froude number of {:.2g} gravity vanishes in round-off: it "
            "changes pressure and velocity by less than {:g} of themselves; "
            "leave it out, or look at its unit",
            U / std::sqrt( depth ), vanishing );
    }

    explicit Gravity( const Json& json )
        : _g( toVector<Dim>( json.at( "acceleration" ) ) )
    {
    }
    //! @}

    bool exertsForce( const int axis ) const override { return _g[axis] != 0; }
    Vector<Dim> acceleration() const override { return _g; }

    //! Gas at rest must not fall further than that in a step: what counts for
    //! cold gas, as c bounds the step of any other. sqrt(CFL h / |g|)
    Real limitTimeStep( State<Dim>& state ) override
    {
        Real limit = Kokkos::Experimental::infinity_v<Real>;
        for ( int d = 0; d < Dim; ++d )
            if ( _g[d] != 0 )
                limit = Kokkos::min(
                    limit, Kokkos::sqrt( static_cast<Real>( state.cfl ) *
                                         state.grid.spacing[d] /
                                         Kokkos::abs( _g[d] ) ) );
        return limit;
    }

    void layOut( State<Dim>& state ) override
    {
        _force = makeNodeSum( "Machpoint::gravity", state, Dim );
    }

    void keepDeposit( State<Dim>& state ) override
    {
        _force.copyDeposit( state.nodes.moment_sum, 0 );
    }

    void gridForce( State<Dim>& state ) override
    {
        foldWeight( state, _force );
        pushNodes<Dim>( state, _force.field(), _g ); // until here the mass
    }

    void gridWork( State<Dim>& state ) override
    {
        state.ledger.energy_in += workOnNodes( state, _force.field() );
    }

  private:
    Vector<Dim> _g;
    NodeSum _force; // mass, then force [nodes][Dim]
};

} // namespace Machpoint

#endif
