/*!
  \file series.hpp
  \brief Layer 1: time series that are written with the output.
*/
#ifndef MACHPOINT_SERIES_HPP
#define MACHPOINT_SERIES_HPP

#include <core/archive.hpp>

#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

//! A time series that a module reports, one row per step, the same on all
//! ranks.
struct Series
{
    std::string name;                      //!< file name without suffix
    std::vector<std::string> columns;      //!< first is time
    std::vector<std::vector<double>> rows; //!< [steps][columns]

    //! Writes the rows, or reads them. \throws ArchiveError
    //! \throws std::logic_error a row is longer or shorter than the columns
    void checkpoint( Archive& archive )
    {
        std::vector<double> values;
        for ( const auto& row : rows )
        {
            if ( row.size() != columns.size() )
                throw std::logic_error(
                    name + " has a row that does not fit its columns" );
            values.insert( values.end(), row.begin(), row.end() );
        }
        archive.table( "series", values, columns.size() );
        rows.clear();
        for ( auto row = values.begin(); row != values.end();
              row += static_cast<std::ptrdiff_t>( columns.size() ) )
            rows.emplace_back(
                row, row + static_cast<std::ptrdiff_t>( columns.size() ) );
    }
};

} // namespace Machpoint

#endif
