#include "calibrate/import/import_poses.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "calibrate/import/imported_poses.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/json.h"
#include "core/files/output_folder.h"
#include "core/geometry/line_gaps.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions{".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"};

std::optional<fs::path> existing(const fs::path& file) {
  if (fs::is_regular_file(file)) return file;
  // A name without an extension may have dots of its own.
  for (const char* extension : kExtensions) {
    fs::path added = file;
    added += extension;
    if (fs::is_regular_file(added)) return added;
  }
  for (const char* extension : kExtensions) {
    const fs::path replaced = fs::path(file).replace_extension(extension);
    if (fs::is_regular_file(replaced)) return replaced;
  }
  return std::nullopt;
}

fs::path file_of(const ImportedFrame& frame, const fs::path& folder) {
  for (const fs::path& name : {fs::path(frame.file), fs::path(frame.file).filename()}) {
    if (const auto file = existing(folder / name)) return *file;
  }
  throw Error(
      fmt::format("{}: there is no panorama {} in {}; put it there, or name another folder "
                  "with --panoramas",
                  frame.where, excerpt(frame.file), folder.string()));
}

bool is_picture(const fs::path& file) {
  const std::string extension = file.extension().string();
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

void warn_of_others(const std::vector<fs::path>& files, const fs::path& folder) {
  const std::set<fs::path> used(files.begin(), files.end());
  std::size_t others = 0;
  std::string first;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (!is_picture(entry.path()) || used.contains(entry.path())) continue;
    ++others;
    if (first.empty() || entry.path().filename() < first) first = entry.path().filename();
  }
  if (others == 0) return;
  spdlog::warn("{}: {} pictures have no pose and are left out, such as {}", folder.string(), others,
               first);
}

// The file of each frame: in `folder`, or else where the source says; under the name that the
// source gives it or, without its folders, its last part; with its extension or, if there is no
// such file, another one of pictures. Warns of panoramas in the folder that have no pose. Throws
// UsageError if the folder is unknown; Error naming the frame for one without a file, and as
// panorama_header_of does.
std::vector<fs::path> find_panoramas(const ImportedPoses& poses,
                                     const std::optional<fs::path>& folder) {
  const std::optional<fs::path> chosen = folder ? folder : poses.panoramas;
  if (!chosen) {
    throw UsageError(poses.kind + " does not say where the panoramas are; give --panoramas");
  }
  if (!fs::is_directory(*chosen)) {
    throw Error(chosen->string() + ": no such folder of panoramas; give --panoramas");
  }
  std::vector<fs::path> files;
  std::set<fs::path> used;
  for (const ImportedFrame& frame : poses.frames) {
    files.push_back(file_of(frame, *chosen));
    if (!used.insert(files.back()).second) {
      throw Error(fmt::format("{}: {} has a pose already", frame.where, files.back().string()));
    }
    panorama_header_of(files.back());
  }
  warn_of_others(files, *chosen);
  return files;
}

constexpr const char* kSignature = "raywalk-import";

void require_free(const ImportOptions& options) {
  const fs::path list = options.out / "poses.csv";
  const fs::path record = options.out / "import.json";
  if (!fs::exists(fs::symlink_status(list)) && !fs::exists(fs::symlink_status(record))) return;
  if (!options.replace) require_absent(list, "--out");
  if (!options.replace) require_absent(record, "--out");
  if (fs::exists(record) && read_file_prefix(record, 400).find(kSignature) != std::string::npos) {
    return;
  }
  throw Error("--force does not replace " + list.string() +
              ": it was not made by an import; remove it yourself or choose another name");
}

std::vector<KnownPosition> known_positions(const ImportedPoses& poses, const fs::path& list) {
  const FrameSearch search(poses.frames);
  std::vector<KnownPosition> known;
  for (const Frame& frame : read_frame_list(list)) {
    const auto found = search.find(frame.file);
    if (found) known.push_back({*found, frame.position_m});
  }
  return known;
}

double residual_mm(const ImportedPoses& poses, const GridAxes& axes,
                   const std::vector<KnownPosition>& known) {
  double sum = 0.0;
  for (const KnownPosition& position : known) {
    sum += (moved(axes, poses.frames[position.frame].pose).position_m - position.position_m)
               .squaredNorm();
  }
  return 1000.0 * std::sqrt(sum / static_cast<double>(known.size()));
}

GridAxes axes_of(const ImportedPoses& poses, const ImportOptions& options) {
  if (options.reference) {
    const std::vector<KnownPosition> known = known_positions(poses, *options.reference);
    GridAxes axes = fit_known_positions(poses, known);
    spdlog::info("{} panoramas of {} are within {:.1f} mm (root mean square) of their positions",
                 known.size(), options.reference->string(), residual_mm(poses, axes, known));
    return axes;
  }
  if (!poses.in_world && !options.axes.scale.any()) {
    throw UsageError(fmt::format(
        "{}: {} does not say how long its unit is; give --cell-m, --spacing-mm, --distance, "
        "--reference or, if it is metres, --scale 1",
        options.source.string(), poses.kind));
  }
  return fit_grid_axes(poses, options.axes);
}

