#include <drivers/study_effects.hpp>

#include <drivers/input.hpp>

#include <core/price.hpp>
#include <core/registry.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace Machpoint
{

namespace
{

bool isEquationOfState( const Json& entry )
{
    const auto& factories = physicsModules<3>();
    return std::any_of( factories.begin(), factories.end(),
                        [&]( const auto& factory )
                        {
                            return factory.is_equation_of_state &&
                                   entry.at( "type" ) == factory.name;
                        } );
}

//! The effects that keys switch and that are on.
class Switches
{
  public:
    //! \param input resolved
    explicit Switches( const Json& input )
        : _dimension( input.at( "dimension" ) )
    {
        collect( inputParameters( _dimension ), input, "" );
    }

    //! Each once, though several keys may switch it.
    const std::vector<OptionalEffect>& effects() const { return _effects; }

  private:
    //! Those of the keys of an object.
    void collect( const Parameters& parameters, const Json& object,
                  const std::string& prefix )
    {
        for ( const auto& key : parameters.keys() )
        {
            const auto value = object.find( key.name );
            if ( value == object.end() )
                continue;
            const auto path = prefix + key.name;
            if ( !key.effect.empty() && *value != key.off )
                add( key.effect, path, key.off );
            if ( key.kind == Parameter::Kind::Object )
                collect( *key.nested, *value, path + "." );
            else if ( key.kind == Parameter::Kind::OneOf )
                collectOfMember( key.family, *value, path + "." );
            else if ( key.kind == Parameter::Kind::ListOf )
                for ( std::size_t k = 0; k < value->size(); ++k )
                    collectOfMember( key.family, value->at( k ),
                                     fmt::format( "{}.{}.", path, k ) );
        }
    }

    //! The same of an object that is one of a family.
    void collectOfMember( const Family& family, const Json& object,
                          const std::string& prefix )
    {
        for ( const auto& member : family.members( _dimension ) )
            if ( object.at( "type" ) == member.name() )
                collect( member, object, prefix );
    }

    void add( const std::string& effect, const std::string& path,
              const Json& off )
    {
        for ( auto& known : _effects )
            if ( known.name == effect )
            {
                known.off[path] = off;
                return;
            }
        _effects.push_back( { effect, { { path, off } } } );
    }

    int _dimension;
    std::vector<OptionalEffect> _effects;
};

//! `physics` without the entries for which `isLeftOut` holds.
template <class Predicate>
Json physicsWithout( const Json& physics, const Predicate& isLeftOut )
{
    Json rest = Json::array();
    for ( const auto& entry : physics )
        if ( !isLeftOut( entry ) )
            rest.push_back( entry );
    return { { "physics", rest } };
}

const StudyRow* findRow( const std::vector<StudyRow>& rows,
                         const std::string& line )
{
    const auto found = std::find_if( rows.begin(), rows.end(),
                                     [&]( const StudyRow& row )
                                     { return row.run.line == line; } );
    return found == rows.end() ? nullptr : &*found;
}

//! What a run takes less than another one, as measured.
Json price( const Json& whole, const Json& without )
{
    Json price;
    for ( const auto* key : { "seconds", "kernels", "steps", "array_bytes" } )
        price[key] =
            whole.at( key ).get<double>() - without.at( key ).get<double>();
    return price;
}

//! Of passes and memory that serve an effect alone; null if it has none.
Json ownCost( const Json& record, const std::string& effect )
{
    for ( const auto& entry : record.at( "effects" ) )
        if ( entry.at( "name" ) == effect &&
             ( entry.at( "kernels" ) > 0 || entry.at( "bytes" ) > 0 ) )
            return { { "kernels", entry.at( "kernels" ) },
                     { "seconds", entry.at( "share" ).get<double>() *
                                      record.at( "seconds" ).get<double>() },
                     { "bytes", entry.at( "bytes" ) } };
    return nullptr;
}

//! Columns of the table behind the prices: what changes, and the error against
//! the exact solution where there is one.
std::vector<std::string> resultNames( const Study& study )
{
    std::vector<std::string> names = { "density.change", "velocity.change",
                                       "pressure.change" };
    if ( isFieldError( study.error ) )
        names.push_back( study.error );
    else if ( !study.error.empty() )
        names.push_back( fmt::format( "{}.change", study.error ) );
    return names;
}

std::string number( const double value )
{
    return std::isnan( value ) ? "-" : fmt::format( "{:.2e}", value );
}

std::string signedBytes( const double bytes )
{
    const double size = std::abs( bytes );
    return size < 1024      ? fmt::format( "{:+.0f} B", bytes )
           : size < 1048576 ? fmt::format( "{:+.3g} KiB", bytes / 1024 )
                            : fmt::format( "{:+.3g} MiB", bytes / 1048576 );
}

//! Of a column of results: a change needs no other word than its field.
std::string heading( const std::string& name )
{
    const std::string change = ".change";
    return name.ends_with( change )
               ? name.substr( 0, name.size() - change.size() )
               : name;
}

//! A number with its sign; what rounds to nothing is +0.
std::string signedNumber( const double value, const int digits )
{
    const double unit = std::pow( 10, -digits );
    return fmt::format( "{:+.{}f}", std::abs( value ) < 0.5 * unit ? 0 : value,
                        digits );
}

double kernelsPerStep( const StudyRow& row )
{
    return row.record.at( "kernels" ).get<double>() /
           row.record.at( "steps" ).get<double>();
}

//! One line of the table. \param entry of effectsTable
//! \param whole, row the scene as it is, and without the effect
std::string formatEntry( const Study& study, const Json& entry,
                         const StudyRow& whole, const StudyRow& row )
{
    const double steps = whole.record.at( "steps" );
    const double whole_seconds = whole.record.at( "seconds" );
    std::string kernels = "-", seconds = "-";
    if ( const auto& own = entry.at( "own" ); !own.is_null() )
    {
        kernels =
            fmt::format( "{:.3g}", own.at( "kernels" ).get<double>() / steps );
        const double time = own.at( "seconds" );
        seconds = fmt::format( "{:.3f} s {:>6.1f} %", time,
                               100 * time / whole_seconds );
    }
    auto text = fmt::format( "  {:<22}{:>8}{:>19}",
                             entry.at( "effect" ).get<std::string>(), kernels,
                             seconds );
    if ( row.isFailed() )
        return fmt::format( "{}  failed: {:.60}...\n", text,
                            row.record.at( "message" ).get<std::string>() );
    if ( !row.isFinished() )
        return fmt::format( "{}  not run yet\n", text );
    auto more = [&]( const char* key )
    { return 0 - entry.at( "price" ).at( key ).get<double>(); };
    text += fmt::format(
        "{:>9}{:>11}{:>9}{:>11}{:>7}",
        signedNumber( kernelsPerStep( row ) - kernelsPerStep( whole ), 1 ),
        signedNumber( more( "seconds" ), 3 ) + " s",
        signedNumber( 100 * more( "seconds" ) / whole_seconds, 1 ) + " %",
        signedBytes( more( "array_bytes" ) ),
        signedNumber( more( "steps" ), 0 ) );
    for ( const auto& name : resultNames( study ) )
        text += fmt::format( "{:>{}}", number( row.error( name ) ),
                             heading( name ).size() + 3 );
    return text + "\n";
}

} // namespace

std::vector<OptionalEffect> optionalEffects( const Json& input )
{
    std::vector<OptionalEffect> effects;
    const auto& physics = input.at( "physics" );
    for ( const auto& entry : physics )
        if ( !isEquationOfState( entry ) )
            effects.push_back(
                { reportName( entry ),
                  physicsWithout( physics, [&]( const Json& other )
                                  { return other == entry; } ) } );
    const Switches switches( input );
    effects.insert( effects.end(), switches.effects().begin(),
                    switches.effects().end() );
    return effects;
}

Json withoutAll( const Json& input )
{
    auto settings = Json::object();
    auto bare = input;
    const Switches switches( input );
    for ( const auto& effect : switches.effects() )
        for ( const auto& item : effect.off.items() )
        {
            applyOverride(
                bare, fmt::format( "{}={}", item.key(), item.value().dump() ) );
            // Places in `physics` are others without its effects.
            if ( !item.key().starts_with( "physics." ) )
                settings[item.key()] = item.value();
        }
    setKeys( settings,
             physicsWithout( bare.at( "physics" ), []( const Json& entry )
                             { return !isEquationOfState( entry ); } ) );
    return settings;
}

std::string lineWithout( const std::string& effect )
{
    return fmt::format( "without {}", effect );
}

void addRound( Json& effects, const Json& summary )
{
    if ( effects.is_null() )
        effects = Json::array();
    for ( const auto& measured : summary.at( "effects" ) )
    {
        auto entry = std::find_if(
            effects.begin(), effects.end(),
            [&]( const Json& known )
            { return known.at( "name" ) == measured.at( "name" ); } );
        if ( entry == effects.end() )
        {
            effects.push_back( { { "name", measured.at( "name" ) },
                                 { "shares", Json::array() } } );
            entry = effects.end() - 1;
        }
        auto& known = *entry;
        known["kernels"] = measured.at( "kernels" );
        known["bytes"] = measured.at( "bytes" );
        known["shares"].push_back( measured.at( "seconds" ).get<double>() /
                                   summary.at( "wall_seconds" ).get<double>() );
        known["share"] = median( known.at( "shares" ) );
    }
}

Json effectsTable( const Study& study, const std::vector<StudyRow>& rows )
{
    const auto& whole = rows.front();
    Json table = Json::array();
    for ( const auto& effect : study.effects )
    {
        const auto* row = findRow( rows, lineWithout( effect ) );
        if ( !row ) // all of them, and there is one
            continue;
        Json entry = { { "effect", effect }, { "id", row->record.at( "id" ) } };
        entry["own"] =
            whole.isFinished() ? ownCost( whole.record, effect ) : Json();
        entry["price"] = whole.isFinished() && row->isFinished()
                             ? price( whole.record, row->record )
                             : Json();
        for ( const auto& name : resultNames( study ) )
        {
            const double value = row->error( name );
            entry["result"][name] =
                std::isnan( value ) ? Json() : Json( value );
        }
        table.push_back( entry );
    }
    return table;
}

double timeNoise( const Study& study, const std::vector<StudyRow>& rows )
{
    double noise = 0;
    for ( const auto& row : rows )
    {
        std::vector<double> rounds = row.record.at(
            study.clock == Clock::wall ? "wall_rounds" : "cpu_rounds" );
        std::sort( rounds.begin(), rounds.end() );
        if ( rounds.size() > 1 )
            noise = std::max( noise, rounds[1] - rounds[0] );
    }
    return noise;
}

std::string formatEffects( const Study& study,
                           const std::vector<StudyRow>& rows )
{
    const auto& whole = rows.front();
    auto text = fmt::format(
        "\n{}: what effects cost, {} time, least of {} run(s) each\n",
        study.name, study.clock == Clock::wall ? "wall" : "processor",
        study.repeats );
    if ( !whole.isFinished() )
        return fmt::format( "{}{}  {}\n", text, formatRow( whole, "" ),
                            whole.run.line );
    const auto& record = whole.record;
    const double error = whole.error( study.error );
    text += fmt::format(
        "as it is: {} cells, {} steps, {:.3g} kernels a step, {}, {:.3g} MiB "
        "of arrays{}\n\n",
        formatCells( whole.run.cells() ),
        record.at( "steps" ).get<std::int64_t>(), kernelsPerStep( whole ),
        formatSeconds( record.at( "seconds" ) ),
        record.at( "array_bytes" ).get<double>() / 1048576,
        std::isnan( error )
            ? ""
            : fmt::format( ", {} {:.3e}", study.error, error ) );
    text += fmt::format( "  {:<22}{:>27}{:>47}   its result changes by\n", "",
                         "its own passes", "without it the run takes" );
    text +=
        fmt::format( "  {:<22}{:>8}{:>19}{:>9}{:>20}{:>11}{:>7}", "left out",
                     "kernels", "time", "kernels", "time", "bytes", "steps" );
    for ( const auto& name : resultNames( study ) )
        text += fmt::format( "   {}", heading( name ) );
    text += "\n";
    for ( const auto& entry : effectsTable( study, rows ) )
        text += formatEntry(
            study, entry, whole,
            *findRow( rows, lineWithout( entry.at( "effect" ) ) ) );
    text += "\n  kernels: launches a step; - : works within other kernels. "
            "Changes: L1 of the\n  difference over L1 of the field as it is";
    if ( isFieldError( study.error ) )
        text += fmt::format( "; {}: without it", study.error );
    text += ".\n";
    if ( const double noise = timeNoise( study, rows ); noise > 0 )
        text += fmt::format( "  The two fastest rounds of a run differ by up "
                             "to {:.3f} s: smaller differences are noise.\n",
                             noise );
    return text;
}

} // namespace Machpoint
