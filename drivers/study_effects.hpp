/*!
  \file study_effects.hpp
  \brief Layer 7: a study of what effects cost: which ones a scene has, and the
  table of what becomes of the run when each is left out.
*/
#ifndef MACHPOINT_STUDY_EFFECTS_HPP
#define MACHPOINT_STUDY_EFFECTS_HPP

#include <drivers/study_report.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

//! What a run does and could do without.
struct OptionalEffect
{
    std::string name; //!< as in the end table of a run
    Json off;         //!< settings that leave it out: path -> value
};

/*!
  \brief All that a scene has beyond its equation of state, its boundaries and
  the bare method: the other entries of `physics`, and the keys that are
  declared to switch an effect and do not have their value `off`.
  \param input resolved
*/
std::vector<OptionalEffect> optionalEffects( const Json& input );

//! Settings that leave out all of them. \param input resolved
Json withoutAll( const Json& input );

//! The name of the effect that is all of them.
inline constexpr const char* all_effects = "all of them";

//! `line` of a run that leaves out an effect.
std::string lineWithout( const std::string& effect );

/*!
  \brief Adds what the effects of a run took to those of its former rounds.
  \param effects of a row: name, kernels, bytes, shares (of each round's wall
  seconds), and share, their median \param summary of the run
*/
void addRound( Json& effects, const Json& summary );

/*!
  \brief `effects` of study.json: one entry for each effect, and one for all.
  \param rows of a study of the kind effects, the scene as it is first
*/
Json effectsTable( const Study& study, const std::vector<StudyRow>& rows );

//! What differences of time cannot be told from, s: the most by which the two
//! fastest rounds of a run differ; 0 where there is one round.
double timeNoise( const Study& study, const std::vector<StudyRow>& rows );

//! Both for a terminal.
std::string formatEffects( const Study& study,
                           const std::vector<StudyRow>& rows );

} // namespace Machpoint

#endif
