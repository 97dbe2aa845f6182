/*!
  \file merging.hpp
  \brief Part of `conservative`: small particles are merged where gas is
  compressed (docs/conservative.md, section 9).
*/
#ifndef MACHPOINT_CONSERVATIVE_MERGING_HPP
#define MACHPOINT_CONSERVATIVE_MERGING_HPP

#include <core/basis.hpp>
#include <core/conservative/history.hpp>
#include <core/soundness.hpp>

#include <Kokkos_Bitset.hpp>

namespace Machpoint
{

namespace Impl
{

//! A mark on every half-cell of a rank's box.
using HalfCellMarks = Kokkos::Bitset<MemorySpace::device_type>;

//! Half-cell of a position within a rank's box, x fastest.
template <int Dim>
KOKKOS_INLINE_FUNCTION int
halfCell( const Grid<Dim>& grid, const CellBox<Dim>& box, const Vector<Dim>& x )
{
    int flat = 0;
    for ( int d = Dim - 1; d >= 0; --d )
    {
        const int last = 2 * box.cells( d ) - 1;
        const int c =
            static_cast<int>( 2 * ( x[d] - grid.lower[d] ) / grid.spacing[d] ) -
            2 * box.begin[d];
        flat = flat * ( last + 1 ) + ( c < 0 ? 0 : ( c > last ? last : c ) );
    }
    return flat;
}

/*!
  \brief Rows of the particles that a pair might be of: smaller than `largest`,
  in a half-cell that has one of less than half of that.

  Of a pair one has less than half of the volume that the two may have, so
  half-cells without such a one are left alone: nearly all where the gas is only
  compressed.
  \param largest volume of a merged particle
  \param marks none on entry; on return those half-cells' are set
*/
template <int Dim>
IndexList listSmall( State<Dim>& state, const Real largest,
                     const HalfCellMarks& marks )
{
    const auto x = state.particles.template slice<Position>();
    const auto V = state.particles.template slice<Volume>();
    const auto grid = state.grid;
    const auto box = state.layout.box;
    const int n = state.particles.size();
    RowList& noted = state.noted;
    noted.clear( n );
    forEachPack(
        "Machpoint::noteTiny", n,
        MACHPOINT_LAMBDA( const Pack p ) MACHPOINT_INLINE {
            noted.note( p, active( p ) &&
                               load( V, p ) < Lanes( 0.5_rt * largest ) );
        } );
    if ( noted.count() == 0 )
        return {};
    const auto tiny = noted.rows(
        n,
        MACHPOINT_LAMBDA( const int p ) { return V( p ) < 0.5_rt * largest; } );
    forEach(
        "Machpoint::markHalfCells", tiny.extent_int( 0 ),
        MACHPOINT_LAMBDA( const int k ) {
            marks.set(
                halfCell<Dim>( grid, box, loadVector<Dim>( x, tiny( k ) ) ) );
        } );
    auto isCandidate = MACHPOINT_LAMBDA( const int p )
    {
        return V( p ) < largest && marks.test( halfCell<Dim>(
                                       grid, box, loadVector<Dim>( x, p ) ) );
    };
    noted.clear( n );
    forEachPack(
        "Machpoint::noteSmall", n,
        MACHPOINT_LAMBDA( const Pack pack ) MACHPOINT_INLINE {
            if ( any( load( V, pack ) < Lanes( largest ) ) )
                forEachOf( pack,
                           [&]( const int p )
                           {
                               if ( isCandidate( p ) )
                                   noted.note( p );
                           } );
        } );
    return noted.rows( n, isCandidate );
}

//! The particles of which pairs are merged, one row after the other.
template <int Dim>
struct Merging
{
    template <std::size_t M>
    using Member =
        decltype( std::declval<State<Dim>>().particles.template slice<M>() );
    template <std::size_t M>
    using History = decltype( Cabana::slice<M>(
        std::declval<Sidecar<HistoryMembers<Dim>>&>().data() ) );

    Grid<Dim> grid;
    AffineMoment moment_of;
    Real largest;       //!< volume of a merged particle
    Real reference;     //!< p_inf of a stiffened gas
    Real squared_sound; //!< c^2 over heat, of an ideal or a stiffened gas
    Member<Position> x;
    Member<Velocity> v;
    Member<VelocityGradient> C;
    Member<Mass> m;
    Member<Volume> V;
    Member<SpecificInternalEnergy> e;
    Member<Id> id;
    History<Stretch> stretch;
    History<OriginalMass> original;

    Merging( State<Dim>& state, const PressureResponse& response,
             Sidecar<HistoryMembers<Dim>>& history, const Real largest_volume )
        : grid( state.grid ), moment_of( state.affine_moment ),
          largest( largest_volume ), reference( response.reference ),
          squared_sound( response.exponent * response.gruneisen ),
          x( state.particles.template slice<Position>() ),
          v( state.particles.template slice<Velocity>() ),
          C( state.particles.template slice<VelocityGradient>() ),
          m( state.particles.template slice<Mass>() ),
          V( state.particles.template slice<Volume>() ),
          e( state.particles.template slice<SpecificInternalEnergy>() ),
          id( state.particles.template slice<Id>() ),
          stretch( Cabana::slice<Stretch>( history.data() ) ),
          original( Cabana::slice<OriginalMass>( history.data() ) )
    {
    }

