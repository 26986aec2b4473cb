#include "render/validation/connect_error_file.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormatVersion = 1;
constexpr std::size_t kMaxBytes = std::size_t{16} << 20;

Json json_of_error(double error) { return std::isnan(error) ? Json(nullptr) : Json(error); }

Json json_of(const ConnectError& measurement) {
  Json rows = Json::array();
  for (const ConnectErrorRow& row : measurement.rows) {
    rows.push_back({{"connection", row.connection},
                    {"k_deg", row.k_deg},
                    {"e_connect", json_of_error(row.e_connect)},
                    {"e_connect_common", json_of_error(row.e_connect_common)},
                    {"coverage", row.coverage}});
  }
  return {{"generation", generation_name(measurement.generation)},
          {"viewpoints", measurement.options.viewpoints},
          {"overlap_deg", measurement.options.overlap_deg},
          {"rows", std::move(rows)}};
}

void require(bool valid, const std::string& what) {
  if (!valid) throw Error(what);
}

double number_in(const Json& json, const char* key, double min, double max) {
  const Json& value = json.at(key);
  require(value.is_number(), fmt::format("'{}' is not a number", key));
  const auto number = value.get<double>();
  require(number >= min && number <= max, fmt::format("'{}' is not in {}..{}", key, min, max));
  return number;
}

double error_in(const Json& json, const char* key) {
  constexpr double kLargest = 255.0 * 255.0;  // black against white
  if (json.at(key).is_null()) return std::nan("");
  return number_in(json, key, 0.0, kLargest);
}

ConnectErrorRow row_of(const Json& json, Generation generation) {
  ConnectErrorRow row;
  row.k_deg = number_in(json, "k_deg", 45.0, 90.0);
  row.connection = connection_name(row.k_deg);
  row.generation = generation;
  row.e_connect = error_in(json, "e_connect");
  row.e_connect_common = error_in(json, "e_connect_common");
  row.coverage = number_in(json, "coverage", 0.0, 1.0);
  require(std::isnan(row.e_connect) == (row.coverage == 0.0), "'coverage' contradicts 'e_connect'");
  return row;
}

ConnectError measurement_of(const Json& json) {
  ConnectError measurement;
  measurement.generation = generation_from_name(json.at("generation").get<std::string>());
  measurement.options.viewpoints = static_cast<int>(number_in(json, "viewpoints", 1.0, 1e6));
  measurement.options.overlap_deg = number_in(json, "overlap_deg", 0.0, 45.0);
  measurement.options.k_list_deg.clear();
  require(json.at("rows").is_array() && !json.at("rows").empty(), "'rows' is not a list of rows");
  for (const Json& row : json.at("rows")) {
    measurement.rows.push_back(row_of(row, measurement.generation));
    measurement.options.k_list_deg.push_back(measurement.rows.back().k_deg);
  }
  return measurement;
}

std::vector<ConnectError> measurements_of(const Json& root) {
  const double version = number_in(root, "format_version", 1.0, 1e6);
  require(version <= kFormatVersion, "made by a newer Raywalk");
  std::vector<ConnectError> measurements;
  std::set<Generation> generations;
  for (const Json& json : root.at("measurements")) {
    measurements.push_back(measurement_of(json));
    require(generations.insert(measurements.back().generation).second, "a generation occurs twice");
  }
  return measurements;
}

// What a new measurement is added to.
std::vector<ConnectError> earlier_measurements(const std::filesystem::path& room) {
  try {
    return read_connect_error(room);
  } catch (const Error& error) {
    spdlog::warn("{}; it is replaced", error.what());
    return {};
  }
}

}  // namespace

std::filesystem::path connect_error_path(const std::filesystem::path& room) {
  return room / "connect-error.json";
}

std::vector<ConnectError> read_connect_error(const std::filesystem::path& room) {
  const std::filesystem::path file = connect_error_path(room);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return {};
  const auto fail = [&](const std::string& what) -> Error {
    return Error(one_line(fmt::format("{}: {}; measure again with raywalk-render connect-error",
                                      file.string(), what)));
  };
  const std::string text = read_file(file, kMaxBytes);
  try {
    return measurements_of(Json::parse(text));
  } catch (const nlohmann::json::exception& e) {
    throw fail(e.what());
  } catch (const Error& e) {
    throw fail(e.what());
  }
}

void store_connect_error(const std::filesystem::path& room, const ConnectError& measurement) {
  std::vector<ConnectError> measurements = earlier_measurements(room);
  std::erase_if(measurements, [&](const ConnectError& earlier) {
    return earlier.generation == measurement.generation;
  });
  measurements.push_back(measurement);
  Json list = Json::array();
  for (const ConnectError& each : measurements) list.push_back(json_of(each));
  const Json root = {{"format_version", kFormatVersion}, {"measurements", std::move(list)}};
  write_file_atomically(connect_error_path(room), root.dump(1) + "\n");
}

void write_connect_error(const Room& room, std::span<const Generation> generations,
                         const ConnectErrorOptions& options, std::ostream& table) {
  // Opened and dropped again: tells whether the room can be written.
  { const AtomicFile probe(connect_error_path(room.directory())); }
  std::vector<ConnectError> measurements;
  for (const Generation generation : generations) {
    measurements.push_back(measure_connect_error(room, generation, options));
    store_connect_error(room.directory(), measurements.back());
  }
  table << connect_error_table(measurements);
}

}  // namespace raywalk
