/*!
  \file Cabana_Label.hpp
  \brief Labels that a kernel can carry for the price of a pointer.
*/
#ifndef CABANA_LABEL_HPP
#define CABANA_LABEL_HPP

#include <mutex>
#include <set>
#include <string>

namespace Cabana
{
namespace Impl
{

/*!
  \brief The one copy of a label that lives until the program ends.

  Slices are captured by kernels, so they must stay small and trivially
  copyable: three slices with their text inside would already exceed the 512
  bytes up to which Kokkos passes a CUDA kernel its arguments directly.
*/
inline const char* internLabel( const std::string& label )
{
    if ( label.empty() )
        return "";
    static std::mutex mutex;
    static std::set<std::string> labels;
    const std::lock_guard lock( mutex );
    // Nodes of a set never move, so the text stays where it is.
    return labels.insert( label ).first->c_str();
}

} // namespace Impl
} // namespace Cabana

#endif
