/*!
  \file basis.hpp
  \brief Layer 2: linear, quadratic and cubic B-splines, and the stencil of a
  particle.

  For every degree the knots lie on cell boundaries: nodes of odd degree stand
  at cell vertices, those of even degree at cell centres (docs/method.md,
  section 2). All particles of a cell share one stencil.

  Each basis gives, for a particle at the fraction f in [0, 1] of its cell:
  weights(f, w), gradients(f, g) (dw/dx times h), offset(f, k) (x_k - x_p over
  h) and moment(f) = sum_k w_k (x_k - x_p)^2 / h^2.
*/
#ifndef MACHPOINT_BASIS_HPP
#define MACHPOINT_BASIS_HPP

#include <core/grid.hpp>

namespace Machpoint
{

//! Hat functions, nodes at cell vertices (the paper's basis).
struct Linear
{
    static constexpr const char* name = "linear";
    static constexpr int nodes = 2;        //!< along one axis
    static constexpr int halo = 0;         //!< layers reached beyond the box
    static constexpr bool centred = false; //!< nodes at vertices
    static constexpr bool constant_moment = false;

    KOKKOS_INLINE_FUNCTION static int first( const int cell ) { return cell; }
    KOKKOS_INLINE_FUNCTION static void weights( const Real f, Real* w )
    {
        w[0] = 1 - f;
        w[1] = f;
    }
    KOKKOS_INLINE_FUNCTION static void gradients( const Real, Real* g )
    {
        g[0] = -1;
        g[1] = 1;
    }
    KOKKOS_INLINE_FUNCTION static Real offset( const Real f, const int k )
    {
        return k - f;
    }
    KOKKOS_INLINE_FUNCTION static Real moment( const Real f )
    {
        return f * ( 1 - f );
    }
};

//! Quadratic B-splines, nodes at cell centres.
struct Quadratic
{
    static constexpr const char* name = "quadratic";
    static constexpr int nodes = 3;
    static constexpr int halo = 1;
    static constexpr bool centred = true;
    static constexpr bool constant_moment = true;

    KOKKOS_INLINE_FUNCTION static int first( const int cell )
    {
        return cell - 1;
    }
    KOKKOS_INLINE_FUNCTION static void weights( const Real f, Real* w )
    {
        w[0] = 0.5 * ( 1 - f ) * ( 1 - f );
        w[1] = 0.75 - ( f - 0.5 ) * ( f - 0.5 );
        w[2] = 0.5 * f * f;
    }
    KOKKOS_INLINE_FUNCTION static void gradients( const Real f, Real* g )
    {
        g[0] = f - 1;
        g[1] = 1 - 2 * f;
        g[2] = f;
    }
    KOKKOS_INLINE_FUNCTION static Real offset( const Real f, const int k )
    {
        return k - 0.5 - f;
    }
    KOKKOS_INLINE_FUNCTION static constexpr Real moment( const Real )
    {
        return 0.25;
    }
};

//! Cubic B-splines, nodes at cell vertices.
struct Cubic
{
    static constexpr const char* name = "cubic";
    static constexpr int nodes = 4;
    static constexpr int halo = 1;
    static constexpr bool centred = false;
    static constexpr bool constant_moment = true;

