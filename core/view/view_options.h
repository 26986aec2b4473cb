// The parameters of a view, which trade its speed for its accuracy, and the table of those that a
// user may turn.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/geometry/layer_count.h"
#include "core/geometry/sphere.h"
#include "core/view/dial.h"

namespace raywalk {

// The vertical cut through the light field; corrected by the distance of every ray, from the line
// in front; the same from the lines in front and behind.
enum class Generation { kInitial, kHlfVd, kTwoSided };
inline constexpr std::array kGenerationNames{"initial", "hlf-vd", "two-sided"};

// How a sample is read from a station's panorama. Initial views of the captured width read whole
// columns without samples.
enum class Interpolation { kNearest, kLinear, kCubic };
inline constexpr std::array kInterpolationNames{"nearest", "linear", "cubic"};

// Precision in which sample positions are computed. Double computes the position of every row with
// the library's arctangent (some 20 times the operations); float interpolates positions between the
// rows of coarser distances. Pictures are mixed in 16-bit fixed point in either case.
enum class Arithmetic { kFloat, kDouble };
inline constexpr std::array kArithmeticNames{"float", "double"};

// Where the lines in front and behind both see a point, a two-sided view either blends them by
// nearness, which is continuous when the viewpoint crosses a line, or reads only the nearer one.
enum class SecondSide { kBlend, kWhereHidden };
inline constexpr std::array kSecondSideNames{"blend", "where-hidden"};

inline constexpr std::array kOffOn{"off", "on"};

// Ranges, help and cost of the members stand in the tables below.
struct ViewOptions {
  Generation generation = Generation::kHlfVd;
  double k_deg = 90.0;       // 45 is LFU, 90 is Ray-space360
  double overlap_deg = 5.0;  // width of the blend at a connection
  int layers = 0;            // 0: as many as `tolerance_px` needs
  // Range of inverse distances for automatic layers; none = that of the maps around the view.
  std::optional<OmegaRange> scene{};
  double tolerance_px = 0.5;  // largest shift of a pixel caused by automatic layers, output pixels
  int width = 0;              // of the output, pixels; 0: size_as_captured (renderer.h)
  Interpolation interpolation = Interpolation::kLinear;
  Arithmetic arithmetic = Arithmetic::kFloat;
  int stations_mixed = 2;  // 1: the nearer one; 2: both, mixed by nearness
  // Every n-th station of a line is used (every_nth_station() in core/room/kept_stations.h):
  // divides the storage by n and hardly changes the time.
  int station_stride = 1;
  int distance_maps = 4;
  // Stations, nearest first, that are searched for a point hidden from the lines in use: some 50
  // operations each per hidden pixel of the distances.
  int fill_stations = 32;
  SecondSide second_side = SecondSide::kBlend;
  double skip_px = 0.0;  // work_skipped.h; in pixels of the captured panoramas
  bool gains = true;     // whether stations are multiplied by their gains (Room::gains)

