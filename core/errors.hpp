/*!
  \file errors.hpp
  \brief Errors, and whose they are.
*/
#ifndef MACHPOINT_ERRORS_HPP
#define MACHPOINT_ERRORS_HPP

#include <new>
#include <stdexcept>
#include <string>

namespace Machpoint
{

//! Base of errors whose type tells the program how to end (command_line.cpp),
//! and whose text where they come from.
struct KnownError
{
};

//! The computation broke down: what, where, when, and what to try.
class NumericalFailure : public std::runtime_error, public KnownError
{
  public:
    using std::runtime_error::runtime_error;
};

/*!
  \brief What action() returns; to any other error of it the text of `where` is
  added.
  \param where called in that case alone: "cooling in gridForce"
  \throws std::runtime_error in place of such an error
*/
template <class Action, class Where>
auto naming( const Action& action, const Where& where )
{
    try
    {
        return action();
    }
    catch ( const KnownError& )
    {
        throw;
    }
    catch ( const std::bad_alloc& )
    {
        throw;
    }
    catch ( const std::exception& error )
    {
        throw std::runtime_error( std::string( error.what() ) + " (" + where() +
                                  ")" );
    }
    catch ( ... )
    {
        throw std::runtime_error( "something that is no std::exception (" +
                                  where() + ")" );
    }
}

} // namespace Machpoint

#endif
