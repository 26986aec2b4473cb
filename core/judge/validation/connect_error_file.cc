#include "core/judge/validation/connect_error_file.h"

#include <fmt/format.h>

#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

ConnectionErrorMeasurement stored_form(const ConnectError& measurement) {
  ConnectionErrorMeasurement stored{.generation = generation_name(measurement.generation),
                                    .viewpoints = measurement.options.viewpoints,
                                    .overlap_deg = measurement.options.overlap_deg,
                                    .common_share = measurement.common_share,
                                    .distances = measurement.distances};
  for (const ConnectErrorRow& row : measurement.rows) {
    stored.rows.push_back({row.k_deg, row.e_connect, row.e_connect_common, row.coverage});
  }
  return stored;
}

ConnectError measured_form(const ConnectionErrorMeasurement& stored) {
  ConnectError measurement{.generation = generation_from_name(stored.generation),
                           .common_share = stored.common_share,
                           .distances = stored.distances};
  measurement.options = {
      .viewpoints = stored.viewpoints, .overlap_deg = stored.overlap_deg, .k_list_deg = {}};
  for (const ConnectionErrorAtK& row : stored.rows) {
    measurement.options.k_list_deg.push_back(row.k_deg);
    measurement.rows.push_back({.connection = connection_name(row.k_deg),
                                .k_deg = row.k_deg,
                                .generation = measurement.generation,
                                .e_connect = row.e_connect,
                                .e_connect_common = row.e_connect_common,
                                .coverage = row.coverage});
  }
  return measurement;
}

}  // namespace

std::vector<ConnectError> read_connect_error(const std::filesystem::path& room) {
  std::vector<ConnectError> measurements;
  for (const ConnectionErrorMeasurement& stored : read_connection_errors(room)) {
    measurements.push_back(measured_form(stored));
  }
  return measurements;
}

void store_connect_error(const std::filesystem::path& room, const ConnectError& measurement) {
  store_connection_errors(room, stored_form(measurement));
}

ConnectError measure_and_store_connect_error(const Room& room, Generation generation,
                                             const ConnectErrorOptions& options) {
  // Opened only to check that the room can be written.
  { const AtomicFile probe(connection_errors_path(room.directory())); }
  ConnectError measurement = measure_connect_error(room, generation, options);
  measurement.distances = room.distances_origin();
  store_connect_error(room.directory(), measurement);
  return measurement;
}

void write_connect_error(const Room& room, std::span<const Generation> generations,
                         const ConnectErrorOptions& options, std::ostream& table) {
  require_connect_error_options(options);
  std::vector<ConnectError> measurements;
  for (const Generation generation : generations) {
    measurements.push_back(measure_and_store_connect_error(room, generation, options));
  }
  table << connect_error_table(measurements);
  table << "distances in use: " << room.distances_origin() << '\n';
}

}  // namespace raywalk
