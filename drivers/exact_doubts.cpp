#include <drivers/exact_doubts.hpp>

#include <drivers/body_doubts.hpp>

#include <core/exact.hpp>
#include <core/initial_gas.hpp>

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

namespace Machpoint
{

namespace
{

//! Of the gas' density, pressure and speeds: what makes a difference.
constexpr double tolerance = 0.01;
constexpr int times = 8;

template <int Dim>
class ExactDoubts
{
  public:
    explicit ExactDoubts( const Json& input )
        : _input( input ), _exact( makeExact( input ) ),
          _law( gasLaw( input ) ), _periods( periodsOf( input ) ),
          _samples( input )
    {
        for ( const auto& entry : input.at( "boundary" ) )
            if ( const auto& hooks = boundaryHooks( entry, Dim ); hooks.solid )
                _bodies.push_back( { "", makeShape<Dim, Kokkos::HostSpace>(
                                             hooks.solid( entry ) ) } );
        _samples.forEach(
            [&]( const Indices<Dim>& i, int ) {
                _densest =
                    std::max( _densest, at( _samples.center( i ), 0 ).density );
            } );
    }

    std::vector<std::string> find() const
    {
        if ( const auto effect = unknownToExact(); !effect.empty() )
            return { fmt::format(
                "/exact: the {} solution knows no {}, so what a run calls its "
                "errors is what that changes, too; leave out either",
                type(), effect ) };
        if ( _exact->holdsAtStart() )
            if ( const auto x = otherStart() )
                return { fmt::format(
                    "/exact: the gas near {} does not start as the {} solution "
                    "does, so what a run calls its errors will be none; leave "
                    "that alone in /initial, or leave out /exact",
                    placeText<Dim>( *x ), type() ) };
        for ( int k = 1; k <= times; ++k )
        {
            const double end = _input.at( "time" ).at( "end" );
            const double t = end * k / times;
            if ( const auto where = misfit( t ); !where.empty() )
                return { fmt::format(
                    "/exact: at t = {:.3g} or before, the {} solution does not "
                    "fit {}, so what a run calls its errors will be none after "
                    "that; end before, or give the flow more room",
                    t, type(), where ) };
        }
        return {};
    }

  private:
    std::string type() const { return _input.at( "exact" ).at( "type" ); }

    //! Gravity, but of gas that stands in it, or an effect that diffuses,
    //! where the solution has something to diffuse and is of gas that does not.
    std::string unknownToExact() const
    {
        const auto solution = type();
        const bool stands = solution == "hydrostatic";
        const bool diffuses =
            solution == "viscous_shock" || solution == "uniform" || stands;
        auto acts = []( const Json& effect, const char* key )
        { return effect.at( key ) != 0; };
        for ( const auto& effect : _input.at( "physics" ) )
        {
            const auto name = effect.at( "type" ).get<std::string>();
            const bool is_felt =
                name == "gravity"
                    ? !stands && effect.at( "acceleration" ) !=
                                     Json( std::vector<double>( Dim, 0.0 ) )
                : name == "viscosity"
                    ? !diffuses &&
                          ( acts( effect, "shear" ) || acts( effect, "bulk" ) )
                    : name == "heat_conduction" && !diffuses &&
                          acts( effect, "conductivity" );
            if ( is_felt )
                return name;
        }
        return "";
    }

    static Vector3 inSpace( const Vector<Dim>& x )
    {
        Vector3 place{};
        for ( int d = 0; d < Dim; ++d )
            place[d] = x[d];
        return place;
    }

    //! The exact gas.
    GasState at( const Vector<Dim>& x, const double t ) const
    {
        return _exact->state( inSpace( x ), t );
    }

    //! Behind a piston there is none, whatever \c at says.
    bool hasGas( const Vector<Dim>& x, const double t ) const
    {
        return _exact->hasGas( inSpace( x ), t );
    }

    //! Is it, or as good as, a vacuum?
    bool isNothing( const GasState& gas ) const
    {
        return gas.density <= tolerance * _densest;
    }

    bool areSame( const GasState& a, const GasState& b ) const
    {
        if ( isNothing( a ) || isNothing( b ) )
            return isNothing( a ) && isNothing( b );
        double difference = 0, speed = soundSpeed( a, _law );
        for ( int d = 0; d < 3; ++d )
        {
            difference += std::abs( a.velocity[d] - b.velocity[d] );
            speed += std::abs( a.velocity[d] );
        }
        // By the inertia, too: cold gas that moves has hardly any pressure.
        const double pressure =
            a.pressure + _law.pressure_offset + a.density * speed * speed;
        return std::abs( a.density - b.density ) <= tolerance * a.density &&
               std::abs( a.pressure - b.pressure ) <= tolerance * pressure &&
               difference <= tolerance * speed;
    }

