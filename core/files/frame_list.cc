#include "core/files/frame_list.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "core/base/error.h"
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

}  // namespace

Eigen::Vector3d read_position_m(const CsvTable& table, std::size_t row) {
  return {metres(table, row, "x"), metres(table, row, "y"), metres(table, row, "z")};
}

Attitude read_attitude(const CsvTable& table, std::size_t row) {
  return {radians(table, row, "yaw"), radians(table, row, "pitch"), radians(table, row, "roll")};
}

std::vector<Frame> read_frame_list(const std::filesystem::path& list) {
  return parse_frame_list(read_file_or_stdin(list), list);
}

std::vector<Frame> parse_frame_list(const std::string& text, const std::filesystem::path& list) {
  const std::string source = input_name(list);
  const CsvTable table =
      CsvTable::parse(text, source, {"file", "x", "y", "z"}, {"yaw", "pitch", "roll", "mask"});
  if (table.rows() == 0) throw Error(source + ": lists no frames");
  std::vector<Frame> frames;
  std::map<std::string, std::string> listed;  // file -> where
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
    const auto [first, is_new] = listed.emplace(frame.file, frame.where);
    if (!is_new) {
      throw Error(
          fmt::format("{}: {} is already listed at {}", frame.where, frame.file, first->second));
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace raywalk
