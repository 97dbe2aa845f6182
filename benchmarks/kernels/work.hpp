/*!
  \file work.hpp
  \brief What the parts of a step have to move and to compute, for one particle
  step: counted from the equations, not measured.

  Bytes: a part reads each column that it needs once, and writes each that it
  changes once, whatever its kernels do; a column is a member of the particles,
  or of the nodes, of which there is one for each cell, and a Deviation counts
  as what it takes of a column. So a part that takes two passes, or whose nodes
  fall out of the cache, shows a smaller fraction of the machine's bandwidth.
  Flops: additions, multiplications, comparisons, divisions and roots count one
  each; products that a row of nodes shares count once. docs/performance.md
  shows the numbers.
*/
#ifndef MACHPOINT_BENCHMARKS_WORK_HPP
#define MACHPOINT_BENCHMARKS_WORK_HPP

#include <core/conservative/parts.hpp>

#include <string>

namespace Machpoint
{

//! Of one particle in one step.
struct Work
{
    Real bytes = 0;
    Real flops = 0;
};

//! What the work depends on.
struct WorkSetting
{
    std::string method; //!< paper, apic or conservative
    bool midpoint;      //!< of `conservative`
    int dim;
    int nodes; //!< of a stencil along one axis: 2, 3 or 4
    int per_cell;
    int sort_every;
    int particle_bytes; //!< of the AoSoA, for one particle
};

//! The counts of one setting, a function for each part.
class WorkOfStep
{
  public:
    explicit WorkOfStep( const WorkSetting& setting )
        : s( setting ), D( setting.dim ), is_paper( s.method == "paper" ),
          is_conservative( s.method == "conservative" )
    {
        stencil_nodes = 1;
        for ( int d = 0; d < s.dim; ++d )
            stencil_nodes *= s.nodes;
        faces = D * stencil_nodes * ( s.nodes - 1 ) / s.nodes;
    }

    //! Work of a part by its name; zero for one that the method does without,
    //! and for `other`, which is not counted.
    Work of( const std::string& part ) const
    {
        if ( part == "prepare" )
            return prepare();
        if ( part == "P2G" )
            return particlesToGrid();
        if ( part == "G2P" )
            return gridToParticles();
        if ( part == "grid" )
            return grid();
        if ( part == "EOS" )
            return equationOfState();
        if ( part == "sort" )
            return sort();
        return {};
    }

    /*!
      \brief What `conservative` rearranges ahead of a step, as far as all
      particles pass through it.

      In 1D each step takes V, m and e to p and c, and exchanges volume: x, V,
      m, e and p read, V and e written; on nodes two fields of two columns,
      written and read. Three passes see their stencils; two numbers of the flow
      tell whose heat is mixed. In 2D and 3D V is looked at for what to merge,
      the diagonal of C advances the stretch, and ConductedHeat tells whether
      there was friction, every few steps each. What follows for the particles
      that are found (heat mixed or conducted, halves, pairs) depends on the
      flow and does not count.
    */
    Work prepare() const
    {
        if ( !is_conservative )
            return {};
        if ( s.dim == 1 )
            return work(
                9 + 2 * share, 8,
                3 * stencil() + 6 * s.nodes + 38 * ( s.nodes - 1 ) + 69, 4 );
        const Real merge = 1.0_rt / ConservativeParts::merge_every;
        const Real track = 1.0_rt / ConservativeParts::track_every;
        const Real conduct = 1.0_rt / ConservativeParts::conduct_every;
        return work( merge + track * D * ( 2 + share ) + conduct * share, 0,
                     merge + track * 5 * D + conduct );
    }

    //! x, v, m, V, p, and C of an affine method; mass, momentum and force.
    //! `conservative` reads c and two numbers of the flow, too, and writes the
    //! working pressure; with `midpoint` it reads two expansions and the
    //! velocity that v lacks, and writes x and V; on nodes mass, momentum,
    //! theta, pressure and blend.
    Work particlesToGrid() const
    {
        const Real affine = is_paper ? 0 : D * D;
        const Real N = stencil_nodes;
        if ( !is_conservative )
            return work( 2 * D + share * affine + 3, 1 + 2 * D,
                         stencil() + N * ( 3 + 5 * D + 2 * affine ) );
        const Real ahead = s.midpoint ? 28 + 3 * D : 0;
        return work( 2 * D + 5 + share * ( affine + 2 ) +
                         ( s.midpoint ? D + 1 + share * ( D + 2 ) : 0 ),
                     2 + 3 * D,
                     stencil() + N * ( 5 + D * ( 2 * D + 2 ) ) + 5 * faces +
                         20 + ahead );
    }

