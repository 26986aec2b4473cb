#include "core/room/refined_record.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/output_folder.h"
#include "core/room/room.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

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
  std::error_code error;
  if (!fs::exists(manifest_path(path), error)) return std::nullopt;
  const auto record = read_manifest(path).refined;
  if (!record || record->hold_out != 0) return std::nullopt;
  if (room_fingerprint(room) == record->source_fingerprint) return Room::open(path);
  spdlog::warn("{} is not used: {} has changed since it was developed from it; refine it again",
               path.string(), room.directory().string());
  return std::nullopt;
}

std::string refined_text(const Room& room) {
  const auto& record = room.manifest().refined;
  if (!record) return "";
  return fmt::format("developed from {} of {}{}",
                     counted(static_cast<std::size_t>(record->source_stations), "photograph"),
                     record->source.string(), change_of(room.directory(), *record));
}

}  // namespace raywalk