    //! May the two be one? Distance and slip are looked at by whoever asks.
    KOKKOS_INLINE_FUNCTION bool areAlike( const int p, const int q ) const
    {
        return V( p ) + V( q ) < largest &&
               m( p ) + m( q ) <= 2 * ( original( p ) + original( q ) ) &&
               Kokkos::abs( heat( p ) - heat( q ) ) <
                   0.1_rt * ( heat( p ) + heat( q ) );
    }
    //! What of e depends on the temperature alone.
    KOKKOS_INLINE_FUNCTION Real heat( const int p ) const
    {
        return heatOf<Real>( e( p ), V( p ), m( p ), reference );
    }

    /*!
      \brief How far from its cell's centre p is along each axis, to 1/1024 of a
      cell, as one number.

      The largest comes first, so that a particle's images, in whichever sides
      of the cell or diagonals, have the same.
    */
    KOKKOS_INLINE_FUNCTION int placeOf( const int p ) const
    {
        int distance[Dim];
        for ( int d = 0; d < Dim; ++d )
        {
            const Real place = ( x( p, d ) - grid.lower[d] ) / grid.spacing[d];
            const Real from_center =
                Kokkos::abs( place - Kokkos::floor( place ) - 0.5_rt );
            const int next =
                static_cast<int>( Kokkos::round( 1024 * from_center ) );
            int k = d;
            for ( ; k > 0 && distance[k - 1] < next; --k )
                distance[k] = distance[k - 1];
            distance[k] = next;
        }
        int place = 0;
        for ( int d = 0; d < Dim; ++d )
            place = 1024 * place + distance[d];
        return place;
    }
    //! Does p choose its partner ahead of q of the same half-cell? Neither the
    //! order in memory decides, nor which of its sides a mirrored gas is on.
    KOKKOS_INLINE_FUNCTION bool isAhead( const int p, const int q ) const
    {
        const int place_p = placeOf( p );
        const int place_q = placeOf( q );
        return place_p != place_q ? place_p < place_q : id( p ) < id( q );
    }

    //! The nearest of rows [begin, end) of `particles` that p may merge with,
    //! the first of equally near ones; -1: none.
    KOKKOS_INLINE_FUNCTION int partnerOf( const int p,
                                          const IndexList& particles,
                                          const int begin, const int end ) const
    {
        int partner = -1;
        Real nearest = Kokkos::Experimental::infinity_v<Real>;
        for ( int j = begin; j < end; ++j )
        {
            const int q = particles( j );
            if ( id( q ) < 0 || !areAlike( p, q ) )
                continue;
            Real distance = 0;
            Real slip = 0;
            for ( int d = 0; d < Dim; ++d )
            {
                const Real dx = x( p, d ) - x( q, d );
                const Real dv = v( p, d ) - v( q, d );
                distance += dx * dx;
                slip += dv * dv;
            }
            // Of the gas as it is: the slice has the speed of sound that the
            // last step, or an output, began with.
            if ( slip < 0.04_rt * squared_sound * heat( p ) &&
                 distance < nearest * ( 1 - round_off ) )
            {
                nearest = distance;
                partner = q;
            }
        }
        return partner;
    }

    //! What the relative velocity of two would be as part of their C[a][b].
    KOKKOS_INLINE_FUNCTION Real spreadOf( const int p, const int q, const int a,
                                          const int b ) const
    {
        const Real mass = m( p ) + m( q );
        return m( p ) / mass * ( m( q ) / mass ) * ( v( p, a ) - v( q, a ) ) *
               ( x( p, b ) - x( q, b ) ) /
               ( moment_of.varies ? grid.spacing[b] * grid.spacing[b]
                                  : moment_of( grid, x( p, b ), b ) );
    }

