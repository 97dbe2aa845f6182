/*!
  \file gather.hpp
  \brief `conservative` back to the particles (docs/conservative.md, sections
  5 to 7).
*/
#ifndef MACHPOINT_CONSERVATIVE_GATHER_HPP
#define MACHPOINT_CONSERVATIVE_GATHER_HPP

#include <core/conservative/drift.hpp>
#include <core/conservative/faces.hpp>
#include <core/conservative/parts.hpp>

namespace Machpoint
{
namespace Impl
{

//! What one particle, or one image, gathers from the grid.
template <class Basis, int Dim>
struct Gathered
{
    // Sums relative to the old velocity: a uniform flow then has zeros to add,
    // not large numbers that cancel.
    Vector<Dim> change{};   //!< sum w (phi - v)
    Vector<Dim> fit[Dim]{}; //!< sum w (phi - v) (x_i - x)^T, or with grad w for
                            //!< hats, whose moment may vanish
    Real squares = 0;       //!< sum w |phi - v|^2
    Real mixing = 0;        //!< sum w beta (2 - beta) |v_i - u|^2
    Vector<Dim> ahead{};    //!< sum w v'_i
    Real expansion = 0;     //!< D of the mean velocity, normalised volume
    Real filling = 0;       //!< sum over axes and faces of w (theta - 1)
    Vector<Dim> crowding{}; //!< h times the gradient of theta

