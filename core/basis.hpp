/*!
  \file basis.hpp
  \brief Layer 2: linear, quadratic and cubic B-splines, and the stencil of a
  particle.

  For every degree the knots lie on cell boundaries: nodes of odd degree stand
  at cell vertices, those of even degree at cell centres (docs/method.md,
  section 2). All particles of a cell share one stencil.

  Each basis gives, for a particle at the fraction f in [0, 1] of its cell:
  weights(f, w), gradients(f, g) (dw/dx times h), offset(f, k) (x_k - x_p over
  h) and moment(f) = sum_k w_k (x_k - x_p)^2 / h^2, and of the places halfway
  between nodes halfwayGradients(f, g). All of them take a Number, of one
  particle or of several (core/lanes.hpp). docs/method.md, section 2, has the
  formulas, and the identities that all of the transfer rests on.
*/
#ifndef MACHPOINT_BASIS_HPP
#define MACHPOINT_BASIS_HPP

#include <core/grid.hpp>
#include <core/lane_members.hpp>
#include <core/lane_rows.hpp>
#include <core/lanes.hpp>

namespace Machpoint
{

//! Hat functions, nodes at cell vertices (the paper's basis).
struct Linear
{
    static constexpr const char* name = "linear"; //!< in `method.basis`
    static constexpr int nodes = 2;               //!< along one axis
    static constexpr int halo = 0;         //!< layers reached beyond the box
    static constexpr bool centred = false; //!< nodes at vertices
    //! Is the moment the same everywhere? That of hats is 0 on nodes, so they
    //! have no slope to divide by it (fitWeight).
    static constexpr bool constant_moment = false;
    //! \name Sum of the squares of the weights, its mean over a cell
    //! For stableTimeStep (docs/conservative.md, section 10).
    //! @{
    static constexpr Real mean_square = 2.0_rt / 3; //!< of nodes
    static constexpr Real halfway_mean_square = 1;  //!< halfway between them
    //! @}

    //! Number of the first node that a cell's particles see, along one axis.
    KOKKOS_INLINE_FUNCTION static int first( const int cell ) { return cell; }
    //! \param f 0 to 1 \param[out] w [nodes], which add up to 1
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void weights( const Number& f,
                                                     Number* w )
    {
        w[0] = 1 - f;
        w[1] = f;
    }
    //! Derivatives of the weights, times h. \param[out] g [nodes]
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void gradients( const Number&,
                                                       Number* g )
    {
        g[0] = -1;
        g[1] = 1;
    }
    //! Derivatives (times h) of the weights halfway between nodes.
    //! \param[out] g [nodes - 1]
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void halfwayGradients( const Number&,
                                                              Number* g )
    {
        g[0] = 0;
    }
    //! (x_k - x_p) / h of node k of those seen, 0 to nodes - 1.
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static Number offset( const Number& f,
                                                      const int k )
    {
        return k - f;
    }
    //! sum_k w_k (x_k - x_p)^2 / h^2.
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static Number moment( const Number& f )
    {
        // A particle on a side of its box may seem beyond it by a rounding.
        return Kokkos::max( Number( f * ( 1 - f ) ), Number( 0.0 ) );
    }
};

//! Quadratic B-splines, nodes at cell centres.
struct Quadratic
{
    //! \name The members of Linear, of another degree
    //! @{
    static constexpr const char* name = "quadratic";
    static constexpr int nodes = 3;
    static constexpr int halo = 1;
    static constexpr bool centred = true;
    static constexpr bool constant_moment = true;
    static constexpr Real mean_square = 11.0_rt / 20;
    static constexpr Real halfway_mean_square = 2.0_rt / 3;

    KOKKOS_INLINE_FUNCTION static int first( const int cell )
    {
        return cell - 1;
    }
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void weights( const Number& f,
                                                     Number* w )
    {
        w[0] = 0.5_rt * ( 1 - f ) * ( 1 - f );
        w[1] = 0.75_rt - ( f - 0.5_rt ) * ( f - 0.5_rt );
        w[2] = 0.5_rt * f * f;
    }
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void gradients( const Number& f,
                                                       Number* g )
    {
        g[0] = f - 1;
        g[1] = 1 - 2 * f;
        g[2] = f;
    }
    //! Derivatives (times h) of the weights halfway between nodes.
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void halfwayGradients( const Number&,
                                                              Number* g )
    {
        g[0] = -1;
        g[1] = 1;
    }
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static Number offset( const Number& f,
                                                      const int k )
    {
        return k - 0.5_rt - f;
    }
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static Number moment( const Number& )
    {
        return 0.25_rt;
    }
    //! @}
};

//! Cubic B-splines, nodes at cell vertices.
struct Cubic
{
    //! \name The members of Linear, of another degree
    //! @{
    static constexpr const char* name = "cubic";
    static constexpr int nodes = 4;
    static constexpr int halo = 1;
    static constexpr bool centred = false;
    static constexpr bool constant_moment = true;
    static constexpr Real mean_square = 151.0_rt / 315;
    static constexpr Real halfway_mean_square = 11.0_rt / 20;

