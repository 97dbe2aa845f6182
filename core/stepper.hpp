/*!
  \file stepper.hpp
  \brief Layer 5: a method on a basis, as the time loop calls it.
*/
#ifndef MACHPOINT_STEPPER_HPP
#define MACHPOINT_STEPPER_HPP

#include <core/method_defaults.hpp>
#include <core/time_loop.hpp>

namespace Machpoint
{

/*!
  \brief One scene, advanced by one method on one basis.

  \tparam Method Paper, Apic or Conservative: what differs within a step.
*/
template <int Dim, class Basis, class Method>
class Stepper : public TimeLoop<Dim>
{
  public:
    //! \param input resolved \throws InputError
    explicit Stepper( const Json& input )
        : TimeLoop<Dim>( input, scheme() ), _storage( this->state(), input )
    {
        this->setUp();
    }

  private:
    static Scheme scheme()
    {
        return { { Basis::centred, Basis::halo, Method::reach, Method::margin },
                 Basis::nodes,
                 Method::template moment_columns<Dim>,
                 Method::template velocity_columns<Dim>,
                 Method::affine,
                 Method::affine ? AffineMoment::of<Basis>() : AffineMoment{},
                 Method::positive_energy,
                 Method::template lag_column<Dim> };
    }

    void layOutFields() override { _storage.layOut( this->state() ); }
    void prepareParticles() override
    {
        Method::template prepare<Basis>( this->state(), _storage, this->gas() );
    }
    void particlesToGrid() override
    {
        Method::template particlesToGrid<Basis>(
            this->state(), _storage, this->gas(),
            [this] { this->mirrorParticles(); } );
    }
    void foldMoments() override
    {
        auto& state = this->state();
        const auto components = Method::template momentComponents<Dim>();
        const auto divide = [&]( const NodeRows& rows )
        { Method::gridVelocity( state, _storage, rows ); };
        auto& moments = state.nodes.moment_sum;
        if ( Method::needs_outer_moments )
            moments.foldAndFill( state.halo, components, divide );
        else
            moments.fold( state.halo, components, divide );
    }
    void advanceVelocities() override
    {
        Method::advanceGridVelocity( this->state(), _storage );
    }
    double stableTimeStep() const override
    {
        return Method::template stableTimeStep<Basis>( this->state(), _storage,
                                                       this->gas() );
    }
    void gridToParticles() override
    {
        Method::template gridToParticles<Basis>( this->state(), _storage,
                                                 [this]( const GridVelocity& v )
                                                 { this->constrain( v ); } );
    }
    int firstRow( const Vector<Dim>& x ) const override
    {
        const auto& state = this->state();
        return Stencil<Basis, Dim>( state.grid, state.layout, x ).base;
    }
    GridData sampleNodes() const override
    {
        return sampleGrid<Basis>( this->state() );
    }

    typename Method::template Storage<Dim> _storage;
};

} // namespace Machpoint

#endif
