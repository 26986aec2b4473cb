#include "build_lf/exposure/make_gains.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "build_lf/exposure/room_gains.h"
#include "build_lf/pack/distances_lock.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

bool all_are_one(const GainFields& fields) {
  return std::ranges::all_of(fields,
                             [](const auto& line) { return std::ranges::all_of(line, is_one); });
}

void write_manifest(const fs::path& room, const RoomManifest& manifest) {
  write_file_atomically(manifest_path(room), manifest_to_json(manifest));
}

// Adds up the solid angle and the squared log gains of a station.
struct Totals {
  double weight = 0.0;
  double square = 0.0;
  double largest_log = 0.0;  // in absolute value

  void add(const ColourGain& gain, double solid_angle) {
    for (int c = 0; c < 3; ++c) {
      const double log_gain = std::log(static_cast<double>(gain[c]));
      weight += solid_angle;
      square += solid_angle * log_gain * log_gain;
      if (std::fabs(log_gain) > std::fabs(largest_log)) largest_log = log_gain;
    }
  }

  void add(const GainField& field) {
    if (field.local.empty()) {
      add(field.whole, 1.0);
      return;
    }
    const int thetas = field.local.rows;
    const int phis = field.local.cols;
    for (int theta = 0; theta < thetas; ++theta) {
      for (int phi = 0; phi < phis; ++phi) {
        // Of a row of patches: the integral of cos phi, over 2 for the whole sphere.
        const double top = std::cos(phi * kPi / phis);
        const double bottom = std::cos((phi + 1) * kPi / phis);
        add(field.whole.mul(field.local.at<cv::Vec3f>(theta, phi)), 0.5 * (top - bottom) / thetas);
      }
    }
  }
};

}  // namespace

GainsSummary summary_of(const GainFields& fields) {
  GainsSummary summary;
  Totals totals;
  for (const auto& line : fields) {
    for (const GainField& field : line) {
      ++summary.stations;
      summary.corrected += is_one(field) ? 0 : 1;
      summary.local += field.local.empty() ? 0 : 1;
      totals.add(field);
    }
  }
  if (totals.weight > 0.0) summary.spread = std::sqrt(totals.square / totals.weight);
  summary.largest = std::exp(totals.largest_log);
  return summary;
}

std::string text_of(const GainsSummary& summary) {
  const auto stations = [](int count) {
    return counted(static_cast<std::size_t>(count), "station");
  };
  if (summary.corrected == 0) {
    return fmt::format("the exposures of {} agree within what can be measured; views need no gains",
                       stations(summary.stations));
  }
  return fmt::format(
      "views apply gains to {} of {}, {} of them locally: {:.1f} % in the mean, at most a factor "
      "of {:.2f}",
      summary.corrected, stations(summary.stations), summary.local,
      100.0 * std::expm1(summary.spread), summary.largest);
}

GainsSummary make_gains(const std::filesystem::path& directory) {
  const Room room = Room::open_without_gains(directory);
  if (!room.has_distances()) {
    throw Error(
        fmt::format("{}: no distances, which show the surfaces that stations share; "
                    "`raywalk-build-lf depth {}` estimates them",
                    directory.string(), shell_word(directory.string())));
  }
  const GainFields fields = solve_room_gains(room, surface_maps_of(room));
  replace_gains(directory, fields);
  return summary_of(fields);
}

void replace_gains(const fs::path& room, const GainFields& fields) {
  if (all_are_one(fields)) {
    remove_gains(room);
    return;
  }
  const DistancesLock lock(room);
  RoomManifest manifest = read_manifest(room);
  write_gain_fields(gains_path(room), manifest.grid, fields);
  manifest.gains = true;
  write_manifest(room, manifest);
}

bool remove_gains(const fs::path& room) {
  const DistancesLock lock(room);
  RoomManifest manifest = read_manifest(room);
  const bool recorded = manifest.gains;
  if (recorded) {
    manifest.gains = false;
    write_manifest(room, manifest);
  }
  std::error_code ignored;
  return fs::remove(gains_path(room), ignored) || recorded;
}

}  // namespace raywalk::build_lf
