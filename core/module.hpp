/*!
  \file module.hpp
  \brief Layer 4: what an effect or a boundary is. A module is a struct with a
  name, its declared parameters, and any of the hooks below; the time loop calls
  the hooks of the modules in the scene, in the order of the input.
*/
#ifndef MACHPOINT_MODULE_HPP
#define MACHPOINT_MODULE_HPP

#include <core/archive.hpp>
#include <core/basis.hpp>
#include <core/bounds.hpp>
#include <core/collect.hpp>
#include <core/images.hpp>
#include <core/node_sum.hpp>
#include <core/parameters.hpp>
#include <core/particles.hpp>
#include <core/placement.hpp>
#include <core/reproducible_sum.hpp>
#include <core/survey.hpp>

#include <string>
#include <vector>

namespace Machpoint
{

//! What crossed the edges of the domain, so that balances can be closed; on
//! many ranks, what this rank saw of it.
struct Ledger
{
    ReproducibleSum mass_in;   //!< mass that entered
    ReproducibleSum mass_out;  //!< mass that left
    ReproducibleSum energy_in; //!< work done by body forces and boundaries
};

//! Node data of a step.
template <int Dim>
struct Nodes
{
    NodeView moments;    //!< mass, momentum [Dim], and more
    NodeSum moment_sum;  //!< the sum that they are
    NodeView velocities; //!< v_i [Dim], v'_i [Dim], and more
};

//! Artificial viscosity q = phi rho h |D| (c1 c + c2 h |D|) of gas that is
//! compressed (docs/conservative.md, section 4).
struct Viscosity
{
    bool acts = false;
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
  \brief How pressure answers a small change at one particle.

  Along an isentrope p(rho) - p = K / g ((rho / rho_0)^g - 1) with K = rho c^2
  = g (p + reference), and heat adds (gruneisen) times its density.
*/
struct PressureResponse
{
    Real exponent;      //!< g; gamma of an ideal or a stiffened gas, exactly
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
    Vector<Dim> acceleration{}; //!< g of all gas
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
    Halo<Dim> halo;
    Particles<Dim> particles;
    Nodes<Dim> nodes;
    Images<Dim> images; //!< of the particles near curved walls, this step
    ImageWeight<Dim> image_weight;
    //! \name Null where the method knows only the gradient that a particle
    //! carries
    //! @{
    Sidecar<RateMembers>* rates = nullptr;
    Sidecar<FlowMembers>* flow = nullptr;
    //! @}
    Viscosity viscosity; //!< that the method adds
    GasSurvey survey;    //!< of the last particleState
    //! Particles that the step may have moved out of this rank's box, and
    //! those that a module moves or marks besides. Before the step: scratch.
    RowList noted;
    IndexList leavers; //!< those of them that are beyond the domain
    Ledger ledger;
    Placement placement = Placement::lattice;
    int per_cell = 1;           //!< particles per cell
    std::uint64_t seed = 1;     //!< of all random draws
    double time = 0;            //!< at the start of the step
    double dt = 0;              //!< of the step, before it of the last one
    double cfl = 0;             //!< Courant number
    AffineMoment affine_moment; //!< of the basis; 0 without affine energy
    bool reproducible = false;  //!< sums have the same bits on any ranks
    Real least_energy = 0;      //!< per mass, that a step may leave
    //! Kernels tell of particles above it (Large).
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

//! A field that particles add to. \param columns of it; it may have more
template <int Dim>
NodeSum makeNodeSum( const std::string& label, const State<Dim>& state,
                     const int columns )
{
    const int stored = state.reproducible ? columns : paddedColumns( columns );
    return { NodeView( label, state.layout.total, stored ),
             state.decomposition.comm(), state.reproducible, state.seams };
}

//! A velocity on the nodes, as a boundary sees it.
struct GridVelocity
{
    NodeView field;   //!< [nodes][>= first + Dim]
    int first = 0;    //!< column of component 0
    bool acts = true; //!< a change of it is an impulse on the gas; false
                      //!< for velocities that only serve as a gradient
};

//! What one side of the domain is, where `covers` says so.
struct SideClaim
{
    int side; //!< 2 * axis + (upper ? 1 : 0)
    SideKind kind;
};

//! A time series that a module reports, one row per step, the same on all
//! ranks.
struct Series
{
    std::string name;                      //!< file name without suffix
    std::vector<std::string> columns;      //!< first is time
    std::vector<std::vector<double>> rows; //!< [steps][columns]

    //! Writes the rows, or reads them.
    void checkpoint( Archive& archive )
    {
        std::vector<double> values;
        for ( const auto& row : rows )
            values.insert( values.end(), row.begin(), row.end() );
        archive.table( "series", values, columns.size() );
        rows.clear();
        for ( auto row = values.begin(); row != values.end();
              row += static_cast<std::ptrdiff_t>( columns.size() ) )
            rows.emplace_back(
                row, row + static_cast<std::ptrdiff_t>( columns.size() ) );
    }
};

/*!
  \brief Base of all physics and boundary modules: hooks that do nothing.

  The time loop calls none that a module does not override (hooksOf).
*/
template <int Dim>
class Module
{
  public:
    virtual ~Module() = default;

