#include "calibrate/poses/colmap_workspace.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/poses/colmap_database.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/sqlite_connection.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

// Incremented when faces, features or matches change for the same inputs, to discard old ones.
constexpr int kWorkspaceVersion = 1;
// The time of matching grows with the square of the number of features, and more add little: a face
// has a few hundred that match in its neighbours.
constexpr int kMostFeatures = 1024;
// COLMAP's minimum number of matches between two pictures.
constexpr std::size_t kLeastPairMatches = 15;
constexpr double kRoundFace_px = 512.0;  // unit of TriangulationRound::error_px

std::size_t count_rows(const fs::path& database, const std::string& table) {
  if (!fs::exists(database)) return 0;
  SqliteConnection connection(database, SqliteAccess::kReadOnly);
  if (connection.integer("SELECT count(*) FROM sqlite_master WHERE name = '" + table + "'") == 0) {
    return 0;
  }
  return static_cast<std::size_t>(connection.integer("SELECT count(*) FROM " + table));
}

void remove_directory(const fs::path& directory) {
  std::error_code error;
  fs::remove_all(directory, error);
  if (error) {
    throw Error(fmt::format("{}: cannot be removed ({}); remove it by hand", directory.string(),
                            error.message()));
  }
}

}  // namespace

ColmapWorkspace::ColmapWorkspace(const CaptureSet& set, std::vector<std::size_t> keyframes,
                                 const ColmapProgram& colmap, WorkspaceOptions options)
    : set_(set),
      keyframes_(std::move(keyframes)),
      colmap_(colmap),
      options_(std::move(options)),
      faces_(panorama_faces(options_.lenses)),
      log_(options_.directory / "log.txt"),
      database_(options_.directory / "database.db") {
  // Now rather than after hours of work.
  for (const ColmapCommand& command : {extraction(), matching({}), triangulation({})}) {
    colmap_.translated(command);
  }
  start_anew_if_changed();
}

// Masks depend on whether there are lenses; the lenses' positions affect only poses.
std::string ColmapWorkspace::inputs_text() const {
  std::string text =
      fmt::format("version {}\ncolmap {}\nface_px {}\nlenses {}\n", kWorkspaceVersion,
                  colmap_.version(), options_.face_px, options_.lenses.has_value());
  if (options_.mask) text += "mask " + sha256_of_pixels(*options_.mask) + "\n";
  for (const std::size_t frame : keyframes_) {
    const CaptureFrame& of = set_.frames[frame];
    text += of.file.string() + " " + stamp_of(of.file).text() + "\n";
    if (of.mask) text += "mask " + of.mask->string() + " " + stamp_of(*of.mask).text() + "\n";
  }
  return text;
}

void ColmapWorkspace::start_anew_if_changed() {
  const fs::path inputs = options_.directory / "inputs.txt";
  const std::string text = inputs_text();
  if (fs::exists(inputs) && read_file(inputs) == text) return;
  remove_directory(options_.directory);
  make_directories(options_.directory);
  write_file_atomically(inputs, text);
}

std::string ColmapWorkspace::image_name(std::size_t frame, std::size_t face) {
  return fmt::format("f{}/{:05d}.png", face, frame);
}

ColmapCommand ColmapWorkspace::extraction() const {
  const double focal_px = face_focal_px(options_.face_px);
  ColmapCommand command{"feature_extractor",
                        {{"--database_path", database_.string()},
                         {"--image_path", (options_.directory / "images").string()},
                         {"--ImageReader.camera_model", "PINHOLE"},
                         {"--ImageReader.single_camera_per_folder", "1"},
                         // Focal lengths and principal point.
                         {"--ImageReader.camera_params", fmt::format("{0},{0},{0},{0}", focal_px)},
                         {"--FeatureExtraction.use_gpu", "0"},
                         {"--FeatureExtraction.num_threads", std::to_string(options_.threads)},
                         {"--SiftExtraction.max_num_features", std::to_string(kMostFeatures)},
                         {"--SiftExtraction.max_num_orientations", "1"},
                         {"--SiftExtraction.first_octave", "0"}}};
  if (has_masks()) {
    command.options.emplace_back("--ImageReader.mask_path",
                                 (options_.directory / "masks").string());
  }
  return command;
}

