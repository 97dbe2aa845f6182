/*!
  \file rows.hpp
  \brief Rows of an archive, out of lists and into them.
*/
#ifndef MACHPOINT_UNITTEST_ROWS_HPP
#define MACHPOINT_UNITTEST_ROWS_HPP

#include <core/archive.hpp>

#include <algorithm>
#include <vector>

namespace Test
{

//! Rows of a list, which must outlive them. \param values [rows][columns]
template <class T>
Machpoint::Rows<T> rowsOf( const std::vector<T>& values,
                           const std::size_t columns )
{
    return { values.size() / columns, columns,
             [&values, columns]( const std::size_t first,
                                 const std::size_t count, T* block ) {
                 std::copy_n( values.data() + first * columns, count * columns,
                              block );
             } };
}

//! All rows. \return [rows][columns]
template <class T>
std::vector<T> listOf( const Machpoint::Rows<T>& rows )
{
    std::vector<T> values;
    rows.forEachBlock(
        [&]( std::size_t, const std::size_t count, const T* block ) {
            values.insert( values.end(), block, block + count * rows.columns );
        } );
    return values;
}

} // namespace Test

#endif
