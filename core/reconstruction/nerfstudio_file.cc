#include "core/reconstruction/nerfstudio_file.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/reconstruction/z_up_axes.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

constexpr const char* kEquirectangular = "EQUIRECTANGULAR";
// Of the columns of a rotation that other programs print with few digits.
constexpr double kRotationTolerance = 1e-3;

// z back instead of forward.
Eigen::Matrix3d look_along_minus_z() { return Eigen::Vector3d(1, 1, -1).asDiagonal(); }

ordered_json matrix_of(const CameraPose& pose) {
  const Eigen::Matrix3d rotation = z_up_matrix() * pose.world_from_camera * look_along_minus_z();
  const Eigen::Vector3d at = z_up_axes(pose.position_m);
  ordered_json rows = ordered_json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back({rotation(row, 0), rotation(row, 1), rotation(row, 2), at[row]});
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

CameraPose pose_of(const CheckedJson& matrix) {
  // Some programs leave out the last row, 0 0 0 1.
  const std::vector<CheckedJson> rows = matrix.items();
  if (rows.size() != 3 && rows.size() != 4) matrix.fail("is not a matrix of 4 x 4 numbers");
  Eigen::Matrix3d rotation;
  Eigen::Vector3d at;
  for (int row = 0; row < 3; ++row) {
    const std::vector<CheckedJson> values = rows[static_cast<std::size_t>(row)].items(4);
    for (int column = 0; column < 3; ++column) {
      rotation(row, column) = values[static_cast<std::size_t>(column)].number();
    }
    at[row] = values[3].number();
  }
  if ((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() > kRotationTolerance) {
    matrix.fail("is not a rotation and a position, but scales or shears");
  }
  if (rotation.determinant() < 0.0) {
    matrix.fail("mirrors; the axes must be right-handed, as nerfstudio's are");
  }
  return {z_up_axes(at), z_up_matrix() * rotation * look_along_minus_z()};
}

void require_equirectangular(const CheckedJson& root, const CheckedJson& frame) {
  const CheckedJson& holder = frame.has("camera_model") ? frame : root;
  const std::string model =
      holder.has("camera_model") ? holder.at("camera_model").text() : std::string("OPENCV");
  if (model == kEquirectangular) return;
  frame.fail(
      fmt::format("its camera_model is {}, that of a flat picture, not {}; give poses of panoramas",
                  excerpt(model), kEquirectangular));
}

std::vector<NerfstudioFrame> frames_of(const CheckedJson& root) {
  std::vector<NerfstudioFrame> frames;
  for (const CheckedJson& frame : root.at("frames").items()) {
    require_equirectangular(root, frame);
    frames.push_back({.file = frame.at("file_path").text(),
                      .mask = frame.has("mask_path") ? frame.at("mask_path").text() : "",
                      .pose = pose_of(frame.at("transform_matrix"))});
    if (frames.back().file.empty()) frame.fail("its file_path is empty");
  }
  if (frames.empty()) root.at("frames").fail("lists no frames");
  return frames;
}

}  // namespace

std::string nerfstudio_text(const std::vector<NerfstudioFrame>& frames, PanoramaSize size,
                            const std::string& points) {
  ordered_json document{{"camera_model", kEquirectangular},
                        {"w", size.width},
                        {"h", size.height},
                        {"fl_x", size.height},
                        {"fl_y", size.height},
                        {"cx", 0.5 * size.width},
                        {"cy", 0.5 * size.height}};
  if (!points.empty()) document["ply_file_path"] = points;
  ordered_json list = ordered_json::array();
  for (const NerfstudioFrame& frame : frames) {
    ordered_json entry{{"file_path", frame.file}};
    if (!frame.mask.empty()) entry["mask_path"] = frame.mask;
    entry["transform_matrix"] = matrix_of(frame.pose);
    list.push_back(std::move(entry));
  }
  document["frames"] = std::move(list);
  return json_text(document);
}

std::vector<NerfstudioFrame> nerfstudio_of_text(const std::string& text,
                                                const std::string& source) {
  return frames_of(CheckedJson::parse(text, source));
}

std::vector<NerfstudioFrame> read_nerfstudio(const std::filesystem::path& file) {
  return frames_of(CheckedJson::read(file));
}

}  // namespace raywalk
