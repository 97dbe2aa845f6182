/*!
  \file hdf5_file.hpp
  \brief Layer 6: HDF5 files of named arrays, written by all ranks together and
  read back by each for itself.
*/
#ifndef MACHPOINT_HDF5_FILE_HPP
#define MACHPOINT_HDF5_FILE_HPP

#include <core/communicator.hpp>
#include <core/file.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace Machpoint
{

/*!
  \brief A named, row-major array on the host, not owned, or this rank's block
  of one. A shape of `{}` is a scalar.
*/
struct Dataset
{
    //! What the elements are: `double`, `float`, `std::int64_t`, `unsigned
    //! char`.
    enum class Type
    {
        real,
        single,
        integer,
        byte
    };

    std::string name;               //!< Path inside the HDF5 file.
    std::vector<std::size_t> shape; //!< Of the block, slowest axis first.
    const void* data = nullptr;     //!< May be null when an extent is 0.
    Type type = Type::real;         //!< Type of the elements.
    //! \name The whole array, and where the block starts in it
    //! Both empty: every rank has the whole array, and the root's is written.
    //! @{
    std::vector<std::size_t> global_shape = {};
    std::vector<std::size_t> start = {};
    //! @}
    //! Instead of `data`: copies `count` rows of the block, from its row
    //! `first` on, to where they are asked for. Each row is asked for once.
    std::function<void( std::size_t first, std::size_t count, void* rows )>
        fetch = nullptr;

    //! Shape of the whole array.
    const std::vector<std::size_t>& extents() const
    {
        return global_shape.empty() ? shape : global_shape;
    }
};

//! Bytes of an element.
constexpr std::size_t elementSize( const Dataset::Type type )
{
    return type == Dataset::Type::byte     ? 1
           : type == Dataset::Type::single ? sizeof( float )
                                           : sizeof( double );
}

//! The type of an array of T.
template <class T>
constexpr Dataset::Type datasetType()
{
    if constexpr ( std::is_same_v<T, double> )
        return Dataset::Type::real;
    else if constexpr ( std::is_same_v<T, float> )
        return Dataset::Type::single;
    else if constexpr ( std::is_same_v<T, std::int64_t> )
        return Dataset::Type::integer;
    else
    {
        static_assert( std::is_same_v<T, unsigned char> );
        return Dataset::Type::byte;
    }
}

/*!
  \brief Arrays whose rows are those of rank 0, then those of rank 1, ...

  Collective. \param[in] blocks this rank's rows, `[n][...]`; n may be 0 and may
  differ between ranks and arrays
*/
std::vector<Dataset> stackRows( const Communicator& ranks,
                                std::vector<Dataset> blocks );

//! Can these ranks write HDF5 files? \throws IoError in a build without HDF5,
//! and for several ranks in one with a serial HDF5; on all ranks
void requireHdf5( const Communicator& ranks );

//! Bytes of a file that one rank writes sooner than several agree on it.
constexpr std::size_t small_file = std::size_t{ 32 } << 20;

/*!
  \brief Writes a whole file or none: beside the target, forced to the disk,
  renamed.

  Collective; the directory exists, and all ranks see it. The root builds small
  files in memory, with the blocks of all ranks. Large ones go to the disk as
  they are written, by all ranks together through MPI-IO; what is fetched takes
  no more memory than a few MiB.

  \param[in] attributes Of the file; the same on all ranks.
  \param[in] datasets On all ranks the same names, types and whole shapes in the
  same order; the blocks cover each array and do not overlap.
  \param[in] compression 0 to 9: effort of deflate after shuffle; 0 is none.
  \param[in] small bytes up to which the root writes alone
  \param[in] then called by all ranks when all datasets were fetched, and before
  the attributes are written, which so may tell of them
  \throws IoError the same on all ranks
*/
void writeHdf5(
    const Communicator& ranks, const std::filesystem::path& target,
    const std::vector<Dataset>& attributes,
    const std::vector<Dataset>& datasets, int compression = 0,
    std::size_t small = small_file, const std::function<void()>& then = [] {} );

/*!
  \brief Reads a file of named arrays. Not collective: a rank reads what it
  wants, and together() shares its failure with the others.

  Reals become those that are asked for. All members throw IoError: where there
  is no such file, dataset or attribute, or one of another type or shape.
*/
class Hdf5Reader
{
  public:
    //! Opens it. A build without HDF5 can open none.
    explicit Hdf5Reader( const std::filesystem::path& file );
    Hdf5Reader( const Hdf5Reader& ) = delete;
    Hdf5Reader& operator=( const Hdf5Reader& ) = delete;
    ~Hdf5Reader();

    //! Is there such a dataset? Throws nothing.
    bool has( const std::string& dataset ) const;
    //! Shape of the whole array.
    std::vector<std::size_t> shape( const std::string& dataset ) const;

    //! A whole array.
    template <class T>
    std::vector<T> read( const std::string& dataset ) const
    {
        const auto all = shape( dataset );
        return read<T>( dataset, std::vector<std::size_t>( all.size(), 0 ),
                        all );
    }
    //! The block `shape` of an array that starts at `start`.
    template <class T>
    std::vector<T> read( const std::string& dataset,
                         const std::vector<std::size_t>& start,
                         const std::vector<std::size_t>& shape ) const
    {
        std::size_t count = 1;
        for ( const auto extent : shape )
            count *= extent;
        std::vector<T> values( count );
        read( dataset, start, shape, values.data() );
        return values;
    }
    //! The same, to where it belongs. \param values [shape]
    template <class T>
    void read( const std::string& dataset,
               const std::vector<std::size_t>& start,
               const std::vector<std::size_t>& shape, T* values ) const
    {
        readBlock( dataset, datasetType<T>(), start, shape, values );
    }
    //! An attribute of the file; a scalar is one value.
    template <class T>
    std::vector<T> attribute( const std::string& name ) const
    {
        std::vector<T> values( attributeSize( name ) );
        readAttribute( name, datasetType<T>(), values.data() );
        return values;
    }

  private:
    void readBlock( const std::string& dataset, Dataset::Type type,
                    const std::vector<std::size_t>& start,
                    const std::vector<std::size_t>& shape, void* values ) const;
    std::size_t attributeSize( const std::string& name ) const;
    void readAttribute( const std::string& name, Dataset::Type type,
                        void* values ) const;

    std::filesystem::path _path;
    std::int64_t _file; // HDF5's identifier
};

} // namespace Machpoint

#endif
