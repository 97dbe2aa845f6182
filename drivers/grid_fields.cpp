#include <drivers/grid_fields.hpp>

#include <core/communicator.hpp>

#include <algorithm>
#include <cmath>

namespace Machpoint
{

namespace
{

//! Places what all ranks gathered, block after block, [nodes][components].
std::vector<Real> assemble( const std::vector<Real>& blocks,
                            const std::vector<std::size_t>& boxes,
                            const std::vector<std::size_t>& shape,
                            const std::size_t components )
{
    const std::size_t axes = shape.size();
    std::size_t nodes = 1;
    for ( const auto n : shape )
        nodes *= n;
    std::vector<Real> whole( nodes * components );
    std::size_t next = 0;
    for ( std::size_t box = 0; box < boxes.size(); box += 2 * axes )
    {
        const auto* start = boxes.data() + box;
        const auto* size = start + axes;
        std::size_t own = 1;
        for ( std::size_t d = 0; d < axes; ++d )
            own *= size[d];
        for ( std::size_t n = 0; n < own; ++n )
        {
            std::size_t row = 0, rest = n, stride = 1;
            for ( std::size_t d = axes; d-- > 0; ) // x is last, and fastest
            {
                row += stride * ( start[d] + rest % size[d] );
                rest /= size[d];
                stride *= shape[d];
            }
            for ( std::size_t c = 0; c < components; ++c )
                whole[row * components + c] = blocks[next++];
        }
    }
    return whole;
}

} // namespace

GridData wholeGrid( const Communicator& ranks, const GridData& own )
{
    if ( ranks.size() == 1 )
        return own;
    auto box = own.start;
    box.insert( box.end(), own.shape.begin(), own.shape.end() );
    const auto boxes = ranks.gather( box );
    auto whole = own;
    whole.shape = own.global_shape;
    whole.start.assign( own.start.size(), 0 );
    auto gather = [&]( std::vector<Real>& values, const std::size_t components )
    {
        const auto blocks = ranks.gather( values );
        values = ranks.isRoot()
                     ? assemble( blocks, boxes, whole.shape, components )
                     : std::vector<Real>();
    };
    for ( auto* values :
          { &whole.density, &whole.pressure, &whole.specific_internal_energy } )
        gather( *values, 1 );
    gather( whole.velocity, own.shape.size() );
    return whole;
}

GridFields::GridFields( const GridData& whole )
    : _lower( whole.lower ), _spacing( whole.spacing ),
      _shape( whole.shape.rbegin(), whole.shape.rend() ), _fields( 3 )
{
    _fields[0].assign( whole.density.begin(), whole.density.end() );
    _fields[1].assign( whole.pressure.begin(), whole.pressure.end() );
    _fields[2].assign( whole.specific_internal_energy.begin(),
                       whole.specific_internal_energy.end() );
    const std::size_t dim = _shape.size();
    const std::size_t nodes = whole.density.size();
    for ( std::size_t d = 0; d < dim; ++d )
    {
        auto& component = _fields.emplace_back( nodes );
        for ( std::size_t i = 0; i < nodes; ++i )
            component[i] = whole.velocity[i * dim + d];
    }
}

std::vector<double> GridFields::at( const std::array<double, 3>& x ) const
{
    const std::size_t dim = _shape.size();
    std::array<std::size_t, 3> first{};
    std::array<double, 3> part{};
    for ( std::size_t d = 0; d < dim; ++d )
    {
        // Beyond the outermost nodes their value holds.
        const double last = static_cast<double>( _shape[d] - 1 );
        const double place =
            std::clamp( ( x[d] - _lower[d] ) / _spacing[d], 0.0, last );
        first[d] = std::min( static_cast<std::size_t>( place ),
                             _shape[d] - ( _shape[d] > 1 ? 2 : 1 ) );
        part[d] = place - static_cast<double>( first[d] );
    }
    std::vector<double> values( _fields.size(), 0.0 );
    for ( std::size_t corner = 0; corner < ( 1u << dim ); ++corner )
    {
        double weight = 1;
        std::size_t node = 0;
        for ( std::size_t d = dim; d-- > 0; )
        {
            const std::size_t upper = ( corner >> d ) & 1;
            weight *= upper ? part[d] : 1 - part[d];
            node = node * _shape[d] + first[d] + upper;
        }
        if ( weight == 0 )
            continue;
        if ( _fields[0][node] <= 0 )
            return {};
        for ( std::size_t f = 0; f < values.size(); ++f )
            values[f] += weight * _fields[f][node];
    }
    return values;
}

std::vector<FieldDifference> fieldDifferences( const GridFields& coarse,
                                               const GridFields& fine,
                                               const Json& input )
{
    const auto& grid = input.at( "grid" );
    const std::vector<std::int64_t> cells = grid.at( "cells" );
    const std::vector<double> lower = grid.at( "lower" );
    const std::vector<double> upper = grid.at( "upper" );
    std::int64_t count = 1;
    double volume = 1; // of a cell
    for ( std::size_t d = 0; d < cells.size(); ++d )
    {
        count *= cells[d];
        volume *= ( upper[d] - lower[d] ) / static_cast<double>( cells[d] );
    }

    std::vector<FieldDifference> fields( 4 );
    const char* names[] = { "density", "velocity", "pressure",
                            "specific_internal_energy" };
    for ( std::size_t f = 0; f < fields.size(); ++f )
        fields[f].error.field = names[f];
    for ( std::int64_t cell = 0; cell < count; ++cell )
    {
        std::array<double, 3> x{};
        auto rest = cell;
        for ( std::size_t d = 0; d < cells.size(); ++d )
        {
            x[d] =
                lower[d] + ( upper[d] - lower[d] ) *
                               ( static_cast<double>( rest % cells[d] ) + .5 ) /
                               static_cast<double>( cells[d] );
            rest /= cells[d];
        }
        const auto a = coarse.at( x ), b = fine.at( x );
        if ( a.empty() || b.empty() )
            continue;
        // Components of the velocity come last.
        std::array<double, 4> difference{ std::abs( a[0] - b[0] ), 0,
                                          std::abs( a[1] - b[1] ),
                                          std::abs( a[2] - b[2] ) };
        std::array<double, 4> value{ std::abs( b[0] ), 0, std::abs( b[1] ),
                                     std::abs( b[2] ) };
        for ( std::size_t f = 3; f < a.size(); ++f )
        {
            difference[1] = std::hypot( difference[1], a[f] - b[f] );
            value[1] = std::hypot( value[1], b[f] );
        }
        for ( std::size_t f = 0; f < fields.size(); ++f )
        {
            auto& [error, size] = fields[f];
            error.L1 += volume * difference[f];
            error.L2 += volume * difference[f] * difference[f];
            error.Linf = std::max( error.Linf, difference[f] );
            size += volume * value[f];
        }
    }
    for ( auto& field : fields )
        field.error.L2 = std::sqrt( field.error.L2 );
    return fields;
}

} // namespace Machpoint
