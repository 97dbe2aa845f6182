/*!
  \file mpi_main.cpp
  \brief The main function of the tests on several ranks. Every rank runs every
  test; mpirun fails when any of them does.
*/
#include <core/communicator.hpp>
#include <core/profile.hpp>

#include <Kokkos_Core.hpp>

#include <gtest/gtest.h>

int main( int argc, char** argv )
{
    const Machpoint::MpiSession mpi( argc, argv );
    Machpoint::Profile::announce(); // as the program does
    const Kokkos::ScopeGuard kokkos( argc, argv );
    testing::InitGoogleTest( &argc, argv );
    return RUN_ALL_TESTS();
}
