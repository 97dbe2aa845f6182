/*!
  \file tell.hpp
  \brief Layer 7: what a run says of itself.
*/
#ifndef MACHPOINT_TELL_HPP
#define MACHPOINT_TELL_HPP

#include <fmt/format.h>

#include <cstdio>
#include <system_error>
#include <utility>

namespace Machpoint
{

//! Prints to stderr: a closed pipe or a full disk behind a log ends no run, nor
//! does it hide an exit code.
template <class... Values>
void tell( fmt::format_string<Values...> text, Values&&... values )
{
    try
    {
        fmt::print( stderr, text, std::forward<Values>( values )... );
        std::fflush( stderr );
    }
    catch ( const std::system_error& )
    {
    }
}

} // namespace Machpoint

#endif
