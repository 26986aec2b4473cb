// The pictures that COLMAP works on: the faces of panoramas, and their masks.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "calibrate/base/frame_masks.h"
#include "calibrate/poses/colmap_workspace.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

// Features closer to the seam may come from either lens.
constexpr double kSeam_deg = 2.0;
// Half the neighbourhood of a small feature, as a share of a face's side: what is found nearer to
// the edge of a frame's own mask may be that edge.
constexpr double kMaskMargin = 4.0 / 512.0;

cv::Mat with_margin(const cv::Mat& face_mask) {
  const int side = 1 + 2 * static_cast<int>(std::ceil(kMaskMargin * face_mask.cols));
  cv::Mat smaller;
  cv::erode(face_mask, smaller, cv::Mat::ones(side, side, CV_8UC1));
  return smaller;
}

}  // namespace

bool ColmapWorkspace::cut_faces() {
  const fs::path images = options_.directory / "images";
  for (std::size_t face = 0; face < kFaceCount; ++face) {
    make_directories(images / fmt::format("f{}", face));
  }
  std::vector<std::size_t> missing;
  for (const std::size_t frame : keyframes_) {
    // Faces are written in order, so the last one marks completion.
    if (!fs::exists(images / image_name(frame, kFaceCount - 1))) missing.push_back(frame);
  }
  cut_masks();
  if (missing.empty()) return true;
  const FaceCutter cutter(faces_, set_.frame, options_.face_px);
  Progress progress("cutting faces", std::ssize(missing), "panoramas");
  parallel_for(0, static_cast<int>(missing.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const std::size_t frame = missing[i];
      const auto cut = cutter.cut(read_panorama(set_.frames[frame].file));
      for (std::size_t face = 0; face < kFaceCount; ++face) {
        cv::Mat grey;
        cv::cvtColor(cut[face], grey, cv::COLOR_BGR2GRAY);
        write_image(images / image_name(frame, face), grey);
      }
      progress.advance();
    }
  });
  return false;
}

// COLMAP needs a mask for every picture if it is given any.
bool ColmapWorkspace::has_masks() const {
  return options_.mask || options_.lenses || any_masks(set_);
}

void ColmapWorkspace::cut_masks() {
  if (!has_masks()) return;
  const cv::Size size(set_.frame.width, set_.frame.height);
  const cv::Mat mask = options_.mask ? *options_.mask : cv::Mat(size, CV_8UC1, cv::Scalar(255));
  const FaceCutter cutter(faces_, set_.frame, options_.face_px);
  const auto cut = cutter.cut_mask(mask, options_.lenses ? kSeam_deg : 0.0);
  for (std::size_t face = 0; face < kFaceCount; ++face) {
    const fs::path folder = options_.directory / "masks" / fmt::format("f{}", face);
    make_directories(folder);
    const fs::path one = options_.directory / "masks" / fmt::format("f{}.png", face);
    write_image(one, cut[face]);
    // Named like the picture plus ".png"; all of a face are the same.
    for (const std::size_t frame : keyframes_) {
      if (set_.frames[frame].mask) continue;
      const fs::path link = options_.directory / "masks" / (image_name(frame, face) + ".png");
      if (!fs::is_symlink(link)) fs::create_symlink(fs::path("..") / one.filename(), link);
    }
  }
  cut_own_masks(cutter, mask);
}

void ColmapWorkspace::cut_own_masks(const FaceCutter& cutter, const cv::Mat& common) {
  std::vector<std::size_t> missing;
  const fs::path folder = options_.directory / "masks";
  const auto file_of = [&](std::size_t frame, std::size_t face) {
    return folder / (image_name(frame, face) + ".png");
  };
  for (const std::size_t frame : keyframes_) {
    const bool own = set_.frames[frame].mask.has_value();
    // Written in order, so the last one marks completion.
    if (own && !fs::exists(file_of(frame, kFaceCount - 1))) missing.push_back(frame);
  }
  parallel_for(0, static_cast<int>(missing.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const std::size_t frame = missing[i];
      const auto cut =
          cutter.cut_mask(joint_mask(set_, frame, common), options_.lenses ? kSeam_deg : 0.0);
      for (std::size_t face = 0; face < kFaceCount; ++face) {
        write_image(file_of(frame, face), with_margin(cut[face]));
      }
    }
  });
}

}  // namespace raywalk::calibrate
