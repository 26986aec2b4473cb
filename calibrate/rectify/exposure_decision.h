// Whether measured exposures differ from each other by more than their uncertainty, and how.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

namespace raywalk::calibrate {

// The simplest of these that the measurement does not contradict is taken.
enum class ExposureModel {
  kEqual,     // no picture differs
  kLines,     // one exposure for each line
  kDrift,     // one exposure and a steady drift for each line
  kStations,  // every picture has its own
};
// "equal", "lines", "drift", "stations".
const char* exposure_model_name(ExposureModel model);

// Log light by picture, with errors that may be common to several pictures: a combination c . value
// has the variance |errors * c|^2.
struct UncertainLight {
  Eigen::VectorXd value;
  Eigen::MatrixXd errors;
  int freedom = 0;  // degrees of freedom of the errors; below 1: not testable
};

// Pictures of one line, in the order of their positions.
struct PictureLine {
  std::vector<int> pictures{};
  std::vector<double> along_m{};
};

// The largest deviation from a model, in standard errors.
struct ModelTest {
  ExposureModel model = ExposureModel::kEqual;
  double largest_t = 0.0;
  int picture = 0;  // where
  bool rejected = false;
};

struct ExposureDecision {
  ExposureModel model = ExposureModel::kEqual;
  std::vector<ModelTest> tests{};  // from the simplest model to the one taken; not kStations
  double t_limit = 0.0;            // of the tests
  double t_limit_single = 0.0;     // of a single picture
  // By picture: the measurement; what the model makes of it, and its standard error (of the
  // measurement for kEqual); what is to be corrected: fitted if it is significant, else exactly 0.
  Eigen::VectorXd measured, fitted, error, correction;
};

// The probability with which a difference is found although there is none.
inline constexpr double kSignificance = 0.01;

// A model is rejected if a picture, or a picture relative to its neighbours on the line, deviates
// from it. The probability of rejecting equal exposures that are equal is at most kSignificance
// (Bonferroni over all deviations examined). Where a model other than kEqual is taken, each picture
// is corrected if its value is significant by itself.
ExposureDecision decide_exposures(const UncertainLight& light, std::span<const PictureLine> lines);

// The probability that |t| exceeds `size` (at least 0) with `freedom` degrees of freedom, 1 to
// 1000.
double two_sided_probability(double size, int freedom);

// The |t| that is exceeded with `probability`, in (0, 1).
double two_sided_quantile(double probability, int freedom);

}  // namespace raywalk::calibrate
