#include "calibrate/lens/calibrate_lens.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "calibrate/lens/capture_fit.h"
#include "calibrate/lens/lens_report.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

// The accuracy that stitching needs: resampling alone costs a third of a pixel.
constexpr double kLargestSigma_px = 0.3;
constexpr double kLargestResidual_px = 1.0;
// Fewer features in the overlap do not determine the relative rotation of the lenses.
constexpr int kLeastOverlap = 12;

void require_options(const LensOptions& options) {
  constexpr int kLeastPairs = 6;
  if (options.pairs < kLeastPairs) {
    throw UsageError(fmt::format("{} stations are too few to fit lenses to; use at least {}",
                                 options.pairs, kLeastPairs));
  }
  if (!(options.ignore_below_deg >= 0.0 && options.ignore_below_deg < 90.0)) {
    throw UsageError(
        fmt::format("the ignored cone about the nadir has {:g} degrees; give 0 to below 90",
                    options.ignore_below_deg));
  }
}

LensFit fit_to_set(const CaptureSet& set, const DualFisheyeCamera& start,
                   const LensOptions& options) {
  if (set.layout == FrameLayout::kPanorama) {
    throw Error(set.source.string() +
                ": its frames are panoramas already, stitched by the camera; there are no lenses "
                "to calibrate, continue with `raywalk-calibrate poses`");
  }
  const bool two_files = !set.frames.empty() && set.frames.front().back.has_value();
  if (two_files != start.two_files) {
    throw Error(fmt::format(
        "{}: says that front and back are in {}, but the frames of {} are not; use a starting lens "
        "file for this camera",
        options.start.string(), start.two_files ? "two files" : "one file", set.source.string()));
  }
  return fit_to_capture(set, scaled_to(start, set.frame), options);
}

void add_warnings(LensFit* fit) {
  if (fit->residual_px > kLargestResidual_px) {
    fit->warnings.push_back(
        fmt::format("the residuals of {:.2f} px exceed noise: the lens model does not describe "
                    "these lenses, or "
                    "the pictures are not of this camera",
                    fit->residual_px));
  }
  if (fit->sigma.worst_px() > kLargestSigma_px) {
    fit->warnings.push_back(
        fmt::format("the image position of a direction is uncertain by {:.2f} px; use more "
                    "stations, spread over lines of both axes",
                    fit->sigma.worst_px()));
  }
  if (fit->overlap_points < kLeastOverlap) {
    fit->warnings.push_back(fmt::format(
        "only {} points were seen by both lenses, too few for their rotation relative to "
        "each other",
        fit->overlap_points));
  }
}

}  // namespace

LensFit calibrate_lens(const CaptureSet& set, const LensOptions& options) {
  require_options(options);
  const DualFisheyeCamera start = read_lens_file(options.start);
  LensFit fit = fit_to_set(set, start, options);
  add_warnings(&fit);
  require_monotonic_radius(fit.camera.layout.front);
  require_monotonic_radius(fit.camera.layout.back);
  make_directories(options.out);
  nlohmann::ordered_json document = lens_document(fit);
  document["figures"] = residual_figures(fit, options.out);
  write_file_atomically(options.out / "lens.json", json_text(document));
  // Last, as the next steps check for this file.
  write_lens_file(options.out / "lens.yaml", fit.camera);
  return fit;
}

}  // namespace raywalk::calibrate
