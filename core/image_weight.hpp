/*!
  \file image_weight.hpp
  \brief Layer 3: the weight of mirror images, which a mirror turns as it turns
  their velocity (docs/conservative.md, section 6).
*/
#ifndef MACHPOINT_IMAGE_WEIGHT_HPP
#define MACHPOINT_IMAGE_WEIGHT_HPP

#include <core/node_force.hpp>
#include <core/profile.hpp>
#include <core/transfer.hpp>

namespace Machpoint
{

//! Allocates what images' weight needs, where bodies have images and the gas
//! has weight.
template <int Dim>
void layOutImageWeight( State<Dim>& state )
{
    if ( state.image_weight.acts )
        state.image_weight.excess =
            makeNodeSum( "Machpoint::imageWeight", state, Dim );
}

namespace Impl
{
//! Adds m w (R g - g) of the images. \param sums the scatter of a field
template <class Basis, int Dim, class Sums>
void addImageWeight( const State<Dim>& state, const Sums& sums )
{
    const auto x = state.particles.template slice<Position>();
    const auto m = state.particles.template slice<Mass>();
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto images = state.images;
    const auto g = state.image_weight.acceleration;
    forEach(
        "Machpoint::addImageWeight", images.count,
        MACHPOINT_LAMBDA( const int k ) {
            const int p = images.particle( k );
            const auto mirror = images.mirror( k );
            const Stencil<Basis, Dim> s(
                grid, layout, mirror.point( loadVector<Dim>( x, p ) ) );
            const auto nodes = accessTo( sums.thread(), p, s, layout );
            const auto turned = mirror.direction( g );
            forEachNode( s, layout,
                         [&]( const auto& i )
                         {
                             for ( int d = 0; d < Dim; ++d )
                                 nodes( i.row, d ) +=
                                     m( p ) * i.weight * ( turned[d] - g[d] );
                         } );
        },
        few_particles );
}
} // namespace Impl

/*!
  \brief Sums m w (R g - g) of the images: nodes get m g of all that is on them,
  and R g is due to an image. Collective where sums are reproducible.
*/
template <class Basis, int Dim>
void depositImageWeight( State<Dim>& state )
{
    if ( state.image_weight.acts )
        state.image_weight.excess.deposit(
            [&]( const auto& sums )
            { Impl::addImageWeight<Basis>( state, sums ); } );
}

//! Adds to v' what images' weight is beyond that of their mass on the nodes.
template <int Dim>
void applyImageWeight( State<Dim>& state )
{
    if ( !state.image_weight.acts )
        return;
    const Profile::Phase phase( "grid force" );
    auto& excess = state.image_weight.excess;
    foldWeight( state, excess );
    Vector<Dim> one;
    for ( int d = 0; d < Dim; ++d )
        one[d] = 1;
    pushNodes<Dim>( state, excess.field(), one );
}

//! The work of it, this rank's part, to the ledger; energy.
template <int Dim>
void accountForImageWeight( State<Dim>& state )
{
    if ( !state.image_weight.acts )
        return;
    const Profile::Phase phase( "grid work" );
    state.ledger.energy_in +=
        workOnNodes( state, state.image_weight.excess.field() );
}

} // namespace Machpoint

#endif
