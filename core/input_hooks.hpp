/*!
  \file input_hooks.hpp
  \brief Layer 4: what a module type says of its entry of an input, before a
  module is made of it.
*/
#ifndef MACHPOINT_INPUT_HOOKS_HPP
#define MACHPOINT_INPUT_HOOKS_HPP

#include <core/flow_facts.hpp>
#include <core/gas_state.hpp>
#include <core/halo.hpp>

#include <functional>
#include <string>
#include <vector>

namespace Machpoint
{

//! What one side of the domain is, where `Module::covers` says so.
struct SideClaim
{
    int side; //!< 2 * axis + (upper ? 1 : 0)
    SideKind kind;
};

//! What an entry may ask of the method.
struct MethodFacts
{
    std::string name; //!< `method.name`
    bool has_images;  //!< does it take mirror images of particles?
};

/*!
  \brief Static functions of a module type, each of which it may leave out: it
  is null then. Asked is the type in the input's dimension; entries are
  resolved.
*/
struct InputHooks
{
    //! Fills in defaults that depend on the method.
    std::function<void( Json& entry, const MethodFacts& )> complete;
    //! What is wrong that no single key can tell, from the entry's place on,
    //! with a remedy: "/velocity: must point into ..."; empty: nothing.
    std::function<std::string( const Json& entry, const MethodFacts& )> fault;
    //! The sides of the domain that a boundary takes; null: none.
    std::function<std::vector<SideClaim>( const Json& entry )> sides;
    //! What gas a boundary shows beyond a side that it takes to `gas` before
    //! it, so that `check` finds shocks; null: nobody knows.
    std::function<GasState( const Json& entry, int side, const GasState& gas )>
        beyond;
    //! Shape of the solid body that a boundary puts into the gas; null: none.
    std::function<Json( const Json& entry )> solid;
    //! Columns of its series but "time", whose name is the entry's "name":
    //! what a study can take for an error; null: none.
    std::function<std::vector<std::string>()> columns;
    //! Why the scene cannot feel an effect (`entry` of it), or will feel its
    //! absence (null), with a remedy; empty: nothing to say. `check` asks.
    std::function<std::string( const Json* entry, const FlowFacts& )> remark;
};

//! Those that a module type has.
template <class Type>
InputHooks inputHooksOf()
{
    InputHooks own;
#define MACHPOINT_TAKE_IF_THERE( hook )                                        \
    if constexpr ( requires { &Type::hook; } )                                 \
        own.hook = &Type::hook;
    MACHPOINT_TAKE_IF_THERE( complete )
    MACHPOINT_TAKE_IF_THERE( fault )
    MACHPOINT_TAKE_IF_THERE( sides )
    MACHPOINT_TAKE_IF_THERE( beyond )
    MACHPOINT_TAKE_IF_THERE( solid )
    MACHPOINT_TAKE_IF_THERE( columns )
    MACHPOINT_TAKE_IF_THERE( remark )
#undef MACHPOINT_TAKE_IF_THERE
    return own;
}

//! Names of the sides, "x_lower" first: side 2 * axis + (upper ? 1 : 0).
//! \param dimension 0: of all axes
inline std::vector<std::string> sideNames( const int dimension )
{
    const std::vector<std::string> all = { "x_lower", "x_upper", "y_lower",
                                           "y_upper", "z_lower", "z_upper" };
    return { all.begin(), all.begin() + 2 * ( dimension ? dimension : 3 ) };
}

//! Number of a side from its name, as validated before.
inline int sideNumber( const Json& name )
{
    const auto text = name.get<std::string>();
    return 2 * ( text[0] - 'x' ) + ( text.substr( 2 ) == "upper" ? 1 : 0 );
}

} // namespace Machpoint

#endif
