// What COLMAP is given, the faces of panoramas, and what it stores of them.
#include "calibrate/poses/colmap_database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "calibrate/poses/matching_faces.h"
#include "core/base/test_error.h"
#include "core/files/sqlite_connection.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using ::testing::HasSubstr;

// Two images of two features each, of which one matches; numbers as COLMAP writes them: float32
// and uint32, little-endian. Only the columns that every version has.
void write_database(const std::filesystem::path& file) {
  SqliteConnection connection(file, SqliteAccess::kReadWrite);
  connection.execute(
      "CREATE TABLE images (image_id INTEGER, name TEXT, camera_id INTEGER);"
      "CREATE TABLE keypoints (image_id INTEGER, rows INTEGER, cols INTEGER, data BLOB);"
      "CREATE TABLE two_view_geometries (pair_id INTEGER, rows INTEGER, cols INTEGER, data BLOB);"
      "INSERT INTO images VALUES (1, 'f0/1.png', 5), (2, 'f0/2.png', 5), (3, 'f0/3.png', 5);"
      // (1, 2), (3, 4)
      "INSERT INTO keypoints VALUES (1, 2, 2, x'0000803f000000400000404000008040');"
      // (1, 2, 0, 0), (0.5, 8, 0, 0)
      "INSERT INTO keypoints VALUES (2, 2, 4, "
      "x'0000803f0000004000000000000000000000003f000000410000000000000000');"
      // 2^31 - 1 + 2: images 1 and 2; feature 0 of the first is feature 1 of the second
      "INSERT INTO two_view_geometries VALUES (2147483649, 1, 2, x'0000000001000000');"
      "INSERT INTO two_view_geometries VALUES (2147483650, 0, 2, NULL);");
}

// COLMAP 3.8 has a prior pose of images, newer ones more tables.
constexpr const char* kOfOtherVersions =
    "ALTER TABLE images ADD COLUMN prior_qw REAL;"
    "ALTER TABLE two_view_geometries ADD COLUMN qvec BLOB;"
    "CREATE TABLE frames (frame_id INTEGER, rig_id INTEGER);"
    "INSERT INTO frames VALUES (1, 5);";

TEST(ColmapDatabase, HasImagesAndVerifiedMatchesInEveryVersion) {
  const TestDirectory directory;
  const std::filesystem::path file = directory / "database.db";
  write_database(file);
  for (const char* more : {"", kOfOtherVersions}) {
    SqliteConnection(file, SqliteAccess::kReadWrite).execute(more);
    const auto images = read_database_images(file);
    ASSERT_EQ(images.size(), 3U);
    EXPECT_EQ(images.at("f0/2.png").id, 2U);
    EXPECT_EQ(images.at("f0/2.png").camera, 5U);
    EXPECT_EQ(images.at("f0/2.png").features, 2);
    EXPECT_EQ(images.at("f0/3.png").features, 0);
    const std::vector<VerifiedPair> pairs = read_verified_pairs(file);
    ASSERT_EQ(pairs.size(), 1U);
    EXPECT_EQ(pairs[0].first, 1U);
    EXPECT_EQ(pairs[0].second, 2U);
    ASSERT_EQ(pairs[0].in_first.size(), 1U);
    EXPECT_EQ(pairs[0].in_first[0].x, 1.0);
    EXPECT_EQ(pairs[0].in_first[0].y, 2.0);
    EXPECT_EQ(pairs[0].in_second[0].x, 0.5);
    EXPECT_EQ(pairs[0].in_second[0].y, 8.0);
  }
}

TEST(ColmapDatabase, RefusesDamage) {
  const TestDirectory directory;
  const std::filesystem::path file = directory / "database.db";
  const auto error = [&] { return error_of([&] { read_verified_pairs(file); }); };
  for (const char* damage :
       {"UPDATE keypoints SET rows = 3 WHERE image_id = 1", "UPDATE keypoints SET cols = 900",
        "UPDATE keypoints SET rows = -1",
        "UPDATE two_view_geometries SET data = x'0000000009000000' WHERE rows = 1",
        "DELETE FROM keypoints WHERE image_id = 2"}) {
    std::filesystem::remove(file);
    write_database(file);
    SqliteConnection(file, SqliteAccess::kReadWrite).execute(damage);
    EXPECT_THAT(error(), HasSubstr("damaged")) << damage;
  }
  std::ofstream(file) << "this is no database, however long the text in it may be";
  EXPECT_NE(error(), "no error");
  std::filesystem::remove(file);
  EXPECT_NE(error(), "no error");
}

constexpr int kMatchedFace_px = 64;

DualFisheyeLayout two_lenses() {
  DualFisheyeLayout lenses;
  lenses.front_position_m = {0.001, 0.002, 0.006};
  lenses.back_position_m = {-0.001, 0.0, -0.004};
  return lenses;
}

TEST(MatchingFaces, LieEachInOneLensAndMeetAtFrontSidesAndBack) {
  const DualFisheyeLayout lenses = two_lenses();
  const auto faces = panorama_faces(lenses);
  int front = 0;
  for (const PanoramaFace& face : faces) {
    const bool is_front = face.camera_from_face.col(2).z() > 0;
    front += is_front ? 1 : 0;
    EXPECT_EQ(face.centre_m, is_front ? lenses.front_position_m : lenses.back_position_m);
    for (const double x : {0.0, static_cast<double>(kMatchedFace_px)}) {
      for (const double y : {0.0, 0.5 * kMatchedFace_px, static_cast<double>(kMatchedFace_px)}) {
        const double z = direction_of(face, kMatchedFace_px, {x, y}).z();
        EXPECT_GE(is_front ? z : -z, -1e-12);
      }
    }
  }
  EXPECT_EQ(front, 2);
  EXPECT_EQ(panorama_faces(std::nullopt)[2].centre_m.norm(), 0.0);
}

TEST(MatchingFaces, AreAsLargeAsThePanoramaDemandsWithinLimits) {
  EXPECT_EQ(default_face_px(256), 384);
  EXPECT_EQ(default_face_px(1024), 512);
  EXPECT_EQ(default_face_px(4096), 768);
}

TEST(OverlappingFaces, LookTheSameWay) {
  const auto faces = panorama_faces(std::nullopt);
  const auto pairs_of = [&](const Attitude& first, const Attitude& second) {
    return overlapping_faces(faces, world_from_camera(first), world_from_camera(second));
  };
  const std::vector<FacePair> alike = pairs_of({0.1, 0.0, 0.05}, {-0.1, 0.1, 0.0});
  ASSERT_EQ(alike.size(), 4U);
  for (const FacePair& pair : alike) EXPECT_EQ(pair.first, pair.second);
  const std::vector<FacePair> to_right = pairs_of({}, {kHalfPi, 0, 0});
  ASSERT_EQ(to_right.size(), 4U);
  for (const auto& [ahead, turned] : to_right) {
    EXPECT_NEAR(faces[ahead].camera_from_face.col(2).dot(world_from_camera({kHalfPi, 0, 0}) *
                                                         faces[turned].camera_from_face.col(2)),
                1.0, 1e-12);
  }
  // Half way between two faces, both overlap by half.
  EXPECT_EQ(pairs_of({}, {0.5 * kHalfPi, 0, 0}).size(), 8U);
}

}  // namespace
}  // namespace raywalk::calibrate
