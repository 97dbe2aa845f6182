/*!
  \file basis.hpp
  \brief Layer 2: linear, quadratic and cubic B-splines, and the moments of
  affine fields on them.

  For every degree the knots lie on cell boundaries: nodes of odd degree stand
  at cell vertices, those of even degree at cell centres (docs/method.md,
  section 2). All particles of a cell share one stencil (core/stencil.hpp).

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

} // namespace Machpoint

#endif
