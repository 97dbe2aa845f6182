/*!
  \file sidecar.hpp
  \brief Layer 2: state of particles that one effect alone needs.
*/
#ifndef MACHPOINT_SIDECAR_HPP
#define MACHPOINT_SIDECAR_HPP

#include <core/member_rows.hpp>
#include <core/migration.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace Machpoint
{

//! A particle that another one has become a part of.
struct MergedPair
{
    int into = -1;  //!< its row; negative: none
    int from = -1;  //!< the other one's
    Real share = 0; //!< of the other one in the mass of both
};
using MergedPairs = Kokkos::View<MergedPair*, MemorySpace>;

namespace Impl
{
//! Are members of types that a checkpoint holds?
template <class... T>
constexpr bool canBeKept( const Cabana::MemberTypes<T...>* )
{
    return (
        (std::is_same_v<std::remove_all_extents_t<T>, float> ||
         std::is_same_v<std::remove_all_extents_t<T>, double> ||
         std::is_same_v<std::remove_all_extents_t<T>, std::int64_t>)&&... );
}
} // namespace Impl

//! State that one effect alone needs, one entry per particle. Removal,
//! insertion and migration carry every sidecar along, and sorting all that no
//! step renews.
class SidecarBase
{
  public:
    virtual ~SidecarBase() = default;
    //! What it is called; no other sidecar of the particles is.
    virtual const std::string& label() const = 0;
    //! Does merge do anything?
    virtual bool averages() const = 0;
    //! Makes room for n particles.
    //! \param clears are new entries zero? Else the caller writes them.
    virtual void resize( std::size_t n, bool clears ) = 0;
    //! Reorders all entries. \param scratch memory that the caller lends
    virtual void permute( const ParticleBins& bins,
                          const Scratch& scratch ) = 0;
    //! Copies entry from(k) onto entry to(k) for k < count.
    virtual void move( const IndexList& from, const IndexList& to,
                       int count ) = 0;
    //! Particles have become one: see WhenMerged.
    virtual void merge( const MergedPairs& pairs ) = 0;
    //! Zeros those of some rows. \param rows less than 0: none
    virtual void forget( const IndexList& rows ) = 0;
    //! \name A step, as in Particles, if one changes the entries
    //! @{
    virtual void beginStep( bool keeps ) = 0;
    virtual void endStep() = 0;
    //! \param n number of particles before the step
    virtual void restore( std::size_t n ) = 0;
    virtual void save() = 0;
    //! @}
#ifdef MACHPOINT_ENABLE_MPI
    //! \name On the way to another rank, as in Migration
    //! @{
    virtual int words() const = 0;
    virtual void pack( Migration& migration, const IndexList& rows ) const = 0;
    virtual void unpack( Migration& migration, int first ) const = 0;
    //! @}
#endif
    //! Writes all entries, or reads n. \throws ArchiveError
    virtual void checkpoint( Archive& archive, std::size_t n ) = 0;
    //! Bytes held.
    virtual std::size_t bytes() const = 0;
};

//! What a step does to a sidecar.
enum class DuringStep
{
    //! A module changes data() where it is, in particleSource: a step that is
    //! repeated begins with a copy.
    edits,
    //! G2P writes all of next() anew; a step that is repeated needs the old
    //! values.
    changes,
    stays, //!< nothing
    renews //!< it makes all anew before it reads it; a sort, which follows the
           //!< limits of dt, leaves it out
};

//! What becomes of an entry where particles merge. (A half has the entry of the
//! particle that it is a half of, so an entry is best a number per mass.)
enum class WhenMerged
{
    averages, //!< real numbers: the mean by mass; others stay
    stays     //!< it is that of the particle that is left
};

//! A sidecar with the given members (Cabana::MemberTypes).
template <class Members>
class Sidecar : public SidecarBase
{
    static_assert( Impl::canBeKept( static_cast<Members*>( nullptr ) ),
                   "members of a sidecar are float, double or std::int64_t" );

  public:
    //! Its memory.
    using aosoa_type = ParticleArray<Members>;

    //! \param label what the memory is called in a profile
    //! \param n particles, whose entries are zero
    //! \param names of the members in a checkpoint; null: numbers below label
    Sidecar( const std::string& label, const std::size_t n,
             const DuringStep during_step, const WhenMerged when_merged,
             const char* const* names )
        : _label( label ), _during_step( during_step ),
          _when_merged( when_merged ), _names( names ), _aosoa( label ),
          _spare( label )
    {
        resize( n, true );
    }
    const std::string& label() const override { return _label; }
    void resize( const std::size_t n, const bool clears ) override
    {
        const int old = static_cast<int>( _aosoa.size() );
        Impl::resizeWithSlack( _aosoa, n );
        auto aosoa = _aosoa;
        const int more = static_cast<int>( n ) - old;
        if ( clears && more > 0 )
            forEach(
                "Machpoint::clearSidecar", more,
                MACHPOINT_LAMBDA( const int k ) {
                    aosoa.setTuple( old + k,
                                    typename aosoa_type::tuple_type{} );
                },
                few_particles );
    }
    void permute( const ParticleBins& bins, const Scratch& scratch ) override
    {
        if ( _during_step != DuringStep::renews )
            Impl::permute( bins, _aosoa, scratch );
    }
    void move( const IndexList& from, const IndexList& to,
               const int count ) override
    {
        Impl::moveTuples( _aosoa, from, to, count );
    }
    bool averages() const override
    {
        return _when_merged == WhenMerged::averages &&
               _during_step != DuringStep::renews;
    }
    void merge( const MergedPairs& pairs ) override
    {
        if ( averages() )
            average( pairs, std::make_index_sequence<Members::size>{} );
    }
    void forget( const IndexList& rows ) override
    {
        const auto aosoa = _aosoa;
        forEach(
            "Machpoint::clearSidecar", rows.extent_int( 0 ),
            MACHPOINT_LAMBDA( const int k ) {
                if ( rows( k ) >= 0 )
                    aosoa.setTuple( rows( k ),
                                    typename aosoa_type::tuple_type{} );
            } );
    }
    void beginStep( const bool keeps ) override
    {
        _keeps = keeps && _during_step == DuringStep::changes;
        if ( _keeps )
            Impl::resizeWithSlack( _spare, _aosoa.size() );
        if ( keeps && _during_step == DuringStep::edits )
            Impl::copyParticles( _spare, _aosoa );
    }
    void endStep() override
    {
        if ( _keeps )
            std::swap( _aosoa, _spare );
        _keeps = false;
    }
    void restore( const std::size_t n ) override
    {
        if ( _during_step == DuringStep::edits )
            std::swap( _aosoa, _spare );
        else if ( _during_step != DuringStep::changes )
            resize( n, true );
        else if ( !_keeps ) // the step has ended
            std::swap( _aosoa, _spare );
        _keeps = false;
    }
    void save() override
    {
        if ( _during_step == DuringStep::changes ||
             _during_step == DuringStep::edits )
            Impl::copyParticles( _spare, _aosoa );
    }
#ifdef MACHPOINT_ENABLE_MPI
    int words() const override
    {
        return words_of<aosoa_type>;
    }
    void pack( Migration& migration, const IndexList& rows ) const override
    {
        migration.pack( _aosoa, rows );
    }
    void unpack( Migration& migration, const int first ) const override
    {
        migration.unpack( _aosoa, first );
    }
#endif
    void checkpoint( Archive& archive, const std::size_t n ) override
    {
        std::optional<Archive::Group> group;
        if ( !_names )
            group.emplace( archive, _label );
        Impl::checkpointMembers( archive, _names, _aosoa );
        if ( _aosoa.size() != n )
            throw ArchiveError( _label + " has another length" );
    }
    std::size_t bytes() const override
    {
        return ( _aosoa.numSoA() + _spare.numSoA() ) *
               sizeof( typename aosoa_type::soa_type );
    }
    //! The data, for slices.
    aosoa_type& data()
    {
        return _aosoa;
    }
    //! Where a step writes all members anew.
    aosoa_type& next()
    {
        return _keeps ? _spare : _aosoa;
    }

    //! The mean by mass of the real members. (Public for nvcc.)
    template <std::size_t... M>
    void average( const MergedPairs& pairs, std::index_sequence<M...> )
    {
        ( averageMember<M>( pairs ), ... );
    }
    template <std::size_t M>
    void averageMember( const MergedPairs& pairs )
    {
        using Type = typename Cabana::MemberTypeAtIndex<M, Members>::type;
        using Value = std::remove_all_extents_t<Type>;
        if constexpr ( std::is_floating_point_v<Value> )
        {
            const auto slice = Cabana::slice<M>( _aosoa );
            constexpr int components = sizeof( Type ) / sizeof( Value );
            forEach(
                "Machpoint::averageSidecar", pairs.extent_int( 0 ),
                MACHPOINT_LAMBDA( const int k ) {
                    const auto [into, from, share] = pairs( k );
                    if ( into < 0 )
                        return;
                    for ( int c = 0; c < components; ++c )
                    {
                        auto& own = Impl::component<Type>( slice, into, c );
                        own +=
                            share *
                            ( Impl::component<Type>( slice, from, c ) - own );
                    }
                } );
        }
    }

  private:
    std::string _label;
    DuringStep _during_step;
    WhenMerged _when_merged;
    const char* const* _names;
    bool _keeps = false;
    aosoa_type _aosoa;
    aosoa_type _spare; // the other state
};

} // namespace Machpoint

#endif
