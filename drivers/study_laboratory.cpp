/*!
  \file study_laboratory.cpp
  \brief Makes the runs of a study, judges them, and keeps what they tell.
*/
#include <drivers/study_laboratory.hpp>

#include <drivers/input.hpp>
#include <drivers/launch.hpp>
#include <drivers/run.hpp>
#include <drivers/study_effects.hpp>
#include <drivers/study_error.hpp>
#include <drivers/study_probe.hpp>
#include <drivers/tell.hpp>

#include <core/output.hpp>
#include <core/revision.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <utility>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

//! A run's name: FNV-1a over its input, its number of threads, what else
//! runs it than Machpoint, and what is read off it.
std::string idOf( const StudyRun& run, const Json& probes )
{
    const auto text =
        fmt::format( "{} {}{}{}", run.input.dump(), threadCount(),
                     run.solver == Solver::finite_volume
                         ? fmt::format( " finite_volume {}", finite_volume_cfl )
                         : "",
                     probes.empty() ? "" : probes.dump() );
    std::uint64_t hash = 0xcbf29ce484222325u;
    for ( const unsigned char c : text )
        hash = ( hash ^ c ) * 0x100000001b3u;
    return fmt::format( "{:016x}", hash );
}

//! Has a finished run's record all that make() puts there? Older programs told
//! less.
bool tellsAll( const Json& record )
{
    const auto keys = { "wall_rounds", "cpu_rounds", "particle_updates",
                        "steps",       "particles",  "memory_bytes",
                        "threads",     "kernels",    "array_bytes" };
    return std::all_of( keys.begin(), keys.end(),
                        [&]( const char* key )
                        { return record.contains( key ); } );
}

//! What study.json holds of a run that has not been made.
StudyRow newRow( const StudyRun& run, const Json& probes )
{
    return { run,
             { { "id", idOf( run, probes ) },
               { "line", run.line },
               { "settings", run.settings },
               { "cells", run.cells() },
               { "status", "waiting" },
               { "wall_rounds", Json::array() },
               { "cpu_rounds", Json::array() } } };
}

} // namespace

Laboratory::Laboratory( const Study& study, const fs::path& folder )
    : _study( study ), _folder( folder )
{
    requireNoRun( folder, "choose" );
    makeDirectory( folder / "runs" );
    _lock = DirectoryLock( folder );
    readFormer();
    for ( auto run : study.reference_run )
    {
        run.line = "reference";
        _reference = known( run );
    }
    for ( const auto& run : study.runs )
    {
        auto row = known( run );
        if ( !find( row.record.at( "id" ) ) ) // two ways to say the same
            _rows.push_back( std::move( row ) );
    }
    forgetGone();
}

std::size_t Laboratory::foreignRows() const
{
    return std::count_if(
        _rows.begin(), _rows.end(),
        []( const StudyRow& row )
        {
            return row.record.value( "revision", revision ) != revision ||
                   row.record.value( "precision", precision_name ) !=
                       precision_name;
        } );
}

bool Laboratory::runAll()
{
    if ( _reference && !complete( *_reference, 1 ) )
        return false;
    for ( int round = 1; round <= _study.repeats; ++round )
        for ( auto& row : _rows )
            if ( !complete( row, round ) )
                return false;
    compare();
    save();
    return true;
}

std::optional<StudyRow> Laboratory::prove( const std::string& request,
                                           const std::string& error,
                                           const StudyRow& like,
                                           const Candidate& candidate )
{
    auto settings = like.run.settings;
    settings["grid.cells"] = candidate.cells;
    auto row = known( makeStudyRun( _study, settings, _study.name ) );
    if ( const auto* measured = find( row.record.at( "id" ) ) )
        row = *measured;
    for ( int round = 1; round <= _study.repeats; ++round )
        if ( !complete( row, round ) )
            return std::nullopt;
    if ( !judgeProof( row, settings ) )
        return std::nullopt;
    const double real = row.error( error );
    const Json proof = {
        { "request", request },
        { "error", error },
        { "predicted",
          { { "seconds", candidate.seconds }, { "error", candidate.error } } },
        { "seconds", row.isFinished() ? row.record.at( "seconds" ) : Json() },
        { "value", std::isnan( real ) ? Json() : Json( real ) },
        { "row", row.record } };
    std::erase_if( _proofs.get_ref<Json::array_t&>(), [&]( const Json& old )
                   { return old.at( "request" ) == request; } );
    _proofs.push_back( proof );
    save();
    return row;
}

