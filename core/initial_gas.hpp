/*!
  \file initial_gas.hpp
  \brief Layer 5: the gas that the entries of `initial` make together.
*/
#ifndef MACHPOINT_INITIAL_GAS_HPP
#define MACHPOINT_INITIAL_GAS_HPP

#include <core/shape_input.hpp>
#include <physics/initial/initial_state.hpp>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace Machpoint
{

//! Later entries go on top of earlier ones. Where two regions meet, a place on
//! the seam belongs to one of them. Host only.
template <int Dim>
class InitialGas
{
  public:
    //! \param input resolved \throws InputError where there is no such gas
    explicit InitialGas( const Json& input );

    //! Of zero density where there is none. \param x position [Dim], length
    //! \param[out] gradient of the velocity, 1/time
    GasState at( const Vector<Dim>& x, Gradient& gradient ) const;

    //! Why there is no such gas, where, and what to do; empty if there is.
    //! \param gas at x
    std::string fault( const Vector<Dim>& x, const GasState& gas ) const;

  private:
    using HostShape = Shape<Dim, Kokkos::HostSpace>;
    struct Entry
    {
        std::unique_ptr<InitialState> state;
        bool is_everywhere;
        HostShape region; // otherwise
    };
    bool reaches( const Entry& entry, const Vector<Dim>& x ) const
    {
        return entry.is_everywhere || entry.region.distance( aside( x ) ) < 0;
    }
    //! A hair beside a place, by another measure along each axis.
    Vector<Dim> aside( Vector<Dim> x ) const
    {
        for ( int d = 0; d < Dim; ++d )
            x[d] += _hair / ( 1 + d );
        return x;
    }

    std::vector<Entry> _entries;
    Real _hair;
    std::optional<GasLaw> _law;
};

} // namespace Machpoint

#endif
