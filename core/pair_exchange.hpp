/*!
  \file pair_exchange.hpp
  \brief Layer 3: heat that particles exchange in pairs, by way of the nodes
  (docs/conservative.md, section 8, and docs/diffusion.md, "Stragglers").
*/
#ifndef MACHPOINT_PAIR_EXCHANGE_HPP
#define MACHPOINT_PAIR_EXCHANGE_HPP

#include <core/transfer.hpp>

namespace Machpoint
{

/*!
  \brief What a particle gains where every pair on a node exchanges a part of
  its difference,

  sum_i w_i sum_q m_q w_iq / m_i (1 - (1 - eta_p)(1 - eta_q)) (e_q - e_p),

  with a part eta in [0, 1] of each particle and m_i = sum_q m_q w_iq. As
  1 - (1 - a)(1 - b) = a + (1 - a) b, the nodes' means of e, eta and eta e are
  all that it needs. The sum of m e stays, and an energy ends between those that
  were there.
*/
struct PairExchange
{
    Lanes e{ 0.0 };     //!< sum w of the nodes' means of e, energy/mass
    Lanes eta{ 0.0 };   //!< the same of eta
    Lanes eta_e{ 0.0 }; //!< the same of eta e, energy/mass

    //! A node's means.
    KOKKOS_FORCEINLINE_FUNCTION void add( const Lanes& weight,
                                          const Lanes& mean_e,
                                          const Lanes& mean_eta,
                                          const Lanes& mean_eta_e )
    {
        e += weight * mean_e;
        eta += weight * mean_eta;
        eta_e += weight * mean_eta_e;
    }
    //! energy/mass \param own e of the particle, energy/mass \param part its
    //! eta
    KOKKOS_FORCEINLINE_FUNCTION Lanes gained( const Lanes& own,
                                              const Lanes& part ) const
    {
        return part * ( e - own ) +
               ( Lanes( 1.0 ) - part ) * ( eta_e - eta * own );
    }
};

/*!
  \brief Adds to nodes what such an exchange needs of the particles: m and m e,
  and where Parts m eta and m eta e, too, eta their ConductedHeat. e is heat,
  e - p_inf / rho, of a stiffened gas.
  \param label of the kernel
  \param sums the scatter of a field [nodes][2], or [nodes][4] where Parts
*/
template <class Basis, bool Parts, int Dim, class Sums>
void depositShares( const char* label, const State<Dim>& state,
                    const Sums& sums )
{
    const Real reference = state.reference_pressure;
    const auto V = state.particles.template slice<Volume>();
    const auto m = state.particles.template slice<Mass>();
    const auto e = state.particles.template slice<SpecificInternalEnergy>();
    const auto share = sliceOfRates<ConductedHeat>( state );
    const auto layout = state.layout;
    forEachDeposit<Basis>(
        label, state, sums,
        MACHPOINT_LAMBDA( const Pack p, const Stencil<Basis, Dim, Lanes>& s,
                          const NodesOf<Sums>& nodes ) MACHPOINT_INLINE {
            [[maybe_unused]] const auto& eta = share;
            Products<ValueTerms<Parts ? 4 : 2>, Dim, Lanes> terms;
            terms.value[0] = load( m, p );
            terms.value[1] =
                terms.value[0] * load( e, p ) - reference * load( V, p );
            if constexpr ( Parts )
                for ( int t = 0; t < 2; ++t )
                    terms.value[2 + t] = load( eta, p ) * terms.value[t];
            return addProductsLater( nodes, p, s, layout, s.w, terms );
        } );
}

} // namespace Machpoint

#endif
