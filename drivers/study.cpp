#include <drivers/study.hpp>

#include <drivers/input.hpp>
#include <drivers/study_effects.hpp>
#include <drivers/study_error.hpp>
#include <drivers/study_probe.hpp>
#include <drivers/study_process.hpp>
#include <drivers/study_report.hpp>
#include <drivers/tell.hpp>

#include <core/file.hpp>
#include <core/output.hpp>
#include <core/price.hpp>
#include <core/revision.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace fs = std::filesystem;

namespace Machpoint
{

namespace
{

//! A run's name: FNV-1a over its input, the threads that it may use, what else
//! runs it than Machpoint, and what is read off it.
std::string idOf( const StudyRun& run, const Json& probes )
{
    const char* threads = std::getenv( "OMP_NUM_THREADS" );
    const auto text =
        fmt::format( "{} {}{}{}", run.input.dump(), threads ? threads : "",
                     run.solver == Solver::finite_volume
                         ? fmt::format( " finite_volume {}", finite_volume_cfl )
                         : "",
                     probes.empty() ? "" : probes.dump() );
    std::uint64_t hash = 0xcbf29ce484222325u;
    for ( const unsigned char c : text )
        hash = ( hash ^ c ) * 0x100000001b3u;
    return fmt::format( "{:016x}", hash );
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

//! The decimal number that a text begins with, 0 if with none, and what
//! follows.
std::pair<double, std::string> leadingNumber( const std::string& text )
{
    double number = 0;
    const char* end = text.data() + text.size();
    const auto rest = std::from_chars( text.data(), end, number ).ptr;
    return { number, std::string( rest, end ) };
}

//! An error that is to be reached.
struct Target
{
    std::string name;
    double value = 0;
};

Target parseTarget( const std::string& text, const Study& study )
{
    const auto equals = text.find( '=' );
    const auto names = errorNames( study );
    Target target{ text.substr( 0, equals ) };
    const auto [number, rest] = leadingNumber(
        equals == std::string::npos ? "" : text.substr( equals + 1 ) );
    target.value = number;
    if ( !rest.empty() || !( number > 0 ) || !std::isfinite( number ) )
        throw InputError( { fmt::format(
            "--target {}: expected NAME=VALUE with a value > 0, as in {}=1e-3",
            text, study.error ) } );
    if ( std::find( names.begin(), names.end(), target.name ) == names.end() )
    {
        const auto near = nearest( target.name, names );
        throw InputError( { fmt::format(
            "--target {}: this study tells {}{}", text,
            fmt::join( names, ", " ),
            near.empty() ? ""
                         : fmt::format( "; did you mean \"{}\"?", near ) ) } );
    }
    return target;
}

//! \return seconds
double parseBudget( const std::string& text )
{
    const auto [number, rest] = leadingNumber( text );
    const std::map<std::string, double> units = {
        { "", 1 }, { "s", 1 }, { "min", 60 }, { "h", 3600 } };
    const auto unit = units.find( rest );
    if ( unit == units.end() || !( number > 0 ) || !std::isfinite( number ) )
        throw InputError( { fmt::format(
            "--budget {}: expected a time > 0, as in 20s, 3min or 1h",
            text ) } );
    return number * unit->second;
}

//! The runs of a study, made one by one, and the directory that they are in.
class Laboratory
{
  public:
    Laboratory( const Study& study, const fs::path& folder )
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
    }

    const std::vector<StudyRow>& rows() const { return _rows; }

    //! Rows that another program has measured.
    std::size_t foreignRows() const
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

    //! Makes all runs, in rounds, so that whatever slows the machine for a
    //! while hits all alike. \return were they all made?
    bool runAll()
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

    //! Proves a prediction. \return the run; none when interrupted
    std::optional<StudyRow> prove( const std::string& request,
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
              { { "seconds", candidate.seconds },
                { "error", candidate.error } } },
            { "seconds",
              row.isFinished() ? row.record.at( "seconds" ) : Json() },
            { "value", std::isnan( real ) ? Json() : Json( real ) },
            { "row", row.record } };
        std::erase_if( _proofs.get_ref<Json::array_t&>(), [&]( const Json& old )
                       { return old.at( "request" ) == request; } );
        _proofs.push_back( proof );
        save();
        return row;
    }

