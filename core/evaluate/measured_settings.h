// What was measured of a room's settings, for choosing one by time or accuracy. A trade writes it,
// views are chosen by it; docs/file-formats.md lists the keys of measured.json. This is all of the
// folder that what makes views may use.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/timing.h"
#include "core/view/view_options.h"

namespace raywalk {

// Runs the work and returns the seconds it took; tests replace it.
using TimeSource = std::function<double(const std::function<void()>&)>;
inline double wall_time_s(const std::function<void()>& work) { return times_of(work).wall_s; }

// The value of a parameter: choices by name, numbers as numbers.
nlohmann::ordered_json json_of(const ViewParameter& parameter, const ViewOptions& options);

// The parameters that a trade varies: {"method": "hlf-vd", "k_deg": 76.0, ...}.
nlohmann::ordered_json swept_parameters_json(const ViewOptions& options);

// The largest PSNR of a measurement, which stands for all above it, also for an infinite one.
inline constexpr double kMostPsnr_db = 100.0;

// One setting that was measured.
struct MeasuredChoice {
  std::string name{};
  ViewOptions options{};  // parameters that a trade does not vary are as in ViewOptions()
  double ratio = 0.0;     // its time per view divided by that of one cv::remap of the same size
  double psnr_db = 0.0;
};

// Of a room itself, on all threads.
struct MeasuredSettings {
  std::string distances_sha256{};  // distances_sha256() of the room it was measured on
  int width_px = 0;                // of the images that were compared
  std::vector<MeasuredChoice> choices{};
};

// A room's measured.json.
std::filesystem::path measured_settings_path(const std::filesystem::path& room);

// Writes the room's file, atomically. Throws Error where it cannot be written.
void write_measured_settings(const std::filesystem::path& room, const MeasuredSettings& measured);

// The room's settings; none where nothing was measured. Throws Error where the file is damaged or
// newer, or holds no setting of the room itself.
std::optional<MeasuredSettings> read_measured_settings(const std::filesystem::path& room);

}  // namespace raywalk
