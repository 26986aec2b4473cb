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

namespace raywalk {
namespace {

// Ten turns: larger angles indicate a wrong column.
constexpr double kMaxDegrees = 3600.0;

double metres(const CsvTable& table, std::size_t row, const std::string& column) {
  const double value = table.number(row, column);
  if (std::abs(value) > kMaxPosition_m) {
    throw Error(fmt::format(
        "{}: {} = {:g} is not a position in metres (at most {:g}); correct the unit or the column",
        table.where(row), column, value, kMaxPosition_m));
  }
  return value;
}

double radians(const CsvTable& table, std::size_t row, const std::string& column) {
  if (!table.has_column(column)) return 0.0;
  const double value = table.number(row, column);
  if (std::abs(value) > kMaxDegrees) {
    throw Error(fmt::format(
        "{}: {} = {:g} is not an angle in degrees (at most {:g}); correct the unit or the column",
        table.where(row), column, value, kMaxDegrees));
  }
  return radians_from_degrees(value);
}

// Quoting by RFC 4180.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos && !text.starts_with('#') &&
      !text.starts_with(' ')) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

// Without a sign where all digits are 0.
std::string nine_decimals(double value) {
  return fmt::format("{:.9f}", std::abs(value) < 0.5e-9 ? 0.0 : value);
}

// Names are parts of file names and JSON, so they are escaped.
std::string stem_of(const std::string& file) {
  return escaped(std::filesystem::path(file).stem().string());
}

std::string joined_path_of(const std::string& file) {
  std::string name = std::filesystem::path(file).replace_extension().generic_string();
  std::replace(name.begin(), name.end(), '/', '_');
  return escaped(name);
}

template <typename NameOf>
std::vector<std::string> names_by(std::span<const std::string> files, const NameOf& name_of) {
  std::vector<std::string> names;
  names.reserve(files.size());
  for (const std::string& file : files) names.push_back(name_of(file));
  return names;
}

bool are_unique(const std::vector<std::string>& names) {
  return std::set<std::string>(names.begin(), names.end()).size() == names.size();
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
  return parse_frame_list(read_file_or_stdin(list), list, ignored);
}

std::vector<Frame> parse_frame_list(const std::string& text, const std::filesystem::path& list,
                                    const std::vector<std::string>& ignored) {
  const std::string source = input_name(list);
  std::vector<std::string> optional{"yaw", "pitch", "roll", "mask", "line"};
  optional.insert(optional.end(), ignored.begin(), ignored.end());
  const CsvTable table = CsvTable::parse(text, source, {"file", "x", "y", "z"}, optional);
  if (table.rows() == 0) throw Error(source + ": lists no frames");
  std::vector<Frame> frames;
  std::unordered_map<std::string, std::string> listed;  // file -> where
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Frame frame;
    frame.where = table.where(row);
    frame.file = table.text(row, "file");
    if (frame.file.empty()) throw Error(frame.where + ": names no file");
    frame.path = list.parent_path() / frame.file;
    frame.position_m = read_position_m(table, row);
    const Attitude attitude = read_attitude(table, row);
    if (attitude.yaw_rad != 0.0 || attitude.pitch_rad != 0.0 || attitude.roll_rad != 0.0) {
      frame.attitude = attitude;
    }
    if (table.has_column("mask") && !table.text(row, "mask").empty()) {
      frame.mask = list.parent_path() / table.text(row, "mask");
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
  const bool attitudes = std::any_of(frames.begin(), frames.end(),
                                     [](const ListedFrame& f) { return f.attitude.has_value(); });
  const bool masks = std::any_of(frames.begin(), frames.end(),
                                 [](const ListedFrame& frame) { return !frame.mask.empty(); });
  const bool lines = std::any_of(frames.begin(), frames.end(),
                                 [](const ListedFrame& frame) { return !frame.line.empty(); });
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

std::vector<std::string> names_of_stems(std::span<const std::string> files) {
  return names_by(files, stem_of);
}

std::vector<std::string> names_of_paths(std::span<const std::string> files) {
  return names_by(files, joined_path_of);
}

std::vector<std::string> frame_names(std::span<const std::string> files,
                                     const std::filesystem::path& list) {
  std::vector<std::string> names = names_of_stems(files);
  if (!are_unique(names)) names = names_of_paths(files);
  if (!are_unique(names)) {
    throw Error(list.string() +
                ": two of its files differ only in their extension; list one of them");
  }
  return names;
}

}  // namespace raywalk
