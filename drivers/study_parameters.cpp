/*!
  \file study_parameters.cpp
  \brief The keys of a study, declared.
*/
#include <drivers/study_input.hpp>

#include <drivers/study_probe.hpp>

namespace Machpoint
{

namespace
{

//! What a run can be measured by.
Family referenceFamily()
{
    return { "reference", []( const int dimension )
             {
                 Parameters run( "run", "one run for all", dimension );
                 run.anything( "set", "its settings: path -> value" );
                 Parameters known( "known", "numbers that are known",
                                   dimension );
                 known.anything( "values", "column -> number" );
                 return std::vector<Parameters>{
                     { "exact", "the scene's exact solution", dimension },
                     { "finer", "the next finer run of the line", dimension },
                     run,
                     known };
             } };
}

} // namespace

Parameters studyParameters()
{
    Parameters all( "study", "many runs of one scene, and what they cost", 0 );
    all.text( "study", "name of the study and of its output directory" )
        .nonEmpty();
    all.text( "input", "the scene: its file, as seen from that of the study" )
        .nonEmpty();
    all.choice( "kind", { "accuracy", "effects" },
                "what accuracy costs: the runs of `vary`; or what effects "
                "cost: the scene as it is, without each of its effects, and "
                "without all" )
        .defaultsTo( "accuracy" );
    all.anything( "set", "settings of all runs: an object path -> value, as "
                         "in --set" )
        .defaultsTo( Json::object() );
    all.anything( "vary", "what the runs differ in: a list of objects path -> "
                          "list of values; each object gives all combinations "
                          "of its values; only of accuracy, which needs it. "
                          "The path solver chooses machpoint or finite_volume, "
                          "the reference solver" )
        .optional();
    all.listOf( "probes", probeFamily(),
                "what is read off the grid outputs (output.every) of the "
                "second half of a run, and averaged" )
        .defaultsTo( Json::array() );
    all.text( "error", "what a run is judged by: FIELD.NORM, or "
                       "NAME.COLUMN of the series of a body or an effect, "
                       "averaged over the second half of the run, or "
                       "PROBE.COLUMN" )
        .nonEmpty()
        .defaultsTo( "density.L1" );
    all.oneOf( "reference", referenceFamily(),
               "what the error is measured against; by default the exact "
               "solution; only of accuracy" )
        .defaultsTo( Json::object( { { "type", "exact" } } ) );
    all.integer( "repeats", "how often each run is timed; the median "
                            "counts, of effects the least" )
        .atLeast( 1 )
        .atMost( 100 )
        .defaultsTo( 3 );
    return all;
}

} // namespace Machpoint
