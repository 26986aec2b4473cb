#include "core/room/gain_fields.h"

#include <gmock/gmock.h>

#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <span>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/test_directory.h"
#include "core/room/hdf5_file.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class GainFieldsTest : public ::testing::Test {
 protected:
  GainFieldsTest() {
    spec_.width = 16;
    spec_.spacing_m = 0.5;
    write_synthetic_room(spec_, room_);
  }

  // A whole gain at x0/0, a local field at z1/2.
  GainFields some_fields() const {
    GainFields fields = unit_gain_fields(grid_);
    fields[0][0].whole = {0.5F, 1.0F, 1.25F};
    cv::Mat local(4, 2, CV_32FC3, cv::Scalar::all(1.0));
    local.at<cv::Vec3f>(3, 1) = {1.5F, 1.0F, 0.75F};
    fields.back()[2].local = local;
    return fields;
  }

  void record() const {
    RoomManifest manifest = read_manifest(room_);
    manifest.gains = true;
    write_file_atomically(manifest_path(room_), manifest_to_json(manifest));
  }

  std::string reading() const {
    return error_of([&] { read_gain_fields(gains_path(room_), grid_); });
  }
  std::string opening() const {
    return error_of([&] { Room::open(room_); });
  }

  // A file with the given values for every station and channel.
  void write_values(const std::vector<double>& values, const Shape& shape,
                    int version = kVolumeFormatVersion) const {
    write_gain_fields(gains_path(room_), grid_, some_fields());
    const auto stations = Hdf5File::open(gains_path(room_)).text_attribute("stations_sha256");
    Hdf5File file = Hdf5File::create(gains_path(room_));
    file.write_format(kGainsFormat, version);
    file.write_attribute("/", "stations_sha256", stations.value());
    file.write_attribute("/", "sha256", sha256_hex(std::as_bytes(std::span(values))));
    file.write("gain", values, shape);
    file.close();
  }

  TestDirectory directory_;
  fs::path room_ = directory_ / "room.lf";
  SyntheticRoomSpec spec_;
  Grid grid_ = synthetic_grid([] {
    SyntheticRoomSpec spec;
    spec.spacing_m = 0.5;
    return spec;
  }());
};

TEST_F(GainFieldsTest, AreReadAsWritten) {
  write_gain_fields(gains_path(room_), grid_, some_fields());
  const GainFields fields = read_gain_fields(gains_path(room_), grid_);
  ASSERT_THAT(fields, SizeIs(4));
  EXPECT_EQ(fields[0][0].whole, ColourGain(0.5F, 1.0F, 1.25F));
  EXPECT_TRUE(fields[0][0].local.empty());
  EXPECT_TRUE(is_one(fields[1][1]));
  EXPECT_EQ(fields[3][2].whole, ColourGain(1.0F, 1.0F, 1.0F));
  EXPECT_EQ(cv::norm(fields[3][2].local, some_fields()[3][2].local, cv::NORM_INF), 0.0);
}

TEST_F(GainFieldsTest, OfAnotherRoomAreRefused) {
  write_gain_fields(gains_path(room_), grid_, some_fields());
  Grid other = grid_;
  other.lines[2].stations.pop_back();
  EXPECT_THAT(error_of([&] { read_gain_fields(gains_path(room_), other); }),
              HasSubstr("of other stations"));
  other = grid_;
  other.lines[2].id = "z5";
  EXPECT_THAT(error_of([&] { read_gain_fields(gains_path(room_), other); }),
              HasSubstr("of other stations"));
}

TEST_F(GainFieldsTest, OutOfRangeAreRefused) {
  for (const double bad : {0.0, -1.0, 17.0, 0.06, std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::quiet_NaN()}) {
    std::vector<double> values(36, 1.0);
    values[7] = bad;
    write_values(values, {12, 1, 1, 3});
    EXPECT_THAT(reading(), HasSubstr("its gains are damaged")) << bad;
  }
  write_values(std::vector<double>(36, 1.0), {12, 1, 1, 3});
  EXPECT_EQ(reading(), "no error");
}

TEST_F(GainFieldsTest, OfAnotherShapeOrVersionAreRefused) {
  write_values(std::vector<double>(36, 1.0), {12, 3, 1, 1});
  EXPECT_THAT(reading(), HasSubstr("'gain' is not [12 stations][theta][phi][3]"));
  write_values(std::vector<double>(33, 1.0), {11, 1, 1, 3});
  EXPECT_THAT(reading(), HasSubstr("'gain' is not [12 stations]"));
  write_values(std::vector<double>(36, 1.0), {12, 1, 1, 3}, kVolumeFormatVersion + 1);
  EXPECT_THAT(reading(), HasSubstr("version"));
  fs::remove(gains_path(room_));
  EXPECT_THAT(reading(), HasSubstr("gains.h5"));
}

TEST_F(GainFieldsTest, AreUsedOnlyAsRecorded) {
  EXPECT_THAT(Room::open(room_).gains(), IsEmpty());
  write_gain_fields(gains_path(room_), grid_, some_fields());
  EXPECT_THAT(Room::open(room_).gains(), IsEmpty());
  record();
  EXPECT_THAT(Room::open(room_).gains(), SizeIs(4));
  EXPECT_EQ(Room::open(room_).gains()[0][0].whole, ColourGain(0.5F, 1.0F, 1.25F));
  EXPECT_THAT(Room::open_without_gains(room_).gains(), IsEmpty());
  fs::remove(gains_path(room_));
  EXPECT_THAT(opening(), HasSubstr("gains.h5"));
  EXPECT_THAT(opening(), HasSubstr("raywalk-build-lf gains"));
}

// Bytes that hold nothing may differ.
TEST_F(GainFieldsTest, AreReadAsTheyWereOrRefusedWithAnyByteDamaged) {
  write_gain_fields(gains_path(room_), grid_, some_fields());
  record();
  const std::string whole = read_file(gains_path(room_));
  const Room intact = Room::open(room_);
  int refused = 0;
  for (std::size_t i = 0; i < whole.size(); i += 37) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    std::ofstream(gains_path(room_), std::ios::binary) << damaged;
    if (const std::string error = opening(); error != "no error") {
      EXPECT_EQ(error.find('\n'), std::string::npos) << i;
      ++refused;
      continue;
    }
    const Room room = Room::open(room_);
    EXPECT_EQ(room.gains()[0][0].whole, intact.gains()[0][0].whole) << i;
    EXPECT_EQ(cv::norm(room.gains()[3][2].local, intact.gains()[3][2].local), 0.0) << i;
  }
  EXPECT_GT(refused, 20);
  std::ofstream(gains_path(room_), std::ios::binary) << whole.substr(0, whole.size() / 2);
  EXPECT_THAT(opening(), HasSubstr("gains.h5"));
}

TEST_F(GainFieldsTest, GoWithTheirStations) {
  write_gain_fields(gains_path(room_), grid_, some_fields());
  record();
  const Room part = Room::open(room_).subset({{0, 2}, {0, 1}, {0, 1}, {1, 2}});
  ASSERT_THAT(part.gains(), SizeIs(4));
  EXPECT_THAT(part.gains()[0], SizeIs(2));
  EXPECT_EQ(part.gains()[0][0].whole, ColourGain(0.5F, 1.0F, 1.25F));
  EXPECT_TRUE(is_one(part.gains()[3][0]));
  EXPECT_FALSE(part.gains()[3][1].local.empty());
}

}  // namespace
}  // namespace raywalk