    //! x, v, C, V, e, m and p read; the first five written, as the new state
    //! stands beside the old one. `paper` needs no C, reads the new v again,
    //! and writes and reads a second velocity on nodes; `conservative` reads c,
    //! beta and theta, writes four fields on faces and two numbers of the flow,
    //! and with `midpoint` reads the expansion that the particle remembers, and
    //! writes that, the next and the velocity that it will.
    Work gridToParticles() const
    {
        const Real N = stencil_nodes;
        const Real written = 2 * D + share * D * D + 2;
        if ( is_paper )
            return work(
                3 * D + 4 + written, 2 * D + 2 * D,
                3 * stencil() +
                    N * ( 1 + 3 * D + 2 + 2 * D + 1 + 3 * D + 2 * D * D ) +
                    4 * D + 8,
                D );
        const Real tail = 4 * D + 5 * D * D + 12;
        if ( is_conservative )
            return work( 2 * D + 5 + written +
                             share * ( D * D + 2 + ( s.midpoint ? D + 3 : 0 ) ),
                         2 * D + 1 + D + 4 * D,
                         stencil() + N * ( 4 + D * ( 13 + 4 * D ) ) +
                             12 * faces + tail + 28 + 1.5 * D * ( D - 1 ),
                         19 * D );
        return work( 2 * D + share * D * D + 4 + written, 2 * D,
                     stencil() + N * ( 2 * D * D + D * ( 13 + 2 * D ) ) +
                         tail );
    }

    //! Mass, momentum and force read; v and v' written. `conservative` has
    //! theta and pressure of faces for the force, and the blend, and writes
    //! beta.
    Work grid() const
    {
        const Real moved = 1 + 2 * D + 2 * D;
        if ( !is_conservative )
            return work( 0, moved, 0, 4 * D );
        return work( 0, moved + D + 2, 0, 4 * D + 7 * D + 3 );
    }

    //! v, m, V, e read; p, c written, and the gas surveyed.
    Work equationOfState() const { return work( D + 5, 0, 2 * D + 12 ); }

    //! All columns but the rates read and written, those that have no second
    //! state twice, with keys and their order (three whole numbers), every few
    //! steps.
    Work sort() const
    {
        const Real advanced = 2 * D + share * D * D + 2;
        auto all = work( 4 * columns() - 2 * advanced + D + 1.5, 0, 3 * D );
        all.bytes /= s.sort_every;
        all.flops /= s.sort_every;
        return all;
    }

  private:
    static constexpr Real column = sizeof( Real );
    //! What a Deviation takes of a column.
    static constexpr Real share = sizeof( Deviation ) / column;

    //! \param particle, node columns moved
    //! \param flops of a particle \param node_flops of a node
    Work work( const Real particle, const Real node, const Real flops,
               const Real node_flops = 0 ) const
    {
        return { column * ( particle + node / s.per_cell ),
                 flops + node_flops / s.per_cell };
    }

    //! Place in the cell, weights, gradients and distances along each axis.
    Real stencil() const
    {
        const Real weights[] = { 1, 8, 19 };
        const Real gradients[] = { 0, 3, 10 };
        const int k = s.nodes - 2;
        return D * ( 3 + weights[k] + gradients[k] + 3 * s.nodes );
    }

    //! Columns of a particle, and what the viscosity, splitting and the
    //! integrator midpoint remember.
    Real columns() const
    {
        const Real sidecars =
            is_conservative ? D + 1 + share * ( 2 + ( s.midpoint ? D + 2 : 0 ) )
                            : 0;
        return s.particle_bytes / column + sidecars;
    }

    WorkSetting s;
    Real D;
    bool is_paper, is_conservative;
    Real stencil_nodes;
    Real faces; //!< that a particle sees, of all axes
};

} // namespace Machpoint

#endif
