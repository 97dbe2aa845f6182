/*!
  \file piston.hpp
  \brief A piston that moves into the gas: a boundary from outside Machpoint.
*/
#ifndef PISTON_HPP
#define PISTON_HPP

#include <core/module.hpp>
#include <core/simulation.hpp>

#include <fmt/format.h>

/*!
  \brief A plane at position + velocity * time, normal to an axis; the gas is
  on its upper side.

  Nodes behind the face are held at the velocity of the piston along the axis;
  the other components are free, so the gas slips along it. No gas is behind:
  particles that the face overtakes are put in front of it. Reports time, the
  force of the piston on the gas, and its position, per step.
*/
template <int Dim>
class Piston : public Machpoint::Module<Dim>
{
  public:
    //! \name Names that every line below needs
    //! @{
    using Real = Machpoint::Real;
    using Range = Machpoint::Range;
    //! The same to the last digit in whatever order it is added up.
    using Sum = Machpoint::ReproducibleSum;
    //! @}

    //! \name What an input says of it
    //! See Machpoint::ModuleFactory and Machpoint::InputHooks.
    //! @{
    static constexpr const char* name = "piston";

    static Machpoint::Parameters declare( const int dimension )
    {
        Machpoint::Parameters p(
            name, "a plane that moves into the gas on its upper side",
            dimension );
        p.text( "name", "what its force and position are reported under" )
            .nonEmpty()
            .defaultsTo( "piston" );
        std::vector<std::string> axes = { "x", "y", "z" };
        axes.resize( dimension == 0 ? 3 : dimension );
        p.choice( "axis", axes, "axis along which it moves" ).defaultsTo( "x" );
        p.number( "position", "where its face starts, along the axis" )
            .unit( "length" );
        p.number( "velocity", "its constant velocity along the axis" )
            .unit( "length/time" );
        return p;
    }

    //! What a study can take for an error: the force of the piston on the gas,
    //! mass length/time^2, and where its face is, length.
    static std::vector<std::string> columns()
    {
        return { "force", "position" };
    }

    explicit Piston( const Machpoint::Json& json )
        : _axis( json.at( "axis" ).get<std::string>()[0] - 'x' ),
          _position( json.at( "position" ) ), _velocity( json.at( "velocity" ) )
    {
        _series.name = json.at( "name" );
        _series.columns = columns();
        _series.columns.insert( _series.columns.begin(), "time" );
    }
    //! @}

    //! Behind the face there is no gas.
    bool isSolid( const Machpoint::Vector<Dim>& x ) const override
    {
        return x[_axis] < _position;
    }

    /*!
      Gives the nodes behind the face its velocity u. The impulse on the gas is
      J = sum m_i (u - v_i), and what the piston spends on it is J u.

      The face is that of the start of the step for both v and v': a node that
      is held has u in both, and then `apic` gains exactly J u. In P2G it turns
      sum m w |u_p - v_i|^2 / 2 into heat, which leaves J u over; the force on
      the nodes works at (v + v') / 2 = u.

      A node stands for half a cell on either side of it, so it is held once
      the face has covered the lower half: the gas then meets the wall at the
      face on average. Without that it ran half a cell too far and piled up.
    */
    void applyToGrid( Machpoint::State<Dim>& state,
                      const Machpoint::GridVelocity& velocity ) override
    {
        const auto layout = state.layout;
        const auto weights = state.halo.weights();
        const auto moments = state.nodes.moments;
        const auto field = velocity.field;
        const int axis = _axis;
        const int column = velocity.first + axis;
        const Real u = _velocity;
        const Real held = faceAt( state.time ) + 0.5 * state.grid.spacing[axis];
        Sum impulse, work;
        Kokkos::parallel_reduce(
            "Piston::applyToGrid", Range( 0, layout.total ),
            MACHPOINT_LAMBDA( const int row, Sum& sum, Sum& work_sum ) {
                const auto i = layout.indices( row );
                if ( layout.position( layout.home( i ) )[axis] >= held )
                    return;
                const Real share = weights( i );
                if ( share > 0 )
                {
                    const double J = share * moments( row, 0 ) *
                                     velocity.takenUp( row ) *
                                     ( u - field( row, column ) );
                    sum += J;
                    work_sum += J * u;
                }
                field( row, column ) = u;
            },
            impulse, work );
        if ( !velocity.acts )
            return;
        _impulse += impulse;
        state.ledger.energy_in += work;
    }

    //! Puts particles that the face overtook just in front of it. Only their
    //! position changes, which costs no momentum, and no energy except with
    //! the linear basis, whose affine energy depends on the place in the cell.
    //! \throws Machpoint::NumericalFailure it has reached the domain's far side
    void applyToParticles( Machpoint::State<Dim>& state ) override
    {
        const int axis = _axis;
        const double time = state.time + state.dt;
        const Real face = faceAt( time );
        const Real front = face + Machpoint::nudge * state.grid.spacing[axis];
        if ( !( front < state.grid.upper[axis] ) )
            throw Machpoint::NumericalFailure( fmt::format(
                "piston \"{}\" reached the far side of the domain at t = "
                "{:.6g}; end the run earlier or widen the domain",
                _series.name, time ) );
        const auto x = state.particles.template slice<Machpoint::Position>();
        const auto noted = state.noted;
        Kokkos::parallel_for(
            "Piston::applyToParticles", Range( 0, state.particles.size() ),
            MACHPOINT_LAMBDA( const int p ) {
                if ( x( p, axis ) < face )
                {
                    x( p, axis ) = front;
                    noted.note( p ); // it may be another rank's now
                }
            } );
        const auto all = Machpoint::sumOfRanks( state.decomposition.comm(),
                                                { _impulse } )[0];
        _series.rows.push_back( { time, all.value() / state.dt, face } );
        _impulse = {};
    }

    //! A step that is repeated starts anew, and one that failed later than
    //! here takes its row back.
    void rejectStep( Machpoint::State<Dim>& state ) override
    {
        _impulse = {};
        auto& rows = _series.rows;
        if ( !rows.empty() && rows.back()[0] > state.time + 0.5 * state.dt )
            rows.pop_back();
    }

    bool exertsForce( int ) const override { return true; }
    const Machpoint::Series* series() const override { return &_series; }
    //! The impulse of a step never outlives it; the rows do.
    void checkpoint( Machpoint::Archive& archive ) override
    {
        _series.checkpoint( archive );
    }

  private:
    Real faceAt( const double time ) const
    {
        return _position + _velocity * time;
    }

    int _axis;
    Real _position;
    Real _velocity;
    Sum _impulse; // of this rank on the gas, in this step
    Machpoint::Series _series;
};

#endif
