#include <drivers/command_line.hpp>

int main( int argc, char** argv )
{
    return Machpoint::runCommandLine( argc, argv );
}
