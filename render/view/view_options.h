// The parameters of rendering: everything that trades the speed of a view for its accuracy. What each
// costs is said beside it, per pixel of the output; "a sample" is a place in one captured panorama,
// found (some 25 operations) and read (4 pixels of 3 bytes unless `interpolation` says otherwise).
#pragma once

#include <optional>
#include <string>

#include "core/geometry/layer_count.h"
#include "core/geometry/sphere.h"

namespace raywalk::render {

// initial: 2 stations' pixels mixed as they are stored, 6 bytes and 2 operations per channel; 12
// bytes in the blend of a connection. hlf-vd: `stations_mixed` samples, twice as many in a blend,
// after a distance view. two-sided: the samples of hlf-vd from the lines in front and behind.
enum class Generation { kInitial, kHlfVd, kTwoSided };

// How a sample is read from a station's panorama: 3, 12 or 48 bytes, 0, 3 or 15 weighted sums per
// channel. Initial views as wide as the panoramas read whole columns and need none of them.
enum class Interpolation { kNearest, kLinear, kCubic };

// Of the loops that find samples. Double finds every row's own, by the library's arctangent (some
// 20 times the operations); float interpolates between the rows of coarser distances. Pictures are
// mixed in 16-bit fixed point in either case.
enum class Arithmetic { kFloat, kDouble };

// What a two-sided view does where the lines in front and behind both see a point: blend them by
// nearness, which is continuous over lines, or read the nearer alone, which halves the samples.
enum class SecondSide { kBlend, kWhereHidden };

struct ViewOptions {
  Generation generation = Generation::kHlfVd;
  double k_deg = 90.0;       // in [45, 90]; 45 is LFU, 90 is Ray-space360; costs nothing
  double overlap_deg = 5.0;  // width of the blend at a connection, in [0, 45]; there samples double
  // Depth layers, 0 = as many as `tolerance_px` needs. A count costs 12 operations per row and
  // source, and finds every row's own samples.
  int layers = 0;
  // Inverse distances to count automatic layers for; none = those of the maps around the view.
  std::optional<OmegaRange> scene{};
  double tolerance_px = 0.5;  // largest move of a pixel that the layers may cause, output pixels
  // Output width in pixels, a multiple of 4 up to 32768; 0 = as captured. Samples grow with its
  // square; below the captured width they do not fall, as larger pictures are averaged down.
  int width = 0;
  Interpolation interpolation = Interpolation::kLinear;
  Arithmetic arithmetic = Arithmetic::kFloat;
  // Around the acquisition point: both neighbours, mixed by nearness, or the nearer alone, which
  // halves the samples.
  int stations_mixed = 2;  // 1 or 2
  // Of every so many stations of a line one is used (Room::every_nth): storage falls by that factor
  // and time hardly.
  int station_stride = 1;  // at least 1
  // Maps that the view's distances are gathered from: 8 bytes and some 60 operations per pixel of
  // each map, once a view.
  int distance_maps = 4;  // 1..4
  // Stations, nearest first, that are asked for a point that the lines in use do not see: some 50
  // operations each per hidden pixel of the distances.
  int fill_stations = 32;  // 0..32
  SecondSide second_side = SecondSide::kBlend;
  // Work that changes a picture by no more than moving its pixels by so much is left out
  // (work_skipped.h): in pixels of the captured panoramas; 0 = none.
  double skip_px = 0.0;  // in [0, 4]
};

// Names as users give them, and back; throws UsageError on any other name.
std::string generation_name(Generation generation);
Generation generation_from_name(const std::string& name);
std::string interpolation_name(Interpolation interpolation);
Interpolation interpolation_from_name(const std::string& name);
std::string arithmetic_name(Arithmetic arithmetic);
Arithmetic arithmetic_from_name(const std::string& name);
std::string second_side_name(SecondSide second_side);
SecondSide second_side_from_name(const std::string& name);

// Throws UsageError on options out of range, once the width is known.
void require_view_options(const ViewOptions& options);

}  // namespace raywalk::render