void Laboratory::readFormer()
{
    const auto file = _folder / "study.json";
    if ( !fs::exists( file ) )
        return;
    try
    {
        const Json former = Json::parse( readFile( file.string() ) );
        if ( former.at( "study" ) != _study.name ||
             former.at( "kind" ) != kindName( _study.kind ) )
            throw IoError( fmt::format(
                "{}: holds another study (\"{}\" of kind {}); choose "
                "another directory with --output DIR, or remove it",
                _folder.string(), former.at( "study" ).get<std::string>(),
                former.at( "kind" ).get<std::string>() ) );
        const bool is_judged = former.at( "error" ) == _study.error &&
                               former.value( "judge", Json() ) == _study.judge;
        auto keep = [&]( Json record )
        {
            // A run that was killed, or met a full disk or memory, may do
            // better. (An input was checked before.)
            const int code = record.value( "exit_code", 0 );
            const bool is_finished =
                record.at( "status" ) == "finished" && tellsAll( record );
            if ( ( is_finished && ( is_judged || judgeAnew( record ) ) ) ||
                 code == numerical_failure )
                _former[record.at( "id" )] = record;
        };
        for ( const auto& record : former.at( "rows" ) )
            keep( record );
        if ( former.contains( "reference_row" ) )
            keep( former.at( "reference_row" ) );
        for ( const auto& proof : former.at( "proofs" ) )
            keep( proof.at( "row" ) );
        if ( is_judged )
            _proofs = former.at( "proofs" );
    }
    catch ( const Json::exception& )
    {
        throw IoError( fmt::format(
            "{}: is no study of this program; move it away, or choose "
            "another directory with --output",
            file.string() ) );
    }
}

bool Laboratory::judgeAnew( Json& record ) const
{
    const auto folder = _folder / "runs" / record.at( "id" ).get<std::string>();
    if ( isFieldError( _study.error ) && _study.reference != Reference::exact &&
         !fs::exists( folder / "grid" ) )
        return false;
    for ( const auto* key : { "errors", "values", "compared_to" } )
        record.erase( key );
    try
    {
        const auto summary = readFile( ( folder / "summary.json" ).string() );
        readResults( record, folder, Json::parse( summary ) );
    }
    catch ( const std::exception& ) // whatever is amiss with its files
    {
        return false;
    }
    return true;
}

void Laboratory::readResults( Json& record, const fs::path& folder,
                              const Json& summary ) const
{
    if ( _study.kind == StudyKind::effects ||
         _study.reference == Reference::exact )
        record["errors"] = exactErrors( summary );
    if ( !isFieldError( _study.error ) )
    {
        record["values"] = seriesMeans( folder );
        if ( !_study.probes.empty() )
            setKeys( record["values"], probeMeans( folder, _study.probes ) );
    }
}

void Laboratory::forgetGone()
{
    const bool by_fields = _study.kind == StudyKind::effects ||
                           ( isFieldError( _study.error ) &&
                             ( _study.reference == Reference::finer ||
                               _study.reference == Reference::run ) );
    if ( !by_fields )
        return;
    auto forget = [&]( StudyRow& row )
    {
        if ( row.isFinished() && !fs::exists( folderOf( row ) / "grid" ) )
            row = newRow( row.run, _study.probes );
    };
    for ( auto& row : _rows )
    {
        auto* better = judgeOf( row );
        if ( !row.isFinished() || !better || better == &row ||
             row.record.value( "compared_to", Json() ) ==
                 better->record.at( "id" ) )
            continue;
        forget( row );
        forget( *better );
    }
}

