/*!
  \file method_conservative.hpp
  \brief `conservative`: affine transfer on a staggered pressure that is
  normalised by the volume which the particles deposit. docs/conservative.md
  has the equations and the evidence.
*/
#ifndef MACHPOINT_METHOD_CONSERVATIVE_HPP
#define MACHPOINT_METHOD_CONSERVATIVE_HPP

#include <core/conservative/body_sides.hpp>
#include <core/conservative/conduction.hpp>
#include <core/conservative/deposit.hpp>
#include <core/conservative/drift.hpp>
#include <core/conservative/faces.hpp>
#include <core/conservative/gather.hpp>
#include <core/conservative/merging.hpp>
#include <core/conservative/mixing.hpp>
#include <core/conservative/open_sides.hpp>
#include <core/conservative/parts.hpp>
#include <core/conservative/pressure.hpp>
#include <core/conservative/splitting.hpp>
#include <core/conservative/stability.hpp>
#include <core/image_weight.hpp>
#include <core/method_defaults.hpp>
#include <core/profile.hpp>

#include <algorithm>

namespace Machpoint
{

//! The `conservative` method: what differs between methods within a step.
struct Conservative : MethodDefaults
{
    //! \name What method_defaults.hpp asks of every method
    //! @{
    static constexpr const char* name = "conservative";
    static constexpr const char* summary =
        "volume-normalised staggered pressure; mass, momentum and total energy "
        "exact";
    static constexpr const char* default_basis = "quadratic";
    static constexpr bool affine = true;
    //! @}
    //! Half a step of motion leads up to a cell beyond the box, and so may
    //! images lie.
    static constexpr int reach = 1;
    //! A new velocity takes the faces on both sides of its node, the limiter
    //! of the viscosity the new velocities next to a face.
    static constexpr int margin = 2;
    //! The face ahead of a rank's first node is in a row of its halo.
    static constexpr bool needs_outer_moments = true;

    //! mass, momentum [Dim], theta [Dim], pressure [Dim], blend
    template <int Dim>
    static constexpr int moment_columns = 2 + 3 * Dim;
    //! v [Dim], v' [Dim], 1 - beta, and perhaps some that pad them
    template <int Dim>
    static constexpr int velocity_columns = Impl::velocity_columns<Dim>;
    //! Behind v and v'.
    template <int Dim>
    static constexpr int lag_column = 2 * Dim;

    //! What moment_columns lists.
    template <int Dim>
    static auto momentComponents()
    {
        return Impl::conservativeMoments<Dim>();
    }

    //! v, v', 1 - beta
    template <int Dim>
    static auto velocityComponents()
    {
        NodeComponents<2 * Dim + 1> list{};
        for ( int c = 0; c < 2 * Dim; ++c )
            list[c] = { Parity::velocity, c % Dim };
        return list;
    }

    //! Fields on faces, scratch, and what the parts remember of particles.
    template <int Dim>
    struct Storage
    {
        ConservativeParts parts;         //!< which are on
        NodeView faces;                  //!< [nodes][4 Dim], see FaceMotion
        Impl::OpenFaces<Dim> open_faces; //!< on open sides
        Impl::BodySides<Dim> body_sides; //!< on sides within bodies
        //! Null where particles are neither halved nor merged.
        Sidecar<HistoryMembers<Dim>>* history = nullptr;
        Impl::HalfCellMarks marks; //!< scratch of merging
        Reused<std::int64_t> new_ids{ "Machpoint::newIds" }; //!< of splitting
        NodeSum heat;  //!< scratch of the exchanges of heat and volume
        NodeSum means; //!< scratch of pressure relaxation

