/*!
  \file mpi_scratch.hpp
  \brief A directory for the tests of what several ranks write together.
*/
#ifndef MACHPOINT_UNITTEST_MPI_SCRATCH_HPP
#define MACHPOINT_UNITTEST_MPI_SCRATCH_HPP

#include <core/hdf5_file.hpp>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace Test
{

//! A directory that all ranks share, gone with the test. Skips where this
//! build's ranks cannot write HDF5 together.
class MpiScratch : public testing::Test
{
  protected:
    void SetUp() override
    {
        try
        {
            requireHdf5( _ranks );
        }
        catch ( const Machpoint::IoError& error )
        {
            GTEST_SKIP() << error.what();
        }
        auto pattern =
            ( std::filesystem::temp_directory_path() / "machpoint_XXXXXX" )
                .string();
        if ( _ranks.isRoot() && ::mkdtemp( pattern.data() ) == nullptr )
            _ranks.abort( 1 );
        _scratch = _ranks.fromRoot( pattern );
    }

    void TearDown() override
    {
        _ranks.any( false ); // all have read what they wanted
        if ( _ranks.isRoot() )
            std::filesystem::remove_all( _scratch );
    }

    Machpoint::Communicator _ranks;
    std::filesystem::path _scratch;
};

} // namespace Test

#endif