    KOKKOS_INLINE_FUNCTION static int first( const int cell )
    {
        return cell - 1;
    }
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void weights( const Number& f,
                                                     Number* w )
    {
        const Number r = 1 - f;
        w[0] = r * r * r / 6;
        w[1] = ( ( 3 * f - 6 ) * f * f + 4 ) / 6;
        w[2] = ( ( 3 * r - 6 ) * r * r + 4 ) / 6;
        w[3] = f * f * f / 6;
    }
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void gradients( const Number& f,
                                                       Number* g )
    {
        const Number r = 1 - f;
        g[0] = -0.5_rt * r * r;
        g[1] = ( 1.5_rt * f - 2 ) * f;
        g[2] = -( 1.5_rt * r - 2 ) * r;
        g[3] = 0.5_rt * f * f;
    }
    //! Derivatives (times h) of the weights halfway between nodes.
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static void halfwayGradients( const Number& f,
                                                              Number* g )
    {
        g[0] = f - 1;
        g[1] = 1 - 2 * f;
        g[2] = f;
    }
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static Number offset( const Number& f,
                                                      const int k )
    {
        return k - 1 - f;
    }
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION static Number moment( const Number& )
    {
        return 1.0_rt / 3.0_rt;
    }
    //! @}
};

//! Layout of the nodes of a basis on all cells of a grid.
template <class Basis, int Dim>
NodeLayout<Dim> nodeLayout( const Grid<Dim>& grid )
{
    return NodeLayout<Dim>( grid, Basis::centred, Basis::halo );
}

/*!
  \brief The nodes that a particle sees, with their one-dimensional weights.

  The weight of node (k_0, k_1, ...) is the product of w[d][k_d]. A place up to
  NodeLayout::reach cells outside the box sees nodes of the halo.
  \tparam Number Real for one particle, Lanes for a pack
*/
template <class Basis, int Dim, class Number = Real>
struct Stencil
{
    Bases<Number> base{};         //!< row of the first node
    Number w[Dim][Basis::nodes];  //!< weights
    Number dw[Dim][Basis::nodes]; //!< derivatives, 1/length
    Number dx[Dim][Basis::nodes]; //!< node minus particle, length
    Number fraction[Dim];         //!< place of the particle in its cell, 0 to 1

    //! \param x position [Dim], length; beyond the cells from which particles
    //! scatter the last one's splines go on
    KOKKOS_FORCEINLINE_FUNCTION Stencil( const Grid<Dim>& grid,
                                         const NodeLayout<Dim>& layout,
                                         const VectorOf<Dim, Number>& x )
    {
        for ( int d = 0; d < Dim; ++d )
        {
            const Real h = grid.spacing[d];
            const Number place = ( x[d] - grid.lower[d] ) * grid.inverse[d];
            const Number c = clip( Number( Kokkos::floor( place ) ),
                                   Number( layout.first_cell[d] ),
                                   Number( layout.last_cell[d] ) );
            const Number f = place - c;
            fraction[d] = f;
            Basis::weights( f, w[d] );
            Basis::gradients( f, dw[d] );
            for ( int k = 0; k < Basis::nodes; ++k )
            {
                dw[d][k] *= grid.inverse[d];
                dx[d][k] = Basis::offset( f, k ) * h;
            }
            const Real shift = Basis::first( 0 ) - layout.first_node[d];
            advance( base, c + shift, layout.stride[d] );
        }
    }

