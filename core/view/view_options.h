// The rendering parameters, which trade the speed of a view for its accuracy. Comments give the
// cost of each per output pixel. A sample is one position in a captured panorama, computed (some 25
// operations) and read (4 pixels of 3 bytes, depending on `interpolation`).
#pragma once

#include <optional>
#include <string>

#include "core/geometry/layer_count.h"
#include "core/geometry/sphere.h"

namespace raywalk {

// initial: the stored pixels of 2 stations mixed, 6 bytes and 2 operations per channel; 12 bytes in
// the blend of a connection. hlf-vd: `stations_mixed` samples, twice as many in a blend, after a
// distance view. two-sided: the samples of hlf-vd from the lines in front and behind.
enum class Generation { kInitial, kHlfVd, kTwoSided };

// How a sample is read from a station's panorama: 3, 12 or 48 bytes, 0, 3 or 15 weighted sums per
// channel. Initial views of the captured width read whole columns without samples.
enum class Interpolation { kNearest, kLinear, kCubic };

// Precision in which sample positions are computed. Double computes the position of every row with
// the library's arctangent (some 20 times the operations); float interpolates positions between the
// rows of coarser distances. Pictures are mixed in 16-bit fixed point in either case.
enum class Arithmetic { kFloat, kDouble };

// Where the lines in front and behind both see a point, a two-sided view either blends them by
// nearness, which is continuous when the viewpoint crosses a line, or reads only the nearer one,
// which halves the samples.
enum class SecondSide { kBlend, kWhereHidden };

struct ViewOptions {
  Generation generation = Generation::kHlfVd;
  double k_deg = 90.0;  // in [45, 90]; 45 is LFU, 90 is Ray-space360; costs nothing
  // Width of the blend at a connection, which doubles the samples there.
  double overlap_deg = 5.0;  // in [0, 45]
  // Number of depth layers, 0 = as many as `tolerance_px` needs. An explicit number costs 12
  // operations per row and source, and computes the position of every row.
  int layers = 0;
  // Range of inverse distances for automatic layers; none = that of the maps around the view.
  std::optional<OmegaRange> scene{};
  double tolerance_px = 0.5;  // largest shift of a pixel caused by automatic layers, output pixels
  // Output width in pixels, a multiple of 4 up to 32768; 0 = size_as_captured (renderer.h). The
  // number of samples grows with its square; much smaller pictures cost as much as captured ones,
  // since they are rendered larger and averaged down.
  int width = 0;
  Interpolation interpolation = Interpolation::kLinear;
  Arithmetic arithmetic = Arithmetic::kFloat;
  // Stations at the acquisition point: both neighbours, mixed by nearness, or the nearer one, which
  // halves the samples.
  int stations_mixed = 2;  // 1 or 2
  // Every n-th station of a line is used (every_nth_station() in core/room/kept_stations.h):
  // divides the storage by n and hardly changes the time.
  int station_stride = 1;  // at least 1
  // Maps that the view's distances are gathered from: 8 bytes and some 60 operations per pixel of
  // each map, once per view.
  int distance_maps = 4;  // 1..4
  // Stations, nearest first, that are searched for a point hidden from the lines in use: some 50
  // operations each per hidden pixel of the distances.
  int fill_stations = 32;  // 0..32
  SecondSide second_side = SecondSide::kBlend;
  // Skips work that moves a pixel by at most this much (work_skipped.h), in pixels of the captured
  // panoramas; 0 skips nothing.
  double skip_px = 0.0;  // in [0, 4]
  // Whether stations are multiplied by their gains (Room::gains), where the room has some: some 10
  // operations per reading.
  bool gains = true;
};

// User-visible names, and back; throws UsageError on an unknown name.
std::string generation_name(Generation generation);
Generation generation_from_name(const std::string& name);
std::string interpolation_name(Interpolation interpolation);
Interpolation interpolation_from_name(const std::string& name);
std::string arithmetic_name(Arithmetic arithmetic);
Arithmetic arithmetic_from_name(const std::string& name);
std::string second_side_name(SecondSide second_side);
SecondSide second_side_from_name(const std::string& name);

// Throws UsageError on options out of range. `width` must already be resolved (not 0).
void require_view_options(const ViewOptions& options);

}  // namespace raywalk
