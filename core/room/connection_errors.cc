#include "core/room/connection_errors.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormatVersion = 1;
constexpr std::size_t kMaxErrorsBytes = std::size_t{16} << 20;

Json json_of_error(double error) { return std::isnan(error) ? Json(nullptr) : Json(error); }

Json json_of(const ConnectionErrorMeasurement& measurement) {
  Json rows = Json::array();
  for (const ConnectionErrorAtK& row : measurement.rows) {
    rows.push_back({{"connection", connection_name(row.k_deg)},
                    {"k_deg", row.k_deg},
                    {"e_connect", json_of_error(row.e_connect)},
                    {"e_connect_common", json_of_error(row.e_connect_common)},
                    {"coverage", row.coverage}});
  }
  return {{"generation", measurement.generation},
          {"viewpoints", measurement.viewpoints},
          {"overlap_deg", measurement.overlap_deg},
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

std::string generation_in(const Json& json) {
  auto generation = json.at("generation").get<std::string>();
  const bool known = generation == "initial" || generation == "hlf-vd" || generation == "two-sided";
  require(known, fmt::format("the generation {} is unknown", excerpt(generation)));
  return generation;
}

ConnectionErrorAtK row_of(const Json& json) {
  const ConnectionErrorAtK row{.k_deg = number_in(json, "k_deg", 45.0, 90.0),
                               .e_connect = error_in(json, "e_connect"),
                               .e_connect_common = error_in(json, "e_connect_common"),
                               .coverage = number_in(json, "coverage", 0.0, 1.0)};
  require(std::isnan(row.e_connect) == (row.coverage == 0.0), "'coverage' contradicts 'e_connect'");
  return row;
}

ConnectionErrorMeasurement measurement_of(const Json& json) {
  ConnectionErrorMeasurement measurement{
      .generation = generation_in(json),
      .viewpoints = static_cast<int>(number_in(json, "viewpoints", 1.0, 1e6)),
      .overlap_deg = number_in(json, "overlap_deg", 0.0, 45.0)};
  require(json.at("rows").is_array() && !json.at("rows").empty(), "'rows' is not a list of rows");
  for (const Json& row : json.at("rows")) measurement.rows.push_back(row_of(row));
  return measurement;
}

std::vector<ConnectionErrorMeasurement> measurements_of(const Json& root) {
  const double version = number_in(root, "format_version", 1.0, 1e6);
  require(version <= kFormatVersion, "made by a newer Raywalk");
  std::vector<ConnectionErrorMeasurement> measurements;
  std::set<std::string> generations;
  for (const Json& json : root.at("measurements")) {
    measurements.push_back(measurement_of(json));
    require(generations.insert(measurements.back().generation).second, "a generation occurs twice");
  }
  return measurements;
}

// The existing measurements; none if the file cannot be read.
std::vector<ConnectionErrorMeasurement> earlier_measurements(const std::filesystem::path& room) {
  try {
    return read_connection_errors(room);
  } catch (const Error& error) {
    spdlog::warn("{}; it is replaced", error.what());
    return {};
  }
}

}  // namespace

std::string connection_name(double k_deg) {
  if (k_deg == 45.0) return "lfu";
  return k_deg == 90.0 ? "rayspace360" : "hybrid";
}

std::filesystem::path connection_errors_path(const std::filesystem::path& room) {
  return room / "connect-error.json";
}

std::vector<ConnectionErrorMeasurement> read_connection_errors(const std::filesystem::path& room) {
  const std::filesystem::path file = connection_errors_path(room);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return {};
  const auto fail = [&](const std::string& what) -> Error {
    return Error(one_line(fmt::format("{}: {}; measure again with raywalk-render connect-error",
                                      file.string(), what)));
  };
  const std::string text = read_file(file, kMaxErrorsBytes);
  try {
    return measurements_of(Json::parse(text));
  } catch (const nlohmann::json::exception& e) {
    throw fail(e.what());
  } catch (const Error& e) {
    throw fail(e.what());
  }
}

void store_connection_errors(const std::filesystem::path& room,
                             const ConnectionErrorMeasurement& measurement) {
  std::vector<ConnectionErrorMeasurement> measurements = earlier_measurements(room);
  std::erase_if(measurements, [&](const ConnectionErrorMeasurement& earlier) {
    return earlier.generation == measurement.generation;
  });
  measurements.push_back(measurement);
  Json list = Json::array();
  for (const ConnectionErrorMeasurement& each : measurements) list.push_back(json_of(each));
  const Json root = {{"format_version", kFormatVersion}, {"measurements", std::move(list)}};
  write_file_atomically(connection_errors_path(room), root.dump(1) + "\n");
}

std::optional<ConnectionErrorAtK> least_error(const ConnectionErrorMeasurement& measurement) {
  std::optional<ConnectionErrorAtK> best;
  for (const ConnectionErrorAtK& row : measurement.rows) {
    if (std::isnan(row.e_connect)) continue;
    const bool better = !best || row.e_connect < best->e_connect ||
                        (row.e_connect == best->e_connect && row.k_deg > best->k_deg);
    if (better) best = row;
  }
  return best;
}

std::vector<MeasuredConnection> least_errors(const std::filesystem::path& room) {
  std::vector<MeasuredConnection> least_errors;
  for (const ConnectionErrorMeasurement& each : read_connection_errors(room)) {
    if (const auto least = least_error(each)) {
      least_errors.push_back({each.generation, least->k_deg, least->e_connect});
    }
  }
  return least_errors;
}

}  // namespace raywalk
