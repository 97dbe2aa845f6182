#include <drivers/study_input.hpp>

#include <drivers/input.hpp>
#include <drivers/study_effects.hpp>
#include <drivers/study_fit.hpp>
#include <drivers/study_probe.hpp>
#include <drivers/study_process.hpp>

#include <core/registry.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

namespace Machpoint
{

namespace
{

constexpr auto resolution = "grid.cells"; // what makes a line
constexpr auto solver_key = "solver";     // no part of the input

//! The programs that a study can run, by name.
const std::vector<std::string> solver_names = { "machpoint", "finite_volume" };

//! What a run can be measured by.
Family referenceFamily()
{
    return { "reference", []( const int dimension )
             {
                 Parameters run( "run", "one run for all", dimension );
                 run.anything( "set", "its settings: path -> value" );
                 Parameters known( "known", "numbers that are known",
                                   dimension );
                 known.anything( "values", "column -> number" );
                 return std::vector<Parameters>{
                     { "exact", "the scene's exact solution", dimension },
                     { "finer", "the next finer run of the line", dimension },
                     run,
                     known };
             } };
}

} // namespace

Parameters studyParameters()
{
    Parameters all( "study", "many runs of one scene, and what they cost", 0 );
    all.text( "study", "name of the study and of its output directory" )
        .nonEmpty();
    all.text( "input", "the scene: its file, as seen from that of the study" )
        .nonEmpty();
    all.choice( "kind", { "accuracy", "effects" },
                "what accuracy costs: the runs of `vary`; or what effects "
                "cost: the scene as it is, without each of its effects, and "
                "without all" )
        .defaultsTo( "accuracy" );
    all.anything( "set", "settings of all runs: an object path -> value, as "
                         "in --set" )
        .defaultsTo( Json::object() );
    all.anything( "vary", "what the runs differ in: a list of objects path -> "
                          "list of values; each object gives all combinations "
                          "of its values; only of accuracy, which needs it. "
                          "The path solver chooses machpoint or finite_volume, "
                          "the reference solver" )
        .optional();
    all.listOf( "probes", probeFamily(),
                "what is read off the grid outputs (output.every) of the "
                "second half of a run, and averaged" )
        .defaultsTo( Json::array() );
    all.text( "error", "what a run is judged by: FIELD.NORM, or "
                       "NAME.COLUMN of the series of a body or an effect, "
                       "averaged over the second half of the run, or "
                       "PROBE.COLUMN" )
        .nonEmpty()
        .defaultsTo( "density.L1" );
    all.oneOf( "reference", referenceFamily(),
               "what the error is measured against; by default the exact "
               "solution; only of accuracy" )
        .defaultsTo( Json::object( { { "type", "exact" } } ) );
    all.integer( "repeats", "how often each run is timed; the median "
                            "counts, of effects the least" )
        .atLeast( 1 )
        .atMost( 100 )
        .defaultsTo( 3 );
    return all;
}

bool isFieldError( const std::string& error )
{
    return error.ends_with( ".L1" ) || error.ends_with( ".L2" ) ||
           error.ends_with( ".Linf" );
}

namespace
{

std::vector<std::string> fieldErrors()
{
    std::vector<std::string> names;
    for ( const auto* field :
          { "density", "velocity", "pressure", "specific_internal_energy" } )
        for ( const auto* norm : { "L1", "L2", "Linf" } )
            names.push_back( fmt::format( "{}.{}", field, norm ) );
    return names;
}

//! Columns of the modules' series and of the probes. \param input resolved
std::vector<std::string> columnErrors( const Json& input, const Json& probes )
{
    std::vector<std::string> names;
    for ( const auto& probe : probes )
        names.push_back( probeColumn( probe ) );
    const int dimension = input.at( "dimension" );
    auto addColumns = [&]( const char* list, const auto& hooksOfEntry )
    {
        for ( const auto& entry : input.at( list ) )
        {
            const auto& columns = hooksOfEntry( entry, dimension ).columns;
            if ( !columns || !entry.contains( "name" ) )
                continue;
            const auto name = entry.at( "name" ).get<std::string>();
            for ( const auto& column : columns() )
                names.push_back( fmt::format( "{}.{}", name, column ) );
        }
    };
    addColumns( "boundary", boundaryHooks );
    addColumns( "physics", physicsHooks );
    return names;
}

std::string shown( const Json& value )
{
    return value.is_string() ? value.get<std::string>() : value.dump();
}

//! "conservative cubic per_cell=4": what tells a line from the others.
//! \param whole_paths or "method.name=conservative ... particles.per_cell=4"
std::string lineName( const Json& settings, const bool whole_paths )
{
    std::vector<std::string> words;
    for ( const auto& item : settings.items() )
    {
        if ( item.key() == resolution )
            continue;
        const auto& path = item.key();
        const auto value = shown( item.value() );
        if ( whole_paths )
            words.push_back( fmt::format( "{}={}", path, value ) );
        else if ( item.value().is_string() )
            words.push_back( value );
        else
            words.push_back( fmt::format(
                "{}={}", path.substr( path.rfind( '.' ) + 1 ), value ) );
    }
    return fmt::format( "{}", fmt::join( words, " " ) );
}

//! The name of the line of a run with these settings.
std::string lineOf( const Json& settings, const Study& study )
{
    const auto name = lineName( settings, study.whole_paths );
    return name.empty() ? study.name : name;
}

//! Has each line a name of its own?
bool areLinesTold( const std::vector<StudyRun>& runs )
{
    std::map<std::string, Json> lines;
    for ( const auto& run : runs )
    {
        auto settings = run.settings;
        settings.erase( resolution );
        const auto line = lines.emplace( run.line, settings ).first;
        if ( line->second != settings )
            return false;
    }
    return true;
}

void setValue( Json& input, const std::string& path, const Json& value )
{
    applyOverride( input, fmt::format( "{}={}", path, value.dump() ) );
}

//! Reads a study and collects all that is wrong with it.
class Reader
{
  public:
    explicit Reader( const std::string& file ) : _file( file ) {}

