/*!
  \file stencil.hpp
  \brief Layer 2: the stencil of a particle: the nodes that it sees, with their
  weights; their lines, and the faces and cells between them.
*/
#ifndef MACHPOINT_STENCIL_HPP
#define MACHPOINT_STENCIL_HPP

#include <core/basis.hpp>
#include <core/grid.hpp>
#include <core/lane_rows.hpp>
#include <core/lanes.hpp>

namespace Machpoint
{

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

//! Weights of the face between a node and the next along each axis; none behind
//! the last node.
template <class Basis, int Dim, class Number>
struct FaceWeights
{
    //! [d][i]: of the face behind node i along axis d.
    Number w[Dim][Basis::nodes];

    //! \param s of the particle, or pack
    KOKKOS_FORCEINLINE_FUNCTION
    FaceWeights( const Grid<Dim>& grid, const Stencil<Basis, Dim, Number>& s )
    {
        const HalfwayWeights<Basis, Dim, Number> halfway( grid, s );
        for ( int d = 0; d < Dim; ++d )
        {
            for ( int i = 0; i < Basis::nodes - 1; ++i )
                w[d][i] = halfway.c[d][i];
            w[d][Basis::nodes - 1] = Number( 0.0 );
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
