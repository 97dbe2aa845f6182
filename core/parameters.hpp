/*!
  \file parameters.hpp
  \brief Declared input parameters: strict parsing, checking, defaults, help.

  Whoever reads an input declares its keys once, as \c Parameters. From that
  one declaration follow the check of an input (\c resolve), its help text
  (\c describe) and its JSON Schema (\c jsonSchema). Nothing here knows what
  the keys mean.
*/
#ifndef MACHPOINT_CORE_PARAMETERS_HPP
#define MACHPOINT_CORE_PARAMETERS_HPP

#include <core/errors.hpp>

#include <nlohmann/json.hpp>

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace Machpoint
{

//! JSON that keeps the order of the keys of the input.
using Json = nlohmann::ordered_json;

//! Sets the keys of one object in another, as Json::update is there for. That
//! of nlohmann-json 3.11 leaves the other keys of an ordered object without a
//! parent (its pull request 5017), which its assertions in debug builds refuse.
void setKeys( Json& object, const Json& keys );

//! A wrong input: one message for each thing that is wrong with it.
class InputError : public std::runtime_error, public KnownError
{
  public:
    //! \param[in] messages What is wrong, one line each.
    explicit InputError( std::vector<std::string> messages );

    //! The messages one by one; \c what() joins them by newlines.
    const std::vector<std::string>& messages() const { return _messages; }

  private:
    std::vector<std::string> _messages;
};

class Parameters;

/*!
  \brief Objects that a "type" key tells apart, such as all shapes.

  The members are asked for only when they are needed, so that a family may
  contain itself (a union of shapes is a shape). A family's name identifies it:
  two families of equal name must be the same.
*/
struct Family
{
    //! What the members are, in one word.
    std::string name;

    //! The members that exist in 1, 2 or 3 dimensions; all of them for 0.
    std::function<std::vector<Parameters>( int dimension )> members;
};

/*!
  \brief One declared key. Made by \c Parameters; the builder methods refine it.

  A key is required unless it has a default or is optional.
*/
struct Parameter
{
    //! What kind of value the key takes: see the methods of Parameters, which
    //! have the same names.
    enum class Kind
    {
        Number,
        Integer,
        Boolean,
        Text,
        Choice,
        Vector,
        IntegerVector,
        Points,
        Object,
        OneOf,
        ListOf,
        Anything
    };

    //! Unit of the value, for the help text.
    Parameter& unit( std::string text );
    //! Where the parameter comes from: a paper, an equation.
    Parameter& source( std::string text );
    //! The key may be absent and then has this value. An empty list is
    //! Json::array(), an empty object Json::object(): {} would be null.
    Parameter& defaultsTo( Json value );
    //! The key may be absent and then stays absent in the resolved input, or
    //! whoever declares it fills it in. \param otherwise the default, in words
    Parameter& optional( std::string otherwise = "absent" );
    //! Each number must be > bound. Like the next three, this applies to
    //! numbers, whole numbers, and every entry of vectors and points.
    Parameter& above( double bound );
    //! Each number must be >= bound.
    Parameter& atLeast( double bound );
    //! Each number must be < bound.
    Parameter& below( double bound );
    //! Each number must be <= bound.
    Parameter& atMost( double bound );
    //! A list needs at least one entry, a text at least one character.
    Parameter& nonEmpty();
    //! The key drives an effect that a run can do without. \param effect its
    //! name, as in the table at the end of a run \param off the value at which
    //! nothing of it acts: no kernel runs for it and no memory is held
    Parameter& switches( std::string effect, Json off );

    //! \name What has been declared
    //! By the methods above, and those of Parameters; what was not is empty.
    //!@{
    Kind kind = Kind::Number;
    std::string name;
    std::string description;
    std::string unit_text;
    std::string source_text;
    std::optional<Json> default_value;
    bool is_optional = false;
    std::string otherwise; //!< of what is optional
    bool is_non_empty = false;
    std::optional<double> greater_than;
    std::optional<double> minimum;
    std::optional<double> less_than;
    std::optional<double> maximum;
    std::string effect; //!< that it switches; empty: none
    Json off;
    //! Of a choice.
    std::vector<std::string> options;
    //! Of an object.
    std::shared_ptr<const Parameters> nested;
    //! Of oneOf and listOf.
    Family family;
    //!@}
};

/*!
  \brief The declared keys of one JSON object.

  Every declaring method returns a reference to the new key, which stays valid
  as more keys are declared.
*/
class Parameters
{
  public:
    /*!
      \param[in] name The value of "type" that chooses this object in a family,
                      or else what the object is called.
      \param[in] summary What it is, in one line.
      \param[in] dimension Number of axes, 1 to 3, or 0 for any: a vector then
                           has one to three entries.
      \throws std::logic_error if there can be no such dimension.
    */
    Parameters( std::string name, std::string summary, int dimension );

    //! The value of "type", or what the object is called.
    const std::string& name() const { return _name; }
    //! What it is, in one line.
    const std::string& summary() const { return _summary; }
    //! Number of axes, or 0 for any.
    int dimension() const { return _dimension; }
    //! All keys in declared order.
    const std::deque<Parameter>& keys() const { return _keys; }

    //! \name Declaring a key
    //! \throws std::logic_error if the name is declared already.
    //!@{

    //! A finite number; a whole number will do.
    Parameter& number( std::string name, std::string description );
    //! A whole number of 64 bits, written without point or exponent.
    Parameter& integer( std::string name, std::string description );
    //! true or false.
    Parameter& boolean( std::string name, std::string description );
    //! Any text.
    Parameter& text( std::string name, std::string description );
    //! One of the given texts.
    Parameter& choice( std::string name, std::vector<std::string> options,
                       std::string description );
    //! Numbers [Dim].
    Parameter& vector( std::string name, std::string description );
    //! Whole numbers [Dim].
    Parameter& integerVector( std::string name, std::string description );
    //! Numbers [n][Dim].
    Parameter& points( std::string name, std::string description );
    //! An object with keys of its own. It may be absent if each of them may,
    //! and then resolves to their defaults.
    Parameter& object( std::string name, Parameters nested,
                       std::string description );
    //! An object whose "type" chooses from the family.
    Parameter& oneOf( std::string name, Family family,
                      std::string description );
    //! A list of objects whose "type" chooses from the family.
    Parameter& listOf( std::string name, Family family,
                       std::string description );
    //! Any JSON, which whoever declares it checks.
    Parameter& anything( std::string name, std::string description );
    //!@}

  private:
    Parameter& add( Parameter::Kind kind, std::string name,
                    std::string description );

    std::string _name;
    std::string _summary;
    int _dimension;
    // A deque, because references to keys must outlive later declarations.
    std::deque<Parameter> _keys;
};

/*!
  \brief Parse JSON strictly.

  On top of what JSON itself forbids (comments, trailing commas, NaN, bytes
  that are not UTF-8, ...) these are errors: a key given twice, a number beyond
  the range of double, nesting beyond 64 levels.

  \param[in] text The document.
  \param[in] file Its name, for the messages.
  \return The document, keys in the order in which they were written.
  \throws InputError with file:line:column and the reason, or the place of each
          duplicate key.
*/
Json parseJson( const std::string& text, const std::string& file );

//! The same, but goes on after a key given twice, whose first value counts: all
//! else that is wrong with the document can be told, too.
//! \param[in,out] errors One line is appended for each such key.
Json parseJson( const std::string& text, const std::string& file,
                std::vector<std::string>& errors );

/*!
  \brief Check an input against its declaration and fill in the defaults.

  Accepts whatever JSON there may be: it reports, and never throws for it.

  \param[in] input The JSON object to check.
  \param[in] parameters Its declaration. The keys of \c parameters are all that
             may occur: "type" is a key only inside a family.
  \param[in] file Name of the input, for the messages.
  \param[in,out] errors One line is appended for each thing that is wrong, as
                 in: input/sod.json: /grid/cells/0: must be > 0, got 0
  \return The input with every default, keys in declared order; complete only
          if no error was added.
*/
Json resolve( const Json& input, const Parameters& parameters,
              const std::string& file, std::vector<std::string>& errors );

/*!
  \brief What is wrong with the defaults of a declaration, as "/gain: must be >
  0, got -1". Those that choose from a family are left to \c resolve.
*/
std::vector<std::string> wrongDefaults( const Parameters& parameters );

/*!
  \brief Change one value of an input by its path.

  The path must lead to a list entry that exists, or to a key, new or not, of
  an object that exists. A new key is not judged here: \c resolve will.

  \param[in,out] input The input; unchanged if this throws.
  \param[in] assignment path=value, as in method.basis=cubic,
             grid.cells=[400], physics.1.linear=0.3, physics[1].linear=0.3.
             The value is JSON, or else a bare word, which is taken as text.
  \throws InputError with the remedy.
*/
void applyOverride( Json& input, const std::string& assignment );

//! Help text: a table of all keys, those of nested objects under dotted names.
//! \param name of keys of this name alone, or dotted name; empty: of all
//! \return empty: there is no key of that name
std::string describe( const Parameters& parameters,
                      const std::string& name = "" );

/*!
  \brief JSON Schema (draft 7) of the declared object.

  Families are definitions, referred to by name. The schema is laxer than
  \c resolve in two points that draft 7 cannot express: it takes 3.0 for a whole
  number and lets numbers exceed 64 bits.
*/
Json jsonSchema( const Parameters& parameters );

/*!
  \brief The candidate that a misspelt word probably meant.

  Fewest edits in the sense of Damerau and Levenshtein (insert, delete or
  replace a character, swap two neighbours), upper and lower case being equal;
  at most about a third of the characters may differ.

  \return The nearest candidate, the first among equals; "" if none is near.
*/
std::string nearest( const std::string& word,
                     const std::vector<std::string>& candidates );

} // namespace Machpoint

#endif
