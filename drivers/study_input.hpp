/*!
  \file study_input.hpp
  \brief Layer 7: a study file, from text to the runs that it asks for.
*/
#ifndef MACHPOINT_STUDY_INPUT_HPP
#define MACHPOINT_STUDY_INPUT_HPP

#include <core/parameters.hpp>
#include <core/types.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace Machpoint
{

//! All keys of a study.
Parameters studyParameters();

//! Which program makes a run.
enum class Solver
{
    machpoint,
    finite_volume //!< machpoint_reference (benchmarks/reference)
};

//! One setting of a study.
struct StudyRun
{
    std::string line; //!< what it shares with runs that differ in cells alone
    Json settings;    //!< path -> value, as the study varies them
    Json input;       //!< resolved
    Solver solver = Solver::machpoint;

    //! [Dim]
    std::vector<std::int64_t> cells() const
    {
        return input.at( "grid" ).at( "cells" );
    }
};

//! What a study is about.
enum class StudyKind
{
    accuracy, //!< what accuracy costs in time: many settings of a scene
    effects   //!< what effects cost: the scene without each of them
};

//! What a study measures its runs by.
enum class Reference
{
    none,  //!< of effects, where the scene has no exact solution
    exact, //!< the scene's exact solution
    finer, //!< the next finer run of the line
    run,   //!< one run for all
    known  //!< numbers that are known
};

//! What a run's time is.
enum class Clock
{
    wall,     //!< seconds that pass, from the first step to the end
    processor //!< of all threads, with start and set-up
};

//! A study file, checked.
struct Study
{
    std::string name; //!< and that of its output directory
    StudyKind kind = StudyKind::accuracy;
    std::string error; //!< field.norm, body.column or probe.column; of
                       //!< effects perhaps empty: none
    Reference reference = Reference::exact;
    Json judge;                 //!< the whole of it, as the file has it
    Json known;                 //!< of Reference::known: column -> number
    Json probes;                //!< resolved
    int repeats = 1;            //!< how often each run is timed
    Clock clock = Clock::wall;  //!< not from the file
    bool whole_paths = false;   //!< in names of lines, where shorter ones agree
    Json scene;                 //!< input with `set`, not resolved
    std::vector<StudyRun> runs; //!< in the order of the file; of effects the
                                //!< scene as it is, without each, without all
    std::vector<std::string> effects;    //!< that runs leave out
    std::vector<StudyRun> reference_run; //!< one, or none
};

//! Is this error that of a field, over the domain? Else of a body or a probe.
bool isFieldError( const std::string& error );

/*!
  \brief A run of a study: the scene with these settings.
  \param settings path -> value
  \throws InputError with every mistake at once
*/
StudyRun makeStudyRun( const Study& study, const Json& settings,
                       const std::string& file );

//! The errors that a study tells, as `field.norm`, or as `body.column` and
//! `probe.column`; of effects also changes, as `field.change`.
std::vector<std::string> errorNames( const Study& study );

/*!
  \brief Reads and checks a study and all of its runs.
  \throws InputError with every mistake at once
*/
Study loadStudy( const std::string& file );

} // namespace Machpoint

#endif
