/*!
  \file main.cpp
  \brief The main function of every test executable: GoogleTest, with Kokkos
  alive while tests run.
*/
#include <core/profile.hpp>

#include <Kokkos_Core.hpp>

#include <gtest/gtest.h>

namespace
{

// Kokkos starts with the first test rather than in main, so that tests can be
// listed on a machine that lacks the device they were built for.
class KokkosEnvironment : public testing::Environment
{
  public:
    KokkosEnvironment( int& argc, char** argv ) : _argc( argc ), _argv( argv )
    {
    }

    void SetUp() override
    {
        Machpoint::Profile::announce(); // as the program does
        Kokkos::initialize( _argc, _argv );
    }
    void TearDown() override { Kokkos::finalize(); }

  private:
    int& _argc;
    char** _argv;
};

} // namespace

int main( int argc, char** argv )
{
    testing::InitGoogleTest( &argc, argv );
    // GoogleTest owns the environment and deletes it.
    testing::AddGlobalTestEnvironment( new KokkosEnvironment( argc, argv ) );
    return RUN_ALL_TESTS();
}
