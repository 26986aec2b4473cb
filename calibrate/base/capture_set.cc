#include "calibrate/base/capture_set.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibrate/base/frame_masks.h"
#include "calibrate/base/frame_readers.h"
#include "core/base/error.h"
#include "core/files/image_file.h"
#include "core/geometry/line_gaps.h"
#include "core/geometry/plan_line.h"
#include "core/session/session_file.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

CaptureSet read_frames(const CaptureInput& input) {
  if (!fs::is_directory(input.directory)) {
    throw Error(input.directory.string() +
                ": no such directory; give a capture session, or a "
                "folder with poses.csv");
  }
  if (fs::exists(session_database_path(input.directory))) return read_session_frames(input);
  if (fs::exists(frame_list_of(input.directory))) return read_listed_frames(input);
  throw Error(input.directory.string() +
              ": holds neither a capture session (session.db) nor a frame list (poses.csv); list "
              "where each panorama was taken (file,x,y,z in metres), or take the poses of another "
              "program by raywalk-calibrate import");
}

// Orders the frames line by line and drops lines without frames.
void number_frames(CaptureSet* set) {
  const std::size_t stations = set->stations();
  for (std::size_t i = 0; i < stations; ++i) {
    set->lines[static_cast<std::size_t>(set->frames[i].line)].frames.push_back(static_cast<int>(i));
  }
  std::vector<CaptureLine> lines;
  for (CaptureLine& line : set->lines) {
    if (line.frames.empty()) continue;
    for (const int frame : line.frames) {
      set->frames[static_cast<std::size_t>(frame)].line = static_cast<int>(lines.size());
    }
    lines.push_back(std::move(line));
  }
  set->lines = std::move(lines);
}

ImageHeader header_of(const fs::path& file, FrameLayout layout) {
  return layout == FrameLayout::kPanorama ? panorama_header_of(file) : picture_header_of(file);
}

void require_one_size(CaptureSet* set) {
  const fs::path& first = set->frames.front().file;
  set->frame = header_of(first, set->layout).size;
  TurnedPictures turned;
  const auto require_same = [&](const CaptureFrame& frame, const fs::path& file) {
    if (!frame.where.empty() && !fs::exists(file)) {
      throw Error(fmt::format("{}: {}: no such file; put it there, or correct the row", frame.where,
                              file.string()));
    }
    const ImageHeader header = header_of(file, set->layout);
    const PanoramaSize size = header.size;
    turned.add(file, header.orientation);
    if (size == set->frame) return header;
    if (frame.held_out()) {
      throw Error(fmt::format(
          "{}: {} is {}x{}, but the frames of poses.csv are {}x{}; held-out frames must be of the "
          "same camera and setting: remove the row, or move gt.csv away",
          frame.where, file.string(), size.width, size.height, set->frame.width,
          set->frame.height));
    }
    throw Error(
        fmt::format("{}: {}x{}, but {} is {}x{}; all frames must be of one camera and one "
                    "setting: remove the others",
                    file.string(), size.width, size.height, first.string(), set->frame.width,
                    set->frame.height));
  };
  for (CaptureFrame& frame : set->frames) {
    const ImageHeader header = require_same(frame, frame.file);
    if (!frame.mask && !frame.back && header.has_alpha) frame.mask = frame.file;
    if (frame.back) require_same(frame, *frame.back);
  }
  turned.warn();
}

// The nominal line through its stations, and their spacing.
struct NominalLine {
  PlanLine line{};
  double spacing_m = 0.0;
  std::vector<double> along_m{};
};

NominalLine nominal_line(const CaptureSet& set, const CaptureLine& captured) {
  std::vector<Eigen::Vector2d> points;
  for (const int frame : captured.frames) {
    const Eigen::Vector3d& place = set.frames[static_cast<std::size_t>(frame)].nominal_m;
    points.emplace_back(place.x(), place.z());
  }
  NominalLine nominal{.line = fit_line(points, captured.axis)};
  for (const Eigen::Vector2d& point : points) nominal.along_m.push_back(nominal.line.along(point));
  std::sort(nominal.along_m.begin(), nominal.along_m.end());
  std::vector<double> gaps_m;
  for (std::size_t i = 1; i < nominal.along_m.size(); ++i) {
    gaps_m.push_back(nominal.along_m[i] - nominal.along_m[i - 1]);
  }
  nominal.spacing_m = covering_spacing(std::move(gaps_m));
  return nominal;
}

Eigen::Vector2d intersection(const PlanLine& a, const PlanLine& b) {
  Eigen::Matrix2d directions;
  directions << a.direction, -b.direction;
  return a.origin + (directions.inverse() * (b.origin - a.origin))[0] * a.direction;
}

bool is_near(const NominalLine& line, const Eigen::Vector2d& point) {
  const double along_m = line.line.along(point);
  return std::any_of(line.along_m.begin(), line.along_m.end(), [&](double station_m) {
    return std::abs(station_m - along_m) <= line.spacing_m;
  });
}

}  // namespace

std::size_t CaptureSet::stations() const {
  return static_cast<std::size_t>(std::count_if(
      frames.begin(), frames.end(), [](const CaptureFrame& frame) { return !frame.held_out(); }));
}

double CaptureSet::rail_m(std::size_t frame) const {
  const CaptureFrame& of = frames[frame];
  const bool along_x = lines[static_cast<std::size_t>(of.line)].axis == LineAxis::kX;
  return along_x ? of.nominal_m.x() : of.nominal_m.z();
}

double CaptureSet::nominal_distance_m(std::size_t a, std::size_t b) const {
  return (frames[b].nominal_m - frames[a].nominal_m).norm();
}

bool CaptureSet::is_validation(const CaptureFrame& frame) const {
  return frame.held_out() || lines[static_cast<std::size_t>(frame.line)].validation;
}

std::unordered_map<std::string, std::size_t> indices_by_name(const CaptureSet& set) {
  std::unordered_map<std::string, std::size_t> indices;
  for (std::size_t i = 0; i < set.frames.size(); ++i) indices.emplace(set.frames[i].name, i);
  return indices;
}

CaptureSet read_capture_set(const CaptureInput& input) {
  CaptureSet set = read_frames(input);
  number_frames(&set);
  require_one_size(&set);
  require_usable_masks(set);
  return set;
}

CaptureSet stations_only(const CaptureSet& set) {
  CaptureSet stations = set;
  stations.frames.resize(set.stations());
  return stations;
}

std::vector<LineIntersection> intersections_of(const CaptureSet& set) {
  std::vector<LineIntersection> intersections;
  for (std::size_t x = 0; x < set.lines.size(); ++x) {
    if (set.lines[x].axis != LineAxis::kX || set.lines[x].frames.size() < 2) continue;
    const NominalLine along_x = nominal_line(set, set.lines[x]);
    for (std::size_t z = 0; z < set.lines.size(); ++z) {
      if (set.lines[z].axis != LineAxis::kZ || set.lines[z].frames.size() < 2) continue;
      const NominalLine along_z = nominal_line(set, set.lines[z]);
      const Eigen::Vector2d at = intersection(along_x.line, along_z.line);
      if (!is_near(along_x, at) || !is_near(along_z, at)) continue;
      intersections.push_back(
          {.along_x = static_cast<int>(x), .along_z = static_cast<int>(z), .at = {at.x(), at.y()}});
    }
  }
  return intersections;
}

}  // namespace raywalk::calibrate
