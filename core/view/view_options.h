// The parameters of a view, which trade its speed for its accuracy, and the table of those that a
// user may turn.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "core/geometry/sphere.h"
#include "core/view/view_parameter.h"

namespace raywalk {

// The vertical cut through the light field; corrected by the distance of every ray, from the line
// in front; the same from the lines in front and behind.
enum class ViewMethod { kInitial, kHlfVd, kTwoSided };
inline constexpr std::array kViewMethodNames{"initial", "hlf-vd", "two-sided"};

// How a sample is read from a station's panorama. Initial views of the captured width read whole
// columns without samples.
enum class Interpolation { kLinear, kCubic };
inline constexpr std::array kInterpolationNames{"linear", "cubic"};

// Where the lines in front and behind both see a point, a two-sided view mixes them by nearness, or
// reads only the nearer side but for a fade where both are about as near. Both are continuous when
// the viewpoint crosses a line.
enum class SecondSide { kEverywhere, kFaded };
inline constexpr std::array kSecondSideNames{"everywhere", "faded"};

inline constexpr std::array kOffOn{"off", "on"};

// Ranges, help and cost of the members stand in the tables below.
struct ViewOptions {
  ViewMethod method = ViewMethod::kHlfVd;
  double k_deg = 90.0;       // 45 is LFU, 90 is Ray-space360
  double overlap_deg = 5.0;  // width of the blend at a connection
  int width = 0;             // of the output, pixels; 0: size_as_captured (renderer.h)
  Interpolation interpolation = Interpolation::kLinear;
  int stations_mixed = 1;     // of each line and pixel, those nearest in angle first
  double station_fade = 1.0;  // over which one fades into the next, in spacings of stations
  int distance_maps = 8;      // of the four lines of a cell two each
  SecondSide second_side = SecondSide::kEverywhere;
  bool gains = true;  // whether stations are multiplied by their gains (Room::gains)

  friend bool operator==(const ViewOptions&, const ViewOptions&) = default;
};

// In the order of help texts, tables and names.
inline constexpr auto kViewParameters = std::to_array<ViewParameter>({
    {.key = "method",
     .flag = "--method",
     .value = kAccess<&ViewOptions::method>,
     .names = kViewMethodNames,
     .help = "initial (vertical cut), hlf-vd (corrected by distance) or two-sided (corrected, from "
             "both sides)",
     .cost = "initial: the stored pixels of 2 stations mixed, 6 bytes and 2 operations per "
             "channel, twice that in the blend of a connection; hlf-vd: as many samples as "
             "stations are mixed, twice as many in a blend, after a distance view; two-sided: the "
             "samples of hlf-vd from the lines in front and behind",
     .sweep = ParameterSweep{}},
    {.key = "k_deg",
     .flag = "--k",
     .value = kAccess<&ViewOptions::k_deg>,
     .unit = "degrees",
     .least = 45.0,
     .most = 90.0,
     .group = ParameterGroup::kConnection,
     .help = "Largest incidence angle of the hybrid connection in degrees, 45 to 90",
     .cost = "none",
     .phrase = "k {}°",
     .sweep = ParameterSweep{.values = {45.0, 76.0, 90.0}}},
    {.key = "overlap_deg",
     .flag = "--overlap-deg",
     .value = kAccess<&ViewOptions::overlap_deg>,
     .unit = "degrees",
     .least = 0.0,
     .most = 45.0,
     .group = ParameterGroup::kConnection,
     .help = "Width of the blend at a connection, degrees",
     .cost = "twice the samples in the blend",
     .phrase = "overlap {}°",
     .sweep = ParameterSweep{.values = {0.0, 15.0}}},
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
     .sweep = ParameterSweep{.values = {0.5, 0.75}, .of_truth_width = true}},
    {.key = "interpolation",
     .flag = "--interpolation",
     .value = kAccess<&ViewOptions::interpolation>,
     .names = kInterpolationNames,
     .group = ParameterGroup::kTrade,
     .help = "How a pixel is read from a panorama: linear or cubic",
     .cost = "12 or 48 bytes, 3 or 15 weighted sums per channel and sample",
     .sweep = ParameterSweep{.values = {1}}},
    {.key = "stations_mixed",
     .flag = "--stations-mixed",
     .value = kAccess<&ViewOptions::stations_mixed>,
     .least = 1.0,
     .most = 16.0,
     .group = ParameterGroup::kTrade,
     .help = "Stations of a line that are mixed in a pixel, those nearest in angle first",
     .cost = "so many samples",
     .phrase = "stations {}",
     .sweep = ParameterSweep{.values = {2, 4, 8, 16}}},
    {.key = "station_fade",
     .flag = "--station-fade",
     .value = kAccess<&ViewOptions::station_fade>,
     .unit = "spacings",
     .least = 0.1,
     .most = 1.0,
     .group = ParameterGroup::kTrade,
     .help = "Part of a spacing of stations over which one station fades into the next; more is "
             "better where stations are far apart, their photographs noisy or unevenly exposed",
     .cost = "so much of one more sample for each line",
     .phrase = "fade {}",
     .sweep = ParameterSweep{.values = {0.125, 0.5}}},
    {.key = "distance_maps",
     .flag = "--distance-maps",
     .value = kAccess<&ViewOptions::distance_maps>,
     .least = 1.0,
     .most = 8.0,
     .group = ParameterGroup::kTrade,
     .help = "Distance maps that a view's distances are gathered from",
     .cost = "4 bytes and some 60 operations per pixel of each map, once per view",
     .phrase = "maps {}",
     .sweep = ParameterSweep{.values = {1, 2, 4}}},
    {.key = "second_side",
     .flag = "--second-side",
     .value = kAccess<&ViewOptions::second_side>,
     .names = kSecondSideNames,
     .group = ParameterGroup::kTrade,
     .help = "Where a two-sided view reads both sides: everywhere (that both see), or faded (only "
             "where both are about as near, else the nearer one)",
     .cost = "faded halves the samples of most pixels",
     .phrase = "second side {}",
     .sweep = ParameterSweep{.values = {1}, .of_two_sided_views = true}},
    {.key = "gains",
     .flag = "--no-gains",
     .value = kAccess<&ViewOptions::gains>,
     .names = kOffOn,
     .flag_sets = "off",
     .group = ParameterGroup::kTrade,
     .help = "Show the panoramas' own exposures instead of those made equal by the room's gains "
             "(raywalk-build-lf gains)",
     .cost = "some 10 operations per reading, where the room has gains"},
});

// One of kViewParameters. Throws std::out_of_range where there is none of this key.
const ViewParameter& parameter_of(std::string_view key);

// Every parameter at default_of().
ViewOptions default_options();

// All of the options, for keys of what was rendered with them: different options have different
// texts.
std::string text_of(const ViewOptions& options);

// User-visible names, and back; throws UsageError on an unknown name.
std::string method_name(ViewMethod method);
ViewMethod method_from_name(const std::string& name);

// Throws UsageError on options out of range. What the program chooses for a room must already be
// chosen: `width` must not be 0.
void require_view_options(const ViewOptions& options);

}  // namespace raywalk
