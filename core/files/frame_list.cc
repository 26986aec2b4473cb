#include "core/files/frame_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/listed_files.h"

namespace raywalk {
namespace {

constexpr double kMaxDegrees = 3600.0;  // ten turns

// A field whose value, where it is larger than the limit, is of another unit or column.
double read_within(double limit, const char* meaning, const CsvTable& table, std::size_t row,
                   const std::string& column) {
  const double value = table.number(row, column);
  if (std::abs(value) <= limit) return value;
  throw Error(fmt::format("{}: {} = {:g} is not {} (at most {:g}); correct the unit or the column",
                          table.where(row), column, value, meaning, limit));
}

double metres(const CsvTable& table, std::size_t row, const std::string& column) {
  return read_within(kMaxPosition_m, "a position in metres", table, row, column);
}

double radians(const CsvTable& table, std::size_t row, const std::string& column) {
  if (!table.has_column(column)) return 0.0;
  return radians_from_degrees(read_within(kMaxDegrees, "an angle in degrees", table, row, column));
}

// Without a sign where all digits are 0.
std::string nine_decimals(double value) {
  return fmt::format("{:.9f}", std::abs(value) < 0.5e-9 ? 0.0 : value);
}

// "a/b_0" of "a/b_0.png", or only its last part. Names are parts of file names and JSON.
std::vector<std::string> names_of(std::span<const std::string> files, bool whole_paths) {
  std::vector<std::string> names;
  for (const std::string& file : files) {
    const std::filesystem::path path = std::filesystem::path(file).replace_extension();
    std::string name = (whole_paths ? path : path.filename()).generic_string();
    std::ranges::replace(name, '/', '_');
    names.push_back(escaped(name));
  }
  return names;
}

}  // namespace

Eigen::Vector3d read_position_m(const CsvTable& table, std::size_t row) {
  return {metres(table, row, "x"), metres(table, row, "y"), metres(table, row, "z")};
}

Attitude read_attitude(const CsvTable& table, std::size_t row) {
  return {radians(table, row, "yaw"), radians(table, row, "pitch"), radians(table, row, "roll")};
}

std::vector<Frame> read_frame_list(const std::filesystem::path& list,
                                   const std::vector<std::string>& ignored) {
  const std::string source = input_name(list);
  std::vector<std::string> optional{"yaw", "pitch", "roll", "mask", "line"};
  optional.insert(optional.end(), ignored.begin(), ignored.end());
  const CsvTable table = CsvTable::read(list, {"file", "x", "y", "z"}, optional);
  if (table.rows() == 0) throw Error(source + ": lists no frames");
  std::vector<Frame> frames;
  std::unordered_map<std::string, std::string> listed;  // file -> where
  ListedFiles files(list.parent_path());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Frame frame;
    frame.where = table.where(row);
    frame.file = table.text(row, "file");
    if (frame.file.empty()) throw Error(frame.where + ": names no file");
    frame.path = files.find(frame.file);
    frame.position_m = read_position_m(table, row);
    const Attitude attitude = read_attitude(table, row);
    if (attitude.yaw_rad != 0.0 || attitude.pitch_rad != 0.0 || attitude.roll_rad != 0.0) {
      frame.attitude = attitude;
    }
    if (table.has_column("mask") && !table.text(row, "mask").empty()) {
      frame.mask = files.find(table.text(row, "mask"));
    }
    if (table.has_column("line")) frame.line = table.text(row, "line");
    const auto [first, is_new] = listed.emplace(frame.file, frame.where);
    if (!is_new) {
      throw Error(
          fmt::format("{}: {} is already listed at {}", frame.where, frame.file, first->second));
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

std::string frame_list_text(const std::vector<ListedFrame>& frames) {
  const auto any = [&](auto has) { return std::ranges::any_of(frames, has); };
  const bool attitudes = any([](const ListedFrame& frame) { return frame.attitude.has_value(); });
  const bool masks = any([](const ListedFrame& frame) { return !frame.mask.empty(); });
  const bool lines = any([](const ListedFrame& frame) { return !frame.line.empty(); });
  std::string text = "file,x,y,z";
  if (attitudes) text += ",yaw,pitch,roll";
  if (masks) text += ",mask";
  if (lines) text += ",line";
  text += '\n';
  for (const ListedFrame& frame : frames) {
    const Eigen::Vector3d& at = frame.position_m;
    text += fmt::format("{},{},{},{}", csv_field(frame.file), nine_decimals(at.x()),
                        nine_decimals(at.y()), nine_decimals(at.z()));
    if (attitudes) {
      const Attitude attitude = frame.attitude.value_or(Attitude{});
      text += fmt::format(",{},{},{}", nine_decimals(degrees_from_radians(attitude.yaw_rad)),
                          nine_decimals(degrees_from_radians(attitude.pitch_rad)),
                          nine_decimals(degrees_from_radians(attitude.roll_rad)));
    }
    if (masks) text += "," + csv_field(frame.mask);
    if (lines) text += "," + csv_field(frame.line);
    text += '\n';
  }
  return text;
}

std::vector<std::string> frame_names(std::span<const std::string> files,
                                     const std::filesystem::path& list,
                                     std::span<const std::string> taken) {
  for (const bool whole_paths : {false, true}) {
    std::vector<std::string> names = names_of(files, whole_paths);
    std::set<std::string> all(taken.begin(), taken.end());
    if (std::ranges::all_of(names, [&](const std::string& n) { return all.insert(n).second; })) {
      return names;
    }
  }
  throw Error(fmt::format("{}: two of its files{} differ only in their extension; {} one of them",
                          list.string(), taken.empty() ? "" : ", or one and another list's,",
                          taken.empty() ? "list" : "rename"));
}

}  // namespace raywalk
