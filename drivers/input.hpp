/*!
  \file input.hpp
  \brief Layer 7: an input file, from text to a resolved and checked document.
*/
#ifndef MACHPOINT_INPUT_HPP
#define MACHPOINT_INPUT_HPP

#include <core/parameters.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

//! All keys of an input. \param dimension 1 to 3, or 0 for any
Parameters inputParameters( int dimension );

//! The keys of `method`. \param name of the method, or empty: those of all
//! \param dimension 1 to 3, or 0 for any
Parameters methodParameters( const std::string& name, int dimension );

//! JSON Schema of an input, where a method refuses what another one alone
//! takes.
Json inputSchema();

//! The text of a file. \throws InputError that names the file
std::string readFile( const std::string& file );

/*!
  \brief Fills in the defaults of an input and checks it.
  \param file its name, for messages
  \param errors what is known to be wrong already, to be told with the rest
  \throws InputError with every mistake at once
*/
Json resolveInput( const Json& input, const std::string& file,
                   std::vector<std::string> errors = {} );

/*!
  \brief Reads, overrides, resolves and checks an input.
  \param file path of the JSON file
  \param overrides assignments `path=value`
  \return the input with all defaults
  \throws InputError with every mistake at once
*/
Json loadInput( const std::string& file,
                const std::vector<std::string>& overrides );

} // namespace Machpoint

#endif
