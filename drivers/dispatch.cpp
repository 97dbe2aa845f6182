// The one place where a choice made at run time meets a compiled stepper.
#include <core/basis.hpp>
#include <core/method_apic.hpp>
#include <core/method_conservative.hpp>
#include <core/method_paper.hpp>
#include <core/simulation.hpp>
#include <core/stepper_list.hpp>

#include <fmt/format.h>

namespace Machpoint
{

std::unique_ptr<Simulation> makeSimulation( const Json& input )
{
    const int dimension = input.at( "dimension" );
    const auto method = input.at( "method" ).at( "name" ).get<std::string>();
    const auto basis = input.at( "method" ).at( "basis" ).get<std::string>();
#define MACHPOINT_TRY( DIM, BASIS, METHOD )                                    \
    if ( dimension == DIM && basis == BASIS::name && method == METHOD::name )  \
        return makeSimulation<DIM, BASIS, METHOD>( input );
    MACHPOINT_FOR_EACH_STEPPER( MACHPOINT_TRY )
#undef MACHPOINT_TRY
    throw InputError( { fmt::format(
        "/method: this build has no {} on the {} basis in {}D; configure with "
        "Machpoint_DIMENSIONS and Machpoint_BASES that contain them",
        method, basis, dimension ) } );
}

} // namespace Machpoint
