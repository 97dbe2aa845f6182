/*!
  \file transfer.hpp
  \brief Layer 3: what moves between particles and nodes: loops over packs with
  their stencils, which all methods share, and kernels that some do;
  docs/method.md maps each to its equation.
*/
#ifndef MACHPOINT_TRANSFER_HPP
#define MACHPOINT_TRANSFER_HPP

#include <core/products.hpp>
#include <core/soundness.hpp>
#include <core/state.hpp>
#include <core/stencil.hpp>

#include <cstddef>
#include <new>
#include <type_traits>

namespace Machpoint
{

namespace Impl
{
//! Does a body leave nothing to be added later?
template <class Prepare>
KOKKOS_INLINE_FUNCTION constexpr bool leavesNothing()
{
    // The compiler for a GPU must not be asked what a kernel returns.
    if constexpr ( lane_count == 1 )
        return true;
    else
        return std::is_void_v<std::invoke_result_t<Prepare, int>>;
}

//! The places of two things that are made in turn, one ahead of the other.
template <class T>
class TwoPlaces
{
  public:
    template <class Make>
    KOKKOS_FORCEINLINE_FUNCTION void make( const int k, const Make& make )
    {
        new ( _bytes[k & 1] ) T( make( k ) );
    }
    KOKKOS_FORCEINLINE_FUNCTION T& operator()( const int k )
    {
        return *std::launder( reinterpret_cast<T*>( _bytes[k & 1] ) );
    }

  private:
    alignas( T ) std::byte _bytes[2][sizeof( T )];
};

/*!
  \brief Calls prepare( k ) for k from `first` on, and a turn later add() of
  what it returned, if anything.

  How many particles in a row share their nodes is hard to foresee. Until a
  processor knows where it guessed wrong, it makes ready what the next pack
  adds, whose long chain of operations would else begin behind the guess.
*/
template <class Prepare>
KOKKOS_FORCEINLINE_FUNCTION void addBehind( const int first, const int last,
                                            const Prepare& prepare )
{
    if constexpr ( leavesNothing<Prepare>() )
        for ( int k = first; k < last; ++k )
            prepare( k );
    else if ( first < last )
    {
        TwoPlaces<std::invoke_result_t<Prepare, int>> ready;
        for ( int k = first; k <= last; ++k )
        {
            if ( k < last )
                ready.make( k, prepare );
            if ( k > first )
                ready( k - 1 ).add();
        }
    }
}

/*!
  \brief Calls visit( k, make( k ) ) for k from `first` on, where a processor
  works on several particles with make( k + 1 ) ahead of it: the chain of
  operations that leads to a pack's first nodes is long.
*/
template <class Make, class Visit>
KOKKOS_FORCEINLINE_FUNCTION void makeAhead( const int first, const int last,
                                            const Make& make,
                                            const Visit& visit )
{
    if constexpr ( lane_count == 1 )
        for ( int k = first; k < last; ++k )
            visit( k, make( k ) );
    else if ( first < last )
    {
        TwoPlaces<std::invoke_result_t<Make, int>> made;
        made.make( first, make );
        for ( int k = first; k < last; ++k )
        {
            if ( k + 1 < last )
                made.make( k + 1, make );
            visit( k, made( k ) );
        }
    }
}

//! A node field that packs read.
struct FieldAhead
{
    const Real* data;
    int columns;
};

//! Nodes from a pack's first to those that are fetched, some four packs of a
//! lattice with 4 particles a cell.
inline constexpr int nodes_ahead = 8;

/*!
  \brief Tells the processor to fetch rows of a field for the packs to come: of
  the last line of a pack's stencils, which those before have not read yet, and
  of the one behind it, where particles of the next cells may be.

  It does not foresee these itself: they are as far apart as the particles of a
  line of cells, whose own memory is read in between. In 1D all is in one line;
  in 3D it does not pay (docs/performance_tried.md).
  \param base first row of each lane's stencil
*/
template <class Basis, bool Writes, int Dim>
KOKKOS_FORCEINLINE_FUNCTION void
fetchAhead( [[maybe_unused]] const FieldAhead& field,
            [[maybe_unused]] const Bases<Lanes>& base,
            [[maybe_unused]] const NodeLayout<Dim>& layout )
{
    if constexpr ( Dim == 2 && lane_count > 1 )
        for ( int line = Basis::nodes - 1; line <= Basis::nodes; ++line )
            prefetchRow<Writes, 2>( field.data, field.columns,
                                    lane( base, 0 ) + nodes_ahead +
                                        line * layout.stride[1] );
}

//! The same of the sums that a pack adds to.
template <class Basis, int Dim, class Access>
KOKKOS_FORCEINLINE_FUNCTION void
fetchSumsAhead( [[maybe_unused]] const Access& nodes, const Bases<Lanes>& base,
                const NodeLayout<Dim>& layout )
{
    if constexpr ( std::is_same_v<Access, NodeScatter::Access> )
        fetchAhead<Basis, true>( FieldAhead{ nodes.sums, nodes.columns }, base,
                                 layout );
}

template <class Basis, int Dim, class Positions, class Body, std::size_t Fields>
struct GatherTurns
{
    Positions x;
    Grid<Dim> grid;
    NodeLayout<Dim> layout;
    int n;
    Body body;
    Kokkos::Array<FieldAhead, Fields> read;

