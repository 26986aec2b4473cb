// Gains of many pictures from the ratios measured between pairs of them.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace raywalk {

// log gain(from) - log gain(to) = difference, known to within `error` (standard deviation).
struct GainEquation {
  int from = 0;
  int to = 0;
  double difference = 0.0;
  double error = 1.0;
};

// The log gains of `pictures` pictures that fit the equations best. `prior_error`: what a log gain
// is expected to be off 0 by, for pictures that little or nothing is known of; infinite: nothing is
// expected, and each connected part has a mean of 0. Errors may differ by factors up to 1e4.
//
// Huber's estimate by iterative reweighting: a residual r of more than k standard errors s counts
// as k s |r|, not r^2, so a wrong ratio pulls no harder the more it is wrong (k = 1.345 keeps 95 %
// of the efficiency of least squares under normal errors; Huber, Robust Statistics, 1981).
Eigen::VectorXd solve_gain_graph(const std::vector<GainEquation>& equations, int pictures,
                                 double prior_error = std::numeric_limits<double>::infinity());

}  // namespace raywalk
