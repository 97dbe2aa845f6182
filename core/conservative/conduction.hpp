/*!
  \file conduction.hpp
  \brief Part of `conservative` that leads off the heat of friction
  (docs/conservative.md, section 8).
*/
#ifndef MACHPOINT_CONSERVATIVE_CONDUCTION_HPP
#define MACHPOINT_CONSERVATIVE_CONDUCTION_HPP

#include <core/pair_exchange.hpp>
#include <core/soundness.hpp>

namespace Machpoint
{
namespace Impl
{

//! Has any particle of any rank felt friction? Collective.
template <int Dim>
bool findFriction( State<Dim>& state )
{
    const auto share = sliceOfRates<ConductedHeat>( state );
    const int n = state.particles.size();
    RowList& found = state.noted;
    found.clear( n );
    forEachPack(
        "Machpoint::findFriction", n,
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            if ( any( active( p ) && Lanes( 0.0 ) < load( share, p ) ) )
                found.note( p.first );
        } );
    return state.decomposition.comm().sum( std::int64_t( found.count() ) ) > 0;
}

/*!
  \brief Conduction of heat: a pair of particles exchanges it where either has
  felt friction (PairExchange), eta their ConductedHeat. Without friction it
  looks, no more. e is heat, e - p_inf / rho, of a stiffened gas.
  \param heat [nodes][>= 4] scratch
*/
template <class Basis, int Dim>
void conductHeat( State<Dim>& state, NodeSum& heat )
{
    const Real reference = state.reference_pressure;
    if ( !findFriction( state ) )
        return;
    const auto m = state.particles.template slice<Mass>();
    const auto V = state.particles.template slice<Volume>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto share = sliceOfRates<ConductedHeat>( state );
    const auto layout = state.layout;
    const auto means = heat.field();

    heat.deposit(
        [&]( const auto& nodes ) {
            depositShares<Basis, true>( "Machpoint::nodeHeat", state, nodes );
        } );
    heat.foldAndFill( state.halo, NodeComponents<4>{} );
    divideByFirst<4>( "Machpoint::meanHeat", means );
    forEachStencil<Basis>(
        "Machpoint::conductHeat", state,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s )
            MACHPOINT_INLINE {
                const Lanes energy = load( e, p );
                const Lanes own =
                    heatOf( energy, load( V, p ), load( m, p ), reference );
                const Lanes part = load( share, p );
                PairExchange pairs;
                forEachNode( s, layout,
                             [&]( const auto& i ) MACHPOINT_INLINE
                             {
                                 Lanes mean[4]; // m, e, eta, eta e
                                 loadRow( means, i.row, mean );
                                 pairs.add( i.weight, mean[1], mean[2],
                                            mean[3] );
                             } );
                store( e, energy + pairs.gained( own, part ), p );
            },
        means );
}

} // namespace Impl
} // namespace Machpoint

#endif
