/*!
  \file Cabana_Bytes.hpp
  \brief Structs as bytes, for copies that do not look inside.
*/
#ifndef CABANA_BYTES_HPP
#define CABANA_BYTES_HPP

#include <Kokkos_Core.hpp>

#include <cstddef>

namespace Cabana
{
namespace Impl
{

/*!
  \brief The bytes of structs of any type. A copy of views of structs compiles
  eight kernels for each type, one of views of bytes the same for all.
  \param count of structs
*/
template <class MemorySpace, class Struct>
auto bytesOf( Struct* const structs, const std::size_t count )
{
    return Kokkos::View<std::byte*, MemorySpace, Kokkos::MemoryUnmanaged>(
        reinterpret_cast<std::byte*>( structs ), count * sizeof( Struct ) );
}

} // namespace Impl
} // namespace Cabana

#endif