    Study read()
    {
        _written = parseJson( readFile( _file ), _file, _errors );
        if ( _written.is_object() && _written.contains( "scene" ) &&
             !_written.contains( "study" ) )
            throw InputError( { _file + ": an input of one run, not a study; "
                                        "give it to machpoint run" } );
        _json = resolve( _written, studyParameters(), _file, _errors );
        if ( _json.contains( "kind" ) && _json.at( "kind" ) == "effects" )
            _study.kind = StudyKind::effects;
        const bool has_settings = checkSettings( "/set", "set", _json );
        const bool has_matrix = isOfEffects() ? refuseMatrix() : checkMatrix();
        throwIfWrong( !_json.contains( "input" ) ||
                      !_json.at( "input" ).is_string() );
        readScene();
        throwIfWrong( _input.is_null() );
        if ( has_settings )
            applySettings();
        if ( has_matrix )
            tryMatrix();
        checkProbes();
        checkReference();
        checkError();
        throwIfWrong( true );
        makeRuns();
        throwIfWrong( true );
        return std::move( _study );
    }

  private:
    bool isOfEffects() const { return _study.kind == StudyKind::effects; }

    void fail( const std::string& place, const std::string& message )
    {
        _errors.push_back( fmt::format( "{}: {}: {}", _file, place, message ) );
    }

    //! Ends the reading when nothing more can be found.
    void throwIfWrong( const bool at_end )
    {
        if ( at_end && !_errors.empty() )
            throw InputError( _errors );
    }

    //! An object path -> value.
    bool checkSettings( const std::string& place, const char* key,
                        const Json& parent )
    {
        if ( !parent.contains( key ) )
            return false;
        const bool fits = parent.at( key ).is_object();
        if ( !fits )
            fail( place, "expected an object path -> value, as in "
                         "{ \"time.cfl\": 0.2 }" );
        return fits;
    }

    //! A list of objects path -> list of values.
    bool checkMatrix()
    {
        constexpr auto example = "as in [ { \"grid.cells\": [[100], [200]] } ]";
        if ( !_json.contains( "vary" ) )
        {
            fail( "/vary", fmt::format( "missing: a list of objects path -> "
                                        "list of values, {}",
                                        example ) );
            return false;
        }
        const auto& vary = _json.at( "vary" );
        if ( !vary.is_array() || vary.empty() )
        {
            fail( "/vary", fmt::format( "expected a list of objects path -> "
                                        "list of values, {}",
                                        example ) );
            return false;
        }
        bool fits = true;
        for ( std::size_t k = 0; k < vary.size(); ++k )
        {
            const auto place = fmt::format( "/vary/{}", k );
            const bool is_block = vary[k].is_object() && !vary[k].empty();
            if ( !is_block )
                fail( place, fmt::format( "expected an object path -> list of "
                                          "values, {}",
                                          example ) );
            fits = fits && is_block;
            for ( const auto& item : vary[k].items() )
                if ( is_block &&
                     ( !item.value().is_array() || item.value().empty() ) )
                {
                    fail( fmt::format( "{}/{}", place, item.key() ),
                          fmt::format( "expected a list of values, {}",
                                       example ) );
                    fits = false;
                }
        }
        return fits;
    }

