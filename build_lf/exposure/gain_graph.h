// Least-squares gains of a set of pictures from ratios measured between pairs.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace raywalk::build_lf {

// log gain(from) - log gain(to) = difference, with standard deviation `error` > 0.
struct GainEquation {
  int from = 0;
  int to = 0;
  double difference = 0.0;
  double error = 1.0;
};

// The log gains of `pictures` pictures that best fit the equations; each connected component has
// mean 0. Errors may differ by factors up to 1e4.
//
// Huber's estimate by iterative reweighting: a residual r of more than k standard errors s counts
// as k s |r|, not r^2, which bounds the influence of outliers (k = 1.345 keeps 95 % of the
// efficiency of least squares under normal errors; Huber, Robust Statistics, 1981).
Eigen::VectorXd solve_gain_graph(const std::vector<GainEquation>& equations, int pictures);

}  // namespace raywalk::build_lf
