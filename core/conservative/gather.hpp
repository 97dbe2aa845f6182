/*!
  \file gather.hpp
  \brief `conservative` back to the particles (docs/conservative.md, sections
  5 to 7).
*/
#ifndef MACHPOINT_CONSERVATIVE_GATHER_HPP
#define MACHPOINT_CONSERVATIVE_GATHER_HPP

#include <core/conservative/deposit.hpp>
#include <core/conservative/drift.hpp>
#include <core/conservative/parts.hpp>

namespace Machpoint
{
namespace Impl
{

//! What particles, or one image of one, gather from the grid.
template <class Basis, int Dim, class Number>
struct Gathered
{
    // Sums relative to the old velocity: a uniform flow then has zeros to add,
    // not large numbers that cancel.
    VectorOf<Dim, Number> change{};   //!< sum w (phi - v)
    VectorOf<Dim, Number> fit[Dim]{}; //!< sum w (phi - v) (x_i - x)^T, or with
                                      //!< grad w for hats: fitWeight
    Number squares{ 0.0 };            //!< sum w (|phi - v|^2 +
                                      //!< beta (2 - beta) |v_i - u_i|^2)
    VectorOf<Dim, Number> ahead{};    //!< sum w v'_i
    Number expansion{ 0.0 };          //!< bar D: over the filling, of the
                                      //!< mean of v_i and v'_i
    Number next{ 0.0 };               //!< D_h: the same of v'
    Number filling{ 0.0 };            //!< sum over axes and faces of
                                      //!< w (theta - 1)
    VectorOf<Dim, Number> crowding{}; //!< h times the gradient of theta
    Number divergence{ 0.0 };         //!< trace of the affine fit of v'
    Number rough{ 0.0 };              //!< sum over axes and faces of
                                      //!< w (1 - psi) max(-d, 0)