    //! A study of effects has neither a matrix nor a choice of reference.
    bool refuseMatrix()
    {
        for ( const auto* key : { "vary", "reference" } )
            if ( _written.contains( key ) )
                fail( fmt::format( "/{}", key ),
                      "a study of effects compares the scene as it is with "
                      "the scene without each effect; leave this out" );
        return false;
    }

    void readScene()
    {
        const auto path = std::filesystem::path( _file ).parent_path() /
                          _json.at( "input" ).get<std::string>();
        try
        {
            std::vector<std::string> errors;
            _scene =
                parseJson( readFile( path.string() ), path.string(), errors );
            _input = resolveInput( _scene, path.string(), errors );
        }
        catch ( const InputError& error )
        {
            for ( const auto& message : error.messages() )
                fail( "/input", message );
        }
        // Of a study's runs the summary is wanted; how much is written, and
        // how often, would be part of the time.
        // Settings go into objects that are there.
        if ( !_input.is_null() && !_scene.contains( "method" ) )
            _scene["method"] = Json::object();
        if ( !_input.is_null() )
            _scene["output"] = { { "particles", false }, { "grid", false } };
    }

    //! Reports what each setting by itself makes wrong. Conflicts between
    //! keys are those of whole runs.
    void tryAll( const std::string& place, const Json& settings )
    {
        for ( const auto& item : settings.items() )
            tryOne( fmt::format( "{}/{}", place, item.key() ), item.key(),
                    item.value() );
    }

    void tryOne( const std::string& place, const std::string& path,
                 const Json& value )
    {
        auto input = _scene;
        std::vector<std::string> wrong;
        if ( path == solver_key )
        {
            checkSolver( place, value );
            return;
        }
        try
        {
            setValue( input, path, value );
            resolve( input, inputParameters( _input.at( "dimension" ) ), "",
                     wrong );
        }
        catch ( const InputError& error )
        {
            wrong = error.messages();
        }
        for ( const auto& message : wrong )
            fail( place,
                  message.starts_with( ": " ) ? message.substr( 2 ) : message );
    }

    void checkSolver( const std::string& place, const Json& value )
    {
        if ( std::none_of( solver_names.begin(), solver_names.end(),
                           [&]( const auto& name ) { return value == name; } ) )
            fail( place, fmt::format( "expected one of {}, got {}",
                                      fmt::join( solver_names, ", " ),
                                      value.dump() ) );
        else if ( value != solver_names[0] &&
                  !std::filesystem::exists(
                      executable( Solver::finite_volume ) ) )
            fail(
                place,
                fmt::format(
                    "{} is missing: build all of Machpoint, "
                    "or its target machpoint_reference",
                    executable( Solver::finite_volume ).filename().string() ) );
    }

    void applySettings()
    {
        if ( _json.at( "set" ).contains( solver_key ) )
            fail( fmt::format( "/set/{}", solver_key ),
                  "runs choose their solver in vary, as in "
                  "{ \"solver\": [\"finite_volume\"] }" );
        const auto errors = _errors.size();
        tryAll( "/set", _json.at( "set" ) );
        if ( errors == _errors.size() )
            for ( const auto& item : _json.at( "set" ).items() )
                setValue( _scene, item.key(), item.value() );
    }

    void tryMatrix()
    {
        const auto& vary = _json.at( "vary" );
        for ( std::size_t k = 0; k < vary.size(); ++k )
            for ( const auto& item : vary[k].items() )
                for ( std::size_t v = 0; v < item.value().size(); ++v )
                    tryOne( fmt::format( "/vary/{}/{}/{}", k, item.key(), v ),
                            item.key(), item.value()[v] );
    }

