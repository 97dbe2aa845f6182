/*!
  \file scene.cpp
  \brief A scene, built: its modules, bodies and nodes, and what an input may
  name of them.
*/
#include <core/scene.hpp>

#include <core/profile.hpp>
#include <core/scene_parts.hpp>
#include <core/shape_input.hpp>
#include <physics/modules.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace Machpoint
{

namespace
{

template <int Dim>
std::vector<Parameters>
declarations( const std::vector<ModuleFactory<Dim>>& factories,
              const int dimension )
{
    std::vector<Parameters> list;
    for ( const auto& factory : factories )
        list.push_back( factory.declare( dimension ) );
    return list;
}

//! Makes the modules of a list, equations of state first.
template <int Dim>
void makeModules( const Json& list,
                  const std::vector<ModuleFactory<Dim>>& factories,
                  Scene<Dim>& scene )
{
    for ( const bool gas : { true, false } )
        for ( const auto& json : list )
        {
            const auto& factory = findFactory( factories, json );
            if ( factory.is_equation_of_state != gas )
                continue;
            if ( !factory.make )
                throw std::logic_error( fmt::format(
                    "Machpoint_DIMENSIONS leaves out {}D, and so {}", Dim,
                    factory.name ) );
            const auto name = reportName( json );
            const Profile::Effect effect( name );
            auto module = factory.make( json, scene.gas );
            if ( gas )
                scene.gas = static_cast<EquationOfState<Dim>*>( module.get() );
            const auto& input = factory.input;
            scene.modules.push_back(
                { name, std::move( module ), factory.hooks,
                  input.sides ? input.sides( json ) : std::vector<SideClaim>(),
                  input.solid ? input.solid( json ) : Json() } );
        }
}

//! The boxes of the ranks that the input asks for.
template <int Dim>
Decomposition<Dim> decompose( const Json& input, const Grid<Dim>& grid )
{
    const Communicator comm;
    auto ranks = chooseRanks<Dim>( grid.cells, comm.size() );
    const auto block = input.find( "decomposition" );
    if ( block != input.end() && block->contains( "ranks" ) )
        for ( int d = 0; d < Dim; ++d )
            ranks[d] = block->at( "ranks" ).at( d ).template get<int>();
    try
    {
        return Decomposition<Dim>( comm, grid.cells, ranks );
    }
    catch ( const std::invalid_argument& error )
    {
        throw InputError(
            { fmt::format( "/decomposition/ranks: {}", error.what() ) } );
    }
}

//! The node of the domain whose image node i is: periodic or mirrored.
template <int Dim>
Indices<Dim> imageOf( const NodeLayout<Dim>& layout, Indices<Dim> i )
{
    i = layout.home( i );
    const int centre = layout.centred ? 1 : 0;
    for ( int d = 0; d < Dim; ++d )
    {
        const int last = layout.cells[d] - centre;
        if ( i[d] < 0 )
            i[d] = -i[d] - centre;
        else if ( i[d] > last )
            i[d] = 2 * last + centre - i[d];
    }
    return i;
}

//! The halo of this rank's nodes.
template <int Dim>
Halo<Dim> makeHalo( const Scene<Dim>& scene )
{
    const auto& state = scene.state;
    const auto& layout = state.layout;
    const NodeLayout<Dim> whole( state.grid, layout.centred, 0 );
    Kokkos::Array<KindView, 2 * Dim> kinds;
    for ( int side = 0; side < 2 * Dim; ++side )
    {
        const int axis = side / 2;
        const int size = Halo<Dim>::sideSize( layout, axis );
        kinds[side] = KindView( "Machpoint::sideKinds", size );
        auto host = Kokkos::create_mirror_view( kinds[side] );
        for ( int t = 0; t < size; ++t )
        {
            const auto i =
                imageOf<Dim>( layout, Halo<Dim>::sideNode( layout, axis, t ) );
            int flat = 0;
            for ( int d = Dim - 1; d >= 0; --d )
                if ( d != axis )
                    flat = flat * whole.extent[d] + i[d];
            host( t ) = scene.side_kinds[side][flat];
        }
        Kokkos::deep_copy( kinds[side], host );
    }
    return Halo<Dim>( layout, kinds, state.decomposition );
}

template <std::size_t K = 0>
std::vector<Parameters> declareInitialStates( const int dimension )
{
    if constexpr ( K < std::tuple_size_v<InitialStates> )
    {
        using Type = std::tuple_element_t<K, InitialStates>;
        auto list = declareInitialStates<K + 1>( dimension );
        // Some states need a plane; 0 stands for all dimensions.
        if constexpr ( requires { Type::least_dimension; } )
            if ( dimension != 0 && dimension < Type::least_dimension )
                return list;
        list.insert( list.begin(), Type::declare( dimension ) );
        return list;
    }
    return {};
}

//! All bodies, in the order of their modules.
template <int Dim>
Bodies<Dim> findBodies( const Scene<Dim>& scene )
{
    Json members = Json::array();
    std::vector<int> solids;
    std::vector<Real> reach;
    for ( const auto& active : scene.modules )
        if ( !active.solid.is_null() )
        {
            active.module->body = static_cast<int>( solids.size() );
            members.push_back( active.solid );
            solids.push_back(
                makeShape<Dim, Kokkos::HostSpace>( active.solid ).size() );
            reach.push_back( active.module->imageReach() );
        }
    if ( members.empty() )
        return {};
    return { makeShape<Dim>( { { "type", "union" }, { "shapes", members } } ),
             solids, reach };
}

//! How near to a surface particles have an image at most, cells along the
//! normal; 0: there are none.
template <int Dim>
Real imageReach( const Scene<Dim>& scene )
{
    Real farthest = 0;
    for ( const auto& active : scene.modules )
        farthest = std::max( farthest, active.module->imageReach() );
    return farthest;
}

//! The weight of all gas, and whether it pulls at images.
template <int Dim>
void weighImages( Scene<Dim>& scene )
{
    auto& weight = scene.state.image_weight;
    for ( const auto& active : scene.modules )
    {
        const auto g = active.module->acceleration();
        for ( int d = 0; d < Dim; ++d )
            weight.acceleration[d] += g[d];
    }
    weight.acts = imageReach( scene ) > 0 &&
                  dot<Dim>( weight.acceleration, weight.acceleration ) > 0;
}

//! This rank's nodes; images of particles may lie in other ranks' boxes.
template <int Dim>
NodeLayout<Dim> layOutNodes( const Scene<Dim>& scene )
{
    const auto& state = scene.state;
    const auto& needs = scene.needs;
    Indices<Dim> reach{}, margin{};
    for ( int d = 0; d < Dim; ++d )
    {
        reach[d] = needs.reach;
        const bool is_cut = state.decomposition.ranks()[d] > 1;
        const bool is_periodic =
            scene.side_kinds[2 * d].front() == SideKind::periodic;
        if ( !is_cut && !is_periodic )
            continue; // images beyond the domain are left out
        reach[d] += static_cast<int>(
            std::ceil( imageSpan<Dim>( state.grid, imageReach( scene ), d ) ) );
        if ( is_cut )
            margin[d] = needs.margin;
    }
    NodeLayout<Dim> layout( state.grid, state.decomposition.box(),
                            needs.centred, needs.halo, reach, margin );
    for ( int d = 0; d < Dim; ++d )
        if ( scene.side_kinds[2 * d].front() == SideKind::periodic )
            layout.period[d] = layout.cells[d];
    return layout;
}

} // namespace

template <int Dim>
void layOut( Scene<Dim>& scene )
{
    scene.state.layout = layOutNodes( scene );
    try
    {
        Halo<Dim>::requireWideBoxes( scene.state.layout,
                                     scene.state.decomposition );
    }
    catch ( const std::invalid_argument& error )
    {
        throw InputError( { fmt::format(
            "/grid/cells: {}{}", error.what(),
            imageReach( scene ) > 0 ? " (fewer with less image_reach of bodies)"
                                    : "" ) } );
    }
    scene.state.halo = makeHalo( scene );
}

template <int Dim>
Scene<Dim> makeScene( const Json& input, const NodeNeeds& needs )
{
    Scene<Dim> scene;
    scene.needs = needs;
    auto& state = scene.state;
    state.grid = makeGrid<Dim>( input );
    state.decomposition = decompose( input, state.grid );
    const auto& particles = input.at( "particles" );
    state.per_cell = particles.at( "per_cell" );
    state.seed = particles.at( "seed" ).template get<std::uint64_t>();
    const auto placement =
        particles.at( "placement" ).template get<std::string>();
    state.placement = placement == "lattice"    ? Placement::lattice
                      : placement == "jittered" ? Placement::jittered
                                                : Placement::random;
    state.cfl = input.at( "time" ).at( "cfl" );
    state.reproducible = input.at( "reproducible" );
    checkSides<Dim>( input );
    makeModules( input.at( "physics" ), physicsModules<Dim>(), scene );
    makeModules( input.at( "boundary" ), boundaryModules<Dim>(), scene );
    // Bodies before sides: what a body pushes out of the box must still leave.
    // Periodic sides before others: a place on these is one in the domain.
    const auto first_side = std::stable_partition(
        scene.modules.begin(), scene.modules.end(),
        []( const auto& active ) { return active.sides.empty(); } );
    std::stable_partition(
        first_side, scene.modules.end(),
        []( const auto& active )
        { return active.sides.front().kind == SideKind::periodic; } );
    state.bodies = findBodies( scene );
    const auto response = scene.gas->response();
    if ( !( response.exponent > 0 ) )
        throw std::logic_error( fmt::format(
            "the response of a gas has an exponent above 0, not {}",
            response.exponent ) );
    state.reference_pressure = response.reference;
    weighImages( scene );
    for ( const auto& active : scene.modules )
        scene.is_open = scene.is_open || active.module->isOpen() ||
                        std::any_of( active.sides.begin(), active.sides.end(),
                                     []( const SideClaim& claim )
                                     { return claim.kind == SideKind::open; } );
    scene.side_kinds =
        claimSides( scene, NodeLayout<Dim>( state.grid, needs.centred, 0 ) );
    layOut( scene );
    placeParticles( input, scene );
    return scene;
}

Family physicsFamily()
{
    return { "physics", []( const int dimension )
             { return declarations( physicsModules<3>(), dimension ); } };
}

Family boundaryFamily()
{
    return { "boundary", []( const int dimension )
             { return declarations( boundaryModules<3>(), dimension ); } };
}

Family initialFamily()
{
    return { "initial", []( const int dimension )
             {
                 auto list = declareInitialStates( dimension );
                 for ( auto& entry : list )
                     entry
                         .oneOf( "region", shapeFamily(),
                                 "fill only the inside of this shape" )
                         .optional();
                 return list;
             } };
}

template void layOut( Scene<1>& );
template void layOut( Scene<2>& );
template void layOut( Scene<3>& );
template Scene<1> makeScene( const Json&, const NodeNeeds& );
template Scene<2> makeScene( const Json&, const NodeNeeds& );
template Scene<3> makeScene( const Json&, const NodeNeeds& );

} // namespace Machpoint