    //! Makes p of p and q, and marks q for removal.
    KOKKOS_INLINE_FUNCTION void merge( const int p, const int q ) const
    {
        const Real mass = m( p ) + m( q );
        const Real fp = m( p ) / mass;
        const Real fq = m( q ) / mass;
        Real before = 0;      // twice the kinetic energy of the pair
        Real after = 0;       // with the mean C
        Real with_spread = 0; // with the relative velocity in C
        for ( int b = 0; b < Dim; ++b )
        {
            const Real moment_p = moment_of( grid, x( p, b ), b );
            const Real moment_q = moment_of( grid, x( q, b ), b );
            const Real moment =
                moment_of( grid, fp * x( p, b ) + fq * x( q, b ), b );
            const Real dv = v( p, b ) - v( q, b );
            before += fp * fq * dv * dv;
            for ( int a = 0; a < Dim; ++a )
            {
                const Real Cp = C( p, a, b );
                const Real Cq = C( q, a, b );
                const Real mean = fp * Cp + fq * Cq;
                const Real spread = mean + spreadOf( p, q, a, b );
                before += fp * moment_p * Cp * Cp + fq * moment_q * Cq * Cq;
                after += moment * mean * mean;
                with_spread += moment * spread * spread;
            }
        }
        const bool spreads = with_spread <= before;
        const Real kinetic = spreads ? with_spread : after;
        // Without spread it cannot grow, but for hats.
        const Real factor =
            kinetic > before ? Kokkos::sqrt( before / kinetic ) : 1.0_rt;
        Real lost = before; // twice
        for ( int b = 0; b < Dim; ++b )
        {
            const Real moment =
                moment_of( grid, fp * x( p, b ) + fq * x( q, b ), b );
            for ( int a = 0; a < Dim; ++a )
            {
                const Real kept = asDeviation(
                    factor *
                    ( fp * C( p, a, b ) + fq * C( q, a, b ) +
                      ( spreads ? spreadOf( p, q, a, b ) : 0.0_rt ) ) );
                store( C, kept, p, a, b );
                lost -= moment * kept * kept;
            }
        }
        e( p ) = fp * e( p ) + fq * e( q ) + 0.5_rt * lost;
        for ( int a = 0; a < Dim; ++a )
        {
            x( p, a ) = fp * x( p, a ) + fq * x( q, a );
            v( p, a ) = fp * v( p, a ) + fq * v( q, a );
            stretch( p, a ) = fp * stretch( p, a ) + fq * stretch( q, a );
        }
        original( p ) = fp * original( p ) + fq * original( q );
        m( p ) = mass;
        V( p ) += V( q );
        id( q ) = -1;
    }
};

/*!
  \brief Merges pairs of similar small particles of a half-cell: one after the
  other takes the nearest that is left (Merging::isAhead).

  Mass-weighted x, v, C and e; volumes add. The relative velocity goes into C
  where that does not raise the kinetic energy, and what is lost of
  |v|^2/2 + moment |C|^2/2 into e, so mass, momentum, volume and energy stay.
  Similar: |e1 - e2| < .1 (e1 + e2), |dv| < .2 c; no result is heavier than
  four times what its parts started with.
  \param marks none, on entry and on return
*/
template <int Dim>
void mergeParticles( State<Dim>& state, const PressureResponse& response,
                     Sidecar<HistoryMembers<Dim>>& history,
                     const HalfCellMarks& marks,
                     const ConservativeParts& parts )
{
    // Pairs that the gas's own particles would be at the start do not merge.
    const Real largest =
        Kokkos::min( parts.merge_volume, 0.5_rt / state.per_cell ) *
        state.grid.cellVolume();
    const auto rows = listSmall( state, largest, marks );
    const int small = rows.extent_int( 0 );
    if ( small == 0 )
        return;
    const Merging<Dim> pairs( state, response, history, largest );
    const auto box = state.layout.box;
    const int n = state.particles.size();
    IndexList keys( "Machpoint::halfCells", small );
    forEach(
        "Machpoint::halfCellOfParticle", small,
        MACHPOINT_LAMBDA( const int k ) {
            const int p = rows( k );
            keys( k ) =
                halfCell<Dim>( pairs.grid, box, loadVector<Dim>( pairs.x, p ) );
            marks.reset( keys( k ) );
            if ( pairs.original( p ) == 0 )
                pairs.original( p ) = pairs.m( p );
        } );
    state.particles.keepIdentities( rows );
    const auto order = Cabana::sortByKey( keys );
    IndexList ordered( "Machpoint::orderedParticles", small );
    RowList& merged = state.noted;
    merged.clear( n );
    const MergedPairs made( "Machpoint::mergedPairs",
                            state.particles.averageOnMerging() ? small : 0 );
    forEach(
        "Machpoint::mergeParticles", small,
        MACHPOINT_LAMBDA( const int begin ) {
            auto keyOf = [&]( const int i )
            { return keys( static_cast<int>( order.permutation( i ) ) ); };
            const int key = keyOf( begin );
            if ( begin > 0 && keyOf( begin - 1 ) == key )
                return; // another one's half-cell
            int end = begin + 1;
            while ( end < small && keyOf( end ) == key )
                ++end;
            for ( int i = begin; i < end; ++i )
            {
                const int p =
                    rows( static_cast<int>( order.permutation( i ) ) );
                int j = i;
                for ( ; j > begin && pairs.isAhead( p, ordered( j - 1 ) ); --j )
                    ordered( j ) = ordered( j - 1 );
                ordered( j ) = p;
            }
            for ( int i = begin; i < end; ++i )
            {
                const int p = ordered( i );
                const int q = pairs.id( p ) < 0
                                  ? -1
                                  : pairs.partnerOf( p, ordered, i + 1, end );
                if ( q < 0 )
                    continue;
                pairs.merge( p, q );
                merged.note( q );
                if ( made.extent( 0 ) > 0 )
                    made( i ) = { p, q, pairs.m( q ) / pairs.m( p ) };
            }
        },
        few_particles );
    state.particles.merge( made );
    const auto id = pairs.id;
    state.particles.remove( merged.rows(
        n, MACHPOINT_LAMBDA( const int p ) { return id( p ) < 0; } ) );
}

} // namespace Impl
} // namespace Machpoint

#endif