bool ColmapWorkspace::find_features() {
  const std::size_t wanted = keyframes_.size() * kFaceCount;
  const bool done = count_rows(database_, "keypoints") >= wanted;
  if (!done) {
    Progress progress("finding features", std::ssize(keyframes_) * kFaceCount, "faces");
    colmap_.run(extraction(), log_, [&](std::string_view line) {
      if (line.find("Processed file") != std::string_view::npos) progress.advance();
    });
  }
  read_images();
  return done;
}

void ColmapWorkspace::read_images() {
  const auto images = read_database_images(database_);
  images_.clear();
  for (const std::size_t frame : keyframes_) {
    for (std::size_t face = 0; face < kFaceCount; ++face) {
      const auto image = images.find(image_name(frame, face));
      if (image == images.end()) continue;
      const DatabaseImage& found = image->second;
      images_[found.id] = {frame, face, found.camera, found.features};
    }
  }
}

std::map<std::size_t, int> ColmapWorkspace::feature_counts() const {
  std::map<std::size_t, int> counts;
  for (const std::size_t frame : keyframes_) counts[frame] = 0;
  for (const auto& [id, image] : images_) counts[image.frame] += image.features;
  return counts;
}

// Lines of a list for COLMAP: two faces with features that look the same way.
std::vector<std::string> ColmapWorkspace::image_pairs(std::span<const FramePair> pairs,
                                                      const FramePoses& poses) const {
  std::set<std::pair<std::size_t, std::size_t>> featured;  // frame, face
  for (const auto& [id, image] : images_) {
    if (image.features > 0) featured.insert({image.frame, image.face});
  }
  std::vector<std::string> lines;
  for (const auto& [one, other] : pairs) {
    if (!poses[one] || !poses[other]) continue;
    for (const auto& [face, other_face] : overlapping_faces(faces_, poses[one]->world_from_camera,
                                                            poses[other]->world_from_camera)) {
      if (!featured.contains({one, face}) || !featured.contains({other, other_face})) continue;
      lines.push_back(fmt::format("{} {}\n", image_name(one, face), image_name(other, other_face)));
    }
  }
  return lines;
}

bool ColmapWorkspace::match(std::span<const FramePair> pairs, const FramePoses& poses) {
  const std::vector<std::string> list = image_pairs(pairs, poses);
  const fs::path file = options_.directory / "pairs.txt";
  const std::string text = fmt::format("{}", fmt::join(list, ""));
  const bool same = fs::exists(file) && read_file(file) == text;
  const bool done = same && count_rows(database_, "two_view_geometries") >= list.size();
  // COLMAP 3.10 aborts where no picture has a feature.
  if (!done && !list.empty()) {
    write_file_atomically(file, text);
    match_in_batches(list);
  }
  read_matches();
  return done;
}

ColmapCommand ColmapWorkspace::matching(const fs::path& list) const {
  const double max_error_px = 2.0 * options_.face_px / kRoundFace_px;
  return {"matches_importer",
          {{"--database_path", database_.string()},
           {"--match_list_path", list.string()},
           {"--match_type", "pairs"},
           {"--FeatureMatching.use_gpu", "0"},
           {"--FeatureMatching.num_threads", std::to_string(options_.threads)},
           {"--TwoViewGeometry.max_error", fmt::format("{}", max_error_px)}}};
}

// COLMAP tells and stores nothing of the pairs of a list before all are matched, so it is given
// them in pieces; it skips pairs that an interrupted run has matched.
void ColmapWorkspace::match_in_batches(std::span<const std::string> list) const {
  // Starting COLMAP takes less time than matching a few pairs.
  constexpr std::size_t kLeastPairs = 16;
  constexpr std::size_t kBatches = 20;
  const std::size_t batch = std::max(kLeastPairs, (list.size() + kBatches - 1) / kBatches);
  const fs::path file = options_.directory / "batch.txt";
  Progress progress("matching features", std::ssize(list), "pairs");
  for (std::size_t begin = 0; begin < list.size(); begin += batch) {
    const auto pairs = list.subspan(begin, std::min(batch, list.size() - begin));
    write_file_atomically(file, fmt::format("{}", fmt::join(pairs, "")));
    colmap_.run(matching(file), log_);
    progress.advance(std::ssize(pairs));
  }
}

Eigen::Vector3d ColmapWorkspace::bearing(const FaceImage& image, FacePixel pixel) const {
  return direction_of(faces_[image.face], options_.face_px, pixel);
}

