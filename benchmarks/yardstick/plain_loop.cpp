/*!
  \file plain_loop.cpp
  \brief A yardstick: the affine particle-in-cell loop as one writes it by hand.

  Usage: machpoint_plain_loop CELLS STEPS SAMPLES [mixed]

  A block of a weakly compressible fluid falls in the unit square: 4 particles a
  cell, quadratic B-splines, p = -E (J - 1), no energy, no sort, no checks; on
  several threads each has a grid of its own. Prints JSON: the updates per
  second of each sample, and the mean place of the particles, which is that of a
  body in free fall while the block touches no wall. taichi_loop.py and
  warp_loop.py solve the same problem; docs/performance.md compares.

  mixed: particles at random places of their cells, shuffled in memory.
*/
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <vector>

namespace
{

constexpr double stiffness = 400; // E
constexpr double gravity = 9.8;
constexpr double lower = 0.1, upper = 0.9; // of the block, both axes
constexpr int warm_up = 5;                 // steps

struct Particle
{
    double x[2], v[2];
    double C[4]; // affine matrix, row by row
    double J;    // volume over its first
};

struct Node
{
    double v[2]; // momentum first
    double mass;
    double unused; // 32 bytes: a node never straddles a cache line
};

//! The three nodes along one axis that a particle sees.
struct Stencil
{
    int first;
    double f; // particle minus first node, in cells
    double w[3];

    Stencil( const double x, const int cells )
        : first( static_cast<int>( x * cells - 0.5 ) ),
          f( x * cells - first ), w{ 0.5 * ( 1.5 - f ) * ( 1.5 - f ),
                                     0.75 - ( f - 1 ) * ( f - 1 ),
                                     0.5 * ( f - 0.5 ) * ( f - 0.5 ) }
    {
    }
};

class Loop
{
  public:
    Loop( const int cells, const bool mixed )
        : n( cells ), h( 1.0 / cells ), dt( 2e-4 * 128 / cells ),
          grids( omp_get_max_threads(),
                 std::vector<Node>( static_cast<std::size_t>( n ) * n ) )
    {
        const int side =
            2 * static_cast<int>( std::lround( ( upper - lower ) * cells ) );
        const double spacing = ( upper - lower ) / side;
        mass = spacing * spacing;
        std::mt19937_64 engine( 1 );
        std::uniform_real_distribution<double> place( 0, 1 );
        for ( int i = 0; i < side; ++i )
            for ( int j = 0; j < side; ++j )
            {
                Particle p{};
                p.x[0] =
                    lower + ( i + ( mixed ? place( engine ) : 0.5 ) ) * spacing;
                p.x[1] =
                    lower + ( j + ( mixed ? place( engine ) : 0.5 ) ) * spacing;
                p.J = 1;
                particles.push_back( p );
            }
        if ( mixed )
            std::shuffle( particles.begin(), particles.end(), engine );
    }

    void step()
    {
        const auto count = static_cast<long>( particles.size() );
#pragma omp parallel
        {
            auto& own = grids[omp_get_thread_num()];
            std::fill( own.begin(), own.end(), Node{} );
#pragma omp for schedule( static )
            for ( long k = 0; k < count; ++k )
                toGrid( particles[k], own.data() );
#pragma omp for schedule( static )
            for ( int i = 0; i < n; ++i )
                for ( int j = 0; j < n; ++j )
                    advanceNode( i, j );
#pragma omp for schedule( static )
            for ( long k = 0; k < count; ++k )
                toParticle( particles[k], grids[0].data() );
        }
    }

    std::vector<Particle> particles;

  private:
    void toGrid( const Particle& p, Node* const grid ) const
    {
        // Copies, as the nodes might alias members.
        const double h = this->h, mass = this->mass;
        const int n = this->n;
        const Stencil a( p.x[0], n ), b( p.x[1], n );
        const double stress = -dt * 4 * stiffness * mass * ( p.J - 1 ) * n * n;
        const double A[4] = { stress + mass * p.C[0], mass * p.C[1],
                              mass * p.C[2], stress + mass * p.C[3] };
        for ( int i = 0; i < 3; ++i )
            for ( int j = 0; j < 3; ++j )
            {
                const double w = a.w[i] * b.w[j];
                const double dx = ( i - a.f ) * h;
                const double dy = ( j - b.f ) * h;
                Node& node = grid[( a.first + i ) * n + b.first + j];
                node.v[0] += w * ( mass * p.v[0] + A[0] * dx + A[1] * dy );
                node.v[1] += w * ( mass * p.v[1] + A[2] * dx + A[3] * dy );
                node.mass += w * mass;
            }
    }

