// The station spacing that a scene requires: plenoptic sampling (Chai, Tong, Chan, Shum: "Plenoptic
// Sampling", SIGGRAPH 2000) for panoramas along a rail.
//
// A view reads each ray from the two stations on either side of the point A where the ray crosses
// the line, and blends them. Take A in the middle of two stations `step` apart, and a source at
// distance d = 1 / w from A, at the angle psi to the rail. A station t further along the rail
// sees it turned by the angle that t and the source span,
//
//   parallax(t) = atan2(t sin psi, d - t cos psi)                 (~ t w sin psi),
//
// because the source lies at (d cos psi - t, d sin psi) from there. A renderer that takes the
// source to be at the inverse distance w_0 instead moves each station's sample by the parallax
// of w_0; what is left, from the two stations with t = +- step / 2, leaves two copies apart by
//
//   ghost = 2 atan2(h (w - w_0), 1 + h^2 w w_0),  h = step / 2,
//
// at psi = 90 degrees: 2 (atan(h w) - atan(h w_0)) in a form without cancellation. No other
// direction is worse as long as both distances are at least 1.21 steps: with x = h w, y = h
// w_0 and B = 1 + x y, the two residuals add up to atan2(2 (x - y) B sin psi, B^2 - (x + y)^2 +
// 4 x y sin^2 psi), which grows with sin psi as long as (1 - x^2)(1 - y^2) >= 4 x y, that is x, y
// <= tan 22.5 degrees. Across the rail, no other place between the stations is worse either: atan
// is concave there, so the sum of the two angles is largest where they are equal. Away from the
// middle and at an oblique angle the ghost can be larger, by at most the factor (1 + m^2 / 4) / (1
// - m^2), m = step max(w, w_0): the slope of parallax(t) over w is t sin psi / (1 - 2 t
// w cos psi + t^2 w^2) <= t / (1 - m^2). For sources ten steps away that is 1.3 %.
//
// |w - w_0| depends on what is known of the distances:
//   nothing     w_0 = 0 (blended in place, the vertical cut): ghost of the nearest source;
//   one depth   w_0 in the middle of the range, Chai's 1 / z_opt = (1 / z_min + 1 / z_max) / 2:
//               half the range;
//   N layers    equally spaced in w: 1 / (2 N) of the range;
//   distances   their own error.
// For small angles the largest step is tolerance / |w - w_0|. Chai's critical sampling,
// where the spectra of the light field's copies touch, is a disparity range of two pixels between
// stations: one pixel to either side of the optimal depth, a tolerance of 1 px here.
//
// Not covered: occlusion and view-dependent appearance (reflections). Distances do not help where a
// station does not see the source.
//
// Lengths are metres, inverse distances 1/m (0: infinitely far), angles radians. A tolerance in
// pixels of a panorama of width W is an angle of tolerance_px * 2 pi / W. Results are within 1e-14
// of the exact value of the formula, relative, unless stated; nothing is NaN within its domain.
// Arguments are not checked.
#pragma once

namespace raywalk {

// Inverse distances of a scene, 1/m; 0 is infinitely far. 0 <= min <= max.
struct InverseRange {
  double min = 0.0;
  double max = 0.0;

  friend bool operator==(const InverseRange&, const InverseRange&) = default;
};

// The angle, radians, of `tolerance_px` pixels of a panorama `width_px` > 0 pixels wide.
double angle_of_pixels(double tolerance_px, int width_px);

// Half a layer: the largest error, 1/m, when inverse distances are quantised to `layers` >= 1
// layers. One layer is Chai's constant depth.
double inverse_error_of_layers(InverseRange scene, int layers);

// The largest spacing, metres, that keeps every ghost of a scene within `tolerance_rad` when the
// inverse distances used are off by up to `inverse_error` >= 0, 1/m; infinity if there is no limit.
// The relative error is up to 1e-14 / r where the two steps at which the ghost equals the tolerance
// nearly coincide (r: their difference relative to their sum).
double spacing_needed(InverseRange scene, double inverse_error, double tolerance_rad);
// The same when samples are not moved.
double spacing_needed_without_depth(InverseRange scene, double tolerance_rad);

// The largest ghost of a scene, radians, at a spacing when samples are not moved.
double largest_ghost_without_depth(InverseRange scene, double spacing_m);

// The distance, metres, beyond which sources stay within the tolerance at a spacing when samples
// are not moved.
double nearest_distance_resolved(double spacing_m, double tolerance_rad);

// The number of depth layers a view needs.
//
// HLF-VD can correct in N layers, equally spaced in inverse distance. The inverse distance of a
// pixel is then off by at most half a layer, and phi* by at most half a layer times |d alpha / d
// w|, where alpha = phi* + asin(q), q = d_p w sin phi* (law of sines), w = 1 / d_src:
//
//   d alpha / d w = d_p sin phi* / sqrt(1 - q^2) <= d_p / sqrt(1 - q^2).
//
// The slope is unbounded as q approaches 1 (the ray grazes the layer's circle), so the count is
// computed for q = sin 80 deg and holds for every pixel with a smaller q.
//
// Layers needed to keep the error of phi* within `tolerance_rad` (> 0) at the largest d_p of a
// view, metres. In [1, 65536].
int layers_for_tolerance(InverseRange range, double largest_d_p_m, double tolerance_rad);

}  // namespace raywalk