  friend bool operator==(const ViewOptions&, const ViewOptions&) = default;
};

// In the order of help texts, tables and names.
inline constexpr auto kDials = std::to_array<Dial>({
    {.key = "generation",
     .flag = "--generation",
     .value = kAccess<&ViewOptions::generation>,
     .names = kGenerationNames,
     .help = "initial (vertical cut), hlf-vd (corrected by distance) or two-sided (corrected, from "
             "both sides)",
     .cost = "initial: the stored pixels of 2 stations mixed, 6 bytes and 2 operations per "
             "channel, twice that in the blend of a connection; hlf-vd: as many samples as "
             "stations are mixed, twice as many in a blend, after a distance view; two-sided: the "
             "samples of hlf-vd from the lines in front and behind",
     .sweep = DialSweep{}},
    {.key = "k_deg",
     .flag = "--k",
     .value = kAccess<&ViewOptions::k_deg>,
     .unit = "degrees",
     .least = 45.0,
     .most = 90.0,
     .zero = "auto",
     .group = DialGroup::kConnection,
     .help = "Largest incidence angle of the hybrid connection in degrees, 45 to 90, or auto: the "
             "one that connect-error measured to be best on the room, else 90",
     .cost = "none",
     .phrase = "k {}°",
     .sweep = DialSweep{.singly = {45.0, 76.0, 90.0},
                        .grid = DialGrid::kLayout,
                        .in_grid = {45.0, 76.0, 90.0}}},
    {.key = "overlap_deg",
     .flag = "--overlap-deg",
     .value = kAccess<&ViewOptions::overlap_deg>,
     .unit = "degrees",
     .least = 0.0,
     .most = 45.0,
     .group = DialGroup::kConnection,
     .help = "Width of the blend at a connection, degrees",
     .cost = "twice the samples in the blend",
     .phrase = "overlap {}°",
     .sweep =
         DialSweep{.singly = {0.0, 15.0}, .grid = DialGrid::kLayout, .in_grid = {0.0, 5.0, 15.0}}},
    {.key = "layers",
     .flag = "--layers",
     .value = kAccess<&ViewOptions::layers>,
     .least = 1.0,
     .most = 65536.0,
     .zero = "auto",
     .renders_at_zero = true,
     .group = DialGroup::kConnection,
     .help = "Depth layers, or auto: as many as --tolerance-px needs, for the scene that the "
             "room's require.json describes",
     .cost = "of an explicit number 12 operations per row and source; the position of every row is "
             "computed",
     .phrase = "layers {}",
     .effect = DialEffect::kCorrectedViews,
     .sweep =
         DialSweep{.singly = {4, 16, 64}, .grid = DialGrid::kLayout, .in_grid = {0, 4, 16, 64}}},
    {.key = "tolerance_px",
     .flag = "--tolerance-px",
     .value = kAccess<&ViewOptions::tolerance_px>,
     .unit = "pixels",
     .least = 0.01,
     .most = 100.0,
     .group = DialGroup::kConnection,
     .help = "Largest shift of a pixel caused by automatic layers",
     .cost = "none",
     .effect = DialEffect::kCorrectedViews},
    {.key = "width_px",
     .flag = "--width",
     .value = kAccess<&ViewOptions::width>,
     .unit = "pixels",
     .least = 4.0,
     .most = 32768.0,
     .multiple_of = 4,
     .zero = "0",
     .help = "Width of the picture in pixels, a multiple of 4; 0 = as captured",
     .cost = "the samples grow with its square; pictures much smaller than captured cost as much "
             "as captured ones, since they are rendered larger and averaged down",
     .phrase = "{} px wide",
     .sweep = DialSweep{.singly = {0.5, 0.75},
                        .grid = DialGrid::kLayout,
                        .in_grid = {0.5, 1.0},
                        .of_truth_width = true}},
    {.key = "interpolation",
     .flag = "--interpolation",
     .value = kAccess<&ViewOptions::interpolation>,
     .names = kInterpolationNames,
     .group = DialGroup::kTrade,
     .help = "How a pixel is read from a panorama: nearest, linear or cubic",
     .cost = "3, 12 or 48 bytes, 0, 3 or 15 weighted sums per channel and sample",
     .effect = DialEffect::kSampledViews,
     .sweep = DialSweep{.singly = {0, 2}, .grid = DialGrid::kSamples, .in_grid = {0, 1, 2}}},
    {.key = "stations_mixed",
     .flag = "--stations-mixed",
     .value = kAccess<&ViewOptions::stations_mixed>,
     .least = 1.0,
     .most = 2.0,
     .group = DialGroup::kTrade,
     .help = "Stations mixed at the point where a ray crosses a line: both neighbours (2) or the "
             "nearer one (1)",
     .cost = "one halves the samples",
     .phrase = "{} station mixed",
     .sweep = DialSweep{.singly = {1}, .grid = DialGrid::kSamples, .in_grid = {1, 2}}},
    {.key = "distance_maps",
     .flag = "--distance-maps",
     .value = kAccess<&ViewOptions::distance_maps>,
     .least = 1.0,
     .most = 4.0,
     .group = DialGroup::kTrade,
     .help = "Distance maps that a view's distances are gathered from",
     .cost = "4 bytes and some 60 operations per pixel of each map, once per view",
     .phrase = "maps {}",
     .effect = DialEffect::kCorrectedViews,
     .sweep = DialSweep{.singly = {1, 2}, .grid = DialGrid::kSamples, .in_grid = {1, 2, 4}}},
    {.key = "second_side",
     .flag = "--second-side",
     .value = kAccess<&ViewOptions::second_side>,
     .names = kSecondSideNames,
     .group = DialGroup::kTrade,
     .help = "When a two-sided view reads the second side: blend (wherever both see a point) or "
             "where-hidden (only where the nearer one does not)",
     .cost = "where-hidden halves the samples",
     .phrase = "second side {}",
     .effect = DialEffect::kTwoSidedViews,
     .sweep = DialSweep{.singly = {1}, .grid = DialGrid::kSamples, .in_grid = {0, 1}}},
    {.key = "skip_px",
     .flag = "--skip-px",
     .value = kAccess<&ViewOptions::skip_px>,
     .unit = "pixels",
     .least = 0.0,
     .most = 4.0,
     .group = DialGroup::kTrade,
     .help = "Skip work that would move a pixel by at most this many captured pixels; 0 skips "
             "nothing",
     .cost = "less the more is skipped, which the view reports",
     .phrase = "skip {} px",
     .effect = DialEffect::kCorrectedViews,
     .sweep =
         DialSweep{.singly = {0.5, 1.0}, .grid = DialGrid::kSamples, .in_grid = {0.0, 0.5, 1.0}}},
    {.key = "gains",
     .flag = "--no-gains",
     .value = kAccess<&ViewOptions::gains>,
     .names = kOffOn,
     .flag_sets = "off",
     .group = DialGroup::kTrade,
     .help = "Show the panoramas' own exposures instead of those made equal by the room's gains "
             "(raywalk-build-lf gains)",
     .cost = "some 10 operations per reading, where the room has gains"},
});

// What nobody turns by hand: for tests and benchmarks.
inline constexpr auto kBenchDials = std::to_array<Dial>({
    {.key = "arithmetic", .value = kAccess<&ViewOptions::arithmetic>, .names = kArithmeticNames},
    {.key = "station_stride",
     .value = kAccess<&ViewOptions::station_stride>,
     .least = 1.0,
     .most = 1e6},
    {.key = "fill_stations",
     .value = kAccess<&ViewOptions::fill_stations>,
     .least = 0.0,
     .most = 32.0},
});

// One of kDials. Throws std::out_of_range where there is none of this key.
const Dial& dial_of(std::string_view key);

// Every dial at default_of().
ViewOptions default_options();

// All of the options, for keys of what was rendered with them: different options have different
// texts.
std::string text_of(const ViewOptions& options);

// User-visible names, and back; throws UsageError on an unknown name.
std::string generation_name(Generation generation);
Generation generation_from_name(const std::string& name);
std::string interpolation_name(Interpolation interpolation);
std::string second_side_name(SecondSide second_side);

// Throws UsageError on options out of range. What the program chooses for a room must already be
// chosen: `k_deg` and `width` must not be 0.
void require_view_options(const ViewOptions& options);

}  // namespace raywalk
