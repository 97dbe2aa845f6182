/*!
  \file registry.hpp
  \brief From a name in the input to a module: the lists of modules, and how a
  program outside this repository adds its own.
*/
#ifndef MACHPOINT_REGISTRY_HPP
#define MACHPOINT_REGISTRY_HPP

#include <core/module.hpp>

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace Machpoint
{

//! Hooks of Module that the time loop calls with the state, of the modules that
//! override them. One that is not in this list would never be called, but for
//! rejectStep, which is called of all.
#define MACHPOINT_HOOKS( APPLY )                                               \
    APPLY( layOut )                                                            \
    APPLY( initialize )                                                        \
    APPLY( particleState )                                                     \
    APPLY( limitTimeStep )                                                     \
    APPLY( mirrorParticles )                                                   \
    APPLY( keepDeposit )                                                       \
    APPLY( gridForce )                                                         \
    APPLY( applyToGrid )                                                       \
    APPLY( gridWork )                                                          \
    APPLY( particleSource )                                                    \
    APPLY( applyToParticles )                                                  \
    APPLY( inject )

//! What else a module may override.
#define MACHPOINT_ANSWERS( APPLY )                                             \
    APPLY( imageReach )                                                        \
    APPLY( acceleration )                                                      \
    APPLY( covers )                                                            \
    APPLY( isSolid )                                                           \
    APPLY( isOpen )                                                            \
    APPLY( exertsForce )                                                       \
    APPLY( checkpoint )                                                        \
    APPLY( rejectStep )                                                        \
    APPLY( series )

//! Names of the hooks.
enum class Hook : unsigned
{
#define MACHPOINT_NAME( hook ) hook,
    MACHPOINT_HOOKS( MACHPOINT_NAME )
#undef MACHPOINT_NAME
};

//! As in the code, for messages.
constexpr const char* nameOf( const Hook hook )
{
    switch ( hook )
    {
#define MACHPOINT_NAME( hook )                                                 \
    case Hook::hook:                                                           \
        return #hook;
        MACHPOINT_HOOKS( MACHPOINT_NAME )
#undef MACHPOINT_NAME
    }
    return "";
}

//! Those that a module type overrides: no others are called.
class Hooks
{
  public:
    constexpr bool has( const Hook hook ) const { return _bits & bit( hook ); }
    constexpr void add( const Hook hook ) { _bits |= bit( hook ); }

  private:
    static constexpr unsigned bit( const Hook hook )
    {
        return 1u << static_cast<unsigned>( hook );
    }

    unsigned _bits = 0;
};

//! The type of a pointer to a member as one to a member of another class.
template <class Type, class Member>
struct AsMemberOf;
//! Of functions.
template <class Type, class Function, class Owner>
struct AsMemberOf<Type, Function Owner::*>
{
    using type = Function Type::*; //!< with the same parameters
};

//! Is a member of `Type` that has a hook's name the hook, perhaps overridden?
//! If not it only hides it, and nothing calls it. \tparam Own its pointer
//! \tparam Hook that of Module
template <class Type, class Own, class Hook>
inline constexpr bool is_hook =
    std::is_convertible_v<Own, typename AsMemberOf<Type, Hook>::type>;

//! The hooks that a module type overrides. A pointer to a hook is one to a
//! member of the class that overrides it last. (What cannot be asked for, as it
//! is private, is taken for one.)
template <int Dim, class Type>
constexpr Hooks hooksOf()
{
    Hooks own;
#define MACHPOINT_REQUIRE_SIGNATURE( hook )                                    \
    if constexpr ( requires { &Type::hook; } )                                 \
        static_assert( is_hook<Type, decltype( &Type::hook ),                  \
                               decltype( &Module<Dim>::hook )>,                \
                       "the module's " #hook " has not the parameters of "     \
                       "Module::" #hook ", so nothing would call it: write "   \
                       "override behind it, and the compiler tells why" );
    MACHPOINT_HOOKS( MACHPOINT_REQUIRE_SIGNATURE )
    MACHPOINT_ANSWERS( MACHPOINT_REQUIRE_SIGNATURE )
#undef MACHPOINT_REQUIRE_SIGNATURE
#define MACHPOINT_ADD_IF_OVERRIDDEN( hook )                                    \
    if constexpr ( !requires {                                                 \
                       requires std::is_same_v<                                \
                           decltype( &Type::hook ),                            \
                           decltype( &Module<Dim>::hook )>;                    \
                   } )                                                         \
        own.add( Hook::hook );
    MACHPOINT_HOOKS( MACHPOINT_ADD_IF_OVERRIDDEN )
#undef MACHPOINT_ADD_IF_OVERRIDDEN
    return own;
}

//! How to declare and make one kind of module.
template <int Dim>
struct ModuleFactory
{
    std::string name; //!< "type" of its entries
    //! Its keys. \param dimension 1 to 3, or 0 for any
    std::function<Parameters( int dimension )> declare;
    //! Equations of state are made before all others, which may need them.
    bool is_equation_of_state;
    //! From a resolved entry and the scene's equation of state, which is null
    //! for that itself. Null where the build leaves the dimension out.
    std::function<std::unique_ptr<Module<Dim>>( const Json& resolved,
                                                const EquationOfState<Dim>* )>
        make;
    Hooks hooks{};      //!< that it overrides
    InputHooks input{}; //!< static functions that it has
};

//! What a module type declares. \param type its name
//! \throws std::logic_error it has another name there, or keys whose names
//! mean something else (InputHooks)
Parameters checkedDeclaration( const std::string& type, Parameters declared );

//! What an entry's module is called in reports: its type, and its `side` and
//! `name`.
std::string reportName( const Json& entry );

//! Converts to Json and to nothing else.
struct JsonAlone
{
    operator const Json&() const; //!< to ask for, never to call
};

//! Can a module be made from Json itself, not only from a number that Json
//! would become?
template <class Type>
inline constexpr bool is_made_from_json =
    std::is_abstract_v<Type> || // of which the compiler tells more
    std::is_constructible_v<Type, JsonAlone>;

//! What an input may say of a module type, without what makes one: kernels are
//! compiled where they are made. The type has `name` and `declare`, and static
//! functions of InputHooks.
template <int Dim, template <int> class ModuleType>
ModuleFactory<Dim> moduleDeclaration()
{
    using Type = ModuleType<Dim>;
    return { Type::name,
             []( const int dimension )
             {
                 return naming(
                     [&] {
                         return checkedDeclaration(
                             Type::name, Type::declare( dimension ) );
                     },
                     [] { return whereOf( Type::name, "declare" ); } );
             },
             std::is_base_of_v<EquationOfState<Dim>, Type>,
             nullptr,
             hooksOf<Dim, Type>(),
             inputHooksOf<Dim, Type>() };
}

//! The factory of a module type: constructible from its resolved JSON, or
//! from that and the equation of state. \throws std::logic_error for a side
//! without applyToParticles
template <int Dim, template <int> class ModuleType>
ModuleFactory<Dim> moduleFactory()
{
    using Type = ModuleType<Dim>;
    using Gas = EquationOfState<Dim>;
    constexpr bool takes_gas =
        std::is_constructible_v<Type, JsonAlone, const Gas&>;
    static_assert( takes_gas || is_made_from_json<Type>,
                   "a module needs a public constructor from const Json&, or "
                   "from that and const EquationOfState<Dim>&" );
    auto factory = moduleDeclaration<Dim, ModuleType>();
    factory.make = []( const Json& json,
                       const Gas* gas ) -> std::unique_ptr<Module<Dim>>
    {
        return naming(
            [&]() -> std::unique_ptr<Module<Dim>>
            {
                if constexpr ( takes_gas )
                    return std::make_unique<Type>( json, *gas );
                else
                {
                    static_cast<void>( gas );
                    return std::make_unique<Type>( json );
                }
            },
            [] { return whereOf( Type::name, "its constructor" ); } );
    };
    if ( factory.input.sides && !factory.hooks.has( Hook::applyToParticles ) )
        throw std::logic_error( std::string( Type::name ) +
                                " takes sides of the domain, so it has to say "
                                "in applyToParticles what becomes of the "
                                "particles beyond them" );
    return factory;
}

//! An explicit list of modules (physics/modules.hpp, boundary/modules.hpp).
template <template <int> class... ModuleTypes>
struct ModuleList
{
    //! Of all, in the order of the list.
    template <int Dim>
    static std::vector<ModuleFactory<Dim>> factories()
    {
        return { moduleFactory<Dim, ModuleTypes>()... };
    }

    //! The same of a dimension that Machpoint_DIMENSIONS leaves out.
    template <int Dim>
    static std::vector<ModuleFactory<Dim>> declarations()
    {
        return { moduleDeclaration<Dim, ModuleTypes>()... };
    }
};

//! \name All known modules, in the order of `machpoint list`
//! Defined once per dimension, in files generated from cmake/modules.cpp.in.
//! @{
template <int Dim>
std::vector<ModuleFactory<Dim>>& physicsModules();
template <>
std::vector<ModuleFactory<1>>& physicsModules<1>();
template <>
std::vector<ModuleFactory<2>>& physicsModules<2>();
template <>
std::vector<ModuleFactory<3>>& physicsModules<3>();
template <int Dim>
std::vector<ModuleFactory<Dim>>& boundaryModules();
template <>
std::vector<ModuleFactory<1>>& boundaryModules<1>();
template <>
std::vector<ModuleFactory<2>>& boundaryModules<2>();
template <>
std::vector<ModuleFactory<3>>& boundaryModules<3>();
//! @}

//! The factory of an entry's "type". \throws std::logic_error if there is none
template <int Dim>
const ModuleFactory<Dim>&
findFactory( const std::vector<ModuleFactory<Dim>>& factories,
             const Json& entry )
{
    const auto name = entry.at( "type" ).template get<std::string>();
    for ( const auto& factory : factories )
        if ( factory.name == name )
            return factory;
    throw std::logic_error( "no module " + name );
}

//! What the type of an entry of `physics` says of it.
//! \param dimension of the input
inline const InputHooks& physicsHooks( const Json& entry, const int dimension )
{
    return dimension == 1   ? findFactory( physicsModules<1>(), entry ).input
           : dimension == 2 ? findFactory( physicsModules<2>(), entry ).input
                            : findFactory( physicsModules<3>(), entry ).input;
}

//! The same of an entry of `boundary`.
inline const InputHooks& boundaryHooks( const Json& entry, const int dimension )
{
    return dimension == 1   ? findFactory( boundaryModules<1>(), entry ).input
           : dimension == 2 ? findFactory( boundaryModules<2>(), entry ).input
                            : findFactory( boundaryModules<3>(), entry ).input;
}

//! The sides that an entry of `boundary` takes, all or in part.
inline std::vector<SideClaim> sidesOf( const Json& entry, const int dimension )
{
    const auto& hooks = boundaryHooks( entry, dimension );
    return hooks.sides ? hooks.sides( entry ) : std::vector<SideClaim>();
}

//! Adds a module to a list. \throws std::invalid_argument the name is taken
template <template <int> class ModuleType, int Dim>
void addModule( std::vector<ModuleFactory<Dim>>& list )
{
    auto factory = moduleFactory<Dim, ModuleType>();
    for ( const auto& there : list )
        if ( there.name == factory.name )
            throw std::invalid_argument( "a module is called \"" +
                                         factory.name +
                                         "\" already; take another name" );
    list.push_back( std::move( factory ) );
}

//! Adds a physics module from outside this repository, before runCommandLine,
//! which does not see the error: uncaught, it ends the program with its text.
//! \throws std::invalid_argument its name is taken
template <template <int> class ModuleType>
void registerPhysics()
{
    addModule<ModuleType>( physicsModules<1>() );
    addModule<ModuleType>( physicsModules<2>() );
    addModule<ModuleType>( physicsModules<3>() );
}

//! The same for a boundary.
template <template <int> class ModuleType>
void registerBoundary()
{
    addModule<ModuleType>( boundaryModules<1>() );
    addModule<ModuleType>( boundaryModules<2>() );
    addModule<ModuleType>( boundaryModules<3>() );
}

//! \name The same as families of input objects
//! @{
Family physicsFamily();
Family boundaryFamily();
Family initialFamily();
//! @}

} // namespace Machpoint

#endif
