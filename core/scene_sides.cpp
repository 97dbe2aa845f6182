/*!
  \file scene_sides.cpp
  \brief Does each place of the domain's sides belong to one entry of the input,
  and to which one?
*/
#include <core/scene_parts.hpp>

#include <core/shape_input.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace Machpoint
{

namespace
{

//! A place near which something is wrong, for messages.
template <int Dim>
std::string near( const Vector<Dim>& x )
{
    std::string text;
    for ( int d = 0; d < Dim; ++d )
        text += fmt::format( "{}{:.4g}", d ? ", " : "", x[d] );
    return fmt::format( "near ({})", text );
}

//! Adds what is wrong with a side. \param gap,overlap a place of each; none:
//! empty
void tellOfSide( std::vector<std::string>& errors, const std::string& side,
                 const std::string& gap, const std::string& overlap )
{
    if ( !gap.empty() )
        errors.push_back( fmt::format(
            "/boundary: no entry for side {} {}; add one, for example "
            "{{ \"type\": \"slip_wall\", \"side\": \"{}\" }}",
            side, gap, side ) );
    if ( !overlap.empty() )
        errors.push_back( fmt::format(
            "/boundary: more than one entry for side {} {}; keep one, or "
            "give them regions that do not overlap",
            side, overlap ) );
}

//! The regions of a side's entries that have one.
template <int Dim>
std::vector<Shape<Dim, Kokkos::HostSpace>> regionsOf( const Json& input,
                                                      const int side )
{
    std::vector<Shape<Dim, Kokkos::HostSpace>> regions;
    for ( const auto& entry : input.at( "boundary" ) )
        for ( const auto& claim : sidesOf( entry, Dim ) )
            if ( claim.side == side && entry.contains( "region" ) )
                regions.push_back(
                    makeShape<Dim, Kokkos::HostSpace>( entry.at( "region" ) ) );
    return regions;
}

//! A body that reaches through a periodic side must go on beyond the opposite
//! one, and one with images whose gas is beyond it, too: asks at the nodes of
//! both.
template <int Dim>
void checkPeriodicBodies( const Json& input, const Grid<Dim>& grid,
                          std::vector<std::string>& errors )
{
    Json solids = Json::array();
    Real reach = 0;
    Indices<Dim> is_periodic{};
    for ( const auto& entry : input.at( "boundary" ) )
    {
        if ( const auto& hooks = boundaryHooks( entry, Dim ); hooks.solid )
        {
            solids.push_back( hooks.solid( entry ) );
            if ( entry.value( "treatment", Json() ) == "images" )
                reach =
                    Kokkos::max( reach, entry.value( "image_reach", 0.0_rt ) *
                                            grid.maxSpacing() );
        }
        for ( const auto& claim : sidesOf( entry, Dim ) )
            if ( claim.kind == SideKind::periodic )
                is_periodic[claim.side / 2] = 1;
    }
    if ( solids.empty() )
        return;
    const auto shape = makeShape<Dim, Kokkos::HostSpace>(
        { { "type", "union" }, { "shapes", solids } } );
    const NodeLayout<Dim> whole( grid, false, 0 );
    // What rounding makes of a surface disturbs nothing.
    const Real slight = 0.25_rt * grid.minSpacing();
    const auto names = sideNames( Dim );
    for ( int axis = 0; axis < Dim; ++axis )
        for ( int t = 0;
              is_periodic[axis] && t < Halo<Dim>::sideSize( whole, axis ); ++t )
        {
            auto x = whole.position( Halo<Dim>::sideNode( whole, axis, t ) );
            x[axis] = grid.lower[axis];
            const Real lower = shape.distance( x );
            x[axis] = grid.upper[axis];
            const Real upper = shape.distance( x );
            const Real nearer = Kokkos::min( lower, upper );
            if ( nearer > reach || Kokkos::max( lower, upper ) < 0 ||
                 Kokkos::abs( lower - upper ) < slight )
                continue;
            const int side = 2 * axis + ( lower < upper ? 0 : 1 );
            if ( lower < upper )
                x[axis] = grid.lower[axis];
            errors.push_back( fmt::format(
                "/boundary: the body {} the periodic side {} {} does not go on "
                "at {}; add it once more, moved by the domain's length, as a "
                "member of a union",
                nearer < 0 ? "that reaches through" : "within image_reach of",
                names[side], near<Dim>( x ), names[side ^ 1] ) );
            break;
        }
}

} // namespace

//! Asks in the middle of each quarter of a cell of a side whose entries have
//! regions; in 3D of 512 parts along an axis at most. A seam belongs to both.
template <int Dim>
void checkSides( const Json& input )
{
    const auto grid = makeGrid<Dim>( input );
    const auto names = sideNames( Dim );
    std::vector<std::string> errors;
    for ( int side = 0; side < 2 * Dim; ++side )
    {
        const int axis = side / 2;
        const auto regions = regionsOf<Dim>( input, side );
        if ( regions.empty() )
            continue; // whole sides are counted where the input is read
        constexpr int most = Dim == 3 ? 512 : 1 << 18;
        Indices<Dim> parts{};
        int count = 1;
        for ( int d = 0; d < Dim; ++d )
        {
            parts[d] = d == axis ? 1 : std::min( 4 * grid.cells[d], most );
            count *= parts[d];
        }
        std::string gap, overlap;
        for ( int k = 0; k < count; ++k )
        {
            Vector<Dim> x{};
            int rest = k;
            for ( int d = 0; d < Dim; ++d )
            {
                x[d] = grid.lower[d] + ( rest % parts[d] + 0.5_rt ) *
                                           ( grid.upper[d] - grid.lower[d] ) /
                                           parts[d];
                rest /= parts[d];
            }
            x[axis] = side % 2 ? grid.upper[axis] : grid.lower[axis];
            const Real seam = nudge * grid.minSpacing();
            const auto within = [&]( const Real distance )
            {
                return std::count_if(
                    regions.begin(), regions.end(),
                    [&]( const auto& region )
                    { return region.distance( x ) < distance; } );
            };
            if ( gap.empty() && within( seam ) == 0 )
                gap = near<Dim>( x );
            if ( overlap.empty() && within( -seam ) > 1 )
                overlap = near<Dim>( x );
        }
        tellOfSide( errors, names[side], gap, overlap );
    }
    checkPeriodicBodies( input, grid, errors );
    if ( !errors.empty() )
        throw InputError( errors );
}

void checkSides( const Json& input )
{
    switch ( input.at( "dimension" ).get<int>() )
    {
    case 1:
        return checkSides<1>( input );
    case 2:
        return checkSides<2>( input );
    default:
        return checkSides<3>( input );
    }
}

template <int Dim>
std::vector<std::vector<SideKind>> claimSides( Scene<Dim>& scene,
                                               const NodeLayout<Dim>& whole )
{
    std::vector<std::vector<SideKind>> kinds;
    std::vector<std::string> errors;
    const auto names = sideNames( Dim );
    for ( int side = 0; side < 2 * Dim; ++side )
    {
        const int axis = side / 2;
        auto& list = kinds.emplace_back();
        std::string gap, overlap;
        for ( int t = 0; t < Halo<Dim>::sideSize( whole, axis ); ++t )
        {
            auto x = whole.position( Halo<Dim>::sideNode( whole, axis, t ) );
            // Regions may end at the domain's edge, or at a node.
            const auto& grid = scene.state.grid;
            const Real hair = nudge * grid.minSpacing();
            for ( int d = 0; d < Dim; ++d )
                x[d] = std::clamp( x[d] + hair, grid.lower[d] + hair,
                                   grid.upper[d] - hair );
            x[axis] = side % 2 ? grid.upper[axis] : grid.lower[axis];
            int claims = 0;
            SideKind kind{};
            for ( const auto& active : scene.modules )
                for ( const auto& claim : active.sides )
                    if ( claim.side == side && active.module->covers( x ) )
                    {
                        kind = claim.kind;
                        ++claims;
                    }
            list.push_back( kind );
            auto& problem = claims == 0 ? gap : overlap;
            if ( claims != 1 && problem.empty() )
                problem = near<Dim>( x );
            if ( kind == SideKind::no_slip )
                for ( int d = 0; d < Dim; ++d )
                    scene.has_wall[d] = 1;
            else if ( kind == SideKind::slip )
                scene.has_wall[axis] = 1;
        }
        tellOfSide( errors, names[side], gap, overlap );
    }
    if ( !errors.empty() )
        throw InputError( errors );
    return kinds;
}

template void checkSides<1>( const Json& );
template void checkSides<2>( const Json& );
template void checkSides<3>( const Json& );
template std::vector<std::vector<SideKind>> claimSides( Scene<1>&,
                                                        const NodeLayout<1>& );
template std::vector<std::vector<SideKind>> claimSides( Scene<2>&,
                                                        const NodeLayout<2>& );
template std::vector<std::vector<SideKind>> claimSides( Scene<3>&,
                                                        const NodeLayout<3>& );

} // namespace Machpoint
