#include "core/room/requirements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class RequirementsTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, path_);
    return Room::open(path_);
  }
  static nlohmann::json measured_on(const Room& room) {
    return {{"format", kRequirementsFormat},
            {"format_version", kRequirementsVersion},
            {"distances_sha256", distances_sha256(room)},
            {"layers", {{"omega_max_per_m", 2.0}}},
            {"spacing", {{"needed_with_distances_m", 0.09}}},
            {"storage", {{"worth_width_px", nullptr}, {"needed_distance_width_px", 256}}}};
  }
  void keep(const std::string& text) const {
    write_file_atomically(requirements_path(path_), text);
  }

  TestDirectory directory_;
  std::filesystem::path path_ = directory_ / "room.lf";
};

TEST_F(RequirementsTest, AreThoseOfTheRoomsDistances) {
  Room room = room_of({.width = 32});
  EXPECT_FALSE(current_requirements(room));
  const std::string measured = measured_on(room).dump();
  keep(measured);
  const auto required = current_requirements(room);
  ASSERT_TRUE(required);
  EXPECT_EQ(required->omega_max_per_m, 2.0);
  EXPECT_EQ(required->spacing_m, 0.09);
  EXPECT_TRUE(std::isinf(required->worth_width_px));
  EXPECT_EQ(required->distance_width_px, 256);

  SyntheticRoomSpec other{.width = 32};
  other.scene.walls.max_m.x() += 0.01;
  room = room_of(other);
  keep(measured);
  EXPECT_FALSE(current_requirements(room)) << "different distances";
  room = room_of({.width = 32, .distance_every = 2});
  keep(measured);
  EXPECT_FALSE(current_requirements(room)) << "fewer distances";
}

TEST_F(RequirementsTest, DamageIsReportedWithARemedy) {
  const Room room = room_of({.width = 32});
  const nlohmann::json whole = measured_on(room);
  std::vector<std::string> damaged{"", "null", "[]", "{}", whole.dump().substr(0, 60)};
  const auto with = [&](const char* pointer, const nlohmann::json& value) {
    nlohmann::json other = whole;
    other[nlohmann::json::json_pointer(pointer)] = value;
    damaged.push_back(other.dump());
  };
  with("/format", "other");
  with("/format_version", "1");
  with("/format_version", 2);
  with("/layers/omega_max_per_m", nullptr);
  with("/layers/omega_max_per_m", -1.0);
  with("/spacing/needed_with_distances_m", "0.09");
  with("/storage/needed_distance_width_px", 2.5);
  with("/storage/needed_distance_width_px", 0);
  for (const std::string& text : damaged) {
    keep(text);
    EXPECT_THAT(
        error_of([&] { current_requirements(room); }),
        AllOf(HasSubstr("room.lf/require.json: "), HasSubstr("run raywalk-build-lf require")))
        << text;
  }
}

}  // namespace
}  // namespace raywalk