    KOKKOS_FORCEINLINE_FUNCTION void operator()( const int first,
                                                 const int last ) const
    {
        Own<Positions> own_x = x;
        Own<Grid<Dim>> own_grid = grid;
        Own<NodeLayout<Dim>> own_layout = layout;
        Own<Body> own_body = body;
        [[maybe_unused]] const auto own_read = read;
        const int all = n;
        makeAhead(
            first, last,
            [&]( const int k ) MACHPOINT_INLINE
            {
                return Stencil<Basis, Dim, Lanes>(
                    own_grid, own_layout,
                    loadVector<Dim>( own_x, Pack::of( k, all ) ) );
            },
            [&]( const int k, const Stencil<Basis, Dim, Lanes>& s )
                MACHPOINT_INLINE
            {
                if constexpr ( Dim == 2 )
                    for ( std::size_t f = 0; f < Fields; ++f )
                        fetchAhead<Basis, false>( own_read[f], s.base,
                                                  own_layout );
                own_body( Pack::of( k, all ), s );
            } );
    }
};

template <class Ready, class Basis, int Dim, class Sums, class Act,
          class Deposit>
struct DepositTurns
{
    Grid<Dim> grid;
    NodeLayout<Dim> layout;
    int n;
    Sums sums;
    Act act;
    Deposit deposit;

    KOKKOS_FORCEINLINE_FUNCTION void operator()( const int first,
                                                 const int last ) const
    {
        Own<Grid<Dim>> own_grid = grid;
        Own<NodeLayout<Dim>> own_layout = layout;
        Own<Act> own_act = act;
        Own<Deposit> own_deposit = deposit;
        const int all = n;
        const auto thread = sums.thread();
        addBehind( first, last,
                   [&]( const int k ) MACHPOINT_INLINE
                   {
                       const Pack p = Pack::of( k, all );
                       Ready ready;
                       own_act( p, ready );
                       const Stencil<Basis, Dim, Lanes> s( own_grid, own_layout,
                                                           ready.x );
                       const auto nodes = accessTo( thread, p, s, own_layout );
                       fetchSumsAhead<Basis>( nodes, s.base, own_layout );
                       return own_deposit( p, s, nodes, ready );
                   } );
    }
};

//! A pack of which nothing is made ready but its place, and what reads it.
template <int Dim>
struct PlacedPack
{
    VectorOf<Dim, Lanes> x;
};
template <int Dim, class Positions>
struct ReadPlace
{
    Positions x;

    KOKKOS_FORCEINLINE_FUNCTION void operator()( const Pack p,
                                                 PlacedPack<Dim>& own ) const
    {
        own.x = loadVector<Dim>( x, p );
    }
};
//! A body that asks for no more.
template <class Body>
struct DepositOfPlaced
{
    Body body;