    KOKKOS_INLINE_FUNCTION static int first( const int cell )
    {
        return cell - 1;
    }
    KOKKOS_INLINE_FUNCTION static void weights( const Real f, Real* w )
    {
        const Real r = 1 - f;
        w[0] = r * r * r / 6;
        w[1] = ( ( 3 * f - 6 ) * f * f + 4 ) / 6;
        w[2] = ( ( 3 * r - 6 ) * r * r + 4 ) / 6;
        w[3] = f * f * f / 6;
    }
    KOKKOS_INLINE_FUNCTION static void gradients( const Real f, Real* g )
    {
        const Real r = 1 - f;
        g[0] = -0.5 * r * r;
        g[1] = ( 1.5 * f - 2 ) * f;
        g[2] = -( 1.5 * r - 2 ) * r;
        g[3] = 0.5 * f * f;
    }
    KOKKOS_INLINE_FUNCTION static Real offset( const Real f, const int k )
    {
        return k - 1 - f;
    }
    KOKKOS_INLINE_FUNCTION static constexpr Real moment( const Real )
    {
        return 1.0 / 3.0;
    }
};

//! Layout of the nodes of a basis on a grid.
template <class Basis, int Dim>
NodeLayout<Dim> nodeLayout( const Grid<Dim>& grid )
{
    return NodeLayout<Dim>( grid, Basis::centred, Basis::halo );
}

/*!
  \brief The nodes that a particle sees, with their one-dimensional weights.

  The weight of node (k_0, k_1, ...) is the product of w[d][k_d].
*/
template <class Basis, int Dim>
struct Stencil
{
    int base;                   //!< row of the first node
    Real w[Dim][Basis::nodes];  //!< weights
    Real dw[Dim][Basis::nodes]; //!< derivatives, 1/length
    Real dx[Dim][Basis::nodes]; //!< node minus particle, length
    Real fraction[Dim];         //!< place of the particle in its cell, 0 to 1

    KOKKOS_INLINE_FUNCTION Stencil( const Grid<Dim>& grid,
                                    const NodeLayout<Dim>& layout,
                                    const Vector<Dim>& x )
        : base( 0 )
    {
        for ( int d = 0; d < Dim; ++d )
        {
            const Real h = grid.spacing[d];
            const int c = grid.cell( x[d], d );
            const Real f = ( x[d] - grid.lower[d] ) / h - c;
            fraction[d] = f;
            Basis::weights( f, w[d] );
            Basis::gradients( f, dw[d] );
            for ( int k = 0; k < Basis::nodes; ++k )
            {
                dw[d][k] /= h;
                dx[d][k] = Basis::offset( f, k ) * h;
            }
            base += ( Basis::first( c ) + layout.halo ) * layout.stride[d];
        }
    }

    //! sum_i w_i (x_i - x_p)_d^2, length^2.
    KOKKOS_INLINE_FUNCTION Real moment( const int d, const Real h ) const
    {
        return Basis::moment( fraction[d] ) * h * h;
    }
};

//! One node of a stencil, as seen by the particle.
template <int Dim>
struct StencilNode
{
    int row;              //!< row in a NodeView
    Real weight;          //!< w_ip
    Vector<Dim> gradient; //!< grad w_ip, 1/length
    Vector<Dim> dx;       //!< x_i - x_p, length
};

//! Calls visit(StencilNode) for every node of a stencil, x fastest.
template <class Basis, int Dim, class Visitor>
KOKKOS_FORCEINLINE_FUNCTION void forEachNode( const Stencil<Basis, Dim>& s,
                                              const NodeLayout<Dim>& layout,
                                              const Visitor& visit )
{
    constexpr int n = Basis::nodes;
    constexpr int ny = Dim > 1 ? n : 1;
    constexpr int nz = Dim > 2 ? n : 1;
    StencilNode<Dim> node;
    for ( int k = 0; k < nz; ++k )
        for ( int j = 0; j < ny; ++j )
        {
            Real wyz = 1;
            int row = s.base;
            if constexpr ( Dim > 1 )
            {
                wyz = s.w[1][j];
                row += j * layout.stride[1];
                node.dx[1] = s.dx[1][j];
            }
            if constexpr ( Dim > 2 )
            {
                wyz *= s.w[2][k];
                row += k * layout.stride[2];
                node.dx[2] = s.dx[2][k];
            }
            for ( int i = 0; i < n; ++i )
            {
                node.row = row + i;
                node.weight = s.w[0][i] * wyz;
                node.dx[0] = s.dx[0][i];
                node.gradient[0] = s.dw[0][i] * wyz;
                if constexpr ( Dim == 2 )
                    node.gradient[1] = s.w[0][i] * s.dw[1][j];
                if constexpr ( Dim == 3 )
                {
                    node.gradient[1] = s.w[0][i] * s.dw[1][j] * s.w[2][k];
                    node.gradient[2] = s.w[0][i] * s.w[1][j] * s.dw[2][k];
                }
                visit( node );
            }
        }
}

} // namespace Machpoint

#endif
