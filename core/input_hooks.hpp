/*!
  \file input_hooks.hpp
  \brief Layer 4: what a module type says of its entry of an input, before a
  module is made of it.
*/
#ifndef MACHPOINT_INPUT_HOOKS_HPP
#define MACHPOINT_INPUT_HOOKS_HPP

#include <core/errors.hpp>
#include <core/flow_facts.hpp>
#include <core/gas_state.hpp>
#include <core/sides.hpp>

#include <functional>
#include <stdexcept>
#include <string>
#include <type_traits>
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

  Keys of these names mean the same in all types:

  | key | what it is |
  |---|---|
  | `type` | the module's name: no type declares it |
  | `name` | a text: of its series' file, and of the module in reports |
  | `side` | a choice, which reports tell behind the type |
  | `region` | a shape; of a boundary the part of its sides that it takes |
  | `treatment`, `image_reach` | of a body what they are of an `obstacle` |

  A type that declares one of the first four as anything else is refused.
*/
struct InputHooks
{
    //! Fills in defaults that depend on the method.
    std::function<void( Json& entry, const MethodFacts& )> complete;
    //! What is wrong that no single key can tell, with a remedy: "must ...";
    //! of a key "/velocity: must point into ..."; empty: nothing. It is told
    //! behind the entry's place.
    std::function<std::string( const Json& entry, const MethodFacts& )> fault;
    //! The sides of the domain that a boundary takes, which `complete` has no
    //! part in; null: none.
    std::function<std::vector<SideClaim>( const Json& entry )> sides;
    //! What gas a boundary shows beyond a side that it takes to `gas` before
    //! it, so that `check` finds shocks; null: nobody knows. (Whether
    //! the boundary does nothing else to the gas, KeepsUniformGas says.)
    std::function<GasState( const Json& entry, int side, const GasState& gas )>
        beyond;
    //! Layers of cells next to its sides that a boundary keeps in the state
    //! that `beyond` shows, whatever is there; null: none.
    std::function<int( const Json& entry )> imposedCells;
    //! Shape of the solid body that a boundary puts into the gas; null: none.
    std::function<Json( const Json& entry )> solid;
    //! Columns of its series but "time", whose name is the entry's "name":
    //! what a study can take for an error, of an effect or of a boundary;
    //! null: none.
    std::function<std::vector<std::string>()> columns;
    //! Why the scene cannot feel an effect (`entry` of it), or will feel its
    //! absence (null), with a remedy; empty: nothing to say. `check` asks.
    std::function<std::string( const Json* entry, const FlowFacts& )> remark;
    //! Does a boundary leave a gas alone that is uniform, where `beyond` shows
    //! the same gas, or a body one at rest? Its type says so by
    //! `using KeepsUniformGas = Itself;`, which types that derive from it
    //! have to say anew.
    bool keeps_uniform_gas = false;
};

//! For an error of a module, or of what its type says.
inline std::string whereOf( const std::string& module,
                            const std::string& function )
{
    return module + " in " + function;
}

//! The same function, whose errors name the module.
template <class Return, class... Arguments>
std::function<Return( Arguments... )>
namingErrors( const char* module, const char* function,
              const std::function<Return( Arguments... )>& action )
{
    return [=]( Arguments... arguments ) -> Return
    {
        return naming( [&]() -> Return { return action( arguments... ); },
                       [&] { return whereOf( module, function ); } );
    };
}

//! Sides that there are. \throws std::logic_error one of them is not
inline std::vector<SideClaim> checkedSides( std::vector<SideClaim> claims,
                                            const std::string& module,
                                            const int dimension )
{
    for ( const auto& claim : claims )
        if ( claim.side < 0 || claim.side >= 2 * dimension )
            throw std::logic_error(
                module + " claims side " + std::to_string( claim.side ) +
                "; in " + std::to_string( dimension ) + "D they are 0 to " +
                std::to_string( 2 * dimension - 1 ) +
                ", 2 * axis + (upper ? 1 : 0)" );
    return claims;
}

namespace Impl
{
//! A type's members, and one more: where that has the name of one of the
//! type's, whoever may use it, the name is ambiguous. (None may derive from a
//! final type.)
template <class Type, class Named, bool = std::is_final_v<Type>>
struct WithName : Type, Named
{
};
template <class Type, class Named>
struct WithName<Type, Named, true> : Named
{
};
} // namespace Impl

//! Those that a module type has.
template <int Dim, class Type>
InputHooks inputHooksOf()
{
    InputHooks own;
#define MACHPOINT_TAKE_IF_THERE( hook )                                        \
    struct Named_##hook                                                        \
    {                                                                          \
        int hook;                                                              \
    };                                                                         \
    constexpr bool is_free_##hook = requires                                   \
    {                                                                          \
        &Impl::WithName<Type, Named_##hook>::hook;                             \
    };                                                                         \
    static_assert(                                                             \
        is_free_##hook || requires { &Type::hook; },                           \
        "the module's " #hook " is not public, or there are "                  \
        "several" );                                                           \
    if constexpr ( requires { &Type::hook; } )                                 \
    {                                                                          \
        using Function = decltype( own.hook );                                 \
        static_assert(                                                         \
            std::is_constructible_v<Function, decltype( &Type::hook )>,        \
            "the module's " #hook " is no static function with "               \
            "the parameters of InputHooks::" #hook );                          \
        own.hook = namingErrors( Type::name, #hook, Function( &Type::hook ) ); \
    }
    MACHPOINT_TAKE_IF_THERE( complete )
    MACHPOINT_TAKE_IF_THERE( fault )
    MACHPOINT_TAKE_IF_THERE( sides )
    if ( own.sides )
        own.sides = [named = own.sides]( const Json& entry )
        { return checkedSides( named( entry ), Type::name, Dim ); };
    MACHPOINT_TAKE_IF_THERE( beyond )
    MACHPOINT_TAKE_IF_THERE( imposedCells )
    MACHPOINT_TAKE_IF_THERE( solid )
    MACHPOINT_TAKE_IF_THERE( columns )
    MACHPOINT_TAKE_IF_THERE( remark )
#undef MACHPOINT_TAKE_IF_THERE
    own.keeps_uniform_gas = requires
    {
        requires std::is_same_v<typename Type::KeepsUniformGas, Type>;
    };
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
