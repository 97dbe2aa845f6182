/*!
  \file few_turns.hpp
  \brief Leaves short loops to one thread, as programs do and tests else do not.
*/
#ifndef MACHPOINT_UNITTEST_FEW_TURNS_HPP
#define MACHPOINT_UNITTEST_FEW_TURNS_HPP

#include <core/for_each.hpp>

namespace Test
{

//! While it lives.
class FewTurnsUnshared
{
  public:
    FewTurnsUnshared() { Machpoint::sharesFewTurns() = false; }
    ~FewTurnsUnshared() { Machpoint::sharesFewTurns() = true; }
    FewTurnsUnshared( const FewTurnsUnshared& ) = delete;
};

} // namespace Test

#endif