    //! sum_i w_i (x_i - x_p)_d^2, length^2.
    KOKKOS_FORCEINLINE_FUNCTION Number moment( const int d, const Real h ) const
    {
        return Basis::moment( fraction[d] ) * ( h * h );
    }
};

//! Slope along an axis, from its fit by fitWeight: divided by the moment, but
//! for hats. \param fit sum of fitWeight times a value \param inverse 1/h
template <class Basis, class Number>
KOKKOS_FORCEINLINE_FUNCTION Number slopeOfFit( const Number& fit,
                                               const Real inverse )
{
    if constexpr ( Basis::constant_moment )
        return fit * ( 1 / Basis::moment( 0.0_rt ) * ( inverse * inverse ) );
    else
        return fit;
}

//! sum w (x_i - x)_b^2 at a place, length^2; it varies for hats alone.
//! \param x place along axis b, length
template <class Basis, int Dim, class Number>
KOKKOS_INLINE_FUNCTION Number momentAt( const Grid<Dim>& grid, const Number& x,
                                        const int b )
{
    const Real h = grid.spacing[b];
    const Number place = ( x - grid.lower[b] ) * grid.inverse[b];
    return Basis::moment( Number( place - Kokkos::floor( place ) ) ) *
           ( h * h );
}

/*!
  \brief Factor on the slope of an affine field that moves to another place.

  Its energy moment * slope^2 / 2 must not grow, or cold gas would pay for it;
  what it loses becomes heat. 1 but for hats.
*/
template <class Basis, class Number>
KOKKOS_INLINE_FUNCTION Number slopeFactor( const Number& moment_before,
                                           const Number& moment_after )
{
    if constexpr ( Basis::constant_moment )
        return Number( 1.0 );
    else
        return choose( moment_before < moment_after,
                       Number( Kokkos::sqrt( moment_before / moment_after ) ),
                       Number( 1.0 ) );
}

//! The moment of a basis as a number: kernels that know no more of a basis are
//! compiled once for all of them.
struct AffineMoment
{
    Real constant = 0;   //!< over h^2
    bool varies = false; //!< is it that of hats instead?

    template <class Basis>
    static AffineMoment of()
    {
        if ( Basis::constant_moment )
            return { Basis::moment( 0.0_rt ), false };
        return { 0.0_rt, true };
    }
    //! As momentAt.
    template <int Dim>
    KOKKOS_INLINE_FUNCTION Real operator()( const Grid<Dim>& grid, const Real x,
                                            const int b ) const
    {
        return varies ? momentAt<Linear, Dim>( grid, x, b )
                      : constant * ( grid.spacing[b] * grid.spacing[b] );
    }
    //! As Machpoint::slopeFactor.
    KOKKOS_INLINE_FUNCTION Real slopeFactor( const Real before,
                                             const Real after ) const
    {
        return varies ? Machpoint::slopeFactor<Linear>( before, after )
                      : 1.0_rt;
    }

