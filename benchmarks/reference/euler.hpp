/*!
  \file euler.hpp
  \brief The Euler equations of an ideal gas as a finite-volume scheme sees
  them: states, slopes, and the flux between two states.
*/
#ifndef MACHPOINT_REFERENCE_EULER_HPP
#define MACHPOINT_REFERENCE_EULER_HPP

#include <core/exact.hpp>
#include <core/types.hpp>

namespace Machpoint::Reference
{

//! One number per equation [Dim + 2]. Primitive: density, velocity [Dim],
//! pressure. Conserved: density, momentum [Dim] and total energy per volume.
template <int Dim>
using Values = Kokkos::Array<Real, Dim + 2>;

//! Row of a field. \param field View [rows][>= first + Dim + 2]
template <int Dim, class Field>
KOKKOS_INLINE_FUNCTION Values<Dim> load( const Field& field, const int row,
                                         const int first = 0 )
{
    Values<Dim> q;
    for ( int k = 0; k < Dim + 2; ++k )
        q[k] = field( row, first + k );
    return q;
}

//! Sets a row of a field. \param field View [rows][>= first + Dim + 2]
template <int Dim, class Field>
KOKKOS_INLINE_FUNCTION void store( const Field& field, const int row,
                                   const Values<Dim>& q, const int first = 0 )
{
    for ( int k = 0; k < Dim + 2; ++k )
        field( row, first + k ) = q[k];
}

//! Primitive values of a gas state.
template <int Dim>
Values<Dim> primitive( const GasState& gas )
{
    Values<Dim> w;
    w[0] = gas.density;
    for ( int d = 0; d < Dim; ++d )
        w[1 + d] = gas.velocity[d];
    w[Dim + 1] = gas.pressure;
    return w;
}

//! Conserved from primitive values (Toro 2009, section 1.1).
template <int Dim>
KOKKOS_INLINE_FUNCTION Values<Dim> conserved( const Values<Dim>& w,
                                              const Real gamma )
{
    Values<Dim> u;
    Real square = 0;
    u[0] = w[0];
    for ( int d = 0; d < Dim; ++d )
    {
        u[1 + d] = w[0] * w[1 + d];
        square += w[1 + d] * w[1 + d];
    }
    u[Dim + 1] = w[Dim + 1] / ( gamma - 1 ) + 0.5 * w[0] * square;
    return u;
}

/*!
  \brief Primitive from conserved values, with a floor under both.

  Density is at least 1e-14 and pressure at least 1e-16, in the units of the
  scene; the conserved values stay as they are, so that nothing is created.
*/
template <int Dim>
KOKKOS_INLINE_FUNCTION Values<Dim> primitive( const Values<Dim>& u,
                                              const Real gamma )
{
    Values<Dim> w;
    Real square = 0;
    w[0] = Kokkos::max( u[0], 1e-14_rt );
    for ( int d = 0; d < Dim; ++d )
    {
        w[1 + d] = u[1 + d] / w[0];
        square += w[1 + d] * w[1 + d];
    }
    w[Dim + 1] = Kokkos::max(
        ( gamma - 1 ) * ( u[Dim + 1] - 0.5_rt * w[0] * square ), 1e-16_rt );
    return w;
}

//! Sound speed of primitive values (Toro 2009, section 1.2).
template <int Dim>
KOKKOS_INLINE_FUNCTION Real soundSpeed( const Values<Dim>& w, const Real gamma )
{
    return Kokkos::sqrt( gamma * w[Dim + 1] / w[0] );
}

//! Half of a cell's limited difference (van Leer 1974, the harmonic mean):
//! w +- halfSlope never leaves the range of the neighbours, so that positive
//! cells have positive faces.
KOKKOS_INLINE_FUNCTION Real halfSlope( const Real before, const Real after )
{
    return before * after > 0 ? before * after / ( before + after ) : 0.0;
}

//! Values of a cell extrapolated to its face. \param sign -1 for the lower
//! face, +1 for the upper \param before, cell, after primitive, in a line
template <int Dim>
KOKKOS_INLINE_FUNCTION Values<Dim>
faceValues( const Values<Dim>& before, const Values<Dim>& cell,
            const Values<Dim>& after, const Real sign )
{
    Values<Dim> w;
    for ( int k = 0; k < Dim + 2; ++k )
        w[k] = cell[k] +
               sign * halfSlope( cell[k] - before[k], after[k] - cell[k] );
    return w;
}

//! Flux of the conserved values along an axis (Toro 2009, section 1.1).
//! \param w, U primitive and conserved values of one state
template <int Dim>
KOKKOS_INLINE_FUNCTION Values<Dim>
eulerFlux( const Values<Dim>& w, const Values<Dim>& U, const int axis )
{
    const Real u = w[1 + axis];
    const Real p = w[Dim + 1];
    Values<Dim> F;
    for ( int k = 0; k < Dim + 2; ++k )
        F[k] = U[k] * u;
    F[1 + axis] += p;
    F[Dim + 1] += p * u;
    return F;
}

/*!
  \brief HLLC flux through a face (Toro, Spruce and Speares 1994; Toro 2009,
  section 10.4), or HLL's (Harten, Lax and van Leer 1983), with the wave-speed
  bounds of Einfeldt et al. 1991: the outer of each side's own and the Roe
  average's acoustic speed (Toro 2009, section 10.5).
  \param l, r primitive values on the lower and the upper side of the face
  \param axis normal of the face
  \param with_contact HLLC; without the contact between the two waves it is HLL
  \return flux of the conserved values along the axis
*/
template <int Dim>
KOKKOS_INLINE_FUNCTION Values<Dim>
hllFlux( const Values<Dim>& l, const Values<Dim>& r, const int axis,
         const Real gamma, const bool with_contact )
{
    const auto U_l = conserved<Dim>( l, gamma );
    const auto U_r = conserved<Dim>( r, gamma );
    const Real u_l = l[1 + axis], p_l = l[Dim + 1];
    const Real u_r = r[1 + axis], p_r = r[Dim + 1];

    // Roe averages of velocity and enthalpy.
    const Real a =
        Kokkos::sqrt( l[0] ) / ( Kokkos::sqrt( l[0] ) + Kokkos::sqrt( r[0] ) );
    const Real enthalpy = a * ( U_l[Dim + 1] + p_l ) / l[0] +
                          ( 1 - a ) * ( U_r[Dim + 1] + p_r ) / r[0];
    Real square = 0;
    for ( int d = 0; d < Dim; ++d )
    {
        const Real u = a * l[1 + d] + ( 1 - a ) * r[1 + d];
        square += u * u;
    }
    const Real u_roe = a * u_l + ( 1 - a ) * u_r;
    const Real c_roe = Kokkos::sqrt(
        Kokkos::max( ( gamma - 1 ) * ( enthalpy - 0.5_rt * square ), 0.0_rt ) );
    const Real S_l =
        Kokkos::min( u_l - soundSpeed<Dim>( l, gamma ), u_roe - c_roe );
    const Real S_r =
        Kokkos::max( u_r + soundSpeed<Dim>( r, gamma ), u_roe + c_roe );
    if ( S_l >= 0 )
        return eulerFlux<Dim>( l, U_l, axis );
    if ( S_r <= 0 )
        return eulerFlux<Dim>( r, U_r, axis );

    Values<Dim> F;
    if ( !with_contact )
    {
        const auto F_l = eulerFlux<Dim>( l, U_l, axis );
        const auto F_r = eulerFlux<Dim>( r, U_r, axis );
        for ( int k = 0; k < Dim + 2; ++k )
            F[k] = ( S_r * F_l[k] - S_l * F_r[k] +
                     S_l * S_r * ( U_r[k] - U_l[k] ) ) /
                   ( S_r - S_l );
        return F;
    }
    // Mass fluxes into the wave pattern from both sides, one of each sign.
    const Real m_l = l[0] * ( S_l - u_l );
    const Real m_r = r[0] * ( S_r - u_r );
    const Real S_star = ( p_r - p_l + m_l * u_l - m_r * u_r ) / ( m_l - m_r );
    const bool left = S_star >= 0;
    const auto& w = left ? l : r;
    const auto& U = left ? U_l : U_r;
    const Real S = left ? S_l : S_r;
    const Real u = w[1 + axis];
    // The star state beside the contact: F* = F + S (U* - U).
    const Real density = w[0] * ( S - u ) / ( S - S_star );
    const Real energy =
        U[Dim + 1] / w[0] +
        ( S_star - u ) * ( S_star + w[Dim + 1] / ( w[0] * ( S - u ) ) );
    F = eulerFlux<Dim>( w, U, axis );
    F[0] += S * ( density - U[0] );
    for ( int d = 0; d < Dim; ++d )
        F[1 + d] +=
            S * ( density * ( d == axis ? S_star : w[1 + d] ) - U[1 + d] );
    F[Dim + 1] += S * ( density * energy - U[Dim + 1] );
    return F;
}

} // namespace Machpoint::Reference

#endif
