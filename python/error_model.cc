// The error model, (1) to (10) of the paper, on arrays (core/geometry).
#include "core/geometry/error_model.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/geometry/sphere.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/work.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr int kValuesPerTask = 4096;

// An argument of a function: its name and the range in which the function is defined.
struct Domain {
  const char* name;
  double least;
  double most;
};

constexpr Domain kDistance{"d_src_m", 0.0, kInfinity};
constexpr Domain kLatitude{"phi_rad", -kHalfPi, kHalfPi};
constexpr Domain kLatitudePastPole{"phi_rad", -kPi, kPi};
constexpr Domain kIncidence{"theta_rad", -kHalfPi, kHalfPi};
constexpr Domain kPlanDistance{"d_p_m", -kLargest, kLargest};
constexpr Domain kApart{"apart_m", 0.0, kLargest};
constexpr Domain kStep{"step_m", 0.0, kLargest};
constexpr Domain kToSide{"to_side_m", 0.0, kLargest};
constexpr Domain kToFront{"to_front_m", 0.0, kLargest};
constexpr Domain kLimitAngle{"k_deg", 45.0, 90.0};

Numbers numbers_of(const py::object& given, const Domain& domain) {
  Numbers values = Numbers::ensure(given);
  if (!values) {
    PyErr_Clear();
    throw UsageError(fmt::format("{} is neither a number nor an array of them", domain.name));
  }
  const double* data = values.data();
  for (py::ssize_t i = 0; i < values.size(); ++i) {
    if (data[i] >= domain.least && data[i] <= domain.most) continue;
    throw UsageError(fmt::format("{} is {:g}{}; it must be in {:g}..{:g}", domain.name, data[i],
                                 values.ndim() > 0 ? fmt::format(" at value {}", i) : "",
                                 domain.least, domain.most));
  }
  return values;
}

// The arguments, of one shape after NumPy's rules of broadcasting.
template <std::size_t count>
std::array<Numbers, count> broadcast(const std::array<Numbers, count>& arguments) {
  py::tuple given(count);
  for (std::size_t i = 0; i < count; ++i) given[i] = arguments[i];
  const py::sequence same = py::module_::import("numpy").attr("broadcast_arrays")(*given);
  std::array<Numbers, count> result;
  for (std::size_t i = 0; i < count; ++i) result[i] = Numbers(py::object(same[i]));
  return result;
}

// function(values of the arguments) for every element; a number where all arguments are numbers.
template <std::size_t count, typename Function>
py::object on_arrays(const std::array<py::object, count>& given,
                     const std::array<Domain, count>& domains, const Function& function) {
  std::array<Numbers, count> arguments;
  for (std::size_t i = 0; i < count; ++i) arguments[i] = numbers_of(given[i], domains[i]);
  arguments = broadcast(arguments);
  const Numbers& first = arguments[0];
  Numbers result(std::vector<py::ssize_t>(first.shape(), first.shape() + first.ndim()));
  std::array<const double*, count> inputs;
  for (std::size_t i = 0; i < count; ++i) inputs[i] = arguments[i].data();
  double* output = result.mutable_data();
  const py::ssize_t size = result.size();
  if (size > std::numeric_limits<int>::max()) {
    throw UsageError(fmt::format("the arrays have {} values; give at most 2147483647", size));
  }
  without_lock([&] {
    parallel_for(0, static_cast<int>(size), kValuesPerTask, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        std::array<double, count> values;
        for (std::size_t j = 0; j < count; ++j) values[j] = inputs[j][i];
        output[i] = std::apply(function, values);
      }
    });
  });
  if (result.ndim() == 0) return py::float_(*output);
  return result;
}

py::object latitude_shift_of(const py::object& d_src_m, const py::object& phi_rad,
                             const py::object& apart_m) {
  return on_arrays<3>({d_src_m, phi_rad, apart_m}, {kDistance, kLatitude, kApart}, &latitude_shift);
}

py::object bending_distance_of(const py::object& d_src_m, const py::object& phi_rad,
                               const py::object& theta_rad, const py::object& step_m) {
  return on_arrays<4>({d_src_m, phi_rad, theta_rad, step_m},
                      {kDistance, kLatitude, kIncidence, kStep}, &bending_distance);
}

py::object corrected_latitude_of(const py::object& d_src_m, const py::object& d_p_m,
                                 const py::object& phi_rad) {
  return on_arrays<3>({d_src_m, d_p_m, phi_rad}, {kDistance, kPlanDistance, kLatitudePastPole},
                      &corrected_latitude);
}

py::object mismatch_distance_of(const py::object& to_side_m, const py::object& to_front_m,
                                const py::object& k_deg) {
  return on_arrays<3>({to_side_m, to_front_m, k_deg}, {kToSide, kToFront, kLimitAngle},
                      [](double side, double front, double k) {
                        return mismatch_distance({side, front}, k);
                      });
}

py::object corner_angle_of(const py::object& to_side_m, const py::object& to_front_m) {
  return on_arrays<2>({to_side_m, to_front_m}, {kToSide, kToFront}, [](double side, double front) {
    return corner_angle_deg({side, front});
  });
}

// The upper end; the lower one is 45 degrees everywhere.
py::object largest_k_of(const py::object& to_side_m, const py::object& to_front_m) {
  return on_arrays<2>({to_side_m, to_front_m}, {kToSide, kToFront}, [](double side, double front) {
    return connection_range({side, front}).max_deg;
  });
}

py::array array_of_curve(const ConnectionErrorCurve::Values& values) {
  return read_only_copy(std::span<const double>(values), {std::ssize(values)});
}

// The fields of raywalk.error_model.ConnectionErrorCurve but k_deg.
py::dict connection_error_curve_of(const py::object& d_src_m, double side_m, double step_m,
                                   int viewpoints) {
  const Numbers distances = numbers_of(d_src_m, kDistance);
  const std::span<const double> distances_m(distances.data(),
                                            static_cast<std::size_t>(distances.size()));
  const ConnectionErrorCurve curve = without_lock([&] {
    return connection_error_curve({.side_m = side_m, .step_m = step_m, .viewpoints = viewpoints},
                                  distances_m);
  });
  py::dict fields;
  fields["e_m_rad"] = array_of_curve(curve.mismatch_rad);
  fields["e_b_rad"] = array_of_curve(curve.bending_rad);
  fields["e_t"] = array_of_curve(curve.total);
  fields["optimum_k_deg"] = curve.optimum_k_deg;
  return fields;
}

}  // namespace

void bind_error_model(py::module_& module) {
  module.def("latitude_shift", &latitude_shift_of);
  module.def("bending_distance", &bending_distance_of);
  module.def("corrected_latitude", &corrected_latitude_of);
  module.def("mismatch_distance", &mismatch_distance_of);
  module.def("corner_angle_deg", &corner_angle_of);
  module.def("largest_k_deg", &largest_k_of);
  module.def("connection_error_curve", &connection_error_curve_of);
}

}  // namespace raywalk::python
