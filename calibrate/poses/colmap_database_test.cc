#include "calibrate/poses/colmap_database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
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

TEST(ColmapDatabase, ReadsImages) {
  const TestDirectory directory;
  write_database(directory / "database.db");
  const auto images = read_database_images(directory / "database.db");
  ASSERT_EQ(images.size(), 3U);
  EXPECT_EQ(images.at("f0/2.png").id, 2U);
  EXPECT_EQ(images.at("f0/2.png").camera, 5U);
  EXPECT_EQ(images.at("f0/2.png").features, 2);
  EXPECT_EQ(images.at("f0/3.png").features, 0);
}

TEST(ColmapDatabase, ReadsVerifiedMatches) {
  const TestDirectory directory;
  write_database(directory / "database.db");
  const std::vector<VerifiedPair> pairs = read_verified_pairs(directory / "database.db");
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].first, 1U);
  EXPECT_EQ(pairs[0].second, 2U);
  ASSERT_EQ(pairs[0].in_first.size(), 1U);
  EXPECT_EQ(pairs[0].in_first[0].x, 1.0);
  EXPECT_EQ(pairs[0].in_first[0].y, 2.0);
  EXPECT_EQ(pairs[0].in_second[0].x, 0.5);
  EXPECT_EQ(pairs[0].in_second[0].y, 8.0);
}

// COLMAP 3.8 has a prior pose of images, newer ones more tables.
TEST(ColmapDatabase, PassesOverColumnsAndTablesOfOtherVersions) {
  const TestDirectory directory;
  write_database(directory / "database.db");
  SqliteConnection(directory / "database.db", SqliteAccess::kReadWrite)
      .execute(
          "ALTER TABLE images ADD COLUMN prior_qw REAL;"
          "ALTER TABLE two_view_geometries ADD COLUMN qvec BLOB;"
          "CREATE TABLE frames (frame_id INTEGER, rig_id INTEGER);"
          "INSERT INTO frames VALUES (1, 5);");
  EXPECT_EQ(read_database_images(directory / "database.db").at("f0/2.png").features, 2);
  EXPECT_EQ(read_verified_pairs(directory / "database.db").size(), 1U);
}

TEST(ColmapDatabase, RefusesDamage) {
  const TestDirectory directory;
  const std::filesystem::path file = directory / "database.db";
  const auto refusal = [&](const std::string& damage) -> std::string {
    std::filesystem::remove(file);
    write_database(file);
    SqliteConnection(file, SqliteAccess::kReadWrite).execute(damage);
    try {
      read_verified_pairs(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("UPDATE keypoints SET rows = 3 WHERE image_id = 1"), HasSubstr("damaged"));
  EXPECT_THAT(refusal("UPDATE keypoints SET cols = 900"), HasSubstr("damaged"));
  EXPECT_THAT(refusal("UPDATE keypoints SET rows = -1"), HasSubstr("damaged"));
  EXPECT_THAT(refusal("UPDATE two_view_geometries SET data = x'0000000009000000' WHERE rows = 1"),
              HasSubstr("damaged"));
  EXPECT_THAT(refusal("DELETE FROM keypoints WHERE image_id = 2"), HasSubstr("damaged"));
  std::ofstream(file) << "this is no database, however long the text in it may be";
  EXPECT_THROW(read_verified_pairs(file), Error);
  EXPECT_THROW(read_verified_pairs(directory / "none.db"), Error);
}

}  // namespace
}  // namespace raywalk::calibrate