    /*!
      phi_i = u_i + beta_i (v_i - u_i) + v'_i - v_i, u_i = v + C (x_i - x).
      \tparam Rearranges are filling and crowding asked for?
    */
    template <bool Rearranges>
    KOKKOS_FORCEINLINE_FUNCTION void
    gather( const Grid<Dim>& grid, const NodeLayout<Dim>& layout,
            const Stencil<Basis, Dim>& s, const NodeView& moments,
            const NodeView& velocities, const NodeView& faces,
            const Vector<Dim>& v, const Vector<Dim> ( &C )[Dim] )
    {
        forEachNode( s, layout,
                     [&]( const auto& i )
                     {
                         const Real beta = velocities( i.row, 2 * Dim );
                         const Real w = i.weight;
                         for ( int a = 0; a < Dim; ++a )
                         {
                             const Real v_i = velocities( i.row, a );
                             const Real kick =
                                 velocities( i.row, Dim + a ) - v_i;
                             const Real shear = dot<Dim>( C[a], i.dx ); // u - v
                             const Real lag = v_i - v[a] - shear; // v_i - u
                             const Real step = shear + beta * lag + kick;
                             change[a] += w * step;
                             squares += w * step * step;
                             mixing += w * beta * ( 2 - beta ) * lag * lag;
                             ahead[a] += w * ( v_i - v[a] + kick );
                             for ( int b = 0; b < Dim; ++b )
                                 fit[a][b] += step * ( Basis::constant_moment
                                                           ? w * i.dx[b]
                                                           : i.gradient[b] );
                         }
                     } );
        forEachFace( s, HalfwayWeights<Basis, Dim>( grid, s ), layout,
                     [&]( const auto& f )
                     {
                         expansion += f.weight * faces( f.row, f.axis ) *
                                      faces( f.row, Dim + f.axis );
                         if ( Rearranges )
                         {
                             const Real excess =
                                 moments( f.row, 1 + 2 * Dim + f.axis ) - 1;
                             filling += f.weight * excess;
                             crowding[f.axis] += f.slope * excess;
                         }
                     } );
        for ( int a = 0; a < Dim; ++a )
        {
            ahead[a] += v[a];
        }
    }
};

/*!
  \brief Rate at which a particle's volume returns to what space there is
  (docs/conservative.md, section 7), for kd = 1.
  \param excess r - 1: filling of space around the particle, less 1
  \param expansion D, 1/time
  \param gradient |C|_F, 1/time
  \param mach h |C|_F / c of the cell
  \return relative loss of volume, 1/time
*/
KOKKOS_INLINE_FUNCTION Real relaxationRate( const Real excess,
                                            const Real expansion,
                                            const Real gradient,
                                            const Real mach )
{
    const Real clipped = Kokkos::clamp( excess, -0.5, 0.5 );
    auto past = [clipped]( const Real band )
    { return clipped - Kokkos::clamp( clipped, -band, band ); };
    return Kokkos::abs( expansion ) * past( 0.02 ) +
           gradient * Kokkos::min( 16 * mach * mach, 1.0 ) * past( 0.12 );
}

/*!
  \brief G2P of `conservative`.

  v' = sum w phi, C' = sum w phi (x_i - x)^T / moment,
  e' = e - dt (p + q) V D / m + loss, V' = V_start + dt V D,
  x' = x + part dt sum w v', where all of the step (symplectic) or half of it
  (midpoint, after driftParticles) is still to go.

  loss = (2 beta - beta^2)/2 sum w |u - v_i|^2 + 1/2 sum w |phi - u'|^2 makes
  sum m (e + |v|^2/2 + moment |C|^2/2) exact.

  Where Rearranges: V' *= 1 - clip(kd dt relaxationRate, -.25, .25), and the
  velocity of motion loses ks c clip(g, -.5, .5) with g = h grad theta. Uniform
  motion knows neither.
  \param drift of the integrator midpoint, else null
  \param part of the particles
*/
template <class Basis, bool Rearranges, int Dim>
void gatherParticles( const State<Dim>& state, const NodeView& faces,
                      const ConservativeParts& parts,
                      Sidecar<DriftMembers<Dim>>* drift, const Part& part )
{
    using drift_type = typename Sidecar<DriftMembers<Dim>>::aosoa_type;
    const auto drifted = drift ? drift->data() : drift_type( "none" );
    const auto extra = Cabana::slice<ExtraVelocity>( drifted );
    const auto last_expansion = Cabana::slice<LastExpansion>( drifted );
    const auto start_volume = Cabana::slice<StartVolume>( drifted );
    const bool midpoint = drift != nullptr;
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto c = state.particles.template slice<SoundSpeed>();
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const auto grid = state.grid;
    const auto layout = state.layout;
    const Real dt = state.dt;
    const Real smallest = grid.minSpacing();
    const Real returned = parts.loss_return ? 1.0 : 0.0;
    const Real kd = parts.volume_relaxation;
    const Real ks = parts.particle_shifting;
    Kokkos::parallel_for(
        "Machpoint::gatherParticles", Range( 0, state.particles.size() ),
        KOKKOS_LAMBDA( const int p ) {
            if ( !part.contains( p ) )
                return;
            const Vector<Dim> old_x = get<Dim>( x, p );
            const Vector<Dim> old_v = get<Dim>( v, p );
            Vector<Dim> affine[Dim];
            loadAffine<Dim>( C, p, affine );
            const Stencil<Basis, Dim> s( grid, layout, old_x );
            Gathered<Basis, Dim> g;
            g.template gather<Rearranges>( grid, layout, s, moments, velocities,
                                           faces, old_v, affine );
            const Real ahead = midpoint ? 0.5 : 1.0;
            for ( int a = 0; a < Dim; ++a )
            {
                const Real new_v = old_v[a] + g.change[a];
                Real speed = g.ahead[a];
                if ( Rearranges )
                    speed -=
                        ks * c( p ) * Kokkos::clamp( g.crowding[a], -0.5, 0.5 );
                x( p, a ) = old_x[a] + ahead * dt * speed;
                v( p, a ) = new_v;
                if ( midpoint )
                    extra( p, a ) = speed - new_v;
                g.squares -= g.change[a] * g.change[a];
            }
            Real fitted = 0;   // sum w |C' (x_i - x)|^2
            Real carried = 0;  // the same where the particle will be
            Real gradient = 0; // |C'|_F^2
            for ( int b = 0; b < Dim; ++b )
            {
                const Real h = grid.spacing[b];
                const Real moment = s.moment( b, h );
                Real moment_new = moment;
                if constexpr ( !Basis::constant_moment )
                {
                    // Hats: the affine energy depends on the place in the
                    // cell; what it loses on the way becomes heat. The place
                    // is the same after a periodic shift or a reflection.
                    moment_new = momentAt<Basis, Dim>( grid, x( p, b ), b );
                }
                const Real factor = slopeFactor<Basis>( moment, moment_new );
                for ( int a = 0; a < Dim; ++a )
                {
                    const Real slope = Basis::constant_moment
                                           ? g.fit[a][b] / moment
                                           : g.fit[a][b];
                    const Real kept = slope * factor;
                    C( p, a, b ) = kept;
                    fitted += slope * slope * moment;
                    carried += kept * kept * moment_new;
                    gradient += kept * kept;
                }
            }
            const Real residual = Kokkos::max( g.squares - fitted, 0.0 );
            const Real loss =
                0.5 * ( returned * ( g.mixing + residual ) + fitted - carried );
            e( p ) += loss - dt * pressure( p ) * V( p ) / m( p ) * g.expansion;
            const Real before = midpoint ? start_volume( p ) : V( p );
            Real volume =
                before + V( p ) * Kokkos::max( dt * g.expansion, -0.8 );
            if ( midpoint )
                last_expansion( p ) = g.expansion;
            if ( Rearranges )
            {
                gradient = Kokkos::sqrt( gradient );
                const Real rate =
                    relaxationRate( g.filling / Dim, g.expansion, gradient,
                                    smallest * gradient / c( p ) );
                volume *= 1 - Kokkos::clamp( kd * dt * rate, -0.25, 0.25 );
            }
            V( p ) = volume;
        } );
}

/*!
  \brief What curved walls do to the gas during the step.

  Particles and images together keep momentum and energy exactly. The images
  are dropped after the step, so what they gained the gas has lost to the wall.
  \param[out] state.images.impulses momentum that each image gained
  \return energy given to the gas
*/
template <class Basis, int Dim>
ReproducibleSum workOfImages( const State<Dim>& state, const NodeView& faces )
{
    const auto x = state.particles.template slice<Position>();
    const auto v = state.particles.template slice<Velocity>();
    const auto C = state.particles.template slice<VelocityGradient>();
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto pressure = state.particles.template slice<Pressure>();
    const auto moments = state.nodes.moments;
    const auto velocities = state.nodes.velocities;
    const auto grid = state.grid;
    const auto layout = state.layout;
    const auto images = state.images;
    const Real dt = state.dt;
    ReproducibleSum given;
    Kokkos::parallel_reduce(
        "Machpoint::workOfImages", Range( 0, images.count ),
        KOKKOS_LAMBDA( const int k, ReproducibleSum& sum ) {
            const int p = images.particle( k );
            const auto mirror = images.mirror( k );
            const Stencil<Basis, Dim> s( grid, layout,
                                         mirror.point( get<Dim>( x, p ) ) );
            Vector<Dim> affine[Dim];
            loadAffine<Dim>( C, p, affine );
            mirrorAffine<Dim>( mirror, affine );
            const auto u = mirror.direction( get<Dim>( v, p ) );
            Gathered<Basis, Dim> g;
            g.template gather<false>( grid, layout, s, moments, velocities,
                                      faces, u, affine );
            Real kinetic = g.squares + g.mixing; // |phi|^2 - |u_i|^2, summed
            for ( int a = 0; a < Dim; ++a )
            {
                images.impulses( k, a ) = m( p ) * g.change[a];
                kinetic += 2 * u[a] * g.change[a];
                for ( int b = 0; b < Dim; ++b )
                    kinetic -= affine[a][b] * affine[a][b] *
                               s.moment( b, grid.spacing[b] );
            }
            sum += dt * pressure( p ) * V( p ) * g.expansion -
                   0.5 * m( p ) * kinetic;
        },
        given );
    return given;
}

} // namespace Impl
} // namespace Machpoint

#endif
