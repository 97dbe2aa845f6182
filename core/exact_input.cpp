/*!
  \file exact_input.cpp
  \brief What exact solutions take from an input: gas law, periods, directions,
  entries of `initial`.
*/
#include <core/exact.hpp>
#include <core/exact_input.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace Machpoint
{

Vector3 periodsOf( const Json& input )
{
    Vector3 periods{};
    for ( const Json& entry : input.at( "boundary" ) )
        if ( entry.at( "type" ) == "periodic" )
        {
            const int axis =
                entry.at( "side" ).get<std::string>().at( 0 ) - 'x';
            const Json& grid = input.at( "grid" );
            periods[axis] = grid.at( "upper" ).at( axis ).get<double>() -
                            grid.at( "lower" ).at( axis ).get<double>();
        }
    return periods;
}

Vector3 toNearestImage( Vector3 offset, const Vector3& periods )
{
    for ( int d = 0; d < 3; ++d )
        if ( periods[d] > 0 )
            offset[d] = std::remainder( offset[d], periods[d] );
    return offset;
}

std::optional<GasLaw> findGasLaw( const Json& input )
{
    for ( const Json& effect : input.at( "physics" ) )
    {
        if ( effect.at( "type" ) == "ideal_gas" )
            return GasLaw{ effect.at( "gamma" ).get<double>(), 0 };
        if ( effect.at( "type" ) == "stiffened_gas" )
            return GasLaw{ effect.at( "gamma" ).get<double>(),
                           effect.at( "reference_pressure" ).get<double>() };
    }
    return {};
}

GasLaw gasLaw( const Json& input )
{
    if ( const auto law = findGasLaw( input ) )
        return *law;
    throw std::invalid_argument( "needs an entry of type \"ideal_gas\" or "
                                 "\"stiffened_gas\" in /physics" );
}

Vector3 axisVector( const Json& axis )
{
    Vector3 result = { 0, 0, 0 };
    result[axis.get<std::string>().at( 0 ) - 'x'] = 1;
    return result;
}

Vector3 unitNormal( const Json& initial )
{
    if ( !initial.contains( "normal" ) )
        return axisVector( initial.at( "axis" ) );
    Vector3 normal = toVector3( initial.at( "normal" ) );
    const double length = std::hypot( normal[0], normal[1], normal[2] );
    if ( !( length > 0 ) )
        throw std::invalid_argument( "/exact: the normal of the " +
                                     initial.at( "type" ).get<std::string>() +
                                     " entry in /initial is zero" );
    for ( int d = 0; d < 3; ++d )
        normal[d] /= length;
    return normal;
}

AcousticWave makeAcousticWave( const Json& initial, const GasLaw& law )
{
    return { toGasState( initial ),      unitNormal( initial ),
             initial.at( "position" ),   initial.at( "amplitude" ),
             initial.at( "wavelength" ), law };
}

IsentropicVortex makeIsentropicVortex( const Json& initial, const GasLaw& law )
{
    return { toGasState( initial ), toVector3( initial.at( "center" ) ),
             initial.at( "strength" ), initial.at( "radius" ), law };
}

NohSolution makeNoh( const Json& initial, const GasLaw& law )
{
    const Json& center = initial.at( "center" );
    return { static_cast<int>( center.size() ), toVector3( center ),
             initial.at( "density" ),           initial.at( "speed" ),
             initial.at( "pressure" ),          law.gamma };
}

ViscousShock makeViscousShock( const Json& initial, const Json& resolved_input )
{
    const GasLaw law = gasLaw( resolved_input );
    double viscosity = 0, conductivity = 0;
    for ( const Json& effect : resolved_input.at( "physics" ) )
        if ( effect.at( "type" ) == "viscosity" )
            viscosity += 4 * effect.at( "shear" ).get<double>() / 3 +
                         effect.at( "bulk" ).get<double>();
        else if ( effect.at( "type" ) == "heat_conduction" )
            conductivity += effect.at( "conductivity" ).get<double>();
    if ( !( viscosity > 0 ) )
        throw std::invalid_argument(
            "/physics: a viscous_shock needs an effect of the type viscosity" );
    const double due = law.gamma * viscosity;
    if ( std::abs( conductivity - due ) > 1e-6 * due )
        throw std::invalid_argument( fmt::format(
            "/physics: a viscous_shock needs heat_conduction with a "
            "conductivity of gamma (4/3 shear + bulk) = {:.8g}, and here it is "
            "{:g}",
            due, conductivity ) );
    return { toGasState( initial ),
             unitNormal( initial ),
             initial.at( "position" ),
             initial.at( "mach" ),
             viscosity,
             law.gamma,
             law.pressure_offset };
}

} // namespace Machpoint
