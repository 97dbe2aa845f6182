/*!
  \file mpi_main.cpp
  \brief The main function of the tests on several ranks. Every rank runs every
  test; mpirun fails when any of them does.
*/
#include <core/communicator.hpp>
#include <core/for_each.hpp>
#include <core/kokkos_session.hpp>

#include <gtest/gtest.h>

int main( int argc, char** argv )
{
    const Machpoint::MpiSession mpi( argc, argv );
    const Machpoint::KokkosSession kokkos;
    testing::InitGoogleTest( &argc, argv );
    Machpoint::sharesFewTurns() = true;
    return RUN_ALL_TESTS();
}
