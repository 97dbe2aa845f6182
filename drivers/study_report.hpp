/*!
  \file study_report.hpp
  \brief Layer 7: what a study says: its rows, its laws, its files and tables.
*/
#ifndef MACHPOINT_STUDY_REPORT_HPP
#define MACHPOINT_STUDY_REPORT_HPP

#include <drivers/study_fit.hpp>
#include <drivers/study_input.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

//! A run and what has been measured of it.
struct StudyRow
{
    StudyRun run;
    //! A row of study.json; its keys are in docs/output.md.
    Json record;

    bool isFinished() const { return record.at( "status" ) == "finished"; }
    bool isFailed() const { return record.at( "status" ) == "failed"; }
    //! An error of this run; NaN while it is not known.
    double error( const std::string& name ) const;
};

//! The middle of some numbers, of an even count the mean of the two; of one at
//! least.
double median( std::vector<double> values );

//! The finished rows by lines, in the order of the study, coarsest first.
std::vector<Line> makeLines( const std::vector<StudyRow>& rows,
                             const std::string& error );

//! Rows that no other one beats in both time and error; fastest first.
std::vector<std::size_t> rowsOnFront( const std::vector<StudyRow>& rows,
                                      const std::string& error );

//! \name What study.json calls them
//! @{
std::string kindName( StudyKind kind );
std::string referenceName( Reference reference );
//! @}

//! The content of study.json; its keys are a contract (add, never rename).
Json makeStudyJson( const Study& study, const std::vector<StudyRow>& rows,
                    const StudyRow* reference, const Json& proofs );

//! study.csv: a line of names, and one for each row.
std::string makeStudyCsv( const Study& study,
                          const std::vector<StudyRow>& rows );

//! One row, for a terminal.
std::string formatRow( const StudyRow& row, const std::string& error );

//! All rows, the Pareto front and the laws, for a terminal.
std::string formatStudy( const Study& study,
                         const std::vector<StudyRow>& rows );

} // namespace Machpoint

#endif
