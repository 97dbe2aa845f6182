/*!
  \file particles.hpp
  \brief Layer 2: the particles of one material, in AoSoAs, with the sidecars
  that effects keep for their own state.
*/
#ifndef MACHPOINT_PARTICLES_HPP
#define MACHPOINT_PARTICLES_HPP

#include <core/communicator.hpp>
#include <core/kept_identities.hpp>
#include <core/lane_members.hpp>
#include <core/particle_members.hpp>
#include <core/sidecar.hpp>
#include <core/traffic.hpp>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace Machpoint
{

//! Particles and their copies that take more are not in the cache any more
//! when the next kernel reads them (docs/performance_tried.md).
inline constexpr Real cached_bytes = 64 << 20;

//! The particles of one material.
template <int Dim>
class Particles
{
  public:
    //! Memory of the advanced members.
    using aosoa_type = ParticleArray<AdvancedMembers<Dim>>;

    //! None yet.
    Particles()
        : _aosoa( "Machpoint::particles" ), _other( "Machpoint::otherState" ),
          _lasting( addSidecar<LastingMembers>(
              "Machpoint::lastingMembers", DuringStep::stays, WhenMerged::stays,
              member_names + Mass ) )
    {
    }

    //! Number of particles.
    int size() const { return static_cast<int>( _aosoa.size() ); }

    //! Changes the number of particles; existing ones keep their data.
    //! \param clears are sidecars of new ones zero? Else the caller writes
    //! them. \throws std::length_error beyond most_particles
    void resize( const std::size_t n, const bool clears = true )
    {
        Impl::resizeWithSlack( _aosoa, n );
        for ( auto& sidecar : _sidecars )
            sidecar->resize( n, clears );
    }

    //! A member of every particle, e.g. slice<Mass>(); within a step the value
    //! that the step has come to, where it has been `reached`.
    template <std::size_t M>
    auto slice() const
    {
        return sliceOf<M>( isAdvanced( M ) && _reached[M] ? _other : _aosoa,
                           _lasting.data() );
    }

    /*!
      \name A step
      Between beginStep and endStep kernels read the old state from slice<M>()
      and write the new one to next<M>(), so that the old one is there to return
      to. Every advanced member has to be written; the others have one value.
      @{
    */
    //! \param keeps false: the step overwrites the old state
    void beginStep( const bool keeps )
    {
        _keeps = keeps;
        _returns = false;
        _kept.clear();
        if ( keeps )
            Impl::resizeWithSlack( _other, _aosoa.size() );
        for ( auto& sidecar : _sidecars )
            sidecar->beginStep( keeps );
        _streams = keeps && static_cast<Real>( bytes() ) > cached_bytes;
    }
    //! A member of the new state.
    template <std::size_t M>
    auto next() const
    {
        static_assert( isAdvanced( M ) );
        return written( Cabana::slice<M>( _keeps ? _other : _aosoa ) );
    }
    //! From here on slice<M>() is the new one's.
    template <std::size_t... M>
    void reached()
    {
        ( ( _reached[M] = _keeps ), ... );
    }
    //! All is new; the old state is `old()`.
    void endStep()
    {
        if ( _keeps )
            std::swap( _aosoa, _other );
        for ( auto& sidecar : _sidecars )
            sidecar->endStep();
        _reached = {};
        _returns = _keeps;
        _keeps = false;
    }
    //! A slice of a new state, of these or of a sidecar.
    template <class Slice>
    Written<Slice> written( const Slice& slice ) const
    {
        return { slice, _streams };
    }
    //! Are values written to another place than they are read from?
    bool keeps() const { return _keeps; }
    //! The state before the step.
    const aosoa_type& old() const { return _other; }
    //! Keeps for `restore` the mass and id of some particles (pressure is made
    //! anew), which have one value. To be called ahead of what changes a mass
    //! or marks an id; rows that move are kept as they do.
    void keepIdentities( const IndexList& rows )
    {
        if ( _returns )
            _kept.keep( rows, slice<Mass>(), slice<Id>() );
    }
    //! Returns to the state before the step that has ended last, or before the
    //! one that has begun. \throws std::logic_error there is none: it was not
    //! kept, is returned to already, or particles have been sorted since
    void restore()
    {
        if ( !_keeps && !_returns )
            throw std::logic_error(
                "there is no state to return to: begin a step that keeps it, "
                "or save it, and sort no particles in between" );
        if ( !_keeps )
            std::swap( _aosoa, _other );
        _keeps = false;
        _returns = false;
        _reached = {};
        for ( auto& sidecar : _sidecars )
            sidecar->restore( _aosoa.size() );
        _kept.giveBack( slice<Mass>(), slice<Id>(), size() );
    }
    //! Makes this the state to return to until a step begins.
    void save()
    {
        Impl::copyParticles( _other, _aosoa );
        for ( auto& sidecar : _sidecars )
            sidecar->save();
        _returns = true;
        _kept.clear();
    }
    //! @}

    //! Copies all particles to the host.
    HostParticles<Dim> toHost() const
    {
        HostParticles<Dim> host;
        host.resize( size() );
        Cabana::deep_copy( host.advanced, _aosoa );
        Cabana::deep_copy( host.lasting, _lasting.data() );
        return host;
    }
    //! Copies one particle to the host.
    HostParticles<Dim> toHost( const int p ) const
    {
        HostParticles<Dim> host;
        host.resize( 1 );
        Cabana::deep_copy( host.advanced, Impl::singleTuple( _aosoa, p ) );
        Cabana::deep_copy( host.lasting,
                           Impl::singleTuple( _lasting.data(), p ) );
        return host;
    }
    //! Copies a member of all particles to the host. \return [n][components],
    //! row by row
    template <std::size_t M>
    auto copyMember() const
    {
        if constexpr ( isAdvanced( M ) )
            return Impl::copyMember<M>( _aosoa );
        else
            return Impl::copyMember<M - Mass>( _lasting.data() );
    }
    //! Takes all particles from the host, in place of those there are.
    void fromHost( const HostParticles<Dim>& host )
    {
        resize( host.size() );
        put( 0, host );
    }
    //! Overwrites particles from row `first` on, which are there already.
    void put( const std::size_t first, const HostParticles<Dim>& host )
    {
        Impl::putTuples( _aosoa, first, host.advanced );
        Impl::putTuples( _lasting.data(), first, host.lasting );
    }

    //! Creates a sidecar that lives as long as the particles; see Sidecar.
    //! \throws std::logic_error there is one of that label
    template <class Members>
    Sidecar<Members>&
    addSidecar( const std::string& label, const DuringStep during_step,
                const WhenMerged when_merged = WhenMerged::averages,
                const char* const* names = nullptr )
    {
        for ( const auto& other : _sidecars )
            if ( other->label() == label )
                throw std::logic_error(
                    "two sidecars are called " + label +
                    ": a checkpoint could not tell them apart, so give each a "
                    "label of its own" );
        auto sidecar = std::make_unique<Sidecar<Members>>(
            label, size(), during_step, when_merged, names );
        auto& reference = *sidecar;
        _sidecars.push_back( std::move( sidecar ) );
        return reference;
    }

    //! Does merge do anything?
    bool averageOnMerging() const
    {
        return std::any_of( _sidecars.begin(), _sidecars.end(),
                            []( const auto& sidecar )
                            { return sidecar->averages(); } );
    }
    //! Particles have become one: what sidecars make of it (WhenMerged).
    void merge( const MergedPairs& pairs )
    {
        for ( auto& sidecar : _sidecars )
            sidecar->merge( pairs );
    }

    //! Reorders particles and sidecars, through the memory of the old state
    //! where steps keep one. There is no state to return to then.
    void permute( const ParticleBins& bins )
    {
        const auto bytes = []( const aosoa_type& aosoa )
        { return aosoa.numSoA() * sizeof( typename aosoa_type::soa_type ); };
        Kokkos::View<char*, MemorySpace> column;
        Scratch scratch{};
        if ( _other.capacity() > 0 )
        {
            Impl::permute( bins, _aosoa, _other );
            scratch = { _other.data(), bytes( _other ) };
        }
        else
        {
            const std::size_t room = size() * Scratch::least_bytes;
            Kokkos::realloc( Kokkos::WithoutInitializing, column, room );
            scratch = { column.data(), room };
            Impl::permute( bins, _aosoa, scratch );
        }
        for ( auto& sidecar : _sidecars )
            sidecar->permute( bins, scratch );
        _returns = false;
    }

    //! Appends copies of particles, sidecars included. \param rows [n]
    void duplicate( const IndexList& rows )
    {
        const int first = size();
        const int count = static_cast<int>( rows.extent( 0 ) );
        resize( _aosoa.size() + rows.extent( 0 ), false );
        const auto copies = Impl::rowsFrom( _sequence, first, count );
        Impl::moveTuples( _aosoa, rows, copies, count );
        for ( auto& sidecar : _sidecars )
            sidecar->move( rows, copies, count );
    }

    //! Particles enter anew: effects know nothing of their former life.
    //! \param rows less than 0: none
    void forget( const IndexList& rows )
    {
        for ( std::size_t k = 1; k < _sidecars.size(); ++k ) // 0 is _lasting
            _sidecars[k]->forget( rows );
    }

    //! Removes particles; others from the end fill the holes, so the cost is
    //! that of the few that leave. \param rows ascending, each once
    void remove( const IndexList& rows )
    {
        const int n = size();
        const int count = rows.extent_int( 0 );
        if ( count == 0 )
            return;
        const auto removed =
            Kokkos::create_mirror_view_and_copy( Kokkos::HostSpace(), rows );
        const int kept = n - count;
        int moved = 0; // as many stay beyond `kept` as there are holes below
        while ( moved < count && removed( moved ) < kept )
            ++moved;
        const auto movers = _movers.take( moved );
        const auto sources = Kokkos::create_mirror_view( movers );
        int next = moved; // of those removed, the first at or beyond p
        for ( int p = kept, k = 0; p < n; ++p )
        {
            if ( next < count && removed( next ) == p )
                ++next;
            else
                sources( k++ ) = p;
        }
        Kokkos::deep_copy( movers, sources );
        keepIdentities(
            Kokkos::subview( rows, Kokkos::make_pair( 0, moved ) ) );
        keepIdentities( Impl::rowsFrom( _sequence, kept, count ) );
        Impl::moveTuples( _aosoa, movers, rows, moved );
        for ( auto& sidecar : _sidecars )
            sidecar->move( movers, rows, moved );
        resize( kept );
    }

    /*!
      \brief Sends every particle whose cell another rank has to that rank, with
      its sidecars, and removes those with a negative id. Collective.
      \param rank_of a BoxFinder
      \return number of particles on all ranks
    */
    template <class RankOf>
    std::int64_t migrate( const Communicator& comm, const RankOf& rank_of )
    {
        return migrateRows( comm, rank_of,
                            collect( "Machpoint::findStrays", size(),
                                     strays( comm, rank_of ) ) );
    }
    //! The same where all such particles are among those noted.
    template <class RankOf>
    std::int64_t migrate( const Communicator& comm, const RankOf& rank_of,
                          const RowList& noted )
    {
        return migrateRows( comm, rank_of,
                            noted.rows( size(), strays( comm, rank_of ) ) );
    }

    //! Writes all particles and sidecars in their order, or reads them.
    //! \throws ArchiveError
    void checkpoint( Archive& archive )
    {
        const Archive::Group group( archive, "particles" );
        Impl::checkpointMembers( archive, member_names, _aosoa );
        for ( auto& sidecar : _sidecars )
            sidecar->checkpoint( archive, _aosoa.size() );
    }

    //! Bytes of all, sidecars and copies included.
    std::size_t bytes() const
    {
        std::size_t sum = ( _aosoa.numSoA() + _other.numSoA() ) *
                          sizeof( typename aosoa_type::soa_type );
        for ( const auto& sidecar : _sidecars )
            sum += sidecar->bytes();
        return sum;
    }

    //! Which particles are not to stay.
    template <class RankOf, class Positions, class Ids>
    struct Strays
    {
        Positions x;
        Ids id;
        RankOf rank_of; //!< a BoxFinder
        int own;        //!< this rank

        //! The rank to go to; -1 for none.
        KOKKOS_INLINE_FUNCTION int target( const int p ) const
        {
            return id( p ) < 0 ? -1 : rank_of( loadVector<Dim>( x, p ) );
        }
        //! Is p a stray?
        KOKKOS_INLINE_FUNCTION bool operator()( const int p ) const
        {
            return target( p ) != own;
        }
    };
    //! Finds those of this rank; for kernels.
    template <class RankOf>
    auto strays( const Communicator& comm, const RankOf& rank_of ) const
    {
        const auto x = slice<Position>();
        const auto id = slice<Id>();
        return Strays<RankOf, decltype( x ), decltype( id )>{ x, id, rank_of,
                                                              comm.rank() };
    }

    // The next ones are public only because nvcc wants the parent function of
    // a device lambda to be accessible.

    //! The second half of migrate. \param rows of strays, ascending
    template <class RankOf>
    std::int64_t migrateRows( const Communicator& comm, const RankOf& rank_of,
                              const IndexList& rows )
    {
        if ( comm.size() == 1 )
        {
            remove( rows );
            return size();
        }
#ifdef MACHPOINT_ENABLE_MPI
        const Traffic::Timer timer( Activity::migration );
        const int count = rows.extent_int( 0 );
        const auto targets = _targets.take( count );
        const auto target_of = strays( comm, rank_of );
        int sent = 0;
        reduceEach(
            "Machpoint::targetRanks", count, few_rows,
            MACHPOINT_LAMBDA( const int k, int& sum ) {
                targets( k ) = target_of.target( rows( k ) );
                sum += targets( k ) < 0 ? 0 : 1;
            },
            sent );
        const auto sums = comm.sumCounts( { size() - count + sent, sent } );
        if ( sums[1] == 0 )
        {
            remove( rows );
            return sums[0];
        }
        Traffic::own().migrated_particles += sent;
        int words = words_of<aosoa_type>;
        for ( const auto& sidecar : _sidecars )
            words += sidecar->words();
        Migration migration( comm, targets, words );
        migration.pack( _aosoa, rows );
        for ( const auto& sidecar : _sidecars )
            sidecar->pack( migration, rows );
        migration.exchange();
        remove( rows );
        const int kept = size();
        resize( _aosoa.size() + migration.arriving(), false );
        migration.unpack( _aosoa, kept );
        for ( const auto& sidecar : _sidecars )
            sidecar->unpack( migration, kept );
        return sums[0];
#else
        static_cast<void>( rank_of );
        return size();
#endif
    }

  private:
    aosoa_type _aosoa;
    aosoa_type _other; // the state before a step, or the one after it
    bool _keeps = false;
    bool _streams = false; // is what a step writes too much to cache?
    bool _returns = false; // is _other a state to return to?
    KeptIdentities _kept;  // of that state, where they have changed
    Reused<int> _sequence{ "Machpoint::rows" };
    Reused<int> _movers{ "Machpoint::movers" };
    Reused<int> _targets{ "Machpoint::targetRanks" };
    Kokkos::Array<bool, AdvancedMembers<Dim>::size> _reached{};
    std::vector<std::unique_ptr<SidecarBase>> _sidecars;
    Sidecar<LastingMembers>& _lasting; // the first sidecar
};

} // namespace Machpoint

#endif
