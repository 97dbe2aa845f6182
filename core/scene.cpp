#include <core/scene.hpp>

#include <core/initial_gas.hpp>
#include <core/profile.hpp>
#include <core/shape_input.hpp>
#include <physics/modules.hpp>

#include <fmt/format.h>

#include <algorithm>

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

/*!
  \brief What each node of each side of the whole domain is; the modules claim
  them. All ranks find the same, and the same errors.
  \return for each side the kinds of its nodes without halo, x first
*/
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
    try
    {
        return Halo<Dim>( layout, kinds, state.decomposition );
    }
    catch ( const std::invalid_argument& error )
    {
        throw InputError( { fmt::format( "/grid/cells: {}", error.what() ) } );
    }
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

//! Calls visit( id, x, gas, gradient of its velocity ) for each particle that
//! is to be laid into this rank's cells, cell by cell.
template <int Dim, class Visitor>
void forEachNewParticle( const InitialGas<Dim>& initial,
                         const Scene<Dim>& scene, const Visitor& visit )
{
    const auto& state = scene.state;
    const auto& grid = state.grid;
    const auto& box = state.layout.box;
    const int q = latticeSize( state.per_cell, Dim );
    for ( int own_cell = 0; own_cell < box.totalCells(); ++own_cell )
    {
        Indices<Dim> i{};
        int rest = own_cell;
        for ( int d = 0; d < Dim; ++d )
        {
            i[d] = box.begin[d] + rest % box.cells( d );
            rest /= box.cells( d );
        }
        // Ids and random places count the cells of the whole domain.
        std::int64_t cell = 0;
        for ( int d = Dim - 1; d >= 0; --d )
            cell = cell * grid.cells[d] + i[d];
        for ( int k = 0; k < state.per_cell; ++k )
        {
            const auto f =
                placeInCell<Dim>( state.placement, q, state.seed, cell, k );
            Vector<Dim> x{};
            for ( int d = 0; d < Dim; ++d )
                x[d] = grid.lower[d] + ( i[d] + f[d] ) * grid.spacing[d];
            bool solid = false;
            for ( const auto& active : scene.modules )
                solid = solid || active.module->isSolid( x );
            if ( solid )
                continue;
            Gradient gradient;
            const auto gas = initial.at( x, gradient );
            if ( gas.density != 0 ) // else a place without gas
                visit( cell * state.per_cell + k, x, gas, gradient );
        }
    }
}

//! Writes a row of host memory for a new particle.
template <int Dim>
void setParticle( const HostParticles<Dim>& host, const std::size_t p,
                  const std::int64_t id, const Vector<Dim>& x,
                  const GasState& gas, const Gradient& gradient,
                  const Real volume, const Real specific_internal_energy )
{
    for ( int a = 0; a < Dim; ++a )
    {
        host.template slice<Position>()( p, a ) = x[a];
        host.template slice<Velocity>()( p, a ) = gas.velocity[a];
        for ( int b = 0; b < Dim; ++b )
            host.template slice<VelocityGradient>()( p, a, b ) = gradient[a][b];
    }
    host.template slice<Volume>()( p ) = volume;
    host.template slice<SpecificInternalEnergy>()( p ) =
        specific_internal_energy;
    host.template slice<Mass>()( p ) = gas.density * volume;
    host.template slice<Pressure>()( p ) = 0;
    host.template slice<SoundSpeed>()( p ) = 0;
    host.template slice<Id>()( p ) = id;
}

//! Lays the particles into this rank's cells: counted first, then in blocks by
//! way of the host, so that memory holds them once.
template <int Dim>
void placeParticles( const Json& input, Scene<Dim>& scene )
{
    const InitialGas<Dim> initial( input );
    auto& state = scene.state;
    std::size_t count = 0;
    std::string fault;
    forEachNewParticle(
        initial, scene,
        [&]( const auto, const auto& x, const auto& gas, const auto& )
        {
            ++count;
            if ( fault.empty() )
                fault = initial.fault( x, gas );
        } );
    const auto& comm = state.decomposition.comm();
    const double first_fault =
        comm.min( fault.empty() ? comm.size() : comm.rank() );
    if ( first_fault < comm.size() )
        throw InputError(
            { comm.from( static_cast<int>( first_fault ), fault ) } );
    if ( state.decomposition.comm().sum( static_cast<std::int64_t>( count ) ) ==
         0 )
        throw InputError(
            { "/initial: no particle finds room: obstacles and regions leave "
              "no gas in the domain; shrink the obstacle or widen a region" } );
    state.particles.resize( count );
    HostParticles<Dim> block;
    block.resize( std::min<std::size_t>( count, 1 << 14 ) );
    const Real volume = state.grid.cellVolume() / state.per_cell;
    std::size_t first = 0, p = 0;
    forEachNewParticle(
        initial, scene,
        [&]( const std::int64_t id, const Vector<Dim>& x, const GasState& gas,
             const Gradient& gradient )
        {
            setParticle<Dim>( block, p, id, x, gas, gradient, volume,
                              scene.gas->specificInternalEnergy(
                                  gas.density, gas.pressure ) );
            if ( ++p < block.size() )
                return;
            state.particles.put( first, block );
            first += p;
            p = 0;
            block.resize( std::min( count - first, block.size() ) );
        } );
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
void layOut( Scene<Dim>& scene )
{
    scene.state.layout = layOutNodes( scene );
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
    state.reference_pressure = scene.gas->response().reference;
    weighImages( scene );
    for ( const auto& active : scene.modules )
        scene.is_open = scene.is_open || active.module->isOpen();
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
