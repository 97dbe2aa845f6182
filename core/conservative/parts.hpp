/*!
  \file parts.hpp
  \brief The parts of the method `conservative`: keys of the input's `method`,
  with their defaults. docs/conservative.md derives each of them.
*/
#ifndef MACHPOINT_CONSERVATIVE_PARTS_HPP
#define MACHPOINT_CONSERVATIVE_PARTS_HPP

#include <core/parameters.hpp>
#include <core/types.hpp>

namespace Machpoint
{

//! What of `conservative` is on, and how strong. 0 or false: off.
struct ConservativeParts
{
    bool midpoint;             //!< all at the half step, else symplectic
    Real least_filling;        //!< of a face, below which pressure thins out
    Real volume_relaxation;    //!< kd
    Real particle_shifting;    //!< ks
    bool viscosity_limiter;    //!< no viscosity where the flow is smooth
    Real blend;                //!< beta_0: 1 is APIC, 0 affine FLIP
    Real blend_in_compression; //!< kb
    bool loss_return;          //!< kinetic energy lost becomes heat
    Real pressure_relaxation;  //!< eta
    Real heat_mixing;          //!< ck
    Real heat_conduction;      //!< kc
    Real split_volume;         //!< of a particle that is halved, cells
    Real mass_floor;           //!< no half is lighter than this part
    Real merge_volume;         //!< of a pair that is merged, cells

    //! \name Steps from one to the next
    //! @{
    static constexpr int conduct_every = 10; //!< friction takes hundreds
    static constexpr int merge_every = 5;
    //! Looks at how particles are stretched: it takes them dozens to be large.
    static constexpr int track_every = 5;
    //! @}

    //! Is heat conducted at the beginning of a step? The first has no step
    //! before it.
    bool conductsHeat( const std::int64_t step ) const
    {
        return heat_conduction > 0 && step > 0 && step % conduct_every == 0;
    }

    //! Is there anything that the limiter of the viscosity multiplies?
    //! \param is_viscous does artificial viscosity act?
    bool limits( const bool is_viscous ) const
    {
        return viscosity_limiter &&
               ( is_viscous || blend_in_compression > 0 || heat_mixing > 0 );
    }

    //! Splitting and merging need to know where a particle came from.
    bool changesParticles() const
    {
        return split_volume > 0 || merge_volume > 0;
    }

    //! Default of the key `time`.
    static constexpr const char* default_time = "midpoint";
    //! Default of the input's `time.cfl`; on hats shocks ask for shorter
    //! steps. \param time the integrator \param basis its name
    static double defaultCfl( const std::string& time,
                              const std::string& basis )
    {
        if ( time != "midpoint" )
            return 0.4;
        return basis == "linear" ? 0.5 : 0.8;
    }