        //! Gives the particles the sidecars that the parts need, and lays out.
        //! \param input resolved
        Storage( State<Dim>& state, const Json& input )
            : parts( input.at( "method" ) )
        {
            state.weight_parity = Parity::gradient; // of pressures on faces
            state.rates = &state.particles.template addSidecar<RateMembers>(
                "Machpoint::rates", DuringStep::renews );
            state.flow = &state.particles.template addSidecar<FlowMembers>(
                "Machpoint::flow", DuringStep::changes, WhenMerged::stays );
            if ( parts.midpoint )
            {
                const Profile::Effect effect( "midpoint" );
                state.drift =
                    &state.particles.template addSidecar<DriftMembers<Dim>>(
                        "Machpoint::drift", DuringStep::changes,
                        WhenMerged::stays );
            }
            if ( parts.changesParticles() )
            {
                const Profile::Effect effect(
                    parts.split_volume > 0 ? "splitting" : "merging" );
                history =
                    &state.particles.template addSidecar<HistoryMembers<Dim>>(
                        "Machpoint::history", DuringStep::stays,
                        WhenMerged::stays );
            }
            if ( parts.split_volume > 0 )
            {
                state.large_volume = Impl::largeVolume( state, parts );
                // Not known of the first particles, nor of a restart's.
                Kokkos::deep_copy( suspicionOf( state, Large ), 1 );
            }
            layOut( state );
        }

        //! Allocates the node fields, and finds the faces on sides.
        void layOut( const State<Dim>& state )
        {
            const int total = state.layout.total;
            faces =
                NodeView( "Machpoint::faces", total, Impl::face_columns * Dim );
            open_faces = Impl::findOpenFaces( state );
            body_sides = Impl::findBodySides( state );
            const int columns =
                parts.heat_conduction > 0                                ? 4
                : parts.pressure_relaxation > 0 || parts.heat_mixing > 0 ? 2
                                                                         : 0;
            if ( columns > 0 )
                heat = makeNodeSum( "Machpoint::exchange", state, columns );
            if ( parts.merge_volume > 0 )
            {
                const Profile::Effect effect( "merging" );
                marks = Impl::HalfCellMarks(
                    Kokkos::view_alloc( "Machpoint::halfCellMarks" ),
                    state.layout.box.totalCells() << Dim );
            }
            if ( parts.pressure_relaxation > 0 )
            {
                const Profile::Effect effect( "pressure relaxation" );
                means = makeNodeSum( "Machpoint::means", state, 2 );
            }
        }
    };

    //! Sections 8 and 9: what rearranges volume, heat and particles.
    template <class Basis, int Dim>
    static void prepare( State<Dim>& state, Storage<Dim>& storage,
                         EquationOfState<Dim>& gas )
    {
        const auto& parts = storage.parts;
        if ( parts.pressure_relaxation > 0 )
        {
            const Profile::Effect effect( "pressure relaxation" );
            gas.evaluate( state, false );
            Impl::relaxPressure<Basis, Dim>( state, gas.response(),
                                             storage.means, storage.heat,
                                             parts.pressure_relaxation );
        }
        if ( parts.heat_mixing > 0 && state.step > 0 )
        {
            const Profile::Effect effect( "heat mixing" );
            Impl::mixHeat<Basis, Dim>( state, parts.heat_mixing, storage.heat );
        }
        if ( parts.conductsHeat( state.step ) )
        {
            const Profile::Effect effect( "heat conduction" );
            Impl::conductHeat<Basis, Dim>( state, storage.heat );
        }
        if ( parts.merge_volume > 0 && state.step % parts.merge_every == 0 )
        {
            const Profile::Effect effect( "merging" );
            Impl::mergeParticles( state, gas.response(), *storage.history,
                                  storage.marks, parts );
        }
        // Last: until the end of the step a half may stand beyond its rank's
        // box.
        if ( parts.split_volume > 0 )
        {
            const Profile::Effect effect( "splitting" );
            Impl::trackStretch( state, *storage.history, parts );
            Impl::splitParticles( state, *storage.history, storage.new_ids,
                                  parts );
        }
    }

