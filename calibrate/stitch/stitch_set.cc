#include "calibrate/stitch/stitch_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "calibrate/base/figures.h"
#include "calibrate/base/frame_masks.h"
#include "calibrate/stitch/fisheye_source.h"
#include "calibrate/stitch/frames_at_once.h"
#include "calibrate/stitch/measure_balance.h"
#include "calibrate/stitch/stitch_record.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

// One frame stitched with and without correction, CV_8UC3.
struct StitchSample {
  std::string station{};
  cv::Mat panorama{};    // balanced and blended
  cv::Mat unbalanced{};  // neither balanced nor blended
};

constexpr int kSmallestCrop_px = 320;  // enlarged to this
constexpr double kCropSpan_deg = 40.0;

// Where the seam crosses the horizon.
struct SeamPlace {
  double theta_deg;
  const char* captured;  // names of its figures
  const char* balanced;
};
constexpr std::array kPlaces{SeamPlace{-90.0, "stitch_left_captured", "stitch_left"},
                             SeamPlace{90.0, "stitch_right_captured", "stitch_right"}};
constexpr const char* kPanorama = "stitch_panorama";

cv::Mat seam_crop(const cv::Mat& panorama, double theta_deg) {
  const int side = static_cast<int>(panorama.cols * kCropSpan_deg / 360.0);
  const int centre = static_cast<int>(panorama.cols * (0.5 + theta_deg / 360.0));
  cv::Mat shown = panorama(cv::Rect(centre - side / 2, panorama.rows / 2 - side / 2, side, side));
  if (side >= kSmallestCrop_px) return shown;
  cv::Mat enlarged;
  cv::resize(shown, enlarged, {kSmallestCrop_px, kSmallestCrop_px}, 0.0, 0.0, cv::INTER_CUBIC);
  return enlarged;
}

// Writes them into OUT/figures; returns the list for stitch.json (figures.h).
nlohmann::ordered_json write_stitch_figures(const StitchSample& sample, const fs::path& out) {
  constexpr const char* kBalanced = "balanced and blended";
  auto figures = nlohmann::ordered_json::array();
  figures.push_back(
      write_figure(out, kPanorama, "Station " + sample.station, kBalanced, sample.panorama));
  for (const SeamPlace& place : kPlaces) {
    const std::string row = fmt::format("Seam at {:g} degrees", place.theta_deg);
    figures.push_back(write_figure(out, place.captured, row, "as captured",
                                   seam_crop(sample.unbalanced, place.theta_deg)));
    figures.push_back(write_figure(out, place.balanced, row, kBalanced,
                                   seam_crop(sample.panorama, place.theta_deg)));
  }
  return figures;
}

// Whether all of them are there.
bool has_stitch_figures(const fs::path& out) {
  const auto exists = [&](const char* name) {
    return fs::exists(out / "figures" / (std::string(name) + ".png"));
  };
  return exists(kPanorama) && std::ranges::all_of(kPlaces, [&](const SeamPlace& place) {
           return exists(place.captured) && exists(place.balanced);
         });
}

// Blend width of the unblended sample.
constexpr double kHardSeam_deg = 1e-3;

void append(std::string* text, const fs::path& file) {
  *text += file.string() + " " + stamp_of(file).text() + "\n";
}

// Hash of everything that the panoramas depend on.
std::string fingerprint_of(const CaptureSet& set, const DualFisheyeCamera& camera,
                           const StitchOptions& options, int width) {
  std::string text = fmt::format("stitch 1 {} {} {} {} {}\n", width, name_of(options.blend),
                                 options.blend_deg, options.seam_distance_m, options.balance);
  text += camera_text(camera);
  for (const CaptureFrame& frame : set.frames) {
    text += "\n" + frame.name + " ";
    append(&text, frame.file);
    if (frame.back) append(&text, *frame.back);
    if (frame.mask) append(&text, *frame.mask);
  }
  return sha256_hex(text);
}

class SetStitcher {
 public:
  SetStitcher(const CaptureSet& set, const DualFisheyeCamera& camera, const StitchOptions& options)
      : set_(set),
        camera_(camera),
        options_(options),
        folder_(options.out / "panoramas"),
        width_(options.width != 0 ? options.width : default_panorama_width(camera)) {}

  PanoramaSize size() const { return {width_, width_ / 2}; }
  fs::path panorama_of(const CaptureFrame& frame) const { return folder_ / (frame.name + ".png"); }

  fs::path mask_of(const CaptureFrame& frame) const {
    return folder_ / "masks" / (frame.name + ".png");
  }

