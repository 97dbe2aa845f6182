#include <core/communicator.hpp>
#include <drivers/command_line.hpp>

int main( int argc, char** argv )
{
    const Machpoint::MpiSession mpi( argc, argv );
    return Machpoint::runCommandLine( argc, argv );
}
