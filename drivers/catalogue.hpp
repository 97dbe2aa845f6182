/*!
  \file catalogue.hpp
  \brief Layer 7: everything that an input can name, for a terminal.
*/
#ifndef MACHPOINT_CATALOGUE_HPP
#define MACHPOINT_CATALOGUE_HPP

#include <string>

namespace Machpoint
{

//! Prints a line for each entry of a section.
//! \param key the section's first word; empty: all sections
//! \return is there any?
bool listEntries( const std::string& key );

//! Prints what the catalogue knows by a name, what there is of an input's key,
//! or what has such a key. \throws InputError where nothing is called so
void describeByName( const std::string& name );

} // namespace Machpoint

#endif
