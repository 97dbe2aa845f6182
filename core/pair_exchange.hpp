/*!
  \file pair_exchange.hpp
  \brief Layer 3: heat that particles exchange in pairs, by way of the nodes
  (docs/conservative.md, section 8, and docs/diffusion.md, "Stragglers").
*/
#ifndef MACHPOINT_PAIR_EXCHANGE_HPP
#define MACHPOINT_PAIR_EXCHANGE_HPP

#include <core/lanes.hpp>

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

} // namespace Machpoint

#endif
