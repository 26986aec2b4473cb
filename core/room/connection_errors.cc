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
#include "core/files/json.h"

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
  Json json = {{"generation", measurement.generation},
               {"viewpoints", measurement.viewpoints},
               {"overlap_deg", measurement.overlap_deg},
               {"common_share", json_of_error(measurement.common_share)}};
  if (!measurement.distances.empty()) json["distances"] = measurement.distances;
  json["rows"] = std::move(rows);
  return json;
}

double error_in(const CheckedJson& json) {
  constexpr double kLargest = 255.0 * 255.0;  // black against white
  return json.is_null() ? std::nan("") : json.number(0.0, kLargest);
}

std::string generation_in(const CheckedJson& json) {
  std::string generation = json.text();
  const bool known = generation == "initial" || generation == "hlf-vd" || generation == "two-sided";
  if (!known) json.fail("is no generation of views");
  return generation;
}

ConnectionErrorAtK row_of(const CheckedJson& json) {
  const ConnectionErrorAtK row{.k_deg = json.at("k_deg").number(45.0, 90.0),
                               .e_connect = error_in(json.at("e_connect")),
                               .e_connect_common = error_in(json.at("e_connect_common")),
                               .coverage = json.at("coverage").number(0.0, 1.0)};
  if (std::isnan(row.e_connect) != (row.coverage == 0.0)) {
    json.at("coverage").fail("contradicts e_connect");
  }
  return row;
}

ConnectionErrorMeasurement measurement_of(const CheckedJson& json) {
  ConnectionErrorMeasurement measurement{.generation = generation_in(json.at("generation")),
                                         .viewpoints = json.at("viewpoints").integer(1, 1'000'000),
                                         .overlap_deg = json.at("overlap_deg").number(0.0, 45.0)};
  if (json.has("common_share") && !json.at("common_share").is_null()) {
    measurement.common_share = json.at("common_share").number(0.0, 1.0);
  }
  for (const CheckedJson& row : json.at("rows").items()) measurement.rows.push_back(row_of(row));
  if (measurement.rows.empty()) json.at("rows").fail("is empty");
  if (json.has("distances")) measurement.distances = json.at("distances").text();
  return measurement;
}

std::vector<ConnectionErrorMeasurement> measurements_of(const CheckedJson& root) {
  root.require_version(kFormatVersion);
  std::vector<ConnectionErrorMeasurement> measurements;
  std::set<std::string> generations;
  for (const CheckedJson& json : root.at("measurements").items()) {
    measurements.push_back(measurement_of(json));
    if (!generations.insert(measurements.back().generation).second) {
      json.at("generation").fail("occurs twice");
    }
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
  return measurements_of(CheckedJson::parse(read_file(file, kMaxErrorsBytes), file.string(),
                                            "measure again with raywalk-render connect-error"));
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
  write_file_atomically(connection_errors_path(room), json_text(root));
}

std::optional<ConnectionErrorAtK> least_error(const ConnectionErrorMeasurement& measurement) {
  std::optional<ConnectionErrorAtK> best;
  if (!(measurement.common_share >= kLeastCommonShare) || measurement.rows.size() < 2) return best;
  for (const ConnectionErrorAtK& row : measurement.rows) {
    if (std::isnan(row.e_connect_common)) continue;
    const bool better = !best || row.e_connect_common < best->e_connect_common ||
                        (row.e_connect_common == best->e_connect_common && row.k_deg > best->k_deg);
    if (better) best = row;
  }
  return best;
}

std::vector<MeasuredConnection> least_errors(const std::filesystem::path& room) {
  std::vector<MeasuredConnection> least_errors;
  for (const ConnectionErrorMeasurement& each : read_connection_errors(room)) {
    if (const auto least = least_error(each)) {
      least_errors.push_back({each.generation, least->k_deg, least->e_connect_common});
    }
  }
  return least_errors;
}

}  // namespace raywalk
