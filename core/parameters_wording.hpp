/*!
  \file parameters_wording.hpp
  \brief How messages, help and schemas speak of keys and values; for the
  sources of core/parameters alone.
*/
#ifndef MACHPOINT_PARAMETERS_WORDING_HPP
#define MACHPOINT_PARAMETERS_WORDING_HPP

#include <core/parameters.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace Machpoint
{

//! Text from an input, made fit for one line of a terminal.
std::string printable( std::string text );

//! A key as a step of a JSON pointer (RFC 6901: ~ is ~0 and / is ~1).
std::string pointerStep( const std::string& key );

//! Words in quotation marks, with commas between them; "" if there are none.
std::string quoted( const std::vector<std::string>& words );

//! A number of things, as in "1 entry".
std::string counted( std::size_t count, const std::string& one,
                     const std::string& many );

//! "; did you mean ...?", or nothing.
std::string suggestion( const std::string& word,
                        const std::vector<std::string>& candidates );

//! What was found in the place of something else.
std::string found( const Json& value );

//! What a vector holds, as in "a list of 2 whole numbers".
std::string vectorPhrase( int dimension, bool whole );

//! What a key takes, as in "a whole number".
std::string phrase( const Parameter& key, int dimension );

//! The range of a key's numbers, as in "> 0 and <= 1"; "" if there is none.
std::string range( const Parameter& key );

//! The names of a family's members.
std::vector<std::string> namesOf( const std::vector<Parameters>& members );

//! Whether an input may leave the key out.
bool mayBeAbsent( const Parameter& key );

} // namespace Machpoint

#endif