    //! Adds the threads' grids; momentum becomes velocity, and walls are
    //! slippery.
    void advanceNode( const int i, const int j )
    {
        Node& node = grids[0][i * n + j];
        for ( std::size_t t = 1; t < grids.size(); ++t )
        {
            const Node& other = grids[t][i * n + j];
            node.v[0] += other.v[0];
            node.v[1] += other.v[1];
            node.mass += other.mass;
        }
        if ( node.mass > 0 )
        {
            node.v[0] /= node.mass;
            node.v[1] /= node.mass;
        }
        node.v[1] -= dt * gravity;
        const int place[2] = { i, j };
        for ( int d = 0; d < 2; ++d )
        {
            if ( place[d] < 3 )
                node.v[d] = std::max( node.v[d], 0.0 );
            if ( place[d] > n - 3 )
                node.v[d] = std::min( node.v[d], 0.0 );
        }
    }

    void toParticle( Particle& p, const Node* const grid ) const
    {
        const double h = this->h, dt = this->dt;
        const int n = this->n;
        const Stencil a( p.x[0], n ), b( p.x[1], n );
        double v[2] = {}, C[4] = {};
        for ( int i = 0; i < 3; ++i )
            for ( int j = 0; j < 3; ++j )
            {
                const double w = a.w[i] * b.w[j];
                const double dx = ( i - a.f ) * h;
                const double dy = ( j - b.f ) * h;
                const Node& node = grid[( a.first + i ) * n + b.first + j];
                const double u = w * node.v[0], t = w * node.v[1];
                v[0] += u;
                v[1] += t;
                C[0] += u * dx;
                C[1] += u * dy;
                C[2] += t * dx;
                C[3] += t * dy;
            }
        for ( int k = 0; k < 4; ++k )
            p.C[k] = 4.0 * n * n * C[k];
        for ( int d = 0; d < 2; ++d )
        {
            p.v[d] = v[d];
            p.x[d] += dt * v[d];
        }
        p.J *= 1 + dt * ( p.C[0] + p.C[3] );
    }

    int n;
    double h, dt, mass = 0;
    std::vector<std::vector<Node>> grids; // of the threads
};

} // namespace

int main( const int argc, char** argv )
{
    const int cells = argc > 3 ? std::atoi( argv[1] ) : 0;
    const int steps = argc > 3 ? std::atoi( argv[2] ) : 0;
    const int samples = argc > 3 ? std::atoi( argv[3] ) : 0;
    const bool mixed = argc == 5 && std::strcmp( argv[4], "mixed" ) == 0;
    if ( cells < 32 || steps < 1 || samples < 1 || argc > 5 ||
         ( argc == 5 && !mixed ) )
    {
        std::fprintf( stderr, "usage: machpoint_plain_loop CELLS STEPS SAMPLES "
                              "[mixed]; CELLS >= 32\n" );
        return 2;
    }
    Loop loop( cells, mixed );
    for ( int k = 0; k < warm_up; ++k )
        loop.step();
    const auto count = static_cast<double>( loop.particles.size() );
    std::printf( "{\"particles\": %.0f, \"updates_per_second\": [", count );
    for ( int sample = 0; sample < samples; ++sample )
    {
        const double start = omp_get_wtime();
        for ( int k = 0; k < steps; ++k )
            loop.step();
        std::printf( "%s%.6e", sample > 0 ? ", " : "",
                     count * steps / ( omp_get_wtime() - start ) );
    }
    double mean[2] = {};
    for ( const auto& p : loop.particles )
        for ( int d = 0; d < 2; ++d )
            mean[d] += p.x[d] / count;
    std::printf( "], \"mean\": [%.12f, %.12f]}\n", mean[0], mean[1] );
    return 0;
}
