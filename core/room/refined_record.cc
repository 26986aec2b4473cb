#include "core/room/refined_record.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/output_folder.h"
#include "core/room/room_fingerprint.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "raywalk-refined";
constexpr int kFormatVersion = 1;
constexpr double kMostSharpening = 2.0;

fs::path record_path(const fs::path& room) { return room / "refined.json"; }

// Empty if the room is as it was.
std::string change_of(const fs::path& room, const RefinedRecord& record) {
  try {
    const bool same =
        room_fingerprint(Room::open(room / record.source)) == record.source_fingerprint;
    return same ? "" : "; it has changed since: refine it again";
  } catch (const Error& error) {
    return fmt::format("; whether that has changed is unknown: {}", error.what());
  }
}

}  // namespace

fs::path refined_room_path(const fs::path& room) {
  const fs::path plain = without_trailing_slash(room);
  return plain.parent_path() / (plain.stem().string() + "-refined" + plain.extension().string());
}

std::optional<Room> current_refined_room(const Room& room) {
  const fs::path path = refined_room_path(room.directory());
  const auto record = read_refined_record(path);
  if (!record || record->hold_out != 0) return std::nullopt;
  if (room_fingerprint(room) == record->source_fingerprint) return Room::open(path);
  spdlog::warn("{} is not used: {} has changed since it was developed from it; refine it again",
               path.string(), room.directory().string());
  return std::nullopt;
}

void write_refined_record(const fs::path& room, const RefinedRecord& record) {
  const nlohmann::ordered_json json = {{"format", kFormat},
                                       {"format_version", kFormatVersion},
                                       {"source", record.source.string()},
                                       {"source_fingerprint", record.source_fingerprint},
                                       {"source_stations", record.source_stations},
                                       {"hold_out", record.hold_out},
                                       {"sharpening", record.sharpening}};
  write_file_atomically(record_path(room), json_text(json));
}

std::optional<RefinedRecord> read_refined_record(const fs::path& room) {
  std::error_code error;
  if (!fs::exists(record_path(room), error)) return std::nullopt;
  const CheckedJson json =
      CheckedJson::read(record_path(room), "make the room again with raywalk-build-lf refine");
  if (json.at("format").text() != kFormat) json.at("format").fail("is no refined room");
  json.require_version(kFormatVersion);
  RefinedRecord record{.source = json.at("source").text(),
                       .source_fingerprint = json.at("source_fingerprint").text(),
                       .source_stations = json.at("source_stations").integer(1),
                       .hold_out = json.at("hold_out").integer(0)};
  const auto sharpening = json.at("sharpening").items(2);
  for (std::size_t i = 0; i < 2; ++i) {
    record.sharpening[i] = sharpening[i].number(0.0, kMostSharpening);
  }
  return record;
}

std::string refined_text(const fs::path& room) {
  const auto record = read_refined_record(room);
  if (!record) return "";
  return fmt::format("developed from {} of {}{}",
                     counted(static_cast<std::size_t>(record->source_stations), "photograph"),
                     record->source.string(), change_of(room, *record));
}

}  // namespace raywalk
