/*!
  \file stress.hpp
  \brief `conservative` on its way from the grid velocity to the next one: rates
  at the particles, viscosity, pressure on faces (docs/conservative.md, sections
  3 and 4). faces.hpp tells what the columns of the fields are.
*/
#ifndef MACHPOINT_CONSERVATIVE_STRESS_HPP
#define MACHPOINT_CONSERVATIVE_STRESS_HPP

#include <core/conservative/drift.hpp>
#include <core/conservative/faces.hpp>
#include <core/power.hpp>

namespace Machpoint
{
namespace Impl
{

//! What a pack sees of the grid velocity.
struct Rates
{
    Lanes divergence; //!< D, 1/time
    Lanes expansion;  //!< the same, of normalised volume, 1/time
    Lanes limiter;    //!< phi, which is 1 without a limiter
};

/*!
  \brief D, the divergence of normalised volume, and how far from smooth the
  flow is, phi = |D| / (|D| + |curl C| + 1e-4 c/h) times the mean of 1 - psi
  over the faces that compress (Balsara 1995 and Christensen 1990).
  \param faces FaceRate
  \param curl |curl C| \param sound c
*/
template <bool Limited, class Basis, int Dim>
KOKKOS_FORCEINLINE_FUNCTION Rates
gatherRates( const Grid<Dim>& grid, const NodeLayout<Dim>& layout,
             const Stencil<Basis, Dim, Lanes>& s, const NodeView& faces,
             const Lanes& curl, const Lanes& sound )
{
    const Lanes zero( 0.0 );
    Rates rates{ zero, zero, Lanes( 1.0 ) };
    Lanes compression = zero; // sum w |min(d, 0)|
    Lanes rough = zero;       // sum w (1 - psi) |min(d, 0)|
    forEachFace( s, HalfwayWeights<Basis, Dim, Lanes>( grid, s ), layout,
                 [&]( const auto& f ) MACHPOINT_INLINE
                 {
                     Lanes face[Limited ? Rough + 1 : Normalised + 1];
                     loadRow( faces, f.row, face, face_columns * f.axis );
                     rates.divergence += f.weight * face[Difference];
                     rates.expansion += f.weight * face[Normalised];
                     if constexpr ( Limited )
                     {
                         compression += f.weight * face[Closing];
                         rough += f.weight * face[Rough];
                     }
                 } );
    if constexpr ( Limited )
    {
        const Lanes speed = Kokkos::abs( rates.divergence );
        const Lanes whole =
            ( speed + curl + ( 1e-4_rt / grid.minSpacing() ) * sound ) *
            compression;
        // 0 where nothing compresses, or so little that it underflows.
        rates.limiter = choose( zero < whole && zero < sound,
                                Lanes( speed * rough / whole ), Lanes( 1.0 ) );
    }
    return rates;
}

//! How the pressure that exerts force and does work differs from the
//! particles'.
struct WorkingGas
{
    Viscosity viscosity;
    PressureResponse response;
    Real ahead;       //!< time that it is ahead of the particles' state
    Real blending;    //!< kb h
    bool keeps_rates; //!< does anybody ask for them after the stress?

    //! phi (c1 c + c2 h |D|) of compressed gas, 0 elsewhere.
    KOKKOS_FORCEINLINE_FUNCTION Lanes viscousSpeed( const Rates& rates,
                                                    const Lanes& sound,
                                                    const Real h ) const
    {
        const Lanes zero( 0.0 );
        const Lanes hD = h * rates.divergence;
        return choose( hD < zero,
                       rates.limiter * ( viscosity.linear * sound -
                                         viscosity.quadratic * hD ),
                       zero );
    }