    template <class PackStencil, class Nodes, class Ready>
    KOKKOS_FORCEINLINE_FUNCTION auto
    operator()( const Pack p, const PackStencil& s, const Nodes& nodes,
                const Ready& ) const
    {
        return body( p, s, nodes );
    }
};
} // namespace Impl

//! Calls body( p, s ) for the packs of particles and their stencils, in
//! parallel: see forEach. \param read NodeViews of which it reads all of a
//! stencil, to be fetched ahead
template <class Basis, int Dim, class Body, class... Fields>
void forEachStencil( const char* label, const State<Dim>& state,
                     const Body& body, const Fields&... read )
{
    const auto x = state.particles.template slice<Position>();
    const int n = state.particles.size();
    // Blocks that a multiprocessor of a GPU is to hold (RangeOf), as measured:
    // a thread has 128 registers, and in 3D 168.
    forEachShare<Dim == 3 ? 3 : 4>(
        label, countPacks( n ), few_stencils<Dim>,
        Impl::GatherTurns<Basis, Dim, decltype( x ), Body, sizeof...( read )>{
            x,
            state.grid,
            state.layout,
            n,
            body,
            { Impl::FieldAhead{ read.data(),
                                static_cast<int>( read.stride( 0 ) ) }... } } );
}

/*!
  \brief Calls act( p, ready ) and deposit( p, s, nodes, ready ) for the packs
  of particles: first they find out where they are and what they add, then they
  add it. Deposit returns what addProductsLater returns, or nothing.
  \tparam Ready what act sets; its member x is where the pack deposits
  \tparam Blocks that a multiprocessor of a GPU is to hold; in the 128
  registers that a thread of four has, two long bodies would keep numbers in
  memory
  \param sums the scatter of the field
*/
template <class Ready, class Basis, int Blocks = 3, int Dim, class Sums,
          class Act, class Deposit>
void forEachDeposit( const char* label, const State<Dim>& state,
                     const Sums& sums, const Act& act, const Deposit& deposit )
{
    const int n = state.particles.size();
    forEachShare<holds_many_blocks ? Blocks : 1>(
        label, countPacks( n ), few_stencils<Dim>,
        Impl::DepositTurns<Ready, Basis, Dim, Sums, Act, Deposit>{
            state.grid, state.layout, n, sums, act, deposit } );
}

//! The same of packs that stand where their particles do: calls
//! body( p, s, nodes ).
template <class Basis, int Dim, class Sums, class Body>
void forEachDeposit( const char* label, const State<Dim>& state,
                     const Sums& sums, const Body& body )
{
    const auto x = state.particles.template slice<Position>();
    forEachDeposit<Impl::PlacedPack<Dim>, Basis, 4>(
        label, state, sums, Impl::ReadPlace<Dim, decltype( x )>{ x },
        Impl::DepositOfPlaced<Body>{ body } );
}

//! What particles add first: mass, momentum, and the force along each axis.
//! (`conservative` has ConservativeTerms.)
template <int Dim, bool Affine>
struct MomentTerms
{
    //! \name As core/product_terms.hpp asks
    //! @{
    static constexpr int count = 1 + 2 * Dim;
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int column( const int t )
    {
        return t;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr bool isAffine( const int t )
    {
        return Affine && 0 < t && t <= Dim;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int axis( const int t )
    {
        return t <= Dim ? -1 : t - 1 - Dim;
    }
    //! @}
};

//! The terms of mass and of affine momentum. \param[in,out] terms MomentTerms,
//! or others that begin with them \param C affine matrix, 1/time
template <int Dim, class Terms, class Number>
KOKKOS_FORCEINLINE_FUNCTION void
setMoments( Products<Terms, Dim, Number>& terms, const Number& mass,
            const VectorOf<Dim, Number>& v,
            const VectorOf<Dim, Number> ( &C )[Dim] )
{
    terms.value[0] = mass;
    for ( int a = 0; a < Dim; ++a )
    {
        terms.value[1 + a] = mass * v[a];
        for ( int b = 0; b < Dim; ++b )
            terms.slope[1 + a][b] = mass * C[a][b];
    }
}

/*!
  \brief P2G of mass, momentum and internal force (Algorithm 1, lines 2-4).

  m_i = sum m w, (mv)_i = sum m w (v + Affine C (x_i - x)),
  f_i = sum V p grad w.

  \tparam Affine does the momentum carry the affine velocity field?
  \param sums the scatter of a field [nodes][1 + 2 Dim]
*/
template <class Basis, bool Affine, int Dim, class Sums>
void particlesToGrid( const State<Dim>& state, const Sums& sums )
{
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        "Machpoint::particlesToGrid", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes ) MACHPOINT_INLINE {
            const auto u = loadVector<Dim>( v, p );
            VectorOf<Dim, Lanes> affine[Dim];
            loadMatrix<Dim>( C, p, affine );
            Products<MomentTerms<Dim, Affine>, Dim, Lanes> terms;
            setMoments<Dim>( terms, load( m, p ), u, affine );
            const Lanes Vp = load( V, p ) * load( pressure, p );
            for ( int d = 0; d < Dim; ++d )
                terms.value[1 + Dim + d] = Vp;
            return addProductsLater( nodes, p, s, layout, s.dw, terms );
        } );
}

//! The affine field that particles take from the nodes to where they will be.
template <int Dim>
struct LandedFit
{
    VectorOf<Dim, Lanes> C[Dim]; //!< C', 1/time
    Lanes fitted{ 0.0 };         //!< sum w |F (x_i - x)|^2 of the fit F, before
    Lanes carried{ 0.0 };        //!< the same of C' where the particle will be
    Lanes squared{ 0.0 };        //!< |C'|_F^2
};

/*!
  \brief C'_ab = F_ab min(1, sqrt(mu_b(x) / mu_b(x'))) of a fit F with moments
  mu (docs/method.md, section 5): on hats mu depends on the place in a cell, and
  what the affine energy loses on the way becomes heat.
  \param fit sums of fitWeight \param new_x x', before a periodic shift or a
  reflection: the place in the cell stays
*/
template <class Basis, int Dim>
KOKKOS_FORCEINLINE_FUNCTION LandedFit<Dim>
landFit( const Grid<Dim>& grid, const Stencil<Basis, Dim, Lanes>& s,
         const VectorOf<Dim, Lanes> ( &fit )[Dim],
         const VectorOf<Dim, Lanes>& new_x )
{
    LandedFit<Dim> landed;
    for ( int b = 0; b < Dim; ++b )
    {
        const Lanes moment = s.moment( b, grid.spacing[b] );
        Lanes moment_new = moment;
        if constexpr ( !Basis::constant_moment )
            moment_new = momentAt<Basis, Dim>( grid, new_x[b], b );
        const Lanes factor = slopeFactor<Basis>( moment, moment_new );
        for ( int a = 0; a < Dim; ++a )
        {
            const Lanes slope = slopeOfFit<Basis>( fit[a][b], grid.inverse[b] );
            const Lanes kept = asDeviation( slope * factor );
            landed.C[a][b] = kept;
            landed.fitted += slope * slope * moment;
            landed.carried += kept * kept * moment_new;
            landed.squared += kept * kept;
        }
    }
    return landed;
}

//! Sums become means: columns 1 to Columns - 1 of all rows over column 0; 0
//! where that is 0. \param label of the kernel
template <int Columns>
void divideByFirst( const char* label, const NodeView& sums )
{
    forEach(
        label, sums.extent_int( 0 ), MACHPOINT_LAMBDA( const int i ) {
            const Real whole = sums( i, 0 );
            for ( int k = 1; k < Columns; ++k )
                sums( i, k ) = whole > 0 ? sums( i, k ) / whole : 0.0_rt;
        } );
}

//! x / m of a node; 0 without gas, with so little that 1 / m were infinite, or
//! of a mass that is no number.
KOKKOS_FORCEINLINE_FUNCTION Real perMass( const Real x, const Real m )
{
    return m >= Kokkos::Experimental::norm_min_v<Real> ? x / m : 0.0_rt;
}

//! v_i = (mv)_i / m_i on nodes; 0 where there is no gas. Sets columns 0 to
//! Dim - 1 of state.nodes.velocities. \param rows that are served
template <int Dim>
void gridVelocity( const State<Dim>& state, const NodeRows& rows )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    rows.forEach(
        "Machpoint::gridVelocity",
        MACHPOINT_LAMBDA( const int i ) MACHPOINT_INLINE {
            const Real m = moments( i, 0 );
            for ( int d = 0; d < Dim; ++d )
                velocities( i, d ) = perMass( moments( i, 1 + d ), m );
        } );
}

//! v'_i = v_i + dt f_i / m_i (Algorithm 1, line 5) on all stored nodes. Sets
//! columns Dim to 2 Dim - 1 of state.nodes.velocities.
template <int Dim>
void advanceGridVelocity( const State<Dim>& state )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const Real dt = state.dt;
    forEach(
        "Machpoint::advanceGridVelocity", state.layout.total,
        MACHPOINT_LAMBDA( const int i ) MACHPOINT_INLINE {
            const Real m = moments( i, 0 );
            for ( int d = 0; d < Dim; ++d )
                velocities( i, Dim + d ) =
                    velocities( i, d ) +
                    perMass( dt * moments( i, 1 + Dim + d ), m );
        } );
}

} // namespace Machpoint

#endif
