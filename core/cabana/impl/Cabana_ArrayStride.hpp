/*!
  \file Cabana_ArrayStride.hpp
  \brief How far apart the arrays of a struct lie.
*/
#ifndef CABANA_ARRAYSTRIDE_HPP
#define CABANA_ARRAYSTRIDE_HPP

namespace Cabana
{
namespace Impl
{

/*!
  \brief Distance of the arrays of a struct, in values: their length, and nine
  lines of 64 bytes more where they fill pages of 4 KiB.

  What lies whole pages apart shares one set of the first cache, whose 8 to 12
  ways a kernel's many arrays would push each other out of.
*/
template <class T, int VectorLength>
constexpr int array_stride = VectorLength +
                             ( VectorLength * sizeof( T ) % 4096 == 0
                                   ? 9 * 64 / sizeof( T )
                                   : 0 );

} // namespace Impl
} // namespace Cabana

#endif
