// stitch.json: what the panoramas of a capture were stitched by. An interrupted step resumes from
// it, and frames in other axes are made in the same way.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "calibrate/base/capture_set.h"
#include "calibrate/stitch/lens_gain.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

struct StitchRecord {
  std::string fingerprint{};  // of frames, camera and options
  bool complete = false;      // all panoramas are there
  bool has_figures = false;   // and the files of all figures
  int width = 0;              // of the panoramas, pixels
  StitcherOptions options{};
  ColourGains back_gain = kEqualLenses;
};

// Keys: format_version, fingerprint, complete, width_px, height_px, frames, blend ("multi-band",
// "feather"), blend_deg, seam_distance_m (null: infinity), balance {back_gain [red, green, blue],
// frames, points}, seam {step_before_levels, step_after_levels, correlation}, warnings [text]; when
// complete, figures. `frames`: of the capture.
nlohmann::ordered_json stitch_document(const StitchRecord& record, const LensGain& gain,
                                       std::size_t frames);

// nullopt if there is no such file, or it is damaged or of another version.
std::optional<StitchRecord> read_stitch_record(const std::filesystem::path& file);

// The name of a blend method in files and on the command line.
std::string name_of(BlendMethod method);
// Throws UsageError for an unknown name.
BlendMethod blend_method_named(const std::string& name);

// All values of a camera and of how its frames are stitched, as text for a fingerprint.
std::string settings_text(const DualFisheyeCamera& camera, int width,
                          const StitcherOptions& options);

// The fisheye pictures of a capture with what its panoramas were stitched by.
struct FisheyeSource {
  CaptureSet captured{};       // of layout kDualFisheye
  DualFisheyeCamera camera{};  // at the size of its pictures
  int width = 0;               // of the panoramas, pixels
  StitcherOptions options{};
  ColourGains back_gain = kEqualLenses;
};

// Of the panoramas that the step `stitch` made in the directory OUT. Throws Error naming the step
// if its record there is missing, damaged or of an unfinished run, and as fitting_camera.
FisheyeSource read_fisheye_source(const CaptureSet& captured,
                                  const std::optional<DualFisheyeCamera>& camera,
                                  const std::filesystem::path& out);

}  // namespace raywalk::calibrate
