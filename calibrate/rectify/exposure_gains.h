// The gains of linear light that make the frames of a capture equally bright, where they are not.
//
// A camera's exposure and white balance may drift during a capture, even if they were locked.
// Frames taken near each other show the same surfaces (matched_patches.h); the ratios of their
// light, solved over all links (light_estimate.h), are the frames' exposures. What is significant
// against its uncertainty (exposure_decision.h) is corrected; nothing else is touched.
//
// The uncertainty has two parts: the scatter between parts of the scene, and what halves of the
// patches disagree by beyond that scatter. The halves are chosen by what parallax, bad matches and
// vignetting depend on, so that these errors show.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "calibrate/rectify/exposure_decision.h"
#include "calibrate/rectify/matched_patches.h"

namespace raywalk::calibrate {

// Factors of linear light: red, green, blue; above 0.
using LightGain = std::array<double, 3>;

// Applies a gain of linear light to sRGB levels (0..255), clamped to 255.
class LevelsUnderGain {
 public:
  explicit LevelsUnderGain(const LightGain& gain);
  // In OpenCV's order blue, green, red.
  cv::Vec3f operator()(const cv::Vec3f& levels) const;

 private:
  static constexpr int kStepsPerLevel = 4;
  std::array<std::array<float, 255 * kStepsPerLevel + 2>, 3> table_;
};

// The light of all colours, and of red and blue relative to it.
inline constexpr int kLightKinds = 3;
// "brightness", "red", "blue".
const char* light_kind_name(int kind);

// Two halves of the patches, solved separately. Root mean squares over the frames, natural
// logarithms of light.
struct HalvesComparison {
  std::string split{};      // "match quality", "distance", "height", "direction of motion"
  double difference = 0.0;  // of the halves
  double by_chance = 0.0;   // expected from the scatter between parts of the scene
};

struct MeasuredLight {
  double spread = 0.0;  // root mean square of the exposures' logarithms
  std::vector<HalvesComparison> halves{};
  ExposureDecision decision{};  // by frame
};

struct ExposureResult {
  std::vector<LightGain> gains{};  // by frame; exactly 1 where nothing is corrected
  std::vector<bool> measured{};    // by frame: whether it is linked
  int links = 0;                   // compared
  int patches = 0;                 // used of them
  int scene_parts = 0;             // of kSceneParts, in which patches lie
  // Links beyond those that join the frames close this many loops; what the median of a link
  // differs by from the exposures of its frames, root mean square, is what they do not close by.
  int loops = 0;
  double loop_error = 0.0;
  std::array<MeasuredLight, kLightKinds> light{};
};

// What undoes these differences of the logarithm of light, one for each kind.
LightGain gain_of(double brightness, double red, double blue);

// Two frames that show the same surfaces; indices into CaptureSet::frames.
struct FrameLink {
  int from = 0;
  int to = 0;
};

struct LinkPatches {
  FrameLink link{};
  std::vector<MatchedPatch> patches{};
};

// `lines` lists the frames with poses, `centre_m` is the middle of their positions.
ExposureResult measure_exposures(std::span<const LinkPatches> links, int frames,
                                 std::span<const PictureLine> lines,
                                 const Eigen::Vector3d& centre_m);

}  // namespace raywalk::calibrate
