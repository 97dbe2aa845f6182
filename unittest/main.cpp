/*!
  \file main.cpp
  \brief The main function of every test executable: GoogleTest, with Kokkos
  alive while tests run.
*/
#include <core/for_each.hpp>
#include <core/kokkos_session.hpp>

#include <gtest/gtest.h>

#include <optional>

namespace
{

// Kokkos starts with the first test rather than in main, so that tests can be
// listed on a machine that lacks the device they were built for.
class KokkosEnvironment : public testing::Environment
{
    void SetUp() override { _kokkos.emplace(); }
    void TearDown() override { _kokkos.reset(); }

    std::optional<Machpoint::KokkosSession> _kokkos;
};

} // namespace

int main( int argc, char** argv )
{
    testing::InitGoogleTest( &argc, argv );
    Machpoint::sharesFewTurns() = true;
    // GoogleTest owns the environment and deletes it.
    testing::AddGlobalTestEnvironment( new KokkosEnvironment );
    return RUN_ALL_TESTS();
}