    //! Carries the slopes of a particle along axis b from one place on it to
    //! another: what their energy loses becomes heat.
    //! \param affine, e slices of C and of the energy per mass \param p row
    //! \param from, to length
    template <int Dim, class Affine, class Energy>
    KOKKOS_INLINE_FUNCTION void
    carry( const Grid<Dim>& grid, const Affine& affine, const Energy& e,
           const int p, const int b, const Real from, const Real to ) const
    {
        const Real moment = ( *this )( grid, from, b );
        const Real moment_new = ( *this )( grid, to, b );
        const Real factor = slopeFactor( moment, moment_new );
        for ( int a = 0; a < Dim; ++a )
        {
            const Real slope = affine( p, a, b );
            const Real kept = asDeviation( slope * factor );
            store( affine, kept, p, a, b );
            e( p ) +=
                0.5_rt * ( slope * slope * moment - kept * kept * moment_new );
        }
    }
};

//! One node of a stencil, as seen by the particle.
template <int Dim, class Number = Real>
struct StencilNode
{
    NodeRow<Number> row;            //!< row in a NodeView
    Number weight;                  //!< w_ip
    VectorOf<Dim, Number> gradient; //!< grad w_ip, 1/length
    VectorOf<Dim, Number> dx;       //!< x_i - x_p, length
};

//! Calls visit(StencilNode) for every node of a stencil, x fastest.
template <class Basis, int Dim, class Number, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void
forEachNode( const Stencil<Basis, Dim, Number>& s,
             const NodeLayout<Dim>& layout, const Visitor& visit )
{
    constexpr int n = Basis::nodes;
    constexpr int ny = Dim > 1 ? n : 1;
    constexpr int nz = Dim > 2 ? n : 1;
    MACHPOINT_KEEP_LOOP
    for ( int k = 0; k < nz; ++k )
    {
        MACHPOINT_UNROLL
        for ( int j = 0; j < ny; ++j )
        {
            StencilNode<Dim, Number> node;
            Number wyz( 1.0 );
            int row = 0;
            if constexpr ( Dim > 1 )
            {
                wyz = s.w[1][j];
                row += j * layout.stride[1];
                node.dx[1] = s.dx[1][j];
            }
            if constexpr ( Dim > 2 )
            {
                wyz *= pick( s.w[2], k );
                row += k * layout.stride[2];
                node.dx[2] = pick( s.dx[2], k );
            }
            MACHPOINT_UNROLL
            for ( int i = 0; i < n; ++i )
            {
                node.row = rowAt( s.base, row + i );
                node.weight = s.w[0][i] * wyz;
                node.dx[0] = s.dx[0][i];
                node.gradient[0] = s.dw[0][i] * wyz;
                if constexpr ( Dim == 2 )
                    node.gradient[1] = s.w[0][i] * s.dw[1][j];
                if constexpr ( Dim == 3 )
                {
                    node.gradient[1] =
                        s.w[0][i] * s.dw[1][j] * pick( s.w[2], k );
                    node.gradient[2] =
                        s.w[0][i] * s.w[1][j] * pick( s.dw[2], k );
                }
                visit( node );
            }
        }
    }
}

/*!
  \brief A line of a stencil's nodes along the first axis. What depends on the
  other axes alone is the same on all of it, so that sums over nodes are sums
  along lines first.
*/
template <int Dim, class Number = Real>
struct StencilLine
{
    int shift;     //!< rows from the stencil's first node to the line's
    Number weight; //!< product of the weights along the other axes
    //! \name The same product with another factor along axis b > 0; for b = 0,
    //! where sums along the line have that factor, the product as it is
    //! @{
    VectorOf<Dim, Number> gradient; //!< dw, 1/length
    VectorOf<Dim, Number> fit;      //!< fitWeight
    //! @}
    VectorOf<Dim, Number> dx; //!< x_i - x_p along b > 0, length
};

//! What node k along axis d counts in the fit of a slope, before division by
//! the moment: w (x_i - x_p), length; for hats, whose moment may vanish, their
//! derivative, 1/length, not to be divided.
template <class Basis, int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION Number
fitWeight( const Stencil<Basis, Dim, Number>& s, const int d, const int k )
{
    if constexpr ( Basis::constant_moment )
        return pick( s.w[d], k ) * pick( s.dx[d], k );
    else
        return pick( s.dw[d], k );
}

//! Calls visit(StencilLine) for every line of a stencil. \tparam WrittenOut are
//! the lines of a plane to be written out on a CPU, too?
template <bool WrittenOut, class Basis, int Dim, class Number, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void
forEachLine( const Stencil<Basis, Dim, Number>& s,
             const NodeLayout<Dim>& layout, const Visitor& visit )
{
    constexpr int n = Basis::nodes;
    constexpr int ny = Dim > 1 ? n : 1;
    const auto visitLine = [&]( const int j, const int k ) MACHPOINT_INLINE
    {
        StencilLine<Dim, Number> line{ 0, Number( 1.0 ), {}, {}, {} };
        if constexpr ( Dim == 2 )
        {
            line.shift = j * layout.stride[1];
            line.weight = s.w[1][j];
            line.gradient[1] = s.dw[1][j];
            line.fit[1] = fitWeight( s, 1, j );
            line.dx[1] = s.dx[1][j];
        }
        if constexpr ( Dim == 3 )
        {
            const Number wz = pick( s.w[2], k );
            line.shift = j * layout.stride[1] + k * layout.stride[2];
            line.weight = s.w[1][j] * wz;
            line.gradient[1] = s.dw[1][j] * wz;
            line.gradient[2] = s.w[1][j] * pick( s.dw[2], k );
            line.fit[1] = fitWeight( s, 1, j ) * wz;
            line.fit[2] = s.w[1][j] * fitWeight( s, 2, k );
            line.dx[1] = s.dx[1][j];
            line.dx[2] = pick( s.dx[2], k );
        }
        line.gradient[0] = line.weight;
        line.fit[0] = line.weight;
        visit( line );
    };
    MACHPOINT_KEEP_LOOP
    for ( int k = 0; k < ( Dim > 2 ? n : 1 ); ++k )
    {
        if constexpr ( WrittenOut || !runs_on_host )
        {
            MACHPOINT_UNROLL_LINES
            for ( int j = 0; j < ny; ++j )
                visitLine( j, k );
        }
        else
        {
            MACHPOINT_KEEP_LINES
            for ( int j = 0; j < ny; ++j )
                visitLine( j, k );
        }
    }
}

/*!
  \brief Weights of the places halfway between nodes: B-splines of one degree
  less, whose differences are the gradients of the node weights,
  h dw_k = c_{k-1} - c_k.
*/
template <class Basis, int Dim, class Number = Real>
struct HalfwayWeights
{
    static constexpr int places = Basis::nodes - 1; //!< along one axis
    Number c[Dim][places];                          //!< weights
    Number dc[Dim][places];                         //!< derivatives times h