    /*!
      \brief p + q after `ahead` of isentropic change, and q's heat:
      p + K (J^-g - 1) - gruneisen ahead q D / J + q with K = rho c^2 / g and
      J = max(.2, 1 + ahead D) of normalised volume. A pressure below vacuum is
      vacuum's, p - K. \param p, density, sound the particle's at the step's
      start
    */
    KOKKOS_FORCEINLINE_FUNCTION Lanes pressure( const Rates& rates,
                                                const Lanes& p, const Lanes& q,
                                                const Lanes& density,
                                                const Lanes& sound ) const
    {
        if ( ahead == 0 )
            return p + q;
        const Lanes J =
            Kokkos::max( 1 + ahead * rates.expansion, Lanes( 0.2 ) );
        const Lanes K = density * sound * sound * ( 1 / response.exponent );
        const Lanes advanced =
            K * power( J, -response.exponent ) -
            response.gruneisen * ahead * q * rates.divergence / J;
        return Kokkos::max( advanced, Lanes( 0.0 ) ) + ( p - K ) + q;
    }

    //! kb phi h max(-D, 0) / c, 0 without sound.
    template <class Number>
    KOKKOS_FORCEINLINE_FUNCTION Number blend( const Number& divergence,
                                              const Number& limiter,
                                              const Number& sound ) const
    {
        const Number zero( 0.0 );
        return choose( zero < sound,
                       Number( blending * limiter *
                               Kokkos::max( Number( -divergence ), zero ) /
                               sound ),
                       zero );
    }
};

//! Pressure on the faces of each axis, and the blend on nodes.
template <int Dim>
struct StressTerms
{
    static constexpr int count = Dim + 1;
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int column( const int t )
    {
        return t;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr bool isAffine( int )
    {
        return false;
    }
    KOKKOS_FORCEINLINE_FUNCTION static constexpr int axis( const int t )
    {
        return t < Dim ? t : -1;
    }
};

//! Adds particles, or one image of one, to the pressure on faces and the blend
//! on nodes. \param p a particle's row or a pack
//! \param mixed mass times blend \return what addProductsLater returns
template <class Basis, int Dim, class Number, class NodeAccess, class Particle>
KOKKOS_FORCEINLINE_FUNCTION auto
depositStress( const NodeAccess& nodes, const Grid<Dim>& grid,
               const NodeLayout<Dim>& layout,
               const Stencil<Basis, Dim, Number>& s, const Particle p,
               const Number& volume_pressure, const Number& mixed )
{
    Products<StressTerms<Dim>, Dim, Number> terms;
    for ( int a = 0; a < Dim; ++a )
        terms.value[a] = volume_pressure * ( 1 / grid.cellVolume() );
    terms.value[Dim] = mixed;
    return addProductsLater( nodes, p, s, layout,
                             FaceWeights<Basis, Dim, Number>( grid, s ).w,
                             terms );
}

/*!
  \brief sum V (p + q) w^a_f / h^Dim on faces and sum m w kb phi h max(-D, 0) /
  c on nodes, over particles and images: what particles see of the grid
  velocity, the viscosity that follows from it, the pressure and its sum in one
  pass. \tparam Limited has the viscosity a limiter? \param faces FaceRate
  \param drift of the integrator midpoint, else null
  \param sums the scatter of the stress \param[out] state.rates
*/
template <bool Limited, class Basis, int Dim, class Sums>
void depositStress( const State<Dim>& state, const NodeView& faces,
                    const WorkingGas& working,
                    Sidecar<DriftMembers<Dim>>* drift, const Sums& sums )
{
    using drift_type = typename Sidecar<DriftMembers<Dim>>::aosoa_type;
    const bool midpoint = drift != nullptr;
    typename drift_type::template member_slice_type<LastExpansion>
        last_expansion;
    if ( midpoint )
        last_expansion = Cabana::slice<LastExpansion>( drift->data() );
    const auto x = state.particles.template slice<Position>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto acting = sliceOfRates<WorkingPressure>( state );
    const auto viscous_speed = sliceOfRates<ViscousSpeed>( state );
    const auto divergence = sliceOfRates<Divergence>( state );
    const auto limiter = sliceOfRates<Limiter>( state );
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto images = state.images;
    const Real h = grid.minSpacing();
    forEachBlock<Rates, Basis>(
        "Machpoint::depositStress", state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          Rates& seen ) MACHPOINT_INLINE {
            Lanes squares( 0.0 ); // |curl C|^2
            if ( Limited )
                for ( int a = 0; a < Dim; ++a )
                    for ( int b = a + 1; b < Dim; ++b )
                    {
                        const Lanes spin =
                            load( C, p, a, b ) - load( C, p, b, a );
                        squares += spin * spin;
                    }
            seen = gatherRates<Limited>(
                grid, layout, s, faces, Kokkos::sqrt( squares ), load( c, p ) );
        },
        MACHPOINT_LAMBDA( const Pack p, const Rates& seen ) MACHPOINT_INLINE {
            const Lanes sound = load( c, p );
            const Lanes density = load( m, p ) / load( V, p );
            Lanes q( 0.0 );
            if ( working.viscosity.acts )
            {
                const Lanes speed = working.viscousSpeed( seen, sound, h );
                q = -h * density * seen.divergence * speed;
                store( viscous_speed, speed, p );
            }
            Lanes at_start = density;
            if ( midpoint )
                at_start *=
                    driftFactor( working.ahead, load( last_expansion, p ) );
            store( acting,
                   working.pressure( seen, load( pressure, p ), q, at_start,
                                     sound ),
                   p );
            if ( working.keeps_rates )
            {
                store( divergence, seen.divergence, p );
                store( limiter, seen.limiter, p );
            }
        },
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes, const Rates& seen )
            MACHPOINT_INLINE {
                return depositStress(
                    nodes, grid, layout, s, p,
                    Lanes( load( V, p ) * load( acting, p ) ),
                    Lanes( load( m, p ) * working.blend( seen.divergence,
                                                         seen.limiter,
                                                         load( c, p ) ) ) );
            } );
    if ( images.count > 0 )
        Kokkos::parallel_for(
            "Machpoint::depositImageStress", Range( 0, images.count ),
            MACHPOINT_LAMBDA( const int k ) {
                const int p = images.particle( k );
                const Stencil<Basis, Dim> s(
                    grid, layout,
                    images.mirror( k ).point( get<Dim>( x, p ) ) );
                depositStress( accessTo( sums.thread(), p, s, layout ), grid,
                               layout, s, p, V( p ) * acting( p ),
                               m( p ) * working.blend<Real>( divergence( p ),
                                                             limiter( p ),
                                                             c( p ) ) );
            } );
}

/*!
  \brief v'_i = v_i + dt f_i / m_i (Algorithm 1, line 5) with the pressure's
  force f_(i,a) += h^Dim / h_a (p^a_(i-1/2) - p^a_(i+1/2)), and the blend
  beta_i = min(1, beta_0 + kb-sum / m_i). The force telescopes, so momentum is
  exact.
  \param[out] state.nodes.velocities columns Dim to 2 Dim
*/
template <int Dim>
void applyPressure( const State<Dim>& state, const NodeRows& rows,
                    const NodeView& inverse_filling, const NodeView& stress,
                    const Real blend )
{
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const auto layout = state.layout;
    const auto inverse = state.grid.inverse;
    const Real dt = state.dt;
    const Real cell_volume = state.grid.cellVolume();
    const Real own = 1 - blend;
    rows.forEach(
        "Machpoint::applyPressure",
        MACHPOINT_LAMBDA( const int i ) MACHPOINT_INLINE {
            auto pressure = [&]( const int row, const int a ) {
                return row < 0 ? 0.0_rt
                               : stress( row, a ) * inverse_filling( row, a );
            };
            const Real m = moments( i, 0 );
            for ( int a = 0; a < Dim; ++a )
            {
                const Real force = moments( i, force_column<Dim> + a ) +
                                   cell_volume * inverse[a] *
                                       ( pressure( i - layout.stride[a], a ) -
                                         pressure( i, a ) );
                velocities( i, Dim + a ) =
                    velocities( i, a ) + ( m > 0 ? dt * force / m : 0.0_rt );
            }
            velocities( i, 2 * Dim ) =
                m > 0 ? Kokkos::max( 0.0_rt, own - stress( i, Dim ) / m ) : own;
        } );
}

} // namespace Impl
} // namespace Machpoint

#endif