    //! Allocate and list what hangs on this rank's nodes: before initialize,
    //! and again whenever state.layout has changed, because the ranks' boxes
    //! move with the gas. What must outlive that belongs on particles.
    virtual void layOut( State<Dim>& ) {}
    //! Before the first step: precompute.
    virtual void initialize( State<Dim>& ) {}
    //! Sets or adds to the pressure and sound speed of particles.
    virtual void particleState( State<Dim>& ) {}
    //! Largest stable time step for this rank's gas; infinity when there is no
    //! limit.
    virtual Real limitTimeStep( State<Dim>& )
    {
        return Kokkos::Experimental::infinity_v<Real>;
    }
    //! Appends the mirror images of particles that it calls for, where these
    //! stand now; once for each time that a sum asks for them.
    virtual void mirrorParticles( State<Dim>& ) {}
    //! How far from its particle an image may be, length.
    virtual Real imageReach( const Grid<Dim>& ) const { return 0; }
    //! What it gives to all gas in keepDeposit and gridForce, by mass on the
    //! nodes; an image is due its mirror image instead. length/time^2 [Dim]
    virtual Vector<Dim> acceleration() const { return {}; }
    //! Keeps what it needs of state.nodes.moment_sum from before the fold.
    virtual void keepDeposit( State<Dim>& ) {}
    //! Adds dt f / m of a force to v' on all stored nodes, walls and neighbours
    //! folded in.
    virtual void gridForce( State<Dim>& ) {}
    //! Constrains a velocity on all stored nodes: once v, once v', and where
    //! the method has one, a velocity that only serves as a gradient. A rank
    //! constrains its halo as the neighbour does the same nodes, which stand
    //! where NodeLayout::home says; what is beyond a wall is the wall's
    //! business. Sums take nodes with state.halo.weights(), 0 in the halo. A
    //! wall that moves with u does the work impulse . u, exactly if it holds
    //! the same nodes for v and v'; add it to the ledger.
    virtual void applyToGrid( State<Dim>&, const GridVelocity& ) {}
    //! After the new node velocities are known: account for work done.
    virtual void gridWork( State<Dim>& ) {}
    //! Sources of particle momentum or energy, after G2P; not of mass, which
    //! a repeated step would add again. \return did it change any, so that
    //! they have to be checked again?
    virtual bool particleSource( State<Dim>& ) { return false; }
    //! After particles moved: wrap, reflect, push out, or mark for removal
    //! (negative id). Those that are beyond the domain are state.leavers.
    //! Others that it moves or marks it must note in state.noted, or they stay
    //! where they are; before it marks one of them, or changes a mass, it calls
    //! state.particles.keepIdentities.
    virtual void applyToParticles( State<Dim>& ) {}
    //! Adds new particles at the end. Those marked are still there.
    virtual void inject( State<Dim>& ) {}

    //! The sides that a boundary takes.
    virtual std::vector<SideClaim> sides() const { return {}; }
    //! Does it take this place of its sides? \param x on the side [Dim]
    virtual bool covers( const Vector<Dim>& ) const { return true; }
    //! Is a point inside a solid, so that no particle starts there?
    virtual bool isSolid( const Vector<Dim>& ) const { return false; }
    //! Does gas enter or leave here, so that energy cannot balance?
    virtual bool isOpen() const { return false; }
    //! Does it act on the gas from outside, so that momentum changes?
    virtual bool exertsForce() const { return false; }
    //! Names all that this module carries from step to step and that its
    //! parameters do not tell, to write it or to read it back.
    virtual void checkpoint( Archive& ) {}
    //! The step is repeated from its start: forget what it contributed.
    virtual void rejectStep( State<Dim>& ) {}
    //! Time series to be written with the output.
    virtual const Series* series() const { return nullptr; }
};

/*!
  \brief A module that closes the gas: pressure from density and energy.

  The host functions serve initial states and boundaries.
*/
template <int Dim>
class EquationOfState : public Module<Dim>
{
  public:
    //! \param density, pressure of the gas \return energy per mass
    virtual Real specificInternalEnergy( Real density,
                                         Real pressure ) const = 0;
    //! Sets pressure and sound speed of all particles:
    //! physics/evaluate_gas.hpp does so by any formula.
    //! \param surveys does it look at them meanwhile, which takes longer?
    //! \return what it saw
    virtual GasSurvey evaluate( State<Dim>& state, bool surveys ) = 0;
    void particleState( State<Dim>& state ) final
    {
        state.survey = evaluate( state, true );
    }
    //! For integrators that need the pressure of half a step.
    virtual PressureResponse response() const = 0;
};

//! Vector from a resolved input array. \param json [Dim] numbers
template <int Dim>
Vector<Dim> toVector( const Json& json )
{
    Vector<Dim> x{};
    for ( int d = 0; d < Dim; ++d )
        x[d] = json.at( d ).get<Real>();
    return x;
}

//! Names of the sides, "x_lower" first: side 2 * axis + (upper ? 1 : 0).
inline std::vector<std::string> sideNames( const int dimension )
{
    const std::vector<std::string> all = { "x_lower", "x_upper", "y_lower",
                                           "y_upper", "z_lower", "z_upper" };
    return { all.begin(), all.begin() + 2 * ( dimension ? dimension : 3 ) };
}

//! Number of a side from its name, as validated before.
inline int sideNumber( const Json& name )
{
    const auto text = name.get<std::string>();
    return 2 * ( text[0] - 'x' ) + ( text.substr( 2 ) == "upper" ? 1 : 0 );
}

} // namespace Machpoint

#endif