  private:
    //! What an earlier call has measured.
    void readFormer()
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
            const bool is_judged =
                former.at( "error" ) == _study.error &&
                former.at( "reference" ) == referenceName( _study.reference );
            auto keep = [&]( Json record )
            {
                // A run that was killed, or met a full disk or memory, may do
                // better. (An input was checked before.)
                const int code = record.value( "exit_code", 0 );
                const bool is_finished = record.at( "status" ) == "finished";
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

    //! Another error, or one against something else, is asked of a run than
    //! before. \return false where its results are not there any more
    bool judgeAnew( Json& record ) const
    {
        const auto folder =
            _folder / "runs" / record.at( "id" ).get<std::string>();
        if ( isFieldError( _study.error ) && !fs::exists( folder / "grid" ) )
            return false;
        for ( const auto* key : { "errors", "values", "compared_to" } )
            record.erase( key );
        try
        {
            const auto summary =
                readFile( ( folder / "summary.json" ).string() );
            readResults( record, folder, Json::parse( summary ) );
        }
        catch ( const IoError& )
        {
            return false;
        }
        catch ( const Json::exception& )
        {
            return false;
        }
        return true;
    }

    //! What a run by itself tells of its errors.
    void readResults( Json& record, const fs::path& folder,
                      const Json& summary ) const
    {
        if ( _study.kind == StudyKind::effects ||
             _study.reference == Reference::exact )
            record["errors"] = exactErrors( summary );
        if ( !isFieldError( _study.error ) )
        {
            record["values"] = seriesMeans( folder );
            if ( !_study.probes.empty() )
                setKeys( record["values"],
                         probeMeans( folder, _study.probes ) );
        }
    }

    StudyRow known( const StudyRun& run ) const
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

    const StudyRow* find( const std::string& id ) const
    {
        for ( const auto& row : _rows )
            if ( row.record.at( "id" ) == id )
                return &row;
        return nullptr;
    }

    fs::path folderOf( const StudyRow& row ) const
    {
        return _folder / "runs" / row.record.at( "id" ).get<std::string>();
    }

    //! Makes a run unless it has been made in this round.
    //! \return false when interrupted
    bool complete( StudyRow& row, const int round )
    {
        const auto made =
            static_cast<int>( row.record.at( "wall_rounds" ).size() );
        if ( row.isFailed() || made >= round )
            return true;
        if ( !make( row ) )
            return false;
        compare();
        save();
        std::fflush( stdout ); // in order, where both go to one file
        tell( "round {} of {} {} {}\n", round, _study.repeats,
              formatRow( row, _study.error ), row.run.line );
        return true;
    }

    //! The middle of the rounds, by the clock that counts. Of effects the
    //! least: their price is a difference, and what disturbs a run only adds to
    //! it.
    void setSeconds( Json& record ) const
    {
        const auto& rounds = record.at(
            _study.clock == Clock::wall ? "wall_rounds" : "cpu_rounds" );
        if ( !rounds.empty() )
            record["seconds"] =
                _study.kind == StudyKind::effects
                    ? *std::min_element( rounds.begin(), rounds.end() )
                    : Json( median( rounds ) );
    }

    //! \return false when interrupted
    bool make( StudyRow& row )
    {
        const auto folder = folderOf( row );
        const auto input = fs::path( folder ).concat( ".json" );
        const auto text = row.run.input.dump( 2 ) + "\n";
        writeFile( input, text.data(), text.size() );
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
        {
            addRound( record["effects"], summary );
            record.erase( "compared_to" ); // what changes comes on top
        }
        readResults( record, folder, summary );
        return true;
    }

    //! Errors of the rows that are measured by other runs.
    void compare()
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

    //! How far a run without an effect is from the scene as it is.
    void tellChanges( StudyRow& row ) const
    {
        const auto& whole = _rows.front();
        auto& record = row.record;
        const Json& id = whole.record.at( "id" );
        if ( &row == &whole || !row.isFinished() || !whole.isFinished() ||
             record.value( "compared_to", Json() ) == id )
            return;
        setKeys(
            record["errors"],
            gridChanges( folderOf( row ), folderOf( whole ), row.run.input ) );
        if ( record.contains( "values" ) )
            for ( const auto& value : record.at( "values" ).items() )
            {
                const auto before =
                    whole.record.at( "values" ).value( value.key(), Json() );
                record["errors"][fmt::format( "{}.change", value.key() )] =
                    value.value().is_number() && before.is_number() &&
                            before != 0
                        ? Json( std::abs( value.value().get<double>() /
                                              before.get<double>() -
                                          1 ) )
                        : Json();
            }
        record["compared_to"] = id;
    }

    const StudyRow* nextFiner( const StudyRow& row ) const
    {
        const StudyRow* next = nullptr;
        for ( const auto& other : _rows )
        {
            const double cells = cellCount( other.run.cells() );
            if ( other.run.line == row.run.line && !other.isFailed() &&
                 cells > cellCount( row.run.cells() ) &&
                 ( !next || cells < cellCount( next->run.cells() ) ) )
                next = &other;
        }
        return next;
    }

    void compare( StudyRow& row, const StudyRow& better ) const
    {
        auto& record = row.record;
        const Json& id = better.record.at( "id" );
        if ( !row.isFinished() || !better.isFinished() ||
             record.value( "compared_to", Json() ) == id )
            return;
        if ( id == record.at( "id" ) ) // it is the reference itself
            record["errors"] = Json::object();
        else if ( isFieldError( _study.error ) )
            record["errors"] = gridErrors( folderOf( row ), folderOf( better ),
                                           row.run.input );
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

    void compareToKnown( StudyRow& row ) const
    {
        if ( !row.isFinished() )
            return;
        row.record["errors"] = Json::object();
        for ( const auto& known : _study.known.items() )
            row.record["errors"][known.key()] = distance(
                row.record.at( "values" ).value( known.key(), Json() ),
                known.value() );
    }

    //! |a - b|; null unless both are numbers.
    static Json distance( const Json& a, const Json& b )
    {
        return a.is_number() && b.is_number()
                   ? Json( std::abs( a.get<double>() - b.get<double>() ) )
                   : Json();
    }

    //! The error of a run that is not among the rows. \return false when
    //! interrupted
    bool judgeProof( StudyRow& row, Json settings )
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

    void save() const
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

    const Study& _study;
    fs::path _folder;
    DirectoryLock _lock;
    ProcessGuard _guard;
    std::vector<StudyRow> _rows;
    std::optional<StudyRow> _reference;
    std::map<std::string, Json> _former; // by id
    Json _proofs = Json::array();
};

//! What the fits advise, and what becomes of it.
class Adviser
{
  public:
    Adviser( Laboratory& laboratory, std::string error )
        : _laboratory( laboratory ), _error( std::move( error ) ),
          _rows( laboratory.rows() )
    {
        // Settings of Machpoint are asked for; the yardstick is none.
        std::erase_if( _rows, []( const StudyRow& row )
                       { return row.run.solver != Solver::machpoint; } );
    }

    //! The fastest run with such an error.
    ExitCode reach( const double target )
    {
        return advise(
            fmt::format( "{}={:g}", _error, target ), "the fastest run",
            [&]( const auto& lines ) { return cheapest( lines, target ); },
            []( const auto& lines ) { return mostAccurate( lines, infinity ); },
            [&]( const StudyRow& row )
            { return row.error( _error ) <= target; } );
    }

    //! The most accurate run within such a time.
    ExitCode spend( const double budget )
    {
        double used = 0;
        const auto code = advise(
            fmt::format( "{:g}s", budget ), "the most accurate run",
            [&]( const auto& lines ) { return mostAccurate( lines, budget ); },
            []( const auto& lines ) { return cheapest( lines, infinity ); },
            [&]( const StudyRow& row )
            {
                used = row.record.at( "seconds" );
                return used <= budget;
            } );
        if ( code == finished && used < 0.5 * budget )
            fmt::print( "more time is left: the fits are trusted {}\n", trust );
        return code;
    }

  private:
    static constexpr double infinity = std::numeric_limits<double>::infinity();
    //! How often a run that misses teaches the fits before they give up.
    static constexpr int attempts = 4;
    static inline const std::string trust = fmt::format(
        "up to {} times the cells of the finest run along each axis; let the "
        "study vary finer grids, or other settings",
        farthest_refinement );

    /*!
      \brief Chooses, runs, and chooses anew with what that run has shown.
      \param choose, chooseNearest lines -> optional candidate
      \param keeps row -> is it what was asked for?
    */
    template <class Choose, class Nearest, class Keeps>
    ExitCode advise( const std::string& request, const char* what,
                     const Choose& choose, const Nearest& chooseNearest,
                     const Keeps& keeps )
    {
        for ( int attempt = 0; attempt < attempts; ++attempt )
        {
            const auto lines = makeLines( _rows, _error );
            const auto choice = choose( lines );
            tellUnbelieved( request, lines );
            if ( !choice )
            {
                tellNearest( request, lines, chooseNearest( lines ) );
                return numerical_failure;
            }
            fmt::print( "\n{}: by the fits {} is {}\n", request, what,
                        named( lines, *choice ) );
            const auto row = _laboratory.prove(
                request, _error, like( lines[choice->line].name ), *choice );
            if ( !row )
                return stopped_early;
            if ( !row->isFinished() )
            {
                fmt::print( "{}\n", formatRow( *row, _error ) );
                return numerical_failure;
            }
            compare( *choice, *row );
            if ( keeps( *row ) )
            {
                fmt::print( "{}: kept\n", request );
                return finished;
            }
            fmt::print( "{}: missed\n", request );
            _rows.push_back( *row );
        }
        return numerical_failure;
    }

    static std::string named( const std::vector<Line>& lines,
                              const Candidate& candidate )
    {
        return fmt::format( "{}, {} cells", lines[candidate.line].name,
                            formatCells( candidate.cells ) );
    }

    static void tellUnbelieved( const std::string& request,
                                const std::vector<Line>& lines )
    {
        std::vector<std::string> names;
        for ( const auto& line : lines )
            if ( const auto order = unbelievedOrder( line ) )
                names.push_back(
                    fmt::format( "{} (h^{:.1f})", line.name, *order ) );
        if ( !names.empty() )
            fmt::print( "\n{}: between the two finest runs the error falls "
                        "faster than a scheme of second order can, so these "
                        "grids are too coarse for a law, and finer ones are "
                        "expected to be no better: {}\n",
                        request, fmt::join( names, ", " ) );
    }

    static void tellNearest( const std::string& request,
                             const std::vector<Line>& lines,
                             const std::optional<Candidate>& nearest )
    {
        fmt::print( "\n{}: out of reach. The fits are trusted {}\n", request,
                    trust );
        if ( nearest )
            fmt::print( "nearest by the fits is {}: {:.3g} in {}\n",
                        named( lines, *nearest ), nearest->error,
                        formatSeconds( nearest->seconds ) );
    }

    //! A run of this line.
    const StudyRow& like( const std::string& line ) const
    {
        return *std::find_if( _rows.begin(), _rows.end(),
                              [&]( const StudyRow& row )
                              { return row.run.line == line; } );
    }

    void compare( const Candidate& predicted, const StudyRow& real ) const
    {
        const double seconds = real.record.at( "seconds" );
        const double error = real.error( _error );
        auto difference = []( const double a, const double b )
        { return fmt::format( "{:+.0f} %", 100 * ( b / a - 1 ) ); };
        auto show = [&]( const char* head, const std::string& time,
                         const std::string& value )
        { fmt::print( "{:>12}  {:>12}  {:>12}\n", head, time, value ); };
        show( "", "time", _error );
        show( "predicted", formatSeconds( predicted.seconds ),
              fmt::format( "{:.3e}", predicted.error ) );
        show( "real", formatSeconds( seconds ),
              fmt::format( "{:.3e}", error ) );
        show( "", difference( predicted.seconds, seconds ),
              difference( predicted.error, error ) );
    }

    Laboratory& _laboratory;
    std::string _error;
    std::vector<StudyRow> _rows; // the study's, and what has been proven
};

} // namespace

ExitCode runStudy( const std::string& file, const StudyOptions& options )
{
    auto study = loadStudy( file );
    if ( options.clock == "processor" )
        study.clock = Clock::processor;
    const bool of_effects = study.kind == StudyKind::effects;
    if ( of_effects && !( options.target.empty() && options.budget.empty() ) )
        throw InputError( { fmt::format(
            "{}: --target and --budget choose among the runs of a study of "
            "kind accuracy; this one is of effects",
            file ) } );
    std::optional<Target> target;
    if ( !options.target.empty() )
        target = parseTarget( options.target, study );
    std::optional<double> budget;
    if ( !options.budget.empty() )
        budget = parseBudget( options.budget );
    if ( options.dry_run )
    {
        for ( const auto& run : study.runs )
            fmt::print( "{:>13} cells  {}\n", formatCells( run.cells() ),
                        run.line );
        fmt::print( "{}: {} runs, {} time(s) each\n", file, study.runs.size(),
                    study.repeats );
        return finished;
    }

    const fs::path folder = options.output.empty()
                                ? fs::path( "out/studies" ) / study.name
                                : fs::path( options.output );
    Laboratory laboratory( study, folder );
    if ( const auto foreign = laboratory.foreignRows() )
        tell( "machpoint: {} runs in {} are of another build and "
              "kept; to make them anew, remove the directory\n",
              foreign, folder.string() );
    if ( !laboratory.runAll() )
    {
        tell( "machpoint: stopped; to go on, repeat the "
              "command\n" );
        return stopped_early;
    }
    const auto& rows = laboratory.rows();
    fmt::print( "{}", of_effects ? formatEffects( study, rows )
                                 : formatStudy( study, rows ) );
    auto code = ( of_effects && rows.front().isFailed() ) ||
                        std::all_of( rows.begin(), rows.end(),
                                     []( const StudyRow& row )
                                     { return row.isFailed(); } )
                    ? numerical_failure
                    : finished;
    if ( target && code == finished )
        code = Adviser( laboratory, target->name ).reach( target->value );
    if ( budget && code == finished )
        code = Adviser( laboratory, study.error ).spend( *budget );
    fmt::print( "output: {}\n", folder.string() );
    return code;
}

} // namespace Machpoint
