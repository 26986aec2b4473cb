#include "build_lf/depth/depth_steps.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/files/packed_values.h"

namespace raywalk::build_lf {
namespace {

constexpr std::array<const char*, kDepthSteps.size()> kNames{
    "links",  "reach", "surfaces", "colours", "sweep",
    "choose", "fuse",  "moved",    "volumes", "gains"};

void add(StationIndex station, PackedWriter* writer) {
  writer->add(station.line);
  writer->add(station.station);
}

StationIndex next_station(PackedReader* reader) {
  const int line = reader->next<int>();
  return {line, reader->next<int>()};
}

void add(const std::array<double, 3>& values, PackedWriter* writer) {
  for (const double value : values) writer->add(value);
}

std::array<double, 3> next_three(PackedReader* reader) {
  std::array<double, 3> values{};
  for (double& value : values) value = reader->next<double>();
  return values;
}

void add(const std::string& text, PackedWriter* writer) {
  writer->add_all(std::vector<char>(text.begin(), text.end()));
}

std::string next_text(PackedReader* reader) {
  const std::vector<char> text = reader->next_all<char>();
  return {text.begin(), text.end()};
}

}  // namespace

std::string name_of(DepthStep step) { return kNames.at(static_cast<std::size_t>(step)); }

std::string depth_step_names() {
  std::string names;
  for (const char* name : kNames) names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

DepthStep depth_step_from_name(const std::string& name) {
  for (const DepthStep step : kDepthSteps) {
    if (name == name_of(step)) return step;
  }
  throw UsageError(fmt::format("unknown step '{}'; the steps are {}", name, depth_step_names()));
}

std::string bytes_of(const std::vector<StationLink>& links) {
  PackedWriter writer;
  for (const StationLink& link : links) {
    add(link.pair.from, &writer);
    add(link.pair.to, &writer);
    writer.add(static_cast<int>(link.compared.comparable));
    add(link.compared.log_ratio, &writer);
    writer.add(link.compared.change);
    writer.add(link.compared.unexplained_change);
  }
  return writer.bytes();
}

std::vector<StationLink> links_of(std::string_view bytes) {
  std::vector<StationLink> links;
  for (PackedReader reader(bytes); !reader.at_end();) {
    StationLink& link = links.emplace_back();
    link.pair.from = next_station(&reader);
    link.pair.to = next_station(&reader);
    link.compared.comparable = reader.next<int>() != 0;
    link.compared.log_ratio = next_three(&reader);
    link.compared.change = reader.next<double>();
    link.compared.unexplained_change = reader.next<double>();
  }
  return links;
}

std::string bytes_of(const std::vector<MapSummary>& maps) {
  PackedWriter writer;
  for (const MapSummary& map : maps) {
    add(map.line, &writer);
    writer.add(map.station);
    add(map.file, &writer);
    writer.add(map.mean_confidence);
    writer.add(map.low_share);
    writer.add(map.parallax_share);
  }
  return writer.bytes();
}

std::vector<MapSummary> map_summaries_of(std::string_view bytes) {
  std::vector<MapSummary> maps;
  for (PackedReader reader(bytes); !reader.at_end();) {
    MapSummary& map = maps.emplace_back();
    map.line = next_text(&reader);
    map.station = reader.next<int>();
    map.file = next_text(&reader);
    map.mean_confidence = reader.next<double>();
    map.low_share = reader.next<double>();
    map.parallax_share = reader.next<double>();
  }
  return maps;
}

std::string bytes_of(const std::vector<ContradictedStation>& stations) {
  static_assert(sizeof(SurfaceBehind) == 2 * sizeof(int) + sizeof(float),
                "nothing between its members");
  PackedWriter writer;
  for (const ContradictedStation& station : stations) {
    add(station.station, &writer);
    writer.add(station.share);
    writer.add_all(station.runs);
    writer.add_all(station.behind);
  }
  return writer.bytes();
}

std::vector<ContradictedStation> contradicted_stations_of(std::string_view bytes) {
  std::vector<ContradictedStation> stations;
  for (PackedReader reader(bytes); !reader.at_end();) {
    ContradictedStation& station = stations.emplace_back();
    station.station = next_station(&reader);
    station.share = reader.next<double>();
    station.runs = reader.next_all<std::int32_t>();
    station.behind = reader.next_all<SurfaceBehind>();
  }
  return stations;
}

std::string bytes_of(const GainFields& fields) {
  PackedWriter writer;
  for (const std::vector<GainField>& line : fields) {
    writer.add(static_cast<std::uint64_t>(line.size()));
    for (const GainField& field : line) {
      for (int c = 0; c < 3; ++c) writer.add(field.whole[c]);
      writer.add(field.local.rows);
      std::vector<float> local;
      for (int row = 0; row < field.local.rows; ++row) {
        const auto* values = field.local.ptr<float>(row);
        local.insert(local.end(), values, values + 3 * field.local.cols);
      }
      writer.add_all(local);
    }
  }
  return writer.bytes();
}

GainFields gain_fields_of(std::string_view bytes) {
  GainFields fields;
  for (PackedReader reader(bytes); !reader.at_end();) {
    std::vector<GainField>& line = fields.emplace_back();
    const auto stations = reader.next<std::uint64_t>();
    for (std::uint64_t i = 0; i < stations; ++i) {
      GainField& field = line.emplace_back();
      for (int c = 0; c < 3; ++c) field.whole[c] = reader.next<float>();
      const int rows = reader.next<int>();
      const auto local = reader.next_all<float>();
      if (!local.empty()) field.local = cv::Mat(local, true).reshape(3, rows);
    }
  }
  return fields;
}

}  // namespace raywalk::build_lf
