/*!
  \file halos.hpp
  \brief Halos of sides that are of one kind each.
*/
#ifndef MACHPOINT_UNITTEST_HALOS_HPP
#define MACHPOINT_UNITTEST_HALOS_HPP

#include <core/halo.hpp>

#include <array>

namespace Test
{

//! A halo whose sides along axis d are of kind[d]; of the whole domain, where
//! no decomposition is given.
template <int Dim>
Machpoint::Halo<Dim>
makeHalo( const Machpoint::NodeLayout<Dim>& layout,
          const std::array<Machpoint::SideKind, 3>& kind,
          const Machpoint::Decomposition<Dim>& decomposition = {} )
{
    using namespace Machpoint;
    Kokkos::Array<KindView, 2 * Dim> kinds;
    for ( int side = 0; side < 2 * Dim; ++side )
    {
        kinds[side] =
            KindView( "kinds", Halo<Dim>::sideSize( layout, side / 2 ) );
        Kokkos::deep_copy( kinds[side], kind[side / 2] );
    }
    return Halo<Dim>( layout, kinds, decomposition );
}

} // namespace Test

#endif
