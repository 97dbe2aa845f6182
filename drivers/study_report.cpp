#include <drivers/study_report.hpp>

#include <drivers/study_effects.hpp>

#include <core/price.hpp>
#include <core/revision.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <thread>
#include <utility>

namespace Machpoint
{

double StudyRow::error( const std::string& name ) const
{
    const auto errors = record.find( "errors" );
    if ( !isFinished() || errors == record.end() || !errors->contains( name ) ||
         !errors->at( name ).is_number() )
        return std::numeric_limits<double>::quiet_NaN();
    return errors->at( name );
}

double median( std::vector<double> values )
{
    std::sort( values.begin(), values.end() );
    const auto middle = values.size() / 2;
    return values.size() % 2 ? values[middle]
                             : 0.5 * ( values[middle - 1] + values[middle] );
}

std::vector<Line> makeLines( const std::vector<StudyRow>& rows,
                             const std::string& error )
{
    std::vector<const StudyRow*> finished;
    for ( const auto& row : rows )
        if ( row.isFinished() )
            finished.push_back( &row );
    std::vector<Line> lines;
    for ( const auto* row : finished )
        if ( std::none_of( lines.begin(), lines.end(),
                           [&]( const Line& line )
                           { return line.name == row->run.line; } ) )
            lines.push_back( { row->run.line,
                               row->run.input.at( "dimension" ),
                               {},
                               {},
                               {} } );
    std::stable_sort(
        finished.begin(), finished.end(),
        []( const StudyRow* a, const StudyRow* b )
        { return cellCount( a->run.cells() ) < cellCount( b->run.cells() ); } );
    for ( const auto* row : finished )
        for ( auto& line : lines )
            if ( line.name == row->run.line )
            {
                line.cells.push_back( row->run.cells() );
                line.seconds.push_back( row->record.at( "seconds" ) );
                line.errors.push_back( row->error( error ) );
            }
    return lines;
}

std::vector<std::size_t> rowsOnFront( const std::vector<StudyRow>& rows,
                                      const std::string& error )
{
    std::vector<Point> points;
    for ( const auto& row : rows )
        points.push_back( { row.isFinished()
                                ? row.record.at( "seconds" ).get<double>()
                                : std::numeric_limits<double>::quiet_NaN(),
                            row.error( error ) } );
    return paretoFront( points );
}

namespace
{

//! "model name" of the first processor; empty where the system has no such
//! file.
std::string processorName()
{
    std::ifstream stream( "/proc/cpuinfo" );
    std::string line;
    while ( std::getline( stream, line ) )
        if ( line.starts_with( "model name" ) )
            return line.substr( std::min( line.find( ": " ), line.size() - 2 ) +
                                2 );
    return "";
}

template <class T>
Json orNull( const std::optional<T>& value )
{
    return value ? Json( *value ) : Json();
}

const char* clockName( const Clock clock )
{
    return clock == Clock::wall ? "wall" : "processor";
}

Json lawsJson( const std::vector<Line>& lines )
{
    Json json = Json::array();
    for ( const auto& line : lines )
    {
        const auto laws = fitLaws( line );
        json.push_back( { { "line", line.name },
                          { "dimension", line.dimension },
                          { "runs", line.cells.size() },
                          { "time_exponent",
                            laws.cost ? Json( laws.cost->exponent ) : Json() },
                          { "time_scatter",
                            laws.cost ? Json( laws.cost->scatter ) : Json() },
                          { "order", orNull( laws.order ) },
                          { "error_scatter",
                            laws.error ? Json( laws.error->scatter ) : Json() },
                          { "halving_takes", orNull( laws.halving ) } } );
    }
    return json;
}

//! A field of a CSV file, in quotes where it needs them.
std::string csvField( const std::string& text )
{
    if ( text.find_first_of( ",\"\n" ) == std::string::npos )
        return text;
    std::string quoted = "\"";
    for ( const char c : text )
        quoted.append( c == '"' ? 2 : 1, c );
    return quoted + "\"";
}

std::string csvValue( const Json& record, const std::string& key )
{
    const auto found = record.find( key );
    if ( found == record.end() || found->is_null() )
        return "";
    return csvField( found->is_string() ? found->get<std::string>()
                                        : found->dump() );
}

} // namespace

std::string kindName( const StudyKind kind )
{
    return kind == StudyKind::effects ? "effects" : "accuracy";
}

std::string referenceName( const Reference reference )
{
    // In the order of Reference.
    constexpr const char* names[] = { "none", "exact", "finer", "run",
                                      "known" };
    return names[static_cast<int>( reference )];
}

Json makeStudyJson( const Study& study, const std::vector<StudyRow>& rows,
                    const StudyRow* reference, const Json& proofs )
{
    Json json;
    json["study"] = study.name;
    const bool of_effects = study.kind == StudyKind::effects;
    json["kind"] = kindName( study.kind );
    json["scene"] = study.scene.at( "scene" );
    json["dimension"] = study.scene.at( "dimension" );
    json["error"] = study.error;
    json["reference"] = referenceName( study.reference );
    json["judge"] = study.judge;
    json["repeats"] = study.repeats;
    json["clock"] = clockName( study.clock );
    json["revision"] = revision;
    json["precision"] = precision_name;
    json["machine"] = { { "processor", processorName() },
                        { "cores", std::thread::hardware_concurrency() } };
    json["rows"] = Json::array();
    for ( const auto& row : rows )
        json["rows"].push_back( row.record );
    if ( reference )
        json["reference_row"] = reference->record;
    json["pareto"] = Json::array();
    if ( !of_effects )
        for ( const auto k : rowsOnFront( rows, study.error ) )
            json["pareto"].push_back( rows[k].record.at( "id" ) );
    json["laws"] =
        of_effects ? Json::array() : lawsJson( makeLines( rows, study.error ) );
    if ( of_effects )
    {
        json["effects"] = effectsTable( study, rows );
        json["time_noise"] = timeNoise( study, rows );
    }
    json["proofs"] = proofs;
    json["input"] = study.scene;
    return json;
}

std::string makeStudyCsv( const Study& study,
                          const std::vector<StudyRow>& rows )
{
    std::vector<std::string> paths; // that any row varies
    for ( const auto& row : rows )
        for ( const auto& item : row.run.settings.items() )
            if ( std::find( paths.begin(), paths.end(), item.key() ) ==
                 paths.end() )
                paths.push_back( item.key() );
    const std::vector<std::string> measured = {
        "seconds",      "particle_updates", "steps",   "particles",
        "memory_bytes", "threads",          "kernels", "array_bytes" };
    const auto names = errorNames( study );

    std::vector<std::string> head = { "id", "line", "status", "cell_count" };
    using Words = std::vector<std::string>;
    for ( const Words* more : { &std::as_const( paths ), &measured, &names } )
        for ( const auto& name : *more )
            head.push_back( csvField( name ) );
    head.push_back( "message" );
    std::string text = fmt::format( "{}\n", fmt::join( head, "," ) );
    for ( const auto& row : rows )
    {
        std::vector<std::string> fields = {
            csvValue( row.record, "id" ), csvValue( row.record, "line" ),
            csvValue( row.record, "status" ),
            fmt::format( "{:.0f}", cellCount( row.run.cells() ) ) };
        for ( const auto& path : paths )
            fields.push_back( csvValue( row.run.settings, path ) );
        for ( const auto& key : measured )
            fields.push_back( csvValue( row.record, key ) );
        for ( const auto& name : names )
        {
            const double error = row.error( name );
            fields.push_back( std::isnan( error ) ? "" : Json( error ).dump() );
        }
        fields.push_back( csvValue( row.record, "message" ) );
        text += fmt::format( "{}\n", fmt::join( fields, "," ) );
    }
    return text;
}

std::string formatRow( const StudyRow& row, const std::string& error )
{
    const auto head =
        fmt::format( "{:>13} cells", formatCells( row.run.cells() ) );
    // A message says first what happened; study.csv has all of it.
    if ( row.isFailed() )
        return fmt::format( "{}  failed: {:.60}...", head,
                            row.record.at( "message" ).get<std::string>() );
    if ( !row.isFinished() )
        return fmt::format( "{}  not run yet", head );
    const double e = row.error( error );
    const double updates = row.record.at( "particle_updates" );
    return fmt::format(
        "{}  {:>10}  {:>10}  {:>11}  {:>7.1f} MiB", head,
        formatSeconds( row.record.at( "seconds" ) ),
        std::isnan( e ) ? "-" : fmt::format( "{:.3e}", e ),
        updates > 0 ? fmt::format( "{:.3g} M", 1e-6 * updates ) : "-",
        row.record.at( "memory_bytes" ).get<double>() / 1048576 );
}

namespace
{

//! "time ~ cells^1.9, error ~ h^0.9; halving this error takes 4.1 times the
//! time"
std::string formatLaws( const Line& line )
{
    const auto laws = fitLaws( line );
    if ( !laws.cost )
        return "";
    auto text = fmt::format( "time ~ cells^{:.2f}", laws.cost->exponent );
    if ( laws.order )
        text += fmt::format( ", error ~ h^{:.2f}", *laws.order );
    if ( laws.halving )
        text += fmt::format( "; halving this error takes {:.3g} times the time",
                             *laws.halving );
    else if ( laws.is_too_fast )
        text +=
            "; a fall too fast for a scheme of second order, so these grids "
            "are too coarse for a law";
    else if ( laws.order )
        text += "; finer grids do not lessen this error";
    return text;
}

} // namespace

std::string formatStudy( const Study& study, const std::vector<StudyRow>& rows )
{
    const auto front = rowsOnFront( rows, study.error );
    auto text = fmt::format(
        "\n{}: {} time, median of {} run(s) each\n{:>19}  {:>10}  {:>10}  "
        "{:>11}  {:>11}\n",
        study.name, clockName( study.clock ), study.repeats, "", "time",
        study.error, "updates", "memory" );
    std::vector<std::string> lines; // also those that have failed throughout
    for ( const auto& row : rows )
        if ( std::find( lines.begin(), lines.end(), row.run.line ) ==
             lines.end() )
            lines.push_back( row.run.line );
    const auto fitted = makeLines( rows, study.error );
    for ( const auto& name : lines )
    {
        text += fmt::format( "\n  {}\n", name );
        for ( std::size_t k = 0; k < rows.size(); ++k )
            if ( rows[k].run.line == name )
                text += fmt::format(
                    "{}{}\n", formatRow( rows[k], study.error ),
                    std::find( front.begin(), front.end(), k ) != front.end()
                        ? "  *"
                        : "" );
        for ( const auto& line : fitted )
            if ( line.name == name && line.cells.size() > 1 )
                text += fmt::format( "  {}\n", formatLaws( line ) );
    }
    text += fmt::format( "\n  (laws of the {} finest runs)\n", fitted_runs );
    text += "\n  Pareto front (*): no other run is as fast and as accurate\n";
    for ( const auto k : front )
        text += fmt::format( "{}  {}\n", formatRow( rows[k], study.error ),
                             rows[k].run.line );
    return text;
}

} // namespace Machpoint
