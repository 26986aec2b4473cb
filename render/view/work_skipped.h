// What ViewOptions::skip_px leaves out of a corrected view, and how far that can move a pixel.
//
// Places are in pixels of the captured panoramas, and a move of so many pixels is one of so many
// columns and so many rows at most. What is left out is decided row by row of the distances, from
// their own positions, and read in runs of rows. Where two rules meet in a pixel each has half of
// skip_px, so that together they keep to it.
//
// Correction. A sample that lies less than skip_px beside the pixel of the plain cut, in columns
// and in rows, is replaced by that pixel: of both stations, or of the one in use. This needs no
// assumption. Positions that are interpolated between rows of the distances lie between those rows'
// shifts, so a row must satisfy it together with its neighbours.
//
// The second station. Both stations are asked where they saw the point, so leaving out the one with
// the smaller share s moves nothing as long as the distance is right. A measured inverse distance
// that is wrong by the part e of itself misplaces the two samples differently, to first order by e
// times the distance d between their places, and their mix by the share-weighted mean: without the
// second sample it lies s e d elsewhere. The station is left out where s d <= skip_px, which keeps
// to skip_px for all |e| <= 1, that is while the true inverse distance is between none and twice
// the measured one. At a silhouette that only one of the stations sees past, what changes is the
// ghost of the other, of weight s.
//
// The second side. The line behind with share s is left out by the same rule, with d between the
// places where both sides' acquisition points see the point, in rows that the other side sees.
//
// Blending. Outside the overlap of a connection one line alone is a source; nothing is mixed.
//
// Depth layers. Nothing is to be left out: correction snaps each pixel to its own layer, so that
// layers a column does not contain cost nothing.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"
#include "render/view/column_kernels.h"

namespace raywalk::render {

// So many columns and rows of a panorama, as tangents; up to a radian, so that they are positive.
inline MoveLimit move_limit(double move_px, PanoramaSize captured) {
  const auto tangent = [&](double rad_per_px) {
    return static_cast<float>(std::tan(std::min(move_px * rad_per_px, 1.0)));
  };
  return {tangent(kTwoPi / captured.width), tangent(kPi / captured.height)};
}

}  // namespace raywalk::render
