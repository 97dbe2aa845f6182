/*!
  \file revision.hpp
  \brief Which sources this build comes from.
*/
#ifndef MACHPOINT_REVISION_HPP
#define MACHPOINT_REVISION_HPP

namespace Machpoint
{

//! What `git describe --always --dirty` says, or "unknown" without git.
extern const char* const revision;

} // namespace Machpoint

#endif
