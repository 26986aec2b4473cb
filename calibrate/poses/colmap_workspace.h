// The directory that COLMAP works in, and its steps: faces cut from the panoramas, features,
// matches of chosen pairs, triangulation from given poses.
//
//   images/f<face>/<frame>.png, masks/f<face>/<frame>.png.png (frames without a mask of their own
//   share one file), database.db, model/, log.txt
//   inputs.txt: fingerprint of the inputs; if they are unchanged an interrupted run is resumed,
//   else the directory is emptied
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/colmap_program.h"
#include "calibrate/poses/match_pairs.h"
#include "calibrate/poses/matching_faces.h"
#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/seen_points.h"
#include "core/geometry/fisheye_lens.h"
#include "core/reconstruction/colmap_model.h"
#include "core/reconstruction/panorama_faces.h"

namespace raywalk::calibrate {

struct WorkspaceOptions {
  std::filesystem::path directory{};
  int face_px = 512;
  int threads = 1;
  std::optional<cv::Mat> mask{};              // CV_8UC1 of the panoramas' size, of all frames
  std::optional<DualFisheyeLayout> lenses{};  // whose seams are kept clear of features
};

// The matches of all faces of two frames.
struct FrameMatches {
  int face_pairs = 0;  // with matches
  std::vector<BearingMatch> matches{};
};

// Thresholds of a triangulation: the angle between an observed and a predicted ray, and the
// reprojection error in pixels of a face of 512.
struct TriangulationRound {
  double angle_deg = 2.0;
  double error_px = 4.0;
};

class ColmapWorkspace {
 public:
  // Creates the directory, or resumes an interrupted run with the same inputs. `set` and `colmap`
  // must outlive it; `keyframes` are the frames to work on. Throws Error if `colmap` lacks options.
  ColmapWorkspace(const CaptureSet& set, std::vector<std::size_t> keyframes,
                  const ColmapProgram& colmap, WorkspaceOptions options);

  // Each returns whether its work was already done. They throw Error as ColmapProgram::run does and
  // for files that cannot be read or written; Interrupted.
  bool cut_faces();
  bool find_features();
  // Matches the faces of each pair that look the same way by the frames' poses.
  bool match(std::span<const FramePair> pairs, const FramePoses& poses);

  // Number of features of each keyframe, over its faces.
  std::map<std::size_t, int> feature_counts() const;
  // Verified matches.
  const std::map<FramePair, FrameMatches>& matches() const { return matches_; }

  // Scene points triangulated from the matches at these poses by COLMAP's point_triangulator.
  SeenPoints triangulate(const FramePoses& poses, const TriangulationRound& round);

 private:
  struct FaceImage {
    std::size_t frame = 0;
    std::size_t face = 0;
    std::uint32_t camera = 0;  // id in the database
    int features = 0;
  };

  void start_anew_if_changed();
  std::string inputs_text() const;
  static std::string image_name(std::size_t frame, std::size_t face);
  ColmapCommand extraction() const;
  ColmapCommand matching(const std::filesystem::path& list) const;
  ColmapCommand triangulation(const TriangulationRound& round) const;
  bool has_masks() const;
  void cut_masks();
  void cut_own_masks(const FaceCutter& cutter, const cv::Mat& common);
  std::vector<std::string> image_pairs(std::span<const FramePair> pairs,
                                       const FramePoses& poses) const;
  void match_in_batches(std::span<const std::string> list) const;
  void read_images();
  void read_matches();
  Eigen::Vector3d bearing(const FaceImage& image, FacePixel pixel) const;
  // The usable images at these poses, without points.
  ColmapModel model_of(const FramePoses& poses) const;
  SeenPoints points_of(const ColmapModel& model) const;

  const CaptureSet& set_;
  std::vector<std::size_t> keyframes_;
  const ColmapProgram& colmap_;
  WorkspaceOptions options_;
  MatchingFaces faces_;
  std::filesystem::path log_;
  std::filesystem::path database_;
  std::map<std::uint32_t, FaceImage> images_{};  // by id in the database
  std::set<std::uint32_t> usable_{};             // images with enough matches to triangulate
  std::map<FramePair, FrameMatches> matches_{};
};

}  // namespace raywalk::calibrate
