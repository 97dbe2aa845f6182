/*!
  \file study_advice.cpp
  \brief What the fits of a study advise, and what becomes of it.
*/
#include <drivers/study_advice.hpp>

#include <core/price.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace Machpoint
{

namespace
{

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

ExitCode reachTarget( Laboratory& laboratory, const std::string& error,
                      const double target )
{
    return Adviser( laboratory, error ).reach( target );
}

ExitCode spendBudget( Laboratory& laboratory, const std::string& error,
                      const double budget )
{
    return Adviser( laboratory, error ).spend( budget );
}

} // namespace Machpoint
