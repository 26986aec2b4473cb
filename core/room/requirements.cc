#include "core/room/requirements.h"

#include <spdlog/spdlog.h>

#include <limits>
#include <system_error>

#include "core/base/error.h"
#include "core/files/json.h"

namespace raywalk {

std::filesystem::path requirements_path(const std::filesystem::path& room) {
  return room / "require.json";
}

std::optional<RoomRequirements> current_requirements(const Room& room) {
  const std::filesystem::path file = requirements_path(room.directory());
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::nullopt;
  const CheckedJson root =
      CheckedJson::read(file, "run raywalk-build-lf require on the room again");
  if (root.at("format").text() != kRequirementsFormat) {
    root.fail("not written by raywalk-build-lf require");
  }
  root.require_version(kRequirementsVersion);
  const CheckedJson storage = root.at("storage");
  const CheckedJson worth_width_px = storage.at("worth_width_px");
  const RoomRequirements stored{
      .inverse_max_per_m = root.at("layers").at("inverse_max_per_m").number(0.0),
      .spacing_m = root.at("spacing").at("needed_with_distances_m").number(0.0),
      // JSON has null for what is not finite.
      .worth_width_px = worth_width_px.is_null() ? std::numeric_limits<double>::infinity()
                                                 : worth_width_px.number(),
      .distance_width_px = storage.at("needed_distance_width_px").integer(1)};
  if (root.at("distances_sha256").text() == distances_sha256(room)) return stored;
  spdlog::warn(
      "{} was measured with different distances and is ignored; run raywalk-build-lf require on "
      "the room again",
      file.string());
  return std::nullopt;
}

}  // namespace raywalk