void ColmapWorkspace::read_matches() {
  matches_.clear();
  usable_.clear();
  for (const VerifiedPair& pair : read_verified_pairs(database_)) {
    const auto first = images_.find(pair.first);
    const auto second = images_.find(pair.second);
    if (first == images_.end() || second == images_.end()) continue;
    if (pair.in_first.size() >= kLeastPairMatches) usable_.insert({pair.first, pair.second});
    const bool swapped = first->second.frame > second->second.frame;
    FrameMatches& of_frames = matches_[std::minmax(first->second.frame, second->second.frame)];
    ++of_frames.face_pairs;
    for (std::size_t i = 0; i < pair.in_first.size(); ++i) {
      BearingMatch match{bearing(first->second, pair.in_first[i]),
                         bearing(second->second, pair.in_second[i])};
      if (swapped) std::swap(match.in_first, match.in_second);
      of_frames.matches.push_back(match);
    }
  }
}

ColmapModel ColmapWorkspace::model_of(const FramePoses& poses) const {
  ColmapModel model;
  std::set<std::uint32_t> cameras;
  for (const auto& [id, image] : images_) {
    const auto& pose = poses[image.frame];
    // COLMAP fails on pictures without matches.
    if (!pose || !usable_.contains(id)) continue;
    if (cameras.insert(image.camera).second) {
      model.cameras.push_back({image.camera, options_.face_px, face_focal_px(options_.face_px)});
    }
    const PanoramaFace& face = faces_[image.face];
    model.images.push_back({id,
                            image.camera,
                            image_name(image.frame, image.face),
                            colmap_pose({pose->position_m, pose->world_from_camera}, face),
                            {}});
  }
  return model;
}

SeenPoints ColmapWorkspace::points_of(const ColmapModel& model) const {
  std::map<std::uint32_t, const ColmapImage*> by_id;
  for (const ColmapImage& image : model.images) by_id[image.id] = &image;
  SeenPoints seen;
  for (const ColmapPoint& point : model.points) {
    const std::size_t index = seen.points_m.size();
    seen.points_m.push_back(flipped(point.position));
    for (const ColmapTrackElement& element : point.track) {
      const auto image = images_.find(element.image);
      if (image == images_.end()) continue;
      const FacePixel pixel = by_id.at(element.image)->features[element.feature].pixel;
      const PanoramaFace& face = faces_[image->second.face];
      seen.observations.push_back(
          {image->second.frame, index, bearing(image->second, pixel), face.centre_m});
    }
  }
  return seen;
}

ColmapCommand ColmapWorkspace::triangulation(const TriangulationRound& round) const {
  const std::string angle = fmt::format("{}", round.angle_deg);
  const std::string again = fmt::format("{}", std::max(round.angle_deg, 2.0));
  const std::string error_px = fmt::format("{}", round.error_px * options_.face_px / kRoundFace_px);
  return {"point_triangulator",
          {{"--database_path", database_.string()},
           {"--image_path", (options_.directory / "images").string()},
           {"--input_path", (options_.directory / "start").string()},
           {"--output_path", (options_.directory / "model").string()},
           {"--clear_points", "1"},
           {"--Mapper.extract_colors", "0"},
           {"--Mapper.num_threads", std::to_string(options_.threads)},
           {"--Mapper.tri_create_max_angle_error", angle},
           {"--Mapper.tri_continue_max_angle_error", angle},
           {"--Mapper.tri_re_max_angle_error", again},
           {"--Mapper.tri_merge_max_reproj_error", error_px},
           {"--Mapper.tri_complete_max_reproj_error", error_px},
           {"--Mapper.filter_max_reproj_error", error_px},
           {"--Mapper.ba_global_max_refinements", "1"}}};
}

SeenPoints ColmapWorkspace::triangulate(const FramePoses& poses, const TriangulationRound& round) {
  const ColmapModel model = model_of(poses);
  if (model.images.size() < 2) return {};
  const fs::path start = options_.directory / "start";
  const fs::path result = options_.directory / "model";
  make_directories(start);
  make_directories(result);
  write_colmap_model(start, model);
  Progress progress("triangulating", std::ssize(model.images), "faces");
  colmap_.run(triangulation(round), log_, [&](std::string_view line) {
    if (line.find("Triangulating image") != std::string_view::npos) progress.advance();
  });
  return points_of(read_colmap_model(result));
}

}  // namespace raywalk::calibrate
