/*!
  \file study_input.cpp
  \brief A study file, read and checked.
*/
#include <drivers/study_input.hpp>

#include <drivers/input.hpp>
#include <drivers/input_conflicts.hpp>
#include <drivers/study_effects.hpp>
#include <drivers/study_fit.hpp>
#include <drivers/study_probe.hpp>
#include <drivers/study_process.hpp>
#include <drivers/study_run.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace Machpoint
{

namespace
{

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
        if ( _input.is_null() )
            return;
        // Settings go into objects that are there.
        if ( !_scene.contains( "method" ) )
            _scene["method"] = Json::object();
        // Of a study's runs the summary is wanted; how much is written, and
        // how often, would be part of the time.
        _scene["output"] = { { "particles", false }, { "grid", false } };
        _scene.erase( "checkpoint" );
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
            if ( probes[k].contains( "to" ) &&
                 probes[k].at( "to" ) == probes[k].at( "from" ) )
                fail( fmt::format( "/probes/{}/to", k ),
                      "must be another place than from" );
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
        if ( const auto fault = fileNameFault( _study.name ); !fault.empty() )
            fail( "/study", fault );
        _study.error = _json.at( "error" );
        _study.judge = _json.value( "reference", Json() );
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

Study loadStudy( const std::string& file )
{
    return Reader( file ).read();
}

} // namespace Machpoint
