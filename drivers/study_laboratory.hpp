/*!
  \file study_laboratory.hpp
  \brief Layer 7: the runs of a study, made one by one, and the directory that
  they are in.
*/
#ifndef MACHPOINT_STUDY_LABORATORY_HPP
#define MACHPOINT_STUDY_LABORATORY_HPP

#include <drivers/study_fit.hpp>
#include <drivers/study_input.hpp>
#include <drivers/study_process.hpp>
#include <drivers/study_report.hpp>

#include <core/file.hpp>

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief Makes and judges the runs of a study; after each it writes study.json
  and study.csv into the study's directory, which it holds alone. Runs that are
  in study.json are not repeated.
*/
class Laboratory
{
  public:
    //! \param study outlives this \param folder made where it is not there
    //! \throws IoError, also where it holds something else
    Laboratory( const Study& study, const std::filesystem::path& folder );

    //! The study's runs with what is known of them, in its order.
    const std::vector<StudyRow>& rows() const { return _rows; }

    //! Rows that another program has measured.
    std::size_t foreignRows() const;

    //! Makes all runs, in rounds, so that whatever slows the machine for a
    //! while hits all alike. \return were they all made?
    bool runAll();

    //! Proves a prediction. \return the run; none when interrupted
    std::optional<StudyRow> prove( const std::string& request,
                                   const std::string& error,
                                   const StudyRow& like,
                                   const Candidate& candidate );

  private:
    //! What an earlier call has measured.
    void readFormer();

    //! Another error, or one against something else, is asked of a run than
    //! before. \return false where its results are not there any more
    bool judgeAnew( Json& record ) const;

    //! Runs that are yet to be compared, and whose fields are not there any
    //! more, are to be made anew.
    void forgetGone();

    //! The run whose fields a row's are compared with; none: null.
    StudyRow* judgeOf( const StudyRow& row );

    //! What a run by itself tells of its errors.
    void readResults( Json& record, const std::filesystem::path& folder,
                      const Json& summary ) const;

    StudyRow known( const StudyRun& run ) const;
    const StudyRow* find( const std::string& id ) const;
    std::filesystem::path folderOf( const StudyRow& row ) const;

    //! Makes a run unless it has been made in this round.
    //! \return false when interrupted
    bool complete( StudyRow& row, int round );

    //! The middle of the rounds, by the clock that counts. Of effects the
    //! least: their price is a difference, and what disturbs a run only adds to
    //! it.
    void setSeconds( Json& record ) const;

    //! \return false when interrupted
    bool make( StudyRow& row );

    //! Errors of the rows that are measured by other runs.
    void compare();

    //! How far a run without an effect is from the scene as it is.
    void tellChanges( StudyRow& row ) const;

    StudyRow* nextFiner( const StudyRow& row );
    void compare( StudyRow& row, const StudyRow& better ) const;
    void compareToKnown( StudyRow& row ) const;

    //! |a - b|; null unless both are numbers.
    static Json distance( const Json& a, const Json& b );

    //! The error of a run that is not among the rows. \return false when
    //! interrupted
    bool judgeProof( StudyRow& row, Json settings );

    void save() const;

    const Study& _study;
    std::filesystem::path _folder;
    DirectoryLock _lock;
    ProcessGuard _guard;
    std::vector<StudyRow> _rows;
    std::optional<StudyRow> _reference;
    std::map<std::string, Json> _former; // by id
    Json _proofs = Json::array();
};

} // namespace Machpoint

#endif