    //! \param s whose derivatives are summed up to them
    KOKKOS_FORCEINLINE_FUNCTION
    HalfwayWeights( const Grid<Dim>& grid,
                    const Stencil<Basis, Dim, Number>& s )
    {
        for ( int d = 0; d < Dim; ++d )
        {
            Number sum( 0.0 );
            for ( int k = 0; k < places; ++k )
            {
                sum -= s.dw[d][k] * grid.spacing[d];
                c[d][k] = sum;
            }
            Basis::halfwayGradients( s.fraction[d], dc[d] );
        }
    }
};

//! One face of a stencil, as seen by the particle.
template <class Number = Real>
struct StencilFace
{
    int axis; //!< it lies between the node of its row and the next along it
    NodeRow<Number> row; //!< row in a NodeView
    Number weight;       //!< w^axis_f
    Number slope;        //!< h dw/dx along the axis
};

//! One cell of a stencil: the place halfway to the next node along every axis.
template <int Dim, class Number = Real>
struct StencilCell
{
    NodeRow<Number> row;      //!< row in a NodeView
    Number weight;            //!< product of halfway weights
    VectorOf<Dim, Number> dx; //!< x_c - x_p, length
};

namespace Impl
{
//! The faces between neighbours along one axis.
template <int Axis, class Basis, int Dim, class Number, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void
forEachFaceAlong( const Stencil<Basis, Dim, Number>& s,
                  const HalfwayWeights<Basis, Dim, Number>& halfway,
                  const NodeLayout<Dim>& layout, const Visitor& visit )
{
    constexpr int n = Basis::nodes;
    constexpr int places = n - 1;
    // The other axes, of which there may be none.
    constexpr int b = Axis == 0 ? 1 : 0;
    constexpr int c = Axis == 2 ? 1 : 2;
    MACHPOINT_KEEP_LINES
    for ( int k = 0; k < ( Dim > 2 ? n : 1 ); ++k )
    {
        MACHPOINT_KEEP_LINES
        for ( int j = 0; j < ( Dim > 1 ? n : 1 ); ++j )
        {
            Number across( 1.0 );
            int row = 0;
            if constexpr ( Dim > 1 )
            {
                across = s.w[b][j];
                row += j * layout.stride[b];
            }
            if constexpr ( Dim > 2 )
            {
                across *= s.w[c][k];
                row += k * layout.stride[c];
            }
            for ( int i = 0; i < places; ++i )
                visit( StencilFace<Number>{
                    Axis, rowAt( s.base, row + i * layout.stride[Axis] ),
                    across * halfway.c[Axis][i],
                    across * halfway.dc[Axis][i] } );
        }
    }
}
} // namespace Impl

//! Calls visit(StencilFace) for every face of a stencil.
template <class Basis, int Dim, class Number, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void
forEachFace( const Stencil<Basis, Dim, Number>& s,
             const HalfwayWeights<Basis, Dim, Number>& halfway,
             const NodeLayout<Dim>& layout, const Visitor& visit )
{
    Impl::forEachFaceAlong<0>( s, halfway, layout, visit );
    if constexpr ( Dim > 1 )
        Impl::forEachFaceAlong<1>( s, halfway, layout, visit );
    if constexpr ( Dim > 2 )
        Impl::forEachFaceAlong<2>( s, halfway, layout, visit );
}

//! Calls visit(StencilCell) for every cell of a stencil.
template <class Basis, int Dim, class Number, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void
forEachCell( const Grid<Dim>& grid, const Stencil<Basis, Dim, Number>& s,
             const HalfwayWeights<Basis, Dim, Number>& halfway,
             const NodeLayout<Dim>& layout, const Visitor& visit )
{
    constexpr int places = Basis::nodes - 1;
    constexpr int ny = Dim > 1 ? places : 1;
    constexpr int nz = Dim > 2 ? places : 1;
    for ( int k = 0; k < nz; ++k )
        for ( int j = 0; j < ny; ++j )
            for ( int i = 0; i < places; ++i )
            {
                const int at[3] = { i, j, k };
                StencilCell<Dim, Number> cell{ {}, Number( 1.0 ), {} };
                int row = 0;
                for ( int d = 0; d < Dim; ++d )
                {
                    row += at[d] * layout.stride[d];
                    cell.weight *= halfway.c[d][at[d]];
                    cell.dx[d] = s.dx[d][at[d]] + 0.5_rt * grid.spacing[d];
                }
                cell.row = rowAt( s.base, row );
                visit( cell );
            }
}

} // namespace Machpoint

#endif
