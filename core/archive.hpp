/*!
  \file archive.hpp
  \brief Layer 1: the state of a run by names, on the host: what a checkpoint
  holds.
*/
#ifndef MACHPOINT_ARCHIVE_HPP
#define MACHPOINT_ARCHIVE_HPP

#include <core/errors.hpp>
#include <core/types.hpp>

#include <algorithm>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace Machpoint
{

//! An archive that lacks a value, or has it in another shape.
class ArchiveError : public std::runtime_error, public KnownError
{
  public:
    using std::runtime_error::runtime_error;
};

/*!
  \brief A rank's rows of a table, such as its particles, which are fetched
  block by block, so that nobody needs a copy of the whole: out of the particles
  to be written, or out of the file to be read.
*/
template <class T>
struct Rows
{
    std::size_t count = 0;   //!< of this rank
    std::size_t columns = 1; //!< [count][columns]
    //! Copies `count` rows from the row `first` on; throws what its maker
    //! throws. \param[out] values [count][columns]
    std::function<void( std::size_t first, std::size_t count, T* values )>
        fetch;

    //! Rows that make up some MiB, one at least.
    std::size_t block() const
    {
        constexpr std::size_t numbers =
            ( std::size_t{ 4 } << 20 ) / sizeof( T );
        return std::max<std::size_t>(
            1, numbers / std::max<std::size_t>( 1, columns ) );
    }
    //! Fetches all rows, a block at a time. \param visit callable with the
    //! first row, their count, and the values [count][columns]
    template <class Visitor>
    void forEachBlock( const Visitor& visit ) const
    {
        std::vector<T> values( std::min( count, block() ) * columns );
        for ( std::size_t first = 0; first < count; first += block() )
        {
            const auto n = std::min( block(), count - first );
            fetch( first, n, values.data() );
            visit( first, n, values.data() );
        }
    }
};

/*!
  \brief Named values, written or read by the same calls.

  Who has state names each part of it once, in a function `checkpoint( Archive&
  )`; for `archive( "advanced", _advanced )` a writing archive takes the value
  up, a reading one gives it back. Reading throws ArchiveError.
*/
class Archive
{
  public:
    //! A number, a list or a table of numbers, a text, or the rows of a rank.
    struct Entry
    {
        std::vector<std::size_t> shape; //!< of a list or a table, else {}
        //! What it is: a number is a list of one.
        std::variant<std::vector<float>, std::vector<double>,
                     std::vector<std::int64_t>, std::string, Rows<float>,
                     Rows<double>, Rows<std::int64_t>>
            values;
    };
    //! Entries by their full names, as entries() has them.
    using Entries = std::map<std::string, Entry>;

    //! For writing.
    Archive() = default;
    //! For reading.
    explicit Archive( Entries entries )
        : _entries( std::move( entries ) ), _is_reading( true )
    {
    }

    //! Does it give values back, rather than take them up?
    bool isReading() const { return _is_reading; }
    //! All that was written, or is left to be read, by name; groups are
    //! separated by slashes.
    const Entries& entries() const { return _entries; }

    //! \name Values that are the same on all ranks
    //! \throws ArchiveError when reading: there is none of this name, or one of
    //! another type or shape \throws std::logic_error when writing: the name is
    //! taken
    //! @{
    template <class T>
    requires( std::is_floating_point_v<T> ||
              std::is_same_v<T, std::int64_t> ) void
    operator()( const std::string& name, T& value )
    {
        std::vector<T> list = { value };
        exchange( name, list, {} );
        value = list[0];
    }
    template <class T, std::size_t N>
    void operator()( const std::string& name, Kokkos::Array<T, N>& vector )
    {
        std::vector<T> list( vector.data(), vector.data() + N );
        exchange( name, list, { N } );
        std::copy( list.begin(), list.end(), vector.data() );
    }
    void operator()( const std::string& name, std::string& text )
    {
        if ( !_is_reading )
        {
            add( name, { {}, text } );
            return;
        }
        auto entry = take( name );
        auto* read = std::get_if<std::string>( &entry.values );
        if ( !read )
            throw ArchiveError( _prefix + name + " is not a text" );
        text = std::move( *read );
    }
    //! Nothing else, nor do numbers change their type on the way.
    template <class T>
    void operator()( const std::string& name, T& value )
    {
        static_assert( sizeof( T ) == 0,
                       "an archive takes float, double, std::int64_t, "
                       "Kokkos::Array of them and std::string by its call, "
                       "and lists by table( name, values, columns )" );
    }
    //! A table of any length. \param values [rows][columns]
    //! \throws std::logic_error there are no columns, or no whole rows
    template <class T>
    void table( const std::string& name, std::vector<T>& values,
                const std::size_t columns )
    {
        if ( columns == 0 || values.size() % columns != 0 )
            throw std::logic_error( _prefix + name + " has no whole rows of " +
                                    std::to_string( columns ) + " columns" );
        exchange( name, values, { values.size() / columns, columns } );
    }
    //! @}

    //! Rows of this rank, such as its particles. They are fetched while the
    //! archive lives: until then they must stay what they are.
    //! \param rows its columns say what is expected when reading
    //! \throws ArchiveError, std::logic_error as above
    template <class T>
    void rows( const std::string& name, Rows<T>& rows )
    {
        if ( !_is_reading )
        {
            add( name, { {}, rows } );
            return;
        }
        auto entry = take( name );
        auto* read = std::get_if<Rows<T>>( &entry.values );
        if ( !read || read->columns != rows.columns )
            throw ArchiveError( _prefix + name + " has another type or shape" );
        rows = std::move( *read );
    }

    //! Puts what is named while it lives below a name.
    class Group
    {
      public:
        //! \param archive that outlives it
        Group( Archive& archive, const std::string& name )
            : _archive( archive ), _outer( archive._prefix )
        {
            archive._prefix += name + "/";
        }
        ~Group() { _archive._prefix = _outer; }
        Group( const Group& ) = delete;

      private:
        Archive& _archive;
        std::string _outer;
    };

  private:
    // A table may have any number of rows; every other shape is given.
    template <class T>
    void exchange( const std::string& name, std::vector<T>& values,
                   std::vector<std::size_t> shape )
    {
        if ( !_is_reading )
        {
            add( name, { std::move( shape ), values } );
            return;
        }
        auto entry = take( name );
        auto* list = std::get_if<std::vector<T>>( &entry.values );
        if ( shape.size() == 2 && entry.shape.size() == 2 )
            shape[0] = entry.shape[0];
        if ( !list || entry.shape != shape )
            throw ArchiveError( _prefix + name + " has another type or shape" );
        values = std::move( *list );
    }

    //! Each entry is read once.
    Entry take( const std::string& name )
    {
        auto found = _entries.extract( _prefix + name );
        if ( !found )
            throw ArchiveError( "there is no " + _prefix + name );
        return std::move( found.mapped() );
    }

    void add( const std::string& name, Entry entry )
    {
        if ( !_entries.emplace( _prefix + name, std::move( entry ) ).second )
            throw std::logic_error( "a second " + _prefix + name );
    }

    Entries _entries;
    bool _is_reading = false;
    std::string _prefix;
};

} // namespace Machpoint

#endif
