// The error model of a 3D light field at one point: the difference in latitude between a ray read
// from a line and the ray wanted; and the limit angle k that minimises their sums over a cell.
// Equations (n) are those of the paper: "Enabling Five-Degree-of-Freedom From Low-Dimensional Light
// Fields With Extended Light Ray Acquisition Field-of-View".
//
// Metres and radians; k and the corner angle in degrees, so that 45 and 90 degrees are exact. d_src
// is the distance from the acquisition point to the source, 0 to infinity; phi is the latitude of
// the source seen from there, |phi| <= pi/2. No function returns NaN or infinity within its domain.
//
// Accuracy: each result is within 4 ulp of the exact value of its equation for the given doubles,
// unless stated. Multiplying every length by a power of two changes no bit of an angle. Arguments
// are not checked, as that would cost as much as some of the functions.
#pragma once

#include <array>

namespace raywalk {

// (2), (4): the difference in latitude between two acquisition points, the second `apart_m` >= 0
// farther from the source in the plan. With apart = d_p it is the vertical parallax phi - phi* of
// (1). Odd in phi, |result| <= |phi|, decreases with d_src and increases with apart (up to
// rounding); 0 at infinite d_src or apart = 0, phi at d_src = 0.
double latitude_shift(double d_src_m, double phi_rad, double apart_m);

// (3): the difference in plan distance to the source between the station `step_m` >= 0 further
// along the line (away from the source for theta > 0) and this one. `theta_rad` is the incidence
// angle in [-pi/2, pi/2]. |result| <= step. The result crosses zero with n = 2 d_src cos(phi)
// sin(theta) + step; where the terms of n differ in sign the bound is 4 ulp * (sum of their
// magnitudes) / |n|.
double bending_distance(double d_src_m, double phi_rad, double theta_rad, double step_m);

// Distances from a viewpoint to the two lines that meet at a corner, both >= 0 and finite; with the
// paper's cell, to_side = N/2 - x and to_front = N/2 - z.
struct CornerOffset {
  double to_side_m = 0.0;
  double to_front_m = 0.0;
};

// The angle between the front line's normal and the corner, seen from the viewpoint, in [0, 90]; 0
// in the corner itself.
double corner_angle_deg(CornerOffset corner);

// (8): the distance between the points at which the front and the side line read the ray of
// incidence `k_deg` in [45, 90]: 0 for k at or above the corner angle (a physical connection). Its
// limit is where the ray meets the corner: the error is at most 4 ulp * a / (a - b tan k), a =
// to_side, b = to_front, as if a had been off in its last digits; k counts as at the corner angle
// when it equals corner_angle_deg.
double mismatch_distance(CornerOffset corner, double k_deg);

// The sums (7) and (10) over a cell and their weighted sum (6); Fig. 11 plots these errors.

// The sampling of the sums (7) and (10); latitude rows are one degree apart.
struct CellSampling {
  double side_m = 1.0;   // N, > 0
  double step_m = 0.01;  // between stations, >= 0; the paper does not print the one it used
  int viewpoints = 49;   // per side: centres of viewpoints x viewpoints sub-cells, >= 1
};

// The errors at every whole degree of k.
struct ConnectionErrorCurve {
  static constexpr int kMinDeg = 45;  // LFU
  static constexpr int kMaxDeg = 90;  // Ray-space360
  using Values = std::array<double, kMaxDeg - kMinDeg + 1>;

  Values mismatch_rad{};        // E_m (7), falls to 0 at 90 degrees
  Values bending_rad{};         // E_b (10), grows with k
  Values total{};               // E_t (6), in [0, 2]
  int optimum_k_deg = kMaxDeg;  // of the least E_t; ties: the largest, as it connects physically
};

// The errors of a cell whose sources are at the distance `d_src_m` >= 0. The maxima in (6) are
// those over k = 45..90 degrees at the same distance, so E_m / max(E_m) is 1 at 45 and E_b /
// max(E_b) is 1 at 90; an error that is 0 at every k contributes 0. Takes about 0.1 s at 49
// viewpoints.
ConnectionErrorCurve connection_error_curve(const CellSampling& sampling, double d_src_m);

}  // namespace raywalk