    void checkProbes()
    {
        auto& probes = _json["probes"];
        const auto place = _file + ": /probes";
        if ( std::any_of( _errors.begin(), _errors.end(),
                          [&]( const auto& error )
                          { return error.starts_with( place ); } ) )
            probes = Json::array(); // what is wrong with it has been told
        const int dimension = _input.at( "dimension" );
        std::set<std::string> names;
        for ( std::size_t k = 0; k < probes.size(); ++k )
        {
            for ( const auto& key : misfitPlaces( probes[k], dimension ) )
                fail( fmt::format( "/probes/{}/{}", k, key ),
                      fmt::format( "expected {} number(s), as the scene has "
                                   "{} axes",
                                   dimension, dimension ) );
            if ( !names.insert( probeColumn( probes[k] ) ).second )
                fail( fmt::format( "/probes/{}/name", k ),
                      "is that of another probe" );
        }
    }

    //! The values that are known: of columns, the error's among them.
    void checkKnown()
    {
        const auto& reference = _json.at( "reference" );
        if ( !reference.contains( "values" ) ||
             ( _json.contains( "error" ) && !_json.at( "error" ).is_string() ) )
            return; // which has been told
        const auto& values = reference.at( "values" );
        const auto names = columnErrors( _input, _json.at( "probes" ) );
        const auto fits = [&]( const auto& item )
        {
            return item.value().is_number() &&
                   std::find( names.begin(), names.end(), item.key() ) !=
                       names.end();
        };
        const auto items = values.items();
        if ( !values.is_object() ||
             !std::all_of( items.begin(), items.end(), fits ) ||
             !values.contains( _json.value( "error", "" ) ) )
            fail( "/reference/values",
                  fmt::format( "expected an object column -> number with the "
                               "column of /error; columns are {}",
                               fmt::join( names, ", " ) ) );
    }

    void checkReference()
    {
        if ( isOfEffects() )
        {
            _study.reference =
                _input.contains( "exact" ) ? Reference::exact : Reference::none;
            return;
        }
        const auto& reference = _json.at( "reference" );
        const auto type = reference.value( "type", "" );
        if ( type == "exact" && !_input.contains( "exact" ) )
            fail( "/reference",
                  "the scene names no exact solution; choose { \"type\": "
                  "\"finer\" } or { \"type\": \"run\", \"set\": {...} }" );
        if ( type == "run" &&
             checkSettings( "/reference/set", "set", reference ) )
            tryAll( "/reference/set", reference.at( "set" ) );
        if ( type == "known" )
            checkKnown();
        _study.reference = type == "run"     ? Reference::run
                           : type == "known" ? Reference::known
                           : type == "finer" ? Reference::finer
                                             : Reference::exact;
    }

    void checkError()
    {
        auto& error = _json.at( "error" );
        if ( !error.is_string() )
            return;
        // Changes are told in any case; an error takes an exact solution.
        if ( _study.reference == Reference::none &&
             !_written.contains( "error" ) )
        {
            error = "";
            return;
        }
        std::vector<std::string> names;
        if ( _study.reference != Reference::none )
            names = fieldErrors();
        if ( isOfEffects() || _study.reference != Reference::exact )
            for ( const auto& column :
                  columnErrors( _input, _json.at( "probes" ) ) )
                names.push_back( column );
        if ( names.empty() )
        {
            fail( "/error", "the scene has neither an exact solution nor a "
                            "body or an effect that reports a series; leave "
                            "this out" );
            return;
        }
        const auto name = error.get<std::string>();
        if ( std::find( names.begin(), names.end(), name ) != names.end() )
            return;
        const auto near = nearest( name, names );
        fail( "/error",
              fmt::format( "expected one of {}, got \"{}\"{}",
                           fmt::join( names, ", " ), name,
                           near.empty() ? ""
                                        : fmt::format( "; did you mean \"{}\"?",
                                                       near ) ) );
    }