    /*!
      phi_i = u_i + beta_i (v_i - u_i) + v'_i - v_i
            = v'_i - (1 - beta_i) (v_i - u_i), u_i = v + C (x_i - x).
      \tparam Rearranges are filling and crowding asked for?
      \tparam Limited is rough?
    */
    template <bool Rearranges, bool Limited>
    KOKKOS_FORCEINLINE_FUNCTION void
    gather( const Grid<Dim>& grid, const NodeLayout<Dim>& layout,
            const Stencil<Basis, Dim, Number>& s, const NodeView& velocities,
            const NodeView& faces, const VectorOf<Dim, Number>& v,
            const VectorOf<Dim, Number> ( &C )[Dim] )
    {
        VectorOf<Dim, Number> widening{}; // fit of v'_a along a
        forEachLine<false>(
            s, layout,
            [&]( const auto& line ) MACHPOINT_INLINE
            {
                auto u = v; // v + C (x_i - x), the first axis apart
                for ( int a = 0; a < Dim; ++a )
                    for ( int b = 1; b < Dim; ++b )
                        u[a] += C[a][b] * line.dx[b];
                // Sums along the line, its own weight still to come.
                VectorOf<Dim, Number> steps{}, fits{}, futures{};
                Number all_squares( 0.0 ), along( 0.0 );
                for ( int i = 0; i < Basis::nodes; ++i )
                {
                    // v, v', 1 - beta and padding
                    Number node[velocity_columns<Dim>];
                    loadRow( velocities, rowAt( s.base, line.shift + i ),
                             node );
                    const Number& own = node[2 * Dim];
                    const Number& w = s.w[0][i];
                    const Number w_fit = fitWeight( s, 0, i );
                    Number step_squared( 0.0 ), lag_squared( 0.0 );
                    for ( int a = 0; a < Dim; ++a )
                    {
                        const Number lag = // v_i - u_i
                            node[a] - u[a] - C[a][0] * s.dx[0][i];
                        const Number future = node[Dim + a] - v[a];
                        const Number step = future - own * lag;
                        steps[a] += w * step;
                        fits[a] += w_fit * step;
                        futures[a] += w * future;
                        if ( a == 0 )
                            along += w_fit * future;
                        step_squared += step * step;
                        lag_squared += lag * lag;
                    }
                    all_squares +=
                        w * ( step_squared + ( 1 - own * own ) * lag_squared );
                }
                squares += line.weight * all_squares;
                for ( int a = 0; a < Dim; ++a )
                {
                    change[a] += line.weight * steps[a];
                    ahead[a] += line.weight * futures[a];
                    widening[a] +=
                        line.fit[a] * ( a == 0 ? along : futures[a] );
                    for ( int b = 0; b < Dim; ++b )
                        fit[a][b] +=
                            line.fit[b] * ( b == 0 ? fits[a] : steps[a] );
                }
            } );
        forEachFace( s, HalfwayWeights<Basis, Dim, Number>( grid, s ), layout,
                     [&]( const auto& f ) MACHPOINT_INLINE
                     {
                         Number face[Rearranges || Limited ? face_columns
                                                           : Normalised + 1];
                         loadRow( faces, f.row, face, face_columns * f.axis );
                         expansion += f.weight * face[MeanNormalised];
                         next += f.weight * face[Normalised];
                         if constexpr ( Rearranges )
                         {
                             filling += f.weight * face[Excess];
                             crowding[f.axis] += f.slope * face[Excess];
                         }
                         if constexpr ( Limited )
                             rough += f.weight * face[Rough];
                     } );
        for ( int a = 0; a < Dim; ++a )
        {
            ahead[a] += v[a];
            divergence += slopeOfFit<Basis>( widening[a], grid.inverse[a] );
        }
    }
};

/*!
  \brief Rate at which a particle's volume returns to what space there is
  (docs/conservative.md, section 7), for kd = 1.
  \param excess r - 1: filling of space around the particle, less 1
  \param expansion bar D, 1/time
  \param gradient |C|_F, 1/time
  \param fastest c / 4h, above which a rate acts in full, 1/time
  \return relative loss of volume, 1/time
*/
template <class Number>
KOKKOS_FORCEINLINE_FUNCTION Number relaxationRate( const Number& excess,
                                                   const Number& expansion,
                                                   const Number& gradient,
                                                   const Number& fastest )
{
    const Number clipped = clip( excess, Number( -0.5 ), Number( 0.5 ) );
    auto past = [clipped]( const Real band )
    { return clipped - clip( clipped, Number( -band ), Number( band ) ); };
    auto notable = [fastest, inverse = 1 / fastest]( const Number& rate )
    {
        const Number part = rate * inverse;
        return choose( rate < fastest, Number( rate * part * part ), rate );
    };
    return notable( Kokkos::abs( expansion ) ) * past( 0.02_rt ) +
           notable( gradient ) * past( 0.12_rt );
}

//! Part of the velocity gradient that is shear or spin: min(1, |curl|^2 /
//! |C|_F^2), 0 in a plane shock, whichever way it moves, and where C is 0.
//! \param C 1/time
template <int Dim, class Number>
KOKKOS_FORCEINLINE_FUNCTION Number
shearOf( const VectorOf<Dim, Number> ( &C )[Dim] )
{
    Number curl( 0.0 ), whole( 0.0 );
    for ( int a = 0; a < Dim; ++a )
        for ( int b = 0; b < Dim; ++b )
        {
            whole += C[a][b] * C[a][b];
            if ( a < b )
            {
                const Number spin = C[a][b] - C[b][a];
                curl += spin * spin;
            }
        }
    const Number one( 1.0 ), none( 0.0 );
    return choose( none < whole, Number( Kokkos::min( curl / whole, one ) ),
                   none );
}

/*!
  \brief How far from smooth the flow is, phi = min(R, |D|) /
  (|D| + |curl C| + 1e-4 c/h), R = sum w (1 - psi) max(-d, 0)
  (Balsara 1995 and Christensen 1990); 1 without sound.
  \param divergence D, 1/time \param rough R, 1/time
  \param C the new one, 1/time
*/
template <int Dim>
KOKKOS_FORCEINLINE_FUNCTION Lanes limiterOf(
    const Lanes& divergence, const Lanes& rough,
    const VectorOf<Dim, Lanes> ( &C )[Dim], const Lanes& sound, const Real h )
{
    const Lanes zero( 0.0 );
    Lanes spin = zero; // |curl C|
    if constexpr ( Dim == 2 )
        spin = Kokkos::abs( C[0][1] - C[1][0] );
    else if constexpr ( Dim == 3 )
    {
        for ( int a = 0; a < Dim; ++a )
        {
            const int b = ( a + 1 ) % Dim;
            const Lanes part = C[a][b] - C[b][a];
            spin += part * part;
        }
        spin = Kokkos::sqrt( spin );
    }
    const Lanes speed = Kokkos::abs( divergence );
    const Lanes whole = speed + spin + ( 1e-4_rt / h ) * sound;
    return choose( zero < sound, Lanes( Kokkos::min( speed, rough ) / whole ),
                   Lanes( 1.0 ) );
}

/*!
  \brief Part of its heat that a particle exchanges by conduction before the
  next step (docs/conservative.md, section 8): min(1, kc n shear loss / e),
  where n steps lie from one to the next. A part that no sum would feel is none,
  as it could underflow, and so is that of smooth flow.
  \param strength kc n \param C 1/time \param loss heat of friction, energy/mass
  \param heat what the particle had, energy/mass
*/
template <int Dim>
KOKKOS_FORCEINLINE_FUNCTION Lanes
conductedHeat( const Real strength, const VectorOf<Dim, Lanes> ( &C )[Dim],
               const Lanes& loss, const Lanes& heat )
{
    const Lanes friction = shearOf<Dim>( C ) * loss / heat;
    return choose(
        Lanes( 2e-5 ) < friction,
        Lanes( Kokkos::min( Lanes( strength * friction ), Lanes( 1.0 ) ) ),
        Lanes( 0.0 ) );
}

/*!
  \brief G2P of `conservative`.

  v' = sum w phi, C' = sum w phi (x_i - x)^T / moment,
  e' = e - dt (p + q) V bar D / m + loss, V' = V_start + dt V bar D,
  x' = x + part dt sum w v', where all of the step (symplectic) or half of it
  (midpoint, after HalfStep) is still to go.

  loss = (2 beta - beta^2)/2 sum w |u - v_i|^2 + 1/2 sum w |phi - u'|^2 makes
  sum m (e + |v|^2/2 + moment |C|^2/2) exact.

  Where Rearranges: V' *= 1 - clip(kd dt relaxationRate, -.25, .25), and the
  velocity of motion loses ks c clip(g, -.5, .5) with g = h grad theta. Uniform
  motion knows neither. \tparam Limited has the viscosity a limiter?
  \param state whose drift, of the integrator midpoint, is read and written; its
  flow is written, and of its rates ConductedHeat where the next step asks for
  it
*/
template <class Basis, bool Rearranges, bool Limited, int Dim>
void gatherParticles( const State<Dim>& state, const NodeView& faces,
                      const ConservativeParts& parts )
{
    auto* const drift = state.drift;
    const bool midpoint = drift != nullptr;
    const auto last_expansion = sliceOf<LastExpansion>( drift );
    Written<decltype( sliceOf<ExtraVelocity>( drift ) )> next_extra;
    Written<decltype( sliceOf<LastExpansion>( drift ) )> expansion;
    Written<decltype( sliceOf<NextExpansion>( drift ) )> next_expansion;
    if ( midpoint )
    {
        next_extra = state.particles.written(
            Cabana::slice<ExtraVelocity>( drift->next() ) );
        expansion = state.particles.written(
            Cabana::slice<LastExpansion>( drift->next() ) );
        next_expansion = state.particles.written(
            Cabana::slice<NextExpansion>( drift->next() ) );
    }
    const auto next_divergence = state.particles.written(
        Cabana::slice<Divergence>( state.flow->next() ) );
    const auto next_limiter =
        state.particles.written( Cabana::slice<Limiter>( state.flow->next() ) );
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto pressure = sliceOfRates<WorkingPressure>( state );
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto next_x = state.particles.template next<Position>();
    const auto next_v = state.particles.template next<Velocity>();
    const auto next_C = state.particles.template next<VelocityGradient>();
    const auto next_V = state.particles.template next<Volume>();
    const auto next_e = state.particles.template next<SpecificInternalEnergy>();
    const auto note = watch( state, midpoint ? 0.5_rt : 1.0_rt );
    const auto velocities = state.nodes.velocities;
    const auto grid = state.grid;
    const auto layout = state.layout;
    const Real dt = state.dt;
    const Real smallest = grid.minSpacing();
    const Real returned = parts.loss_return ? 1.0_rt : 0.0_rt;
    const Real kd = parts.volume_relaxation;
    const Real ks = parts.particle_shifting;
    const auto conducted = sliceOfRates<ConductedHeat>( state );
    const bool conducts = parts.conductsHeat( state.step + 1 );
    const Real reference = state.reference_pressure;
    const Real conduction =
        parts.heat_conduction * ConservativeParts::conduct_every;
    forEachStencil<Basis>(
        "Machpoint::gatherParticles", state,
        MACHPOINT_LAMBDA(
            const Pack p,
            const Stencil<Basis, Dim, Lanes>& s ) MACHPOINT_INLINE {
            const auto old_x = loadVector<Dim>( x, p );
            const auto old_v = loadVector<Dim>( v, p );
            VectorOf<Dim, Lanes> affine[Dim];
            loadMatrix<Dim>( C, p, affine );
            Gathered<Basis, Dim, Lanes> g;
            g.template gather<Rearranges, Limited>( grid, layout, s, velocities,
                                                    faces, old_v, affine );
            const Lanes zero( 0.0 );
            const Lanes sound = load( c, p );
            const Real ahead = midpoint ? 0.5_rt * dt : dt;
            VectorOf<Dim, Lanes> new_x{}, new_v{};
            for ( int a = 0; a < Dim; ++a )
            {
                new_v[a] = old_v[a] + g.change[a];
                Lanes speed = g.ahead[a];
                if ( Rearranges )
                    speed -= ks * sound *
                             clip( g.crowding[a], Lanes( -0.5 ), Lanes( 0.5 ) );
                new_x[a] = old_x[a] + ahead * speed;
                store( next_x, new_x[a], p, a );
                store( next_v, new_v[a], p, a );
                if ( midpoint )
                    store( next_extra, speed - new_v[a], p, a );
                g.squares -= g.change[a] * g.change[a];
            }
            const auto landed = landFit<Basis, Dim>( grid, s, g.fit, new_x );
            for ( int b = 0; b < Dim; ++b )
                for ( int a = 0; a < Dim; ++a )
                    store( next_C, landed.C[a][b], p, a, b );
            const Lanes lost = Kokkos::max( g.squares - landed.fitted, zero );
            const Lanes loss =
                0.5_rt * ( returned * lost + landed.fitted - landed.carried );
            const Lanes old_e = load( e, p );
            store( next_divergence, g.divergence, p );
            store( next_limiter,
                   Limited ? limiterOf<Dim>( g.divergence, g.rough, landed.C,
                                             sound, smallest )
                           : Lanes( 1.0 ),
                   p );
            const Lanes old_V = load( V, p );
            const Lanes work =
                load( pressure, p ) * old_V / load( m, p ) * g.expansion;
            const Lanes new_e = old_e + loss - dt * work;
            store( next_e, new_e, p );
            // Volume at the start of the step.
            Lanes volume = old_V;
            if ( midpoint )
            {
                volume *= driftFactor( ahead, load( last_expansion, p ) );
                store( expansion, g.expansion, p );
                store( next_expansion, g.next, p );
            }
            if ( conducts )
                store( conducted,
                       conductedHeat<Dim>(
                           conduction, affine, loss,
                           heatOf( old_e, volume, load( m, p ), reference ) ),
                       p );
            volume =
                Kokkos::max( Lanes( volume + old_V * ( dt * g.expansion ) ),
                             Lanes( 0.2_rt * volume ) );
            if ( Rearranges )
            {
                const Lanes rate = relaxationRate(
                    Lanes( g.filling * ( 1.0_rt / Dim ) ), g.expansion,
                    Lanes( Kokkos::sqrt( landed.squared ) ),
                    Lanes( sound * ( 0.25_rt / smallest ) ) );
                Lanes change = clip( Lanes( kd * dt * rate ), Lanes( -0.25 ),
                                     Lanes( 0.25 ) );
                // e stays, of which this much is heat.
                if ( reference > 0 )
                    change *= clip( Lanes( 1 - reference * volume /
                                                   ( load( m, p ) * new_e ) ),
                                    Lanes( 0.0 ), Lanes( 1.0 ) );
                volume *= 1 - change;
            }
            store( next_V, volume, p );
            note( p, old_x, new_x, new_v, volume, new_e, load( m, p ) );
            note.lookAtVolume( p, volume );
        },
        velocities, faces );
}

/*!
  \brief What curved walls do to the gas during the step.

  Particles and images together keep momentum and energy exactly. The images
  are dropped after the step, so what they gained the gas has lost to the wall.
  \param state whose images.impulses get the momentum that each image gained,
  but for its weight
  \return energy given to the gas, this rank's part
*/
template <class Basis, int Dim>
ReproducibleSum workOfImages( const State<Dim>& state, const NodeView& faces )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto pressure = sliceOfRates<WorkingPressure>( state );
    const auto velocities = state.nodes.velocities;
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto images = state.images;
    const auto acceleration = state.image_weight.acceleration;
    const Real dt = state.dt;
    ReproducibleSum given;
    reduceEach(
        "Machpoint::workOfImages", images.count, few_stencils<Dim>,
        MACHPOINT_LAMBDA( const int k, ReproducibleSum& sum ) {
            const int p = images.particle( k );
            const auto mirror = images.mirror( k );
            const Stencil<Basis, Dim> s(
                grid, layout, mirror.point( loadVector<Dim>( x, p ) ) );
            Vector<Dim> affine[Dim];
            loadMatrix<Dim>( C, p, affine );
            mirrorAffine<Dim>( mirror, affine );
            const auto u = mirror.direction( loadVector<Dim>( v, p ) );
            const auto weight = mirror.direction( acceleration );
            Gathered<Basis, Dim, Real> g;
            g.template gather<false, false>( grid, layout, s, velocities, faces,
                                             u, affine );
            Real kinetic = g.squares; // |phi|^2 - |u_i|^2, summed
            for ( int a = 0; a < Dim; ++a )
            {
                // Its weight is not the body's.
                images.impulses( k, a ) =
                    m( p ) * ( g.change[a] - dt * weight[a] );
                kinetic += 2 * u[a] * g.change[a];
                for ( int b = 0; b < Dim; ++b )
                    kinetic -= affine[a][b] * affine[a][b] *
                               s.moment( b, grid.spacing[b] );
            }
            sum += dt * pressure( p ) * V( p ) * g.expansion -
                   0.5_rt * m( p ) * kinetic;
        },
        given );
    return given;
}

} // namespace Impl
} // namespace Machpoint

#endif
