// stitch.json: the inputs and figures of the stitched panoramas, from which an interrupted step is
// resumed.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "calibrate/stitch/measure_balance.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

struct StitchRecord {
  std::string fingerprint{};  // of frames, camera and options
  bool complete = false;      // all panoramas are there
  PanoramaSize panorama{};
  StitcherOptions options{};
  int frames = 0;
  BalanceReport balance{};
};

// Keys: format_version, fingerprint, complete, width_px, height_px, frames, blend ("multi-band",
// "feather"), blend_deg, seam_distance_m (null: infinity), balance {back_gain [red, green, blue],
// falloff_2, falloff_4, gain_sigma, share_45, share_45_sigma, share_90, share_90_sigma, scatter,
// frames, overlap_ratios, motion_ratios, light [{angle_deg, share of the light on the axis}]}, seam
// {step_before_levels, step_after_levels, correlation}, warnings [text]; when complete, figures.
nlohmann::ordered_json stitch_document(const StitchRecord& record);

// nullopt if there is no such file, or it is damaged or of another version.
std::optional<StitchRecord> read_stitch_record(const std::filesystem::path& file);

// The name of a blend method in files and on the command line.
std::string name_of(BlendMethod method);
// Throws UsageError for an unknown name.
BlendMethod blend_method_named(const std::string& name);

}  // namespace raywalk::calibrate