StudyRow* Laboratory::judgeOf( const StudyRow& row )
{
    if ( _study.kind == StudyKind::effects )
        return &_rows.front();
    return _study.reference == Reference::run ? &*_reference : nextFiner( row );
}

StudyRow Laboratory::known( const StudyRun& run ) const
{
    auto row = newRow( run, _study.probes );
    const auto former =
        _former.find( row.record.at( "id" ).get<std::string>() );
    if ( former != _former.end() )
    {
        row.record = former->second;
        row.record["line"] = run.line;
        row.record["settings"] = run.settings;
        setSeconds( row.record );
    }
    return row;
}

const StudyRow* Laboratory::find( const std::string& id ) const
{
    for ( const auto& row : _rows )
        if ( row.record.at( "id" ) == id )
            return &row;
    return nullptr;
}

fs::path Laboratory::folderOf( const StudyRow& row ) const
{
    return _folder / "runs" / row.record.at( "id" ).get<std::string>();
}

bool Laboratory::complete( StudyRow& row, const int round )
{
    const auto made = static_cast<int>( row.record.at( "wall_rounds" ).size() );
    if ( row.isFailed() || made >= round )
        return true;
    if ( !make( row ) )
        return false;
    save(); // whatever a comparison may meet
    compare();
    save();
    std::fflush( stdout ); // in order, where both go to one file
    tell( "round {} of {} {} {}\n", round, _study.repeats,
          formatRow( row, _study.error ), row.run.line );
    return true;
}

void Laboratory::setSeconds( Json& record ) const
{
    const auto& rounds =
        record.at( _study.clock == Clock::wall ? "wall_rounds" : "cpu_rounds" );
    if ( !rounds.empty() )
        record["seconds"] =
            _study.kind == StudyKind::effects
                ? *std::min_element( rounds.begin(), rounds.end() )
                : Json( median( rounds ) );
}

bool Laboratory::make( StudyRow& row )
{
    const auto folder = folderOf( row );
    const auto input = fs::path( folder ).concat( ".json" );
    const auto text = row.run.input.dump( 2 ) + "\n";
    writeFile( input, text.data(), text.size() );
    // What an interrupted run leaves there is no result.
    row.record.erase( "compared_to" );
    const auto result = _guard.run( row.run.solver, input, folder,
                                    fs::path( folder ).concat( ".log" ) );
    if ( _guard.isInterrupted() || result.code == stopped_early )
        return false;
    auto& record = row.record;
    record["revision"] = revision;
    record["precision"] = precision_name;
    record["exit_code"] = result.code;
    if ( result.code != finished )
    {
        record["status"] = "failed";
        record["message"] =
            result.first_words.empty()
                ? fmt::format( "ended with code {}", result.code )
                : result.first_words;
        return true;
    }
    const Json summary =
        Json::parse( readFile( ( folder / "summary.json" ).string() ) );
    const double seconds = summary.at( "wall_seconds" );
    record["status"] = "finished";
    record["wall_rounds"].push_back( seconds );
    record["cpu_rounds"].push_back( result.cpu_seconds );
    setSeconds( record );
    // The yardstick has no particles, and counts no kernels.
    record["particle_updates"] = std::llround(
        summary.value( "particle_updates_per_second", 0.0 ) * seconds );
    record["steps"] = summary.at( "steps" );
    record["particles"] = summary.value( "particles_final", 0 );
    record["memory_bytes"] =
        summary.value( "peak_memory_bytes", result.peak_memory );
    record["threads"] = summary.at( "threads" );
    record["kernels"] = summary.value( "kernels", std::int64_t( 0 ) );
    record["array_bytes"] =
        summary.value( "peak_array_bytes", std::int64_t( 0 ) );
    if ( _study.kind == StudyKind::effects )
        addRound( record["effects"], summary );
    readResults( record, folder, summary );
    return true;
}