  void run() {
    const std::string fingerprint = fingerprint_of(set_, camera_, options_, width_);
    const auto before = read_stitch_record(record_file());
    if (before && before->fingerprint == fingerprint) {
      record_ = *before;
    } else {
      begin(fingerprint);
    }
    const std::vector<int> missing = missing_frames();
    if (record_.complete && missing.empty() && has_stitch_figures(options_.out)) return;
    const Stitcher stitcher(camera_, width_, stitcher_options(), record_.balance.fit.balance);
    stitch(stitcher, missing);
    finish(stitcher);
  }

 private:
  fs::path record_file() const { return options_.out / "stitch.json"; }

  StitcherOptions stitcher_options() const {
    return {options_.blend, options_.blend_deg, options_.seam_distance_m};
  }

  // A new record.
  void measure(const std::string& fingerprint) {
    record_ = {.fingerprint = fingerprint,
               .panorama = size(),
               .options = stitcher_options(),
               .frames = static_cast<int>(set_.frames.size())};
    record_.balance = measure_balance(set_, camera_, options_.balance);
  }

  void make_folder() const { make_directories(any_masks(set_) ? folder_ / "masks" : folder_); }

  // Panoramas of other inputs are removed before a new record is written, which would make them
  // valid.
  void remove_panoramas() const { fs::remove_all(folder_); }

  void begin(const std::string& fingerprint) {
    measure(fingerprint);
    remove_panoramas();
    make_folder();
    write_file_atomically(record_file(), json_text(stitch_document(record_)));
  }

  std::vector<int> missing_frames() const {
    std::vector<int> missing;
    for (std::size_t i = 0; i < set_.frames.size(); ++i) {
      const CaptureFrame& frame = set_.frames[i];
      const bool has_mask = !frame.mask || fs::exists(mask_of(frame));
      if (!has_mask || !fs::exists(panorama_of(frame))) missing.push_back(static_cast<int>(i));
    }
    return missing;
  }

  void stitch(const Stitcher& stitcher, const std::vector<int>& frames) const {
    Progress progress("stitching", static_cast<std::int64_t>(frames.size()), "panoramas");
    const double bytes =
        bytes_of_pictures(camera_) + bytes_of_panorama(table_pixels(camera_, width_));
    for_each_frame(static_cast<int>(frames.size()), frames_at_once(bytes), [&](int i) {
      stitch(stitcher, set_.frames[static_cast<std::size_t>(frames[static_cast<std::size_t>(i)])]);
      progress.advance();
    });
  }

  void stitch(const Stitcher& stitcher, const CaptureFrame& frame) const {
    const FramePictures pictures = read_frame_pictures(frame, camera_);
    const StitchedFrame stitched = stitcher.stitch(pictures.front, pictures.back, pictures.mask);
    if (frame.mask) write_image(mask_of(frame), stitched.mask);
    write_image(panorama_of(frame), stitched.panorama);
  }

  void finish(const Stitcher& stitcher) {
    const CaptureFrame& frame = set_.frames[set_.stations() / 2];
    const FramePictures pictures = read_frame_pictures(frame, camera_);
    StitcherOptions hard = stitcher_options();
    hard.blend = BlendMethod::kFeather;
    hard.blend_deg = kHardSeam_deg;
    const Stitcher unbalanced(camera_, width_, hard, {});
    const StitchSample sample{
        frame.name, stitcher.stitch(pictures.front, pictures.back, pictures.mask).panorama,
        unbalanced.stitch(pictures.front, pictures.back)};
    record_.complete = true;
    nlohmann::ordered_json document = stitch_document(record_);
    document["figures"] = write_stitch_figures(sample, options_.out);
    write_file_atomically(record_file(), json_text(document));
  }

  const CaptureSet& set_;
  const DualFisheyeCamera& camera_;
  const StitchOptions& options_;
  fs::path folder_;
  int width_;
  StitchRecord record_{};
};

}  // namespace

CaptureSet stitch_set(const CaptureSet& set, const std::optional<DualFisheyeCamera>& camera,
                      const StitchOptions& options) {
  if (set.layout == FrameLayout::kPanorama) return set;
  const DualFisheyeCamera fitting = fitting_camera(set, camera);
  make_directories(options.out);
  SetStitcher stitcher(set, fitting, options);
  stitcher.run();
  CaptureSet panoramas = set;
  panoramas.layout = FrameLayout::kPanorama;
  panoramas.frame = stitcher.size();
  for (CaptureFrame& frame : panoramas.frames) {
    frame.file = stitcher.panorama_of(frame);
    frame.back.reset();
    frame.sha256.clear();
    if (frame.mask) frame.mask = stitcher.mask_of(frame);
  }
  return panoramas;
}

}  // namespace raywalk::calibrate
