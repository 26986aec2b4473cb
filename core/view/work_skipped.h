// The work that ViewOptions::skip_px skips in a corrected view, and how far that can move a pixel.
// Positions are in pixels of the captured panoramas, and a shift of n pixels is one of at most n
// columns and n rows. What is skipped is decided for every row of the distances, from its own
// positions, and read in runs of rows. Where two rules apply to a pixel, each may use half of
// skip_px, so that together they stay within it.
// Correction. A sample less than skip_px away from the pixel of the plain cut, in columns and in
// rows, is replaced by that pixel, in both stations or in the one in use. This needs no assumption.
// Positions interpolated between rows of the distances lie between those rows' shifts, so a row
// must satisfy the condition together with its neighbours.
// The second station. Each station's sample is computed from the point's distance, so skipping the
// station of smaller share s moves nothing if the distance is right. A relative error e of the
// measured inverse distance shifts the two samples differently, to first order by e times the
// distance d between their positions, and their mix by the share-weighted mean: without the second
// sample it is shifted by s e d. The station is skipped where s d <= skip_px, which bounds the
// shift by skip_px for all |e| <= 1, that is while the true inverse distance is between zero and
// twice the measured one. At a silhouette that only one of the stations sees past, the ghost of the
// other, of weight s, changes.
// The second side. The line behind with share s is skipped by the same rule, with d the distance
// between the positions at which the acquisition points of both sides see the point, in rows that
// the other side sees.
// Blending. Outside the overlap of a connection only one line is a source; nothing is blended.
// Depth layers. Nothing can be skipped: correction snaps each pixel to its own layer, so layers
// that a column does not contain cost nothing.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"
#include "core/view/column_kernels.h"
#include "core/view/view_inputs.h"

namespace raywalk {

// Whether the options may skip some rows of a source.
inline bool skips_rows(const ViewInputs& view) {
  return view.skip_px > 0.0 || view.second_side == SecondSide::kWhereHidden;
}

// A shift of `move_px` columns and rows of a panorama as tangents; clamped to a radian, so that
// they are positive.
inline MoveLimit move_limit(double move_px, PanoramaSize captured) {
  const auto tangent = [&](double rad_per_px) {
    return static_cast<float>(std::tan(std::min(move_px * rad_per_px, 1.0)));
  };
  return {tangent(kTwoPi / captured.width), tangent(kPi / captured.height)};
}

}  // namespace raywalk
