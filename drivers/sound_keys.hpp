/*!
  \file sound_keys.hpp
  \brief Layer 7: the keys of an input with which nothing is wrong.
*/
#ifndef MACHPOINT_SOUND_KEYS_HPP
#define MACHPOINT_SOUND_KEYS_HPP

#include <core/parameters.hpp>

#include <initializer_list>
#include <set>
#include <string>
#include <vector>

namespace Machpoint
{

//! The keys at an input's root with which nothing is wrong.
class SoundKeys
{
  public:
    //! \param resolved of `written`, perhaps incomplete
    //! \param file its name, as messages have it
    //! \param errors that resolving has met
    SoundKeys( const Json& resolved, const Json& written,
               const std::string& file,
               const std::vector<std::string>& errors );

    //! Those that messages tell of, as in "PREFIX/grid/cells/0: ...".
    void remove( const std::vector<std::string>& messages,
                 const std::string& prefix );

    //! Are all of these sound?
    bool have( std::initializer_list<const char*> keys ) const;

  private:
    std::set<std::string> _keys;
};

} // namespace Machpoint

#endif
