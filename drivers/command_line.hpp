/*!
  \file command_line.hpp
  \brief Layer 7: the program, callable also from a program that adds modules of
  its own (examples/piston).
*/
#ifndef MACHPOINT_COMMAND_LINE_HPP
#define MACHPOINT_COMMAND_LINE_HPP

namespace Machpoint
{

/*!
  \brief Runs `machpoint` with these arguments.

  Initialises and finalises Kokkos. Register modules before, and on several
  ranks start MPI with an MpiSession. All ranks call it; the root prints.
  \return the exit code: see ExitCode in drivers/run.hpp
*/
int runCommandLine( int argc, char** argv );

} // namespace Machpoint

#endif