// Where a list in `out` finds a file.
std::string file_for_list(const fs::path& file, const fs::path& out) {
  const fs::path absolute = fs::absolute(file).lexically_normal();
  const fs::path relative = absolute.lexically_relative(fs::absolute(out).lexically_normal());
  return (relative.empty() ? absolute : relative).generic_string();
}

std::vector<ListedFrame> rows_of(const ImportedPoses& poses, const GridAxes& axes, const Grid& grid,
                                 const std::vector<fs::path>& files, const fs::path& out) {
  std::map<std::string, std::string> line_of;
  for (const Line& line : grid.lines) {
    for (const Station& station : line.stations) line_of[station.file] = line.id;
  }
  std::vector<ListedFrame> rows;
  for (std::size_t i = 0; i < poses.frames.size(); ++i) {
    const CameraPose pose = moved(axes, poses.frames[i].pose);
    rows.push_back({.file = file_for_list(files[i], out),
                    .position_m = pose.position_m,
                    .attitude = attitude_from_world_from_camera(pose.world_from_camera),
                    .line = line_of.at(poses.frames[i].file)});
  }
  return rows;
}

std::string record_text(const ImportOptions& options, const ImportedPoses& poses,
                        const GridAxes& axes) {
  using nlohmann::ordered_json;
  ordered_json rotation = ordered_json::array();
  for (int row = 0; row < 3; ++row) {
    rotation.push_back({axes.rotation(row, 0), axes.rotation(row, 1), axes.rotation(row, 2)});
  }
  const Eigen::Vector3d& t = axes.translation_m;
  const ordered_json document{{"format", kSignature},
                              {"format_version", 1},
                              {"source", options.source.string()},
                              {"kind", poses.kind},
                              {"frames", poses.frames.size()},
                              {"scale", axes.scale},
                              {"rotation", rotation},
                              {"translation_m", {t.x(), t.y(), t.z()}}};
  return json_text(document);
}

std::string summary_of(const ImportedPoses& poses, const GridAxes& axes, const Grid& grid,
                       const ImportOptions& options) {
  std::vector<double> medians;
  for (const Line& line : grid.lines) medians.push_back(1000.0 * median_spacing_m(line));
  const auto [least, most] = std::minmax_element(medians.begin(), medians.end());
  constexpr std::size_t kShownCells = 4;
  std::string cells;
  for (std::size_t i = 0; i < std::min(grid.cells.size(), kShownCells); ++i) {
    const Cell& cell = grid.cells[i];
    cells += fmt::format("{}{:.3f} x {:.3f} m", i == 0 ? "" : ", ", cell.x_max_m - cell.x_min_m,
                         cell.z_max_m - cell.z_min_m);
  }
  if (grid.cells.size() > kShownCells) cells += ", ...";
  const std::string tolerance =
      options.axes.tolerance.off_line_m
          ? fmt::format(" --line-tolerance-mm {:g}", 1000.0 * *options.axes.tolerance.off_line_m)
          : "";
  return fmt::format(
      "{} of {}: {}, stations {:.1f} to {:.1f} mm apart, {}{}; scale {:.6g}\n"
      "next: raywalk-build-lf all --frames {}{}",
      counted(poses.frames.size(), "panorama"), poses.kind, counted(grid.lines.size(), "line"),
      *least, *most, counted(grid.cells.size(), "cell"), cells.empty() ? "" : " (" + cells + ")",
      axes.scale, escaped(shell_word((options.out / "poses.csv").string())), tolerance);
}

}  // namespace

std::string import_poses(const ImportOptions& options) {
  require_free(options);
  const ImportedPoses poses = read_imported_poses(options.source, options.faces);
  const std::vector<fs::path> files = find_panoramas(poses, options.panoramas);
  const GridAxes axes = axes_of(poses, options);
  const Grid grid = find_grid(stations_of(poses.frames, axes), options.axes.tolerance);
  if (const auto doubt = doubt_of_unit(grid)) {
    spdlog::warn("{}: {}", options.source.string(), *doubt);
  }
  for (const std::string& note : line_notes(grid)) {
    spdlog::warn("{}: {}", options.source.string(), note);
  }
  make_directories(options.out);
  write_file_atomically(options.out / "import.json", record_text(options, poses, axes));
  write_file_atomically(options.out / "poses.csv",
                        frame_list_text(rows_of(poses, axes, grid, files, options.out)));
  return summary_of(poses, axes, grid, options);
}

}  // namespace raywalk::calibrate
