/*!
  \file ghost_cells.hpp
  \brief What a cell sees beyond the gas: two layers of cells beyond each side
  of the domain, and the cells inside obstacles.
*/
#ifndef MACHPOINT_REFERENCE_GHOST_CELLS_HPP
#define MACHPOINT_REFERENCE_GHOST_CELLS_HPP

#include "euler.hpp"

#include <core/grid.hpp>
#include <core/module.hpp>
#include <core/shape_input.hpp>
#include <physics/initial/initial_state.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace Machpoint::Reference
{

//! Layers of ghost cells: a face needs two cells on either side.
inline constexpr int ghost_layers = 2;

//! What lies beyond a cell's face on a side of the domain.
enum class Beyond
{
    wall,     //!< the mirrored gas
    periodic, //!< the gas at the opposite side
    inflow,   //!< a fixed state
    outflow   //!< the cell's own state (zero gradient)
};

//! One cell's face on a side.
template <int Dim>
struct SideFace
{
    Beyond beyond;
    Values<Dim> stream; //!< primitive, of an inflow
};

//! A side's faces, in the order of the cells along the other axis.
template <int Dim>
using Side = Kokkos::View<SideFace<Dim>*, MemorySpace>;

//! The cell at `depth` along an axis and `place` along the other one.
template <int Dim>
KOKKOS_INLINE_FUNCTION Indices<Dim> sideCell( const int axis, const int depth,
                                              const int place )
{
    Indices<Dim> i;
    for ( int d = 0; d < Dim; ++d )
        i[d] = d == axis ? depth : place;
    return i;
}

//! The faces of a side as the input's boundaries claim them.
//! \throws InputError where nobody claims a face, or several do
template <int Dim>
Side<Dim> makeSide( const Json& input, const Grid<Dim>& grid,
                    const NodeLayout<Dim>& cells, const int side )
{
    const int axis = side / 2;
    const int size = Dim == 1 ? 1 : grid.cells[1 - axis];
    Side<Dim> faces( "Machpoint::referenceSide", size );
    const auto host = Kokkos::create_mirror_view( faces );
    std::vector<int> claims( size );
    for ( const auto& entry : input.at( "boundary" ) )
    {
        if ( !entry.contains( "side" ) )
            continue;
        const auto type = entry.at( "type" ).get<std::string>();
        const int own = sideNumber( entry.at( "side" ) );
        // What leaves through a recycling side enters through the opposite
        // one, undisturbed.
        const bool recycled = type == "recycle" && own == ( side ^ 1 );
        if ( own != side && !recycled )
            continue;
        SideFace<Dim> face{};
        face.beyond = type == "slip_wall"            ? Beyond::wall
                      : type == "periodic"           ? Beyond::periodic
                      : type == "inflow" || recycled ? Beyond::inflow
                                                     : Beyond::outflow;
        if ( face.beyond == Beyond::inflow )
            face.stream = primitive<Dim>( toGasState( entry ) );
        const bool everywhere = !entry.contains( "region" );
        Shape<Dim, Kokkos::HostSpace> region;
        if ( !everywhere )
            region = makeShape<Dim, Kokkos::HostSpace>( entry.at( "region" ) );
        for ( int t = 0; t < size; ++t )
        {
            auto x = cells.position( sideCell<Dim>( axis, 0, t ) );
            x[axis] = side % 2 ? grid.upper[axis] : grid.lower[axis];
            if ( !everywhere && region.distance( x ) >= 0 )
                continue;
            host( t ) = face;
            ++claims[t];
        }
    }
    for ( int t = 0; t < size; ++t )
        if ( claims[t] != 1 )
            throw InputError( { fmt::format(
                "/boundary: cell {} of side {} has {} entries; it needs one", t,
                sideNames( Dim )[side], claims[t] ) } );
    Kokkos::deep_copy( faces, host );
    return faces;
}

//! Sets the ghost cells beyond a side. \param w primitive, [rows][Dim + 2]
template <int Dim>
void fillSide( const Side<Dim>& faces, const NodeLayout<Dim>& cells,
               const int side, const NodeView& w )
{
    const int axis = side / 2;
    const bool upper = side % 2;
    const int n = cells.owned[axis];
    const int size = static_cast<int>( faces.extent( 0 ) );
    Kokkos::parallel_for(
        "Machpoint::referenceSide", Range( 0, ghost_layers * size ),
        KOKKOS_LAMBDA( const int k ) {
            const int t = k / ghost_layers;
            const int layer = k % ghost_layers;
            const auto face = faces( t );
            // Distances from the side, in cells, of the cell to copy.
            const int depth = face.beyond == Beyond::outflow    ? 0
                              : face.beyond == Beyond::periodic ? n - 1 - layer
                                                                : layer;
            const int source = upper ? n - 1 - depth : depth;
            auto q = load<Dim>( w, cells( sideCell<Dim>( axis, source, t ) ) );
            if ( face.beyond == Beyond::wall )
                q[1 + axis] = -q[1 + axis];
            if ( face.beyond == Beyond::inflow )
                q = face.stream;
            const int ghost = upper ? n + layer : -1 - layer;
            store<Dim>( w, cells( sideCell<Dim>( axis, ghost, t ) ), q );
        } );
}

/*!
  \brief The obstacles of a scene as ghost cells (Mittal and Iaccarino 2005,
  section 3; Tseng and Ferziger 2003).

  A cell whose centre is inside a solid is no gas. Those that gas can see, being
  within two cells along an axis, take the state at their mirror image across
  the surface, (bi)linear in the gas around it, with the velocity along the
  normal reversed. Near the surface some of these neighbours are solid
  themselves; the others' weights are then scaled up. This is first order at the
  body, and mass, momentum and energy are not conserved there: the faces between
  gas and solid carry what the flux of the two states happens to be.
*/
template <int Dim>
struct Solid
{
    static constexpr int corners = 1 << Dim;

    //! A cell in the solid that gas can see.
    struct GhostCell
    {
        int row;
        Vector<Dim> normal;                 //!< of the surface, into the gas
        Kokkos::Array<int, corners> source; //!< rows around the image
        Kokkos::Array<Real, corners> weight;
    };

    //! Is the cell of this row gas? 1 for all cells of the domain outside
    //! solids, 0 for all others.
    Kokkos::View<int*, MemorySpace> is_gas;
    Kokkos::View<GhostCell*, MemorySpace> ghosts;

    Solid( const Json& input, const NodeLayout<Dim>& cells )
        : is_gas( "Machpoint::referenceGas", cells.total )
    {
        Json shapes = Json::array();
        for ( const auto& entry : input.at( "boundary" ) )
            if ( entry.at( "type" ) == "obstacle" )
                shapes.push_back( entry.at( "shape" ) );
        const auto shape = makeShape<Dim, Kokkos::HostSpace>(
            Json{ { "type", "union" }, { "shapes", shapes } } );
        const auto gas = Kokkos::create_mirror_view( is_gas );
        for ( int row = 0; row < cells.total; ++row )
        {
            const auto i = cells.indices( row );
            gas( row ) = cells.isOwned( i ) &&
                         shape.distance( cells.position( i ) ) >= 0;
        }
        std::vector<GhostCell> list;
        for ( int row = 0; row < cells.total; ++row )
            if ( cells.isOwned( cells.indices( row ) ) && !gas( row ) &&
                 isSeen( row, cells, gas ) )
                list.push_back( makeGhost( row, cells, gas, shape ) );
        Kokkos::deep_copy( is_gas, gas );
        ghosts = Kokkos::View<GhostCell*, MemorySpace>(
            "Machpoint::referenceGhosts", list.size() );
        const auto host = Kokkos::create_mirror_view( ghosts );
        std::copy( list.begin(), list.end(), host.data() );
        Kokkos::deep_copy( ghosts, host );
    }

    //! Sets the cells inside solids. \param w primitive, [rows][Dim + 2]
    void fill( const NodeView& w ) const
    {
        const auto list = ghosts;
        Kokkos::parallel_for(
            "Machpoint::referenceSolid",
            Range( 0, static_cast<int>( list.extent( 0 ) ) ),
            KOKKOS_LAMBDA( const int g ) {
                const auto ghost = list( g );
                Values<Dim> q{};
                for ( int c = 0; c < corners; ++c )
                    for ( int k = 0; ghost.weight[c] > 0 && k < Dim + 2; ++k )
                        q[k] += ghost.weight[c] * w( ghost.source[c], k );
                Real normal_velocity = 0;
                for ( int d = 0; d < Dim; ++d )
                    normal_velocity += q[1 + d] * ghost.normal[d];
                for ( int d = 0; d < Dim; ++d )
                    q[1 + d] -= 2 * normal_velocity * ghost.normal[d];
                store<Dim>( w, ghost.row, q );
            } );
    }

  private:
    using HostGas = typename Kokkos::View<int*, MemorySpace>::HostMirror;

    static bool isSeen( const int row, const NodeLayout<Dim>& cells,
                        const HostGas& gas )
    {
        for ( int d = 0; d < Dim; ++d )
            for ( int k = -ghost_layers; k <= ghost_layers; ++k )
                if ( gas( row + k * cells.stride[d] ) )
                    return true;
        return false;
    }

    static GhostCell makeGhost( const int row, const NodeLayout<Dim>& cells,
                                const HostGas& gas,
                                const Shape<Dim, Kokkos::HostSpace>& shape )
    {
        const auto x = cells.position( cells.indices( row ) );
        const auto surface = shape.nearest( x );
        GhostCell ghost{ row, surface.normal, {}, {} };
        Indices<Dim> base{};
        Vector<Dim> fraction{};
        for ( int d = 0; d < Dim; ++d )
        {
            const Real image = x[d] - 2 * surface.distance * surface.normal[d];
            const Real place = ( image - cells.first[d] ) / cells.spacing[d];
            // Beyond the domain the outermost cells stand for the image.
            const Real inside = std::clamp(
                place, 0.0, static_cast<Real>( cells.owned[d] - 1 ) );
            base[d] =
                std::min( static_cast<int>( inside ), cells.owned[d] - 2 );
            fraction[d] = inside - base[d];
        }
        Real total = 0;
        for ( int c = 0; c < corners; ++c )
        {
            ghost.source[c] = cells( base );
            ghost.weight[c] = 1;
            for ( int d = 0; d < Dim; ++d )
            {
                const bool next = ( c >> d ) & 1;
                ghost.source[c] += next ? cells.stride[d] : 0;
                ghost.weight[c] *= next ? fraction[d] : 1 - fraction[d];
            }
            ghost.weight[c] *= gas( ghost.source[c] );
            total += ghost.weight[c];
        }
        if ( total < 1e-6 )
        {
            // No gas around the image, as at a sharp edge: the nearest of the
            // gas that sees the cell stands for it.
            ghost.source[0] = nearestGas( row, cells, gas );
            ghost.weight = {};
            ghost.weight[0] = total = 1;
        }
        for ( int c = 0; c < corners; ++c )
            ghost.weight[c] /= total;
        return ghost;
    }

    static int nearestGas( const int row, const NodeLayout<Dim>& cells,
                           const HostGas& gas )
    {
        for ( int k = 1;; ++k )
            for ( int d = 0; d < Dim; ++d )
                for ( const int sign : { -1, 1 } )
                    if ( gas( row + sign * k * cells.stride[d] ) )
                        return row + sign * k * cells.stride[d];
    }
};

} // namespace Machpoint::Reference

#endif
