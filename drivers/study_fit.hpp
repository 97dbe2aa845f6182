/*!
  \file study_fit.hpp
  \brief Layer 7: the arithmetic of a study: the runs of a matrix, power laws,
  the Pareto front, and what a line of runs predicts. Pure functions.
*/
#ifndef MACHPOINT_STUDY_FIT_HPP
#define MACHPOINT_STUDY_FIT_HPP

#include <core/parameters.hpp>
#include <core/price.hpp>
#include <core/types.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace Machpoint
{

/*!
  \brief All combinations of the values of each block, the last path varying
  fastest; what two blocks have in common counts once.
  \param blocks list of objects: path -> list of values, not empty
  \return one object for each combination: path -> value
*/
std::vector<Json> expandMatrix( const Json& blocks );

//! A measured pair; both are > 0 where a law is fitted.
struct Point
{
    double x = 0, y = 0;
};

//! y = factor x^exponent.
struct PowerLaw
{
    double factor = 0;
    double exponent = 0;
    //! Root mean square of log( y / law ) as a factor: 1 is a perfect fit.
    double scatter = 1;
};

//! Least squares in the logarithms; none for fewer than two different x.
//! Points that have no logarithm are left out.
std::optional<PowerLaw> fitPowerLaw( const std::vector<Point>& points );

/*!
  \brief y at x as measured points have it: along straight lines between
  neighbours in the logarithms, the outermost ones continued.
  \param points sorted by x, at least one; a single one is a constant
*/
double predict( const std::vector<Point>& points, double x );

/*!
  \brief Those that no other one beats in both; cheapest first.
  \param points x: cost, y: error; a NaN is on no front
  \return indices
*/
std::vector<std::size_t> paretoFront( const std::vector<Point>& points );

//! Runs that differ in their cells alone, coarsest first.
struct Line
{
    std::string name;  //!< what its runs have in common
    int dimension = 1; //!< Dim
    std::vector<std::vector<std::int64_t>> cells; //!< [runs][Dim]
    std::vector<double> seconds;                  //!< [runs]
    std::vector<double> errors;                   //!< [runs]; NaN: not known
};

//! Number of cells of a grid.
double cellCount( const std::vector<std::int64_t>& cells );

//! How many of the finest runs of a line its laws are fitted to: coarser ones
//! tell of the time that each step takes whatever its work, and of grids that
//! do not resolve the flow.
constexpr std::size_t fitted_runs = 3;

//! An error that falls with more than this order, which leaves the schemes'
//! some scatter, tells of grids too coarse for a law.
constexpr double too_fast = 1.25 * highest_order;

//! What the finest runs of a line tell together. h ~ cells^(-1/Dim).
struct Laws
{
    std::optional<PowerLaw> cost;  //!< seconds ~ cells^a
    std::optional<PowerLaw> error; //!< error ~ cells^(-p/Dim)
    std::optional<double> order;   //!< p
    //! Does the error fall `too_fast`, over these runs or between the two
    //! finest?
    bool is_too_fast = false;
    //! 2^(a Dim / p): time that half the error takes, over that of the error;
    //! none where the error does not fall, or too fast.
    std::optional<double> halving;
};

//! Least squares in the logarithms, of the `fitted_runs` finest runs for which
//! a number is known.
Laws fitLaws( const Line& line );

//! A setting of a line, with what it is expected to cost and to miss by.
struct Candidate
{
    std::size_t line = 0;            //!< its place in the list of lines
    std::vector<std::int64_t> cells; //!< [Dim]
    double seconds = 0;              //!< expected
    double error = 0;                //!< expected
};

//! How far beyond its finest run, along each axis, a line is believed.
constexpr std::int64_t farthest_refinement = 2;

//! The order that the two finest runs of a line with an error tell, where it is
//! `too_fast`: beyond them the error is then taken for that of the finest.
std::optional<double> unbelievedOrder( const Line& line );

/*!
  \brief The settings that a line can predict, from its coarsest run to
  `farthest_refinement` times its finest one; of a line with a single error that
  run.

  Cells are multiples of what those of the runs have in common, so that
  discontinuities and bodies lie on the grid as they do there.
  \param number of the line, for Candidate::line
  \return coarsest first; none where no error is known
*/
std::vector<Candidate> candidates( const Line& line, std::size_t number );

//! The fastest candidate with error <= target.
std::optional<Candidate> cheapest( const std::vector<Line>& lines,
                                   double target );

//! The candidate of least error with seconds <= budget.
std::optional<Candidate> mostAccurate( const std::vector<Line>& lines,
                                       double budget );

} // namespace Machpoint

#endif