    //! Is the exact start the same a sample aside? It may jump at a place.
    bool isSmooth( Vector<Dim> x ) const
    {
        const auto here = at( x, 0 );
        for ( int d = 0; d < Dim; ++d )
        {
            const Real middle = x[d];
            for ( const Real way : { -1, 1 } )
            {
                x[d] = middle + way * _samples.grid().spacing[d];
                if ( !areSame( here, at( x, 0 ) ) )
                    return false;
            }
            x[d] = middle;
        }
        return true;
    }

    //! Where the gas of `initial` is another one.
    std::optional<Vector<Dim>> otherStart() const
    {
        const InitialGas<Dim> initial( _input );
        std::optional<Vector<Dim>> found;
        _samples.forEach(
            [&]( const Indices<Dim>& i, int )
            {
                const auto x = _samples.center( i );
                Gradient gradient;
                if ( !found && !isInBody<Dim>( _bodies, x ) && hasGas( x, 0 ) &&
                     !areSame( at( x, 0 ), initial.at( x, gradient ) ) &&
                     isSmooth( x ) )
                    found = x;
            } );
        return found;
    }

    //! The first side or body that the exact gas goes through, in words.
    std::string misfit( const double t ) const
    {
        std::string found;
        _samples.forEach(
            [&]( const Indices<Dim>& i, int )
            {
                const auto x = _samples.center( i );
                if ( !found.empty() || isInBody<Dim>( _bodies, x ) ||
                     !hasGas( x, t ) )
                    return;
                for ( int side = 0; side < 2 * Dim && found.empty(); ++side )
                    if ( i[side / 2] ==
                             ( side % 2 ? _samples.grid().cells[side / 2] - 1
                                        : 0 ) &&
                         !fitsSide( side, x, t ) )
                        found = fmt::format( "the side {} near {}",
                                             sideNames( Dim )[side],
                                             placeText<Dim>( x ) );
                if ( found.empty() && !fitsBodies( x, t ) )
                    found =
                        fmt::format( "the body near {}", placeText<Dim>( x ) );
            } );
        return found;
    }

    bool fitsSide( const int side, Vector<Dim> x, const double t ) const
    {
        const auto& grid = _samples.grid();
        const int axis = side / 2;
        x[axis] = side % 2 ? grid.upper[axis] : grid.lower[axis];
        const auto gas = at( x, t );
        if ( !hasGas( x, t ) || isNothing( gas ) )
            return true;
        if ( _periods[axis] > 0 )
        {
            x[axis] = side % 2 ? grid.lower[axis] : grid.upper[axis];
            return areSame( gas, at( x, t ) );
        }
        return areSame( gas, gasBeyond<Dim>( _input, side, x, gas, _law ) );
    }

    //! Does the gas within a cell of a body not go through its surface?
    bool fitsBodies( const Vector<Dim>& x, const double t ) const
    {
        return std::all_of(
            _bodies.begin(), _bodies.end(),
            [&]( const auto& body )
            {
                const auto nearest = body.shape.nearest( x );
                if ( nearest.distance > _samples.grid().minSpacing() )
                    return true;
                const auto gas = at( x, t );
                double normal = 0;
                for ( int d = 0; d < Dim; ++d )
                    normal += gas.velocity[d] * nearest.normal[d];
                return isNothing( gas ) ||
                       std::abs( normal ) <=
                           tolerance * soundSpeed( gas, _law );
            } );
    }

    const Json& _input;
    std::unique_ptr<ExactSolution> _exact;
    GasLaw _law;
    Vector3 _periods;
    SampleGrid<Dim> _samples;
    std::vector<SampledBody<Dim>> _bodies;
    double _densest = 0; // of the exact start
};

} // namespace

std::vector<std::string> findExactDoubts( const Json& input )
{
    if ( !input.contains( "exact" ) )
        return {};
    switch ( input.at( "dimension" ).get<int>() )
    {
    case 1:
        return ExactDoubts<1>( input ).find();
    case 2:
        return ExactDoubts<2>( input ).find();
    default:
        return ExactDoubts<3>( input ).find();
    }
}

} // namespace Machpoint
