/*!
  \file triad.cpp
  \brief Memory bandwidth of one process: a = b + s c (McCalpin's STREAM triad)
  over arrays that no cache holds, for a while.

  Usage: machpoint_triad SECONDS
  Prints bytes per second: the median over passes, 24 bytes for each element
  (two reads and a write, as STREAM counts).
*/
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

int main( const int argc, char** argv )
{
    using Clock = std::chrono::steady_clock;
    using Seconds = std::chrono::duration<double>;
    if ( argc != 2 || std::atof( argv[1] ) <= 0 )
    {
        std::fprintf( stderr, "usage: machpoint_triad SECONDS\n" );
        return 2;
    }
    const double duration = std::atof( argv[1] );
    const std::size_t n = std::size_t{ 8 } << 20; // 64 MiB an array
    std::vector<double> a( n, 0.0 ), b( n, 1.0 ), c( n, 2.0 );
    std::vector<double> rates;
    const auto begin = Clock::now();
    do
    {
        const double s = 1e-3 * static_cast<double>( rates.size() );
        const auto start = Clock::now();
        for ( std::size_t i = 0; i < n; ++i )
            a[i] = b[i] + s * c[i];
        const Seconds seconds = Clock::now() - start;
        rates.push_back( 24.0 * static_cast<double>( n ) / seconds.count() );
        b[rates.size() % n] = a[n / 2]; // a is used: no pass may be left out
    } while ( Seconds( Clock::now() - begin ).count() < duration );
    const auto middle =
        rates.begin() + static_cast<std::ptrdiff_t>( rates.size() / 2 );
    std::nth_element( rates.begin(), middle, rates.end() );
    std::printf( "%.6e\n", *middle );
    return 0;
}
