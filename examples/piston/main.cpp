#include "piston.hpp"

#include <core/communicator.hpp>
#include <core/registry.hpp>
#include <drivers/command_line.hpp>

//! Machpoint's own program, which now also knows the boundary "piston".
int main( int argc, char** argv )
{
    const Machpoint::MpiSession mpi( argc, argv );
    Machpoint::registerBoundary<Piston>();
    return Machpoint::runCommandLine( argc, argv );
}
