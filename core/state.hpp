/*!
  \file state.hpp
  \brief Layer 3: what kernels, methods and modules work on.
*/
#ifndef MACHPOINT_STATE_HPP
#define MACHPOINT_STATE_HPP

#include <core/basis.hpp>
#include <core/bodies.hpp>
#include <core/collect.hpp>
#include <core/decomposition.hpp>
#include <core/halo.hpp>
#include <core/images.hpp>
#include <core/node_sum.hpp>
#include <core/particles.hpp>
#include <core/placement.hpp>
#include <core/reproducible_sum.hpp>
#include <core/survey.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace Machpoint
{

//! What crossed the edges of the domain, so that balances can be closed; on
//! many ranks, what this rank saw of it.
struct Ledger
{
    ReproducibleSum mass_in;  //!< mass that entered
    ReproducibleSum mass_out; //!< mass that left
    //! Work done on the gas by body forces and boundaries, energy.
    ReproducibleSum energy_in;
};

//! Node data of a step.
template <int Dim>
struct Nodes
{
    NodeView moments;    //!< [nodes]: mass, momentum [Dim], and more
    NodeSum moment_sum;  //!< the sum that they are
    NodeView velocities; //!< [nodes]: v_i [Dim], v'_i [Dim], and more
};

//! What a step of a method with viscosity of its own tells the effects, one
//! entry per particle; zero for a particle that has just entered.
using RateMembers = Cabana::MemberTypes<Real, Deviation>;

//! Names of the members of the rates.
enum RateMember : std::size_t
{
    WorkingPressure, //!< p + q, of the half step where the integrator has one
    ConductedHeat    //!< from G2P to the next step: part in [0, 1] of its heat
                     //!< that the particle exchanges
};

//! What the grid's new velocity looked like where the last step left the
//! particle; zero for one that has just entered.
using FlowMembers = Cabana::MemberTypes<Deviation, Deviation>;

//! Names of the members of the flow.
enum FlowMember : std::size_t
{
    Divergence, //!< D, trace of the affine fit to v', 1/time
    Limiter     //!< phi in [0, 1]: 0 where the flow is smooth
};

//! What the integrator `midpoint` remembers of a particle's last step; zero for
//! one that has just entered. (docs/conservative.md has D, bar D and D_h.)
template <int Dim>
using DriftMembers = Cabana::MemberTypes<Deviation[Dim], Deviation, Deviation>;

//! Names of the members of the drift.
enum DriftMember : std::size_t
{
    ExtraVelocity, //!< velocity of motion less v [Dim], length/time
    LastExpansion, //!< bar D of the last step, which did its work, 1/time
    NextExpansion  //!< D_h, over the filling, of its v', 1/time
};

//! Artificial viscosity q = phi rho h |D| (c1 c + c2 h |D|) of gas that is
//! compressed (docs/conservative.md, section 4).
struct Viscosity
{
    bool acts = false;  //!< is there any?
    Real linear = 0;    //!< c1
    Real quadratic = 0; //!< c2

    //! phi (c1 c + c2 h |D|) of compressed gas, 0 elsewhere, length/time.
    //! \param divergence D, 1/time \param limiter phi \param sound c
    KOKKOS_FORCEINLINE_FUNCTION Lanes speed( const Lanes& divergence,
                                             const Lanes& limiter,
                                             const Lanes& sound,
                                             const Real h ) const
    {
        const Lanes zero( 0.0 );
        const Lanes hD = h * divergence;
        return choose( hD < zero, limiter * ( linear * sound - quadratic * hD ),
                       zero );
    }
};

/*!
  \brief How pressure answers a small change of a particle.

  Along an isentrope p(rho) - p = K / g ((rho / rho_0)^g - 1) with K = rho c^2
  = g (p + reference), and heat adds (gruneisen) times its density. One set of
  constants for all gas: where they vary, typical ones. The half step of
  `midpoint`, merging, pressure relaxation and the bound on the time step go by
  them; pressures themselves come from the formula alone.
*/
struct PressureResponse
{
    Real exponent;      //!< g > 0; gamma of an ideal or a stiffened gas
    Real gruneisen;     //!< dp / d(rho e) at constant volume
    Real reference = 0; //!< p_inf of a stiffened gas
};

//! What kernels tell of particles without naming one (State::suspicions).
enum Suspicion : int
{
    Unsound, //!< a step has left one that may not be sound
    Large    //!< one has a volume above State::large_volume
};
inline constexpr int suspicion_count = 2;

//! What weight does to mirror images (core/image_weight.hpp).
template <int Dim>
struct ImageWeight
{
    Vector<Dim> acceleration{}; //!< g of all gas, length/time^2
    bool acts = false;          //!< have bodies images, and has gas weight?
    NodeSum excess;             //!< force beyond m_i g, [nodes][Dim]
};

/*!
  \brief Everything that a time step works on.

  Modules receive it in every hook. On many ranks each has its own box of cells
  with the particles in it: sums over particles or nodes are this rank's, and
  decomposition.comm() adds them up where a module needs the whole.
*/
template <int Dim>
struct State
{
    Grid<Dim> grid; //!< the whole domain
    Decomposition<Dim> decomposition;
    NodeLayout<Dim> layout; //!< this rank's nodes
    //! Which of them are a thread's own.
    NodeSeams seams = NodeSeams::make();
    Halo<Dim> halo;           //!< of fields on them
    Particles<Dim> particles; //!< this rank's
    Nodes<Dim> nodes;
    Images<Dim> images;   //!< of the particles near curved walls, this step
    Bodies<Dim> bodies;   //!< that are solid
    ImageGaps image_gaps; //!< between and beside them
    ImageWeight<Dim> image_weight;
    //! Momentum that sides give to images of each body in this step, this
    //! rank's part [bodies * Dim]; empty without images.
    std::vector<ReproducibleSum> side_impulses;
    //! \name Null where the method knows only the gradient that a particle
    //! carries
    //! @{
    Sidecar<RateMembers>* rates = nullptr;
    Sidecar<FlowMembers>* flow = nullptr;
    //! @}
    Sidecar<DriftMembers<Dim>>* drift = nullptr; //!< null without `midpoint`
    Viscosity viscosity;                         //!< that the method adds
    GasSurvey survey;                            //!< of the last particleState
    //! Particles that the step may have moved out of this rank's box, and
    //! those that a module moves or marks besides. Before the step: scratch.
    RowList noted;
    IndexList leavers; //!< those of them that are beyond the domain
    Ledger ledger;     //!< this rank's part
    Placement placement = Placement::lattice; //!< of new particles
    int per_cell = 1;                         //!< particles per cell
    std::uint64_t seed = 1;                   //!< of all random draws
    double time = 0;                          //!< at the start of the step
    double dt = 0;              //!< of the step, before it of the last one
    double cfl = 0;             //!< Courant number
    AffineMoment affine_moment; //!< of the basis; 0 without affine energy
    //! Of the weight of gas, which the method's pressure has to balance beside
    //! walls, too.
    Parity weight_parity = Parity::force;
    int stencil_nodes = 0;     //!< that a particle sees along an axis
    bool reproducible = false; //!< sums have the same bits on any ranks
    Real least_heat = 0;       //!< energy/mass, that a step may leave
    //! p_inf of a stiffened gas, whose heat is e - p_inf / rho; else 0.
    Real reference_pressure = 0;
    //! Kernels tell of particles above it (Large), length^Dim.
    Real large_volume = Kokkos::Experimental::infinity_v<Real>;
    //! For each Suspicion: not 0 once a kernel has told of it; see Watch.
    Kokkos::View<int[suspicion_count], MemorySpace> suspicions{
        "Machpoint::suspicions" };
    std::int64_t step = 0; //!< steps done
    //! Next id of a particle that is made of another one; beyond all ids of
    //! initial states and inflows.
    std::int64_t next_id = std::int64_t( 1 ) << 60;
};

namespace Impl
{
//! A member of a sidecar; of none, a slice of no memory.
template <std::size_t Member, class Members>
auto sliceOf( Sidecar<Members>* sidecar )
{
    using aosoa_type = typename Sidecar<Members>::aosoa_type;
    typename aosoa_type::template member_slice_type<Member> slice;
    if ( sidecar )
        slice = Cabana::slice<Member>( sidecar->data() );
    return slice;
}
} // namespace Impl

//! A member of the method's rates; with a method that has none, a slice of no
//! memory.
template <std::size_t Member, int Dim>
auto sliceOfRates( const State<Dim>& state )
{
    return Impl::sliceOf<Member>( state.rates );
}

//! Likewise of the flow.
template <std::size_t Member, int Dim>
auto sliceOfFlow( const State<Dim>& state )
{
    return Impl::sliceOf<Member>( state.flow );
}

//! Likewise of the drift.
template <std::size_t Member, int Dim>
auto sliceOfDrift( const State<Dim>& state )
{
    return Impl::sliceOf<Member>( state.drift );
}

//! A field that particles add to. \param columns of it; it may have more
template <int Dim>
NodeSum makeNodeSum( const std::string& label, const State<Dim>& state,
                     const int columns )
{
    const int stored = state.reproducible ? columns : paddedColumns( columns );
    return { NodeView( label, state.layout.total, stored ),
             state.decomposition.comm(), state.reproducible, state.seams };
}

} // namespace Machpoint

#endif