    //! Sections 1 to 4: half a step of motion for the integrator midpoint, and
    //! mass, momentum, volume, and the pressure on faces.
    template <class Basis, int Dim, class MakeImages>
    static void particlesToGrid( State<Dim>& state, Storage<Dim>& storage,
                                 const EquationOfState<Dim>& gas,
                                 const MakeImages& make_images )
    {
        const auto& parts = storage.parts;
        const Impl::WorkingGas working{
            state.viscosity, gas.response(),
            parts.midpoint ? 0.5_rt * static_cast<Real>( state.dt ) : 0.0_rt,
            state.grid.minSpacing(), parts.blend_in_compression };
        const Impl::HalfStep<Basis, Dim> half_step( state );
        half_step.reach( state );
        state.nodes.moment_sum.deposit(
            [&]( const auto& sums )
            {
                Impl::depositParticles<Basis>( state, working, half_step,
                                               sums );
                make_images(); // of particles where they stand now
                Impl::depositImages<Basis>( state, working, sums );
            } );
        depositImageWeight<Basis>( state );
    }

    //! Section 10.
    template <class Basis, int Dim>
    static double stableTimeStep( const State<Dim>& state,
                                  const Storage<Dim>& storage,
                                  const EquationOfState<Dim>& gas )
    {
        return Impl::stableTimeStep<Basis>( state, gas.response(),
                                            storage.parts.least_filling );
    }

    //! Section 5: velocity and blend.
    template <int Dim>
    static void gridVelocity( const State<Dim>& state,
                              const Storage<Dim>& storage,
                              const NodeRows& rows )
    {
        Impl::velocityAndBlend( state, rows, storage.parts.blend );
    }

    //! Section 3: force of the pressure, and new velocity.
    template <int Dim>
    static void advanceGridVelocity( const State<Dim>& state,
                                     Storage<Dim>& storage )
    {
        const auto& parts = storage.parts;
        Impl::fillOpenSides( state, storage.open_faces, parts.least_filling );
        Impl::applyPressure( state, parts.least_filling );
        NodeComponents<2 * Dim> new_velocity{};
        for ( int d = 0; d < Dim; ++d )
            new_velocity[Dim + d] = { Parity::velocity, d };
        state.halo.restOnWalls( state.nodes.velocities, new_velocity );
    }

    //! Sections 5 to 7.
    template <class Basis, int Dim, class Constrain>
    static void gridToParticles( State<Dim>& state, Storage<Dim>& storage,
                                 const Constrain& )
    {
        const auto& parts = storage.parts;
        state.halo.fillSides( state.nodes.velocities,
                              velocityComponents<Dim>() );
        const bool rearranges =
            parts.volume_relaxation > 0 || parts.particle_shifting > 0;
        const bool limits = parts.limits( state.viscosity.acts );
        if ( limits )
        {
            // Measures the motion in passing, which goes on its account.
            const Profile::Effect effect( "viscosity limiter" );
            Impl::measureMotion<true>( state, storage.faces,
                                       parts.least_filling );
        }
        else
            Impl::measureMotion<false>( state, storage.faces,
                                        parts.least_filling );
        if ( rearranges )
        {
            Impl::creditGaps( state, storage.faces );
            Impl::levelOpenSides( state, storage.open_faces, storage.faces );
        }
        state.halo.fillSides( storage.faces, Impl::allFaceComponents<Dim>() );
        if ( state.bodies.have_images )
            Impl::findSideImpulses( state, storage.body_sides,
                                    parts.least_filling );
        // Images read what their particles were.
        if ( state.images.count > 0 )
            state.ledger.energy_in +=
                Impl::workOfImages<Basis>( state, storage.faces );
        if ( rearranges && limits )
            gather<Basis, true, true>( state, storage );
        else if ( rearranges )
            gather<Basis, true, false>( state, storage );
        else if ( limits )
            gather<Basis, false, true>( state, storage );
        else
            gather<Basis, false, false>( state, storage );
    }

  private:
    template <class Basis, bool Rearranges, bool Limited, int Dim>
    static void gather( const State<Dim>& state, const Storage<Dim>& storage )
    {
        Impl::gatherParticles<Basis, Rearranges, Limited>( state, storage.faces,
                                                           storage.parts );
    }
};

} // namespace Machpoint

#endif