    //! The keys. Their defaults are those of a dimension; 0 stands for more
    //! than one.
    static Parameters declare( const int dimension )
    {
        Parameters p( "parts", "parts of the method conservative", dimension );
        const bool line = dimension == 1;
        p.number( "least_filling", "share of a face's volume that particles "
                                   "must fill for the full pressure" )
            .above( 0 )
            .atMost( 1 )
            .defaultsTo( 0.2 )
            .source( "docs/conservative.md, section 3" );
        p.number( "volume_relaxation", "kd: rate, in units of the strain, at "
                                       "which volumes return to true space" )
            .atLeast( 0 )
            .defaultsTo( line ? 0 : 1 )
            .switches( "volume relaxation", 0 )
            .source( "docs/conservative.md, section 7" );
        p.number( "particle_shifting", "ks: speed, in sound speeds, at which "
                                       "particles leave crowds" )
            .atLeast( 0 )
            .atMost( 1 )
            .defaultsTo( line ? 0 : 0.2 )
            .switches( "particle shifting", 0 )
            .source( "after Xu et al. 2009; docs/conservative.md, section 7" );
        p.boolean( "viscosity_limiter",
                   "no artificial viscosity where the flow is smooth; "
                   "limits blend_in_compression and heat_mixing, too" )
            .defaultsTo( true )
            .switches( "viscosity limiter", false )
            .source( "Christensen 1990, Balsara 1995" );
        p.number( "blend", "beta_0: share of the grid's velocity that a "
                           "particle takes; 1 is APIC, 0 affine FLIP" )
            .atLeast( 0 )
            .atMost( 1 )
            .defaultsTo( line ? 0.1 : 0.3 )
            .source( "Fei et al. 2021 (AFLIP)" );
        p.number( "blend_in_compression",
                  "kb: beta_0 grows by kb phi h |D| / c in shocks" )
            .atLeast( 0 )
            .defaultsTo( line ? 0 : 20 )
            .switches( "blend in compression", 0 )
            .source( "docs/conservative.md, section 5" );
        p.boolean( "loss_return",
                   "kinetic energy lost in the transfer becomes heat" )
            .defaultsTo( true )
            .switches( "loss return", false )
            .source( "docs/conservative.md, section 5" );
        p.number( "pressure_relaxation",
                  "eta: exchange of volume between particles of a cell" )
            .atLeast( 0 )
            .atMost( 0.5 )
            .defaultsTo( line ? 0.05 : 0 )
            .switches( "pressure relaxation", 0 )
            .source( "after Tipton 1989; docs/conservative.md, section 8" );
        p.number( "heat_mixing", "ck: exchange of heat in compression, in "
                                 "units of |D|" )
            .atLeast( 0 )
            .defaultsTo( line ? 2 : 0 )
            .switches( "heat mixing", 0 )
            .source( "after Noh 1987; docs/conservative.md, section 8" );
        p.number( "heat_conduction",
                  "kc: exchange of heat in units of what the transfer's "
                  "friction heats a particle by, relative to its own" )
            .atLeast( 0 )
            .defaultsTo( line ? 0 : 20 )
            .switches( "heat conduction", 0 )
            .source( "docs/conservative.md, section 8" );
        p.number( "split_volume", "volume above which a particle is halved" )
            .unit( "cells" )
            .atLeast( 0 )
            .defaultsTo( 0.75 )
            .switches( "splitting", 0 )
            .source( "docs/conservative.md, section 9" );
        p.number( "mass_floor", "no half is lighter than this part of the mass "
                                "that its particle started with" )
            .above( 0 )
            .atMost( 1 )
            .defaultsTo( 1.0 / 16 )
            .source( "docs/conservative.md, section 9" );
        p.number( "merge_volume", "joint volume below which two alike "
                                  "particles become one" )
            .unit( "cells" )
            .atLeast( 0 )
            .defaultsTo( line ? 0 : 0.125 )
            .switches( "merging", 0 )
            .source( "docs/conservative.md, section 9" );
        return p;
    }

    //! From the resolved `method` of an input.
    explicit ConservativeParts( const Json& method )
        : midpoint( method.at( "time" ) == "midpoint" ),
          least_filling( method.at( "least_filling" ) ),
          volume_relaxation( method.at( "volume_relaxation" ) ),
          particle_shifting( method.at( "particle_shifting" ) ),
          viscosity_limiter( method.at( "viscosity_limiter" ) ),
          blend( method.at( "blend" ) ),
          blend_in_compression( method.at( "blend_in_compression" ) ),
          loss_return( method.at( "loss_return" ) ),
          pressure_relaxation( method.at( "pressure_relaxation" ) ),
          heat_mixing( method.at( "heat_mixing" ) ),
          heat_conduction( method.at( "heat_conduction" ) ),
          split_volume( method.at( "split_volume" ) ),
          mass_floor( method.at( "mass_floor" ) ),
          merge_volume( method.at( "merge_volume" ) )
    {
    }
};

} // namespace Machpoint

#endif