    void makeRuns()
    {
        _study.name = _json.at( "study" );
        if ( _study.name.find_first_of( "/\\" ) != std::string::npos ||
             _study.name == "." || _study.name == ".." )
            fail( "/study", "names a directory, so it must hold no slash" );
        _study.error = _json.at( "error" );
        _study.repeats = _json.at( "repeats" );
        _study.probes = _json.at( "probes" );
        if ( _study.reference == Reference::known )
            _study.known = _json.at( "reference" ).at( "values" );
        if ( isOfEffects() || !_study.probes.empty() ||
             ( isFieldError( _study.error ) &&
               _study.reference != Reference::exact ) )
            _scene["output"]["grid"] = true;
        _study.scene = _scene;
        std::set<std::string> told;
        auto add = [&]( const Json& settings, std::vector<StudyRun>& runs,
                        const std::string& line = "" )
        {
            try
            {
                runs.push_back( makeStudyRun( _study, settings, _file ) );
                if ( !line.empty() )
                    runs.back().line = line;
            }
            catch ( const InputError& error )
            {
                for ( const auto& message : error.messages() )
                    if ( told.insert( message ).second )
                        _errors.push_back( message );
            }
        };
        if ( isOfEffects() )
        {
            add( Json::object(), _study.runs, "as it is" );
            throwIfWrong( true );
            const Json input = _study.runs.front().input;
            auto leaveOut =
                [&]( const std::string& effect, const Json& settings )
            {
                _study.effects.push_back( effect );
                add( settings, _study.runs, lineWithout( effect ) );
            };
            for ( const auto& effect : optionalEffects( input ) )
                leaveOut( effect.name, effect.off );
            leaveOut( all_effects, withoutAll( input ) );
            return;
        }
        for ( const auto& settings : expandMatrix( _json.at( "vary" ) ) )
            add( settings, _study.runs );
        if ( !areLinesTold( _study.runs ) )
        {
            _study.whole_paths = true;
            for ( auto& run : _study.runs )
                run.line = lineOf( run.settings, _study );
        }
        if ( _study.reference == Reference::run )
            add( _json.at( "reference" ).at( "set" ), _study.reference_run );
    }

    const std::string& _file;
    std::vector<std::string> _errors;
    Json _written; // the study
    Json _json;    // the same with its defaults
    Json _scene;   // as written, then with `set`
    Json _input;   // the scene resolved
    Study _study;
};

} // namespace

namespace
{
//! \throws InputError where a probe is outside the domain of a run
//! \param name of the run
void requireInside( const Json& probes, const Json& input,
                    const std::string& name )
{
    const auto& grid = input.at( "grid" );
    std::vector<std::string> errors;
    for ( std::size_t k = 0; k < probes.size(); ++k )
        for ( const auto* key : { "at", "from", "to" } )
            for ( std::size_t d = 0;
                  probes[k].contains( key ) && d < probes[k].at( key ).size();
                  ++d )
            {
                const double x = probes[k].at( key ).at( d );
                const double lower = grid.at( "lower" ).at( d );
                const double upper = grid.at( "upper" ).at( d );
                if ( x < lower || x > upper )
                    errors.push_back( fmt::format(
                        "{}: /probes/{}/{}/{}: {:g} is outside the domain, "
                        "which reaches from {:g} to {:g}",
                        name, k, key, d, x, lower, upper ) );
            }
    if ( !errors.empty() )
        throw InputError( errors );
}
} // namespace

StudyRun makeStudyRun( const Study& study, const Json& settings,
                       const std::string& file )
{
    StudyRun run{ lineOf( settings, study ), settings, study.scene };
    std::vector<std::string> words;
    for ( const auto& item : settings.items() )
    {
        if ( item.key() == solver_key )
            run.solver = item.value() == solver_names[0]
                             ? Solver::machpoint
                             : Solver::finite_volume;
        else
            setValue( run.input, item.key(), item.value() );
        words.push_back(
            fmt::format( "{}={}", item.key(), shown( item.value() ) ) );
    }
    if ( !run.input.at( "output" ).contains( "every" ) )
        run.input["output"]["every"] = run.input.at( "time" ).at( "end" );
    const auto name =
        words.empty() ? file
                      : fmt::format( "{}: {}", file, fmt::join( words, " " ) );
    run.input = resolveInput( run.input, name );
    requireInside( study.probes, run.input, name );
    return run;
}

std::vector<std::string> errorNames( const Study& study )
{
    if ( study.reference == Reference::known )
    {
        std::vector<std::string> names;
        for ( const auto& item : study.known.items() )
            names.push_back( item.key() );
        return names;
    }
    if ( study.kind == StudyKind::effects )
    {
        auto names = study.reference == Reference::exact
                         ? fieldErrors()
                         : std::vector<std::string>();
        std::vector<std::string> changing = { "density", "velocity",
                                              "pressure" };
        if ( !study.error.empty() && !isFieldError( study.error ) )
            for ( const auto& column :
                  columnErrors( study.runs.front().input, study.probes ) )
                changing.push_back( column );
        for ( const auto& name : changing )
            names.push_back( fmt::format( "{}.change", name ) );
        return names;
    }
    // Grids are kept only where they are compared.
    return isFieldError( study.error )
               ? fieldErrors()
               : columnErrors( study.runs.front().input, study.probes );
}

Study loadStudy( const std::string& file )
{
    return Reader( file ).read();
}

} // namespace Machpoint