void Laboratory::compare()
{
    for ( auto& row : _rows )
        if ( _study.kind == StudyKind::effects )
            tellChanges( row );
        else if ( _study.reference == Reference::run )
            compare( row, *_reference );
        else if ( _study.reference == Reference::known )
            compareToKnown( row );
        else if ( _study.reference == Reference::finer )
        {
            if ( const auto* next = nextFiner( row ) )
                compare( row, *next );
            else // now the finest; of a former call it may not have been
            {
                row.record.erase( "errors" );
                row.record.erase( "compared_to" );
            }
        }
}

void Laboratory::tellChanges( StudyRow& row ) const
{
    const auto& whole = _rows.front();
    auto& record = row.record;
    const Json& id = whole.record.at( "id" );
    if ( &row == &whole || !row.isFinished() || !whole.isFinished() ||
         record.value( "compared_to", Json() ) == id )
        return;
    setKeys( record["errors"],
             gridChanges( folderOf( row ), folderOf( whole ), row.run.input ) );
    if ( record.contains( "values" ) )
        for ( const auto& value : record.at( "values" ).items() )
        {
            const auto before =
                whole.record.at( "values" ).value( value.key(), Json() );
            record["errors"][fmt::format( "{}.change", value.key() )] =
                value.value().is_number() && before.is_number() && before != 0
                    ? Json( std::abs( value.value().get<double>() /
                                          before.get<double>() -
                                      1 ) )
                    : Json();
        }
    record["compared_to"] = id;
}

StudyRow* Laboratory::nextFiner( const StudyRow& row )
{
    StudyRow* next = nullptr;
    for ( auto& other : _rows )
    {
        const double cells = cellCount( other.run.cells() );
        if ( other.run.line == row.run.line && !other.isFailed() &&
             cells > cellCount( row.run.cells() ) &&
             ( !next || cells < cellCount( next->run.cells() ) ) )
            next = &other;
    }
    return next;
}

void Laboratory::compare( StudyRow& row, const StudyRow& better ) const
{
    auto& record = row.record;
    const Json& id = better.record.at( "id" );
    if ( !row.isFinished() || !better.isFinished() ||
         record.value( "compared_to", Json() ) == id )
        return;
    if ( id == record.at( "id" ) ) // it is the reference itself
        record["errors"] = Json::object();
    else if ( isFieldError( _study.error ) )
        record["errors"] =
            gridErrors( folderOf( row ), folderOf( better ), row.run.input );
    else
    {
        record["errors"] = Json::object();
        for ( const auto& value : record.at( "values" ).items() )
            record["errors"][value.key()] = distance(
                value.value(),
                better.record.at( "values" ).value( value.key(), Json() ) );
    }
    record["compared_to"] = id;
}

void Laboratory::compareToKnown( StudyRow& row ) const
{
    if ( !row.isFinished() )
        return;
    row.record["errors"] = Json::object();
    for ( const auto& known : _study.known.items() )
        row.record["errors"][known.key()] =
            distance( row.record.at( "values" ).value( known.key(), Json() ),
                      known.value() );
}

Json Laboratory::distance( const Json& a, const Json& b )
{
    return a.is_number() && b.is_number()
               ? Json( std::abs( a.get<double>() - b.get<double>() ) )
               : Json();
}

bool Laboratory::judgeProof( StudyRow& row, Json settings )
{
    if ( _study.reference == Reference::run )
        compare( row, *_reference );
    if ( _study.reference == Reference::known )
        compareToKnown( row );
    if ( _study.reference == Reference::finer && !row.isFailed() )
    {
        for ( auto& n : settings.at( "grid.cells" ) )
            n = 2 * n.get<std::int64_t>();
        auto finer = known( makeStudyRun( _study, settings, _study.name ) );
        if ( !complete( finer, 1 ) )
            return false;
        compare( row, finer );
    }
    return true;
}

void Laboratory::save() const
{
    const auto json =
        makeStudyJson( _study, _rows, _reference ? &*_reference : nullptr,
                       _proofs )
            .dump( 2, ' ', false, Json::error_handler_t::replace ) +
        "\n";
    writeFile( _folder / "study.json", json.data(), json.size() );
    const auto csv = makeStudyCsv( _study, _rows );
    writeFile( _folder / "study.csv", csv.data(), csv.size() );
}

} // namespace Machpoint
