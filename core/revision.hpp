/*!
  \file revision.hpp
  \brief Which sources this build comes from, and what it stands on.
*/
#ifndef MACHPOINT_REVISION_HPP
#define MACHPOINT_REVISION_HPP

namespace Machpoint
{

//! What `git describe --always --dirty` says, or "unknown" without git.
extern const char* const revision;

//! \name Known when CMake configures (libraries.cpp.in)
//! @{
extern const char* const version; //!< of Machpoint
//! What the build stands on, a name and its version a line; "no": built
//! without.
extern const char* const libraries;
//! @}

} // namespace Machpoint

#endif
