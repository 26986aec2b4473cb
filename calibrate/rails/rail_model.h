// The model of a rail: positions and attitudes of its stations as functions of the slider's
// position.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/rotation.h"

namespace raywalk::calibrate {

// The planned position of a line, and the scale of its parameters.
struct RailFrame {
  LineAxis axis = LineAxis::kX;
  Eigen::Vector3d middle_m{0, 0, 0};  // world, planned, at the rail position rail_middle_m
  double rail_middle_m = 0.0;
  double half_length_m = 1.0;  // the outermost stations are at u = -1 and 1

  double u_of(double rail_m) const { return (rail_m - rail_middle_m) / half_length_m; }
};

// The Legendre polynomials are orthogonal over the line, so bow and twist are independent of
// offset, direction and rotation.
inline double legendre2(double u) { return 0.5 * (3.0 * u * u - 1.0); }
inline double legendre3(double u) { return 0.5 * u * (5.0 * u * u - 3.0); }

// Indices of a rail's parameters; metres and radians. Rotation vectors are in world axes and apply
// to the planned attitudes.
struct RailParameter {
  enum : int {
    kOffset = 0,        // x, y, z of the middle relative to the plan
    kHeading = 3,       // turns +z towards +x
    kTilt = 4,          // raises the end of larger rail positions
    kRotation = 5,      // 3
    kBow = 8,           // across, up by P2
    kSBow = 10,         // across, up by P3
    kTwist = 12,        // 3, by u
    kCurvedTwist = 15,  // 3, by P2
    kCount = 18
  };
};

using RailParameters = std::array<double, RailParameter::kCount>;

template <typename T>
struct RailAxes {
  Eigen::Matrix<T, 3, 1> direction;
  Eigen::Matrix<T, 3, 1> across;  // horizontal; towards +z of a line along x, +x of one along z
  Eigen::Matrix<T, 3, 1> up;
};

template <typename T>
RailAxes<T> rail_axes(LineAxis axis, const T& heading, const T& tilt) {
  using std::cos;
  using std::sin;
  using Vector = Eigen::Matrix<T, 3, 1>;
  const T c = cos(heading);
  const T s = sin(heading);
  const Vector towards_x(c, T(0), -s);
  const Vector towards_z(s, T(0), c);
  const Vector& level = axis == LineAxis::kX ? towards_x : towards_z;
  const Vector& across = axis == LineAxis::kX ? towards_z : towards_x;
  const Vector upwards(T(0), T(1), T(0));
  return {level * cos(tilt) + upwards * sin(tilt), across, upwards * cos(tilt) - level * sin(tilt)};
}

template <typename T>
Eigen::Matrix<T, 3, 1> rail_position(const RailFrame& frame, const T* parameters, double rail_m) {
  using P = RailParameter;
  const RailAxes<T> axes = rail_axes(frame.axis, parameters[P::kHeading], parameters[P::kTilt]);
  const double u = frame.u_of(rail_m);
  const T across = parameters[P::kBow] * legendre2(u) + parameters[P::kSBow] * legendre3(u);
  const T up = parameters[P::kBow + 1] * legendre2(u) + parameters[P::kSBow + 1] * legendre3(u);
  const Eigen::Map<const Eigen::Matrix<T, 3, 1>> offset(parameters + P::kOffset);
  return frame.middle_m.cast<T>() + offset + axes.direction * T(rail_m - frame.rail_middle_m) +
         axes.across * across + axes.up * up;
}

// The rotation vector from a station's planned attitude to the predicted one.
template <typename T>
Eigen::Matrix<T, 3, 1> rail_rotation(const RailFrame& frame, const T* parameters, double rail_m) {
  using P = RailParameter;
  using Vector = Eigen::Map<const Eigen::Matrix<T, 3, 1>>;
  const double u = frame.u_of(rail_m);
  return Vector(parameters + P::kRotation) + Vector(parameters + P::kTwist) * T(u) +
         Vector(parameters + P::kCurvedTwist) * T(legendre2(u));
}

// The planned attitude of a frame.
inline Eigen::Matrix3d planned_attitude(const CaptureFrame& frame) {
  return world_from_camera(frame.nominal_attitude.value_or(Attitude{}));
}

RailFrame rail_frame(const CaptureSet& set, int line);

// The typical distance of neighbouring stations, metres: thresholds are relative to it, so that
// they hold for grids of any size.
double station_spacing_m(const CaptureSet& set);

}  // namespace raywalk::calibrate
