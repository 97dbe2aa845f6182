#include <core/initial_gas.hpp>

#include <core/scene.hpp>
#include <physics/modules.hpp>

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace Machpoint
{

namespace
{

template <std::size_t K = 0>
std::unique_ptr<InitialState> makeInitialState( const Json& json,
                                                const SceneFacts& facts )
{
    if constexpr ( K < std::tuple_size_v<InitialStates> )
    {
        using Type = std::tuple_element_t<K, InitialStates>;
        if ( json.at( "type" ) == Type::name )
        {
            if constexpr ( std::is_constructible_v<Type, const Json&,
                                                   const SceneFacts&> )
                return std::make_unique<Type>( json, facts );
            else
                return std::make_unique<Type>( json );
        }
        return makeInitialState<K + 1>( json, facts );
    }
    throw std::logic_error( "no initial state " + json.at( "type" ).dump() );
}

} // namespace

template <int Dim>
InitialGas<Dim>::InitialGas( const Json& input )
    : _hair( nudge * makeGrid<Dim>( input ).minSpacing() ),
      _law( findGasLaw( input ) )
{
    const SceneFacts facts{ Dim, input };
    for ( const auto& json : input.at( "initial" ) )
    {
        Entry entry;
        try
        {
            entry.state = makeInitialState( json, facts );
        }
        catch ( const std::invalid_argument& error )
        {
            throw InputError( { fmt::format( "/initial/{}: {}", _entries.size(),
                                             error.what() ) } );
        }
        entry.is_everywhere = !json.contains( "region" );
        if ( !entry.is_everywhere )
            entry.region =
                makeShape<Dim, Kokkos::HostSpace>( json.at( "region" ) );
        _entries.push_back( std::move( entry ) );
    }
}

template <int Dim>
GasState InitialGas<Dim>::at( const Vector<Dim>& x, Gradient& gradient ) const
{
    Vector3 place{};
    for ( int d = 0; d < Dim; ++d )
        place[d] = x[d];
    GasState gas{};
    gradient = {};
    for ( const auto& entry : _entries )
        if ( reaches( entry, x ) )
            entry.state->apply( place, gas, gradient );
    return gas;
}

template <int Dim>
std::string InitialGas<Dim>::fault( const Vector<Dim>& x,
                                    const GasState& gas ) const
{
    const double least = _law ? -_law->pressure_offset
                              : -std::numeric_limits<double>::infinity();
    const double square = dot<3>( gas.velocity, gas.velocity );
    constexpr double smallest = 1 / largest_quantity, most = largest_quantity;
    if ( gas.density == 0 ||
         ( gas.density > smallest && gas.density < most &&
           gas.pressure >= least && gas.pressure < most &&
           gas.pressure / gas.density < most && square < most ) )
        return {};
    std::size_t last = 0; // entry that reaches x
    for ( std::size_t k = 0; k < _entries.size(); ++k )
        if ( reaches( _entries[k], x ) )
            last = k;
    std::string place;
    for ( int d = 0; d < Dim; ++d )
        place += fmt::format( "{}{:.6g}", d ? ", " : "", x[d] );
    return fmt::format(
        "/initial/{}: no gas has the density {:.6g}, pressure {:.6g} and speed "
        "{:.6g} that are asked for at ({}); change the entry's numbers, or the "
        "domain",
        last, gas.density, gas.pressure, std::sqrt( square ), place );
}

template class InitialGas<1>;
template class InitialGas<2>;
template class InitialGas<3>;

} // namespace Machpoint
