#include "calibrate/stitch/stitch_set.h"

#include <fmt/format.h>

#include <cstddef>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "calibrate/base/figures.h"
#include "calibrate/base/frame_masks.h"
#include "calibrate/stitch/fisheye_frames.h"
#include "calibrate/stitch/lens_gain.h"
#include "calibrate/stitch/stitch_record.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "panoramas";

cv::Mat seam_crop(const cv::Mat& panorama, double theta_deg) {
  constexpr double kSpan_deg = 40.0;
  constexpr int kSmallest_px = 320;  // enlarged to this
  const int side = static_cast<int>(panorama.cols * kSpan_deg / 360.0);
  const int centre = static_cast<int>(panorama.cols * (0.5 + theta_deg / 360.0));
  cv::Mat shown = panorama(cv::Rect(centre - side / 2, panorama.rows / 2 - side / 2, side, side));
  if (side >= kSmallest_px) return shown;
  cv::Mat enlarged;
  cv::resize(shown, enlarged, {kSmallest_px, kSmallest_px}, 0.0, 0.0, cv::INTER_CUBIC);
  return enlarged;
}

class SetStitcher {
 public:
  SetStitcher(const CaptureSet& set, const DualFisheyeCamera& camera, const StitchOptions& options)
      : set_(set),
        camera_(camera),
        options_(options),
        record_{.width = options.width != 0 ? options.width : default_panorama_width(camera),
                .options = {options.blend, options.blend_deg, options.seam_distance_m}} {
    record_.fingerprint = fingerprint();
  }

  int width() const { return record_.width; }
  fs::path panorama_of(const CaptureFrame& frame) const {
    return options_.out / panorama_file(frame);
  }
  fs::path mask_of(const CaptureFrame& frame) const {
    return options_.out / panorama_mask_file(frame);
  }

  void run() {
    const auto before = read_stitch_record(record_file());
    const bool same = before && before->fingerprint == record_.fingerprint;
    const bool complete = same && before->complete && before->has_figures;
    if (complete && missing_frames().empty()) return;
    // A run that is resumed measures the same again.
    const LensGain gain = measure_lens_gain(set_, camera_, options_.balance);
    record_.back_gain = gain.back_gain;
    // Panoramas of other inputs are removed before the new record makes them valid.
    const fs::path folder = options_.out / kFolder;
    if (!same) fs::remove_all(folder);
    make_directories(any_masks(set_) ? folder / "masks" : folder);
    nlohmann::ordered_json document = stitch_document(record_, gain, set_.frames.size());
    write_file_atomically(record_file(), json_text(document));
    const Stitcher stitcher(camera_, width(), record_.options, record_.back_gain);
    stitch(stitcher, missing_frames());
    document["complete"] = true;
    document["figures"] = write_figures(stitcher);
    write_file_atomically(record_file(), json_text(document));
  }

 private:
  fs::path record_file() const { return options_.out / "stitch.json"; }

  // Hash of everything that the panoramas depend on.
  std::string fingerprint() const {
    std::string text = "stitch 1 " + settings_text(camera_, record_.width, record_.options) +
                       (options_.balance ? "balanced" : "as captured");
    const auto append = [&](const fs::path& file) {
      text += file.string() + " " + stamp_of(file).text() + "\n";
    };
    for (const CaptureFrame& frame : set_.frames) {
      text += "\n" + frame.name + " ";
      append(frame.file);
      if (frame.back) append(*frame.back);
      if (frame.mask) append(*frame.mask);
    }
    return sha256_hex(text);
  }

  std::vector<const CaptureFrame*> missing_frames() const {
    std::vector<const CaptureFrame*> missing;
    for (const CaptureFrame& frame : set_.frames) {
      const bool has_mask = !frame.mask || fs::exists(mask_of(frame));
      if (!has_mask || !fs::exists(panorama_of(frame))) missing.push_back(&frame);
    }
    return missing;
  }

  void stitch(const Stitcher& stitcher, const std::vector<const CaptureFrame*>& frames) const {
    Progress progress("stitching", std::ssize(frames), "panoramas");
    for_each_frame(frames.size(), frames_at_once(camera_, width(), false), [&](std::size_t i) {
      const CaptureFrame& frame = *frames[i];
      const FramePictures pictures = read_frame_pictures(frame, camera_);
      const StitchedFrame stitched = stitcher.stitch(pictures.front, pictures.back, pictures.mask);
      if (frame.mask) write_image(mask_of(frame), stitched.mask);
      write_image(panorama_of(frame), stitched.panorama);
      progress.advance();
    });
  }

  // Of the middle station, balanced and blended, and neither. Returns the list for stitch.json
  // (figures.h).
  nlohmann::ordered_json write_figures(const Stitcher& stitcher) const {
    constexpr double kHardSeam_deg = 1e-3;
    constexpr const char* kBalanced = "balanced and blended";
    const CaptureFrame& frame = set_.frames[set_.stations() / 2];
    const FramePictures pictures = read_frame_pictures(frame, camera_);
    const cv::Mat panorama = stitcher.stitch(pictures.front, pictures.back, pictures.mask).panorama;
    StitcherOptions hard = record_.options;
    hard.blend = BlendMethod::kFeather;
    hard.blend_deg = kHardSeam_deg;
    const cv::Mat captured = Stitcher(camera_, width(), hard).stitch(pictures.front, pictures.back);
    auto figures = nlohmann::ordered_json::array();
    const auto add = [&](const std::string& name, const std::string& row, const char* caption,
                         const cv::Mat& image) {
      figures.push_back(write_figure(options_.out, "stitch_" + name, row, caption, image));
    };
    add("panorama", "Station " + frame.name, kBalanced, panorama);
    // Where the seam crosses the horizon.
    for (const auto& [theta_deg, side] : {std::pair(-90.0, "left"), std::pair(90.0, "right")}) {
      const std::string row = fmt::format("Seam at {:g} degrees", theta_deg);
      add(side + std::string("_captured"), row, "as captured", seam_crop(captured, theta_deg));
      add(side, row, kBalanced, seam_crop(panorama, theta_deg));
    }
    return figures;
  }

  const CaptureSet& set_;
  const DualFisheyeCamera& camera_;
  const StitchOptions& options_;
  StitchRecord record_;
};

}  // namespace

fs::path panorama_file(const CaptureFrame& frame) {
  return fs::path(kFolder) / (frame.name + ".png");
}

fs::path panorama_mask_file(const CaptureFrame& frame) {
  return fs::path(kFolder) / "masks" / (frame.name + ".png");
}

CaptureSet stitch_set(const CaptureSet& set, const std::optional<DualFisheyeCamera>& camera,
                      const StitchOptions& options) {
  if (set.layout == FrameLayout::kPanorama) return set;
  const DualFisheyeCamera fitting = fitting_camera(set, camera);
  make_directories(options.out);
  SetStitcher stitcher(set, fitting, options);
  stitcher.run();
  CaptureSet panoramas = set;
  panoramas.layout = FrameLayout::kPanorama;
  panoramas.frame = {stitcher.width(), stitcher.width() / 2};
  for (CaptureFrame& frame : panoramas.frames) {
    frame.file = stitcher.panorama_of(frame);
    frame.back.reset();
    frame.sha256.clear();
    if (frame.mask) frame.mask = stitcher.mask_of(frame);
  }
  return panoramas;
}

}  // namespace raywalk::calibrate
