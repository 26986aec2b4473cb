#include "core/room/room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>
#include <string>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr int kStations = 3;
constexpr PanoramaSize kSize{8, 4};
constexpr std::size_t kColumnBytes = 12;

// rays[i] = i modulo 251, so that every byte identifies its position.
std::vector<std::uint8_t> numbered_rays() {
  std::vector<std::uint8_t> rays(kStations * 8 * kColumnBytes);
  for (size_t i = 0; i < rays.size(); ++i) rays[i] = static_cast<std::uint8_t>(i % 251);
  return rays;
}

// A line volume; its valid rows, if they have a shape, are each {station + theta - 1, 4 + theta}.
void write_line(const fs::path& path, const Shape& valid_rows = {},
                int version = kVolumeFormatVersion, const std::string& format = kLineVolumeFormat) {
  Hdf5File file = Hdf5File::create(path);
  file.write_format(format, version);
  const std::vector<std::uint8_t> rays = numbered_rays();
  file.create_contiguous("rays", ElementType::kUint8, {kStations, 8, 4, 3});
  if (!valid_rows.empty()) file.create_contiguous("valid_rows", ElementType::kInt32, valid_rows);
  for (int station = 0; station < kStations; ++station) {
    const auto i = static_cast<size_t>(station);
    file.write_slab("rays", i, rays.data() + i * 8 * kColumnBytes);
    if (valid_rows.empty()) continue;
    std::vector<std::int32_t> rows;
    for (int theta = 0; theta < static_cast<int>(valid_rows[1]); ++theta) {
      rows.insert(rows.end(), {station + theta - 1, 4 + theta});
    }
    rows.resize(valid_rows[1] * valid_rows[2]);
    file.write_slab("valid_rows", i, rows.data());
  }
  file.close();
}

void write_distances(const fs::path& path, const std::vector<std::int32_t>& stations,
                     const Shape& shape) {
  Hdf5File file = Hdf5File::create(path);
  file.write_format(kDistanceVolumeFormat);
  file.write("station", stations);
  std::vector<float> metres(shape[1] * shape[2]);
  std::iota(metres.begin(), metres.end(), 1.0F);
  metres[0] = std::numeric_limits<float>::infinity();
  const std::vector<std::uint8_t> confidence(metres.size(), 200);
  file.create_contiguous("distance_m", ElementType::kFloat32, shape);
  file.create_contiguous("confidence", ElementType::kUint8, shape);
  for (size_t i = 0; i < shape[0]; ++i) {
    file.write_slab("distance_m", i, metres.data());
    file.write_slab("confidence", i, confidence.data());
  }
  file.close();
}

Line line_of(int stations) {
  Line line;
  line.id = "x0";
  line.stations.resize(static_cast<size_t>(stations));
  return line;
}

class VolumeTest : public ::testing::Test {
 protected:
  std::string line_error(int stations = kStations, PanoramaSize size = kSize) {
    return error_of([&] { LineVolume::open(file_, stations, size); });
  }
  std::string distance_error(int stations = kStations) {
    return error_of([&] { DistanceVolume::open(file_, line_of(stations)); });
  }

  TestDirectory directory_;
  fs::path file_ = directory_ / "x0.h5";
};

TEST_F(VolumeTest, ColumnsAreWhatWasWritten) {
  write_line(file_);
  const LineVolume volume = LineVolume::open(file_, kStations, kSize);
  const std::vector<std::uint8_t> rays = numbered_rays();
  for (int station = 0; station < kStations; ++station) {
    for (int theta = 0; theta < kSize.width; ++theta) {
      const auto begin = rays.begin() + (station * kSize.width + theta) * 12;
      EXPECT_THAT(volume.column(station, theta),
                  ::testing::ElementsAreArray(begin, begin + kColumnBytes));
    }
  }
}

TEST_F(VolumeTest, ValidRowsAreWithinTheColumn) {
  write_line(file_);
  const LineVolume plain = LineVolume::open(file_, kStations, kSize);
  EXPECT_FALSE(plain.masked());
  EXPECT_EQ(plain.valid_rows(2, 7), (RowRun{0, 4}));
  EXPECT_TRUE(plain.stored_valid_rows(1).empty());
  write_line(file_, {kStations, 8, 2});
  const LineVolume masked = LineVolume::open(file_, kStations, kSize);
  EXPECT_TRUE(masked.masked());
  // A damaged file may hold any number.
  EXPECT_EQ(masked.valid_rows(0, 0), (RowRun{0, 4}));
  EXPECT_EQ(masked.valid_rows(2, 1), (RowRun{2, 4}));
  EXPECT_TRUE(masked.valid_rows(2, 7).empty());
  EXPECT_EQ(masked.stored_valid_rows(1).size(), 16U);
}

TEST_F(VolumeTest, ValidRowsOfAnotherShapeAreRefused) {
  write_line(file_, {kStations, 7, 2});
  EXPECT_THAT(line_error(), AllOf(HasSubstr(file_.string()), HasSubstr("'valid_rows'"),
                                  HasSubstr("[3, 7, 2]"), HasSubstr("[3, 8, 2]")));
  write_line(file_, {kStations, 8, 3});
  EXPECT_THAT(line_error(), HasSubstr("'valid_rows'"));
}

TEST_F(VolumeTest, FileThatIsMissingOrNotHdf5IsNamed) {
  EXPECT_THAT(line_error(), AllOf(HasSubstr(file_.string()), HasSubstr("no such file")));
  write_file_atomically(file_, "not a volume");
  EXPECT_THAT(line_error(), AllOf(HasSubstr(file_.string()), HasSubstr("not an HDF5 file")));
}

TEST_F(VolumeTest, EveryLengthShorterThanTheFileIsRefused) {
  write_line(file_);
  const std::string whole = read_file(file_);
  const fs::path cut = directory_ / "cut.h5";
  for (size_t length = 0; length < whole.size(); length += 37) {
    std::ofstream(cut, std::ios::binary) << whole.substr(0, length);
    EXPECT_THAT(error_of([&] { LineVolume::open(cut, kStations, kSize); }),
                AllOf(HasSubstr("cut.h5"), Not(HasSubstr("\n"))))
        << length;
  }
}

TEST_F(VolumeTest, ShapeMustBeTheManifests) {
  write_line(file_);
  EXPECT_THAT(line_error(kStations + 1), HasSubstr("[3, 8, 4, 3], the manifest says [4, 8, 4, 3]"));
  EXPECT_THAT(line_error(kStations, {16, 8}), HasSubstr("[3, 16, 8, 3]"));
}

TEST_F(VolumeTest, OtherVersionsAndFormatsAreRefused) {
  write_line(file_, {}, kVolumeFormatVersion + 1);
  EXPECT_THAT(line_error(), HasSubstr("newer"));
  write_line(file_, {}, kVolumeFormatVersion - 1);
  EXPECT_THAT(line_error(), HasSubstr("older"));
  write_line(file_, {}, kVolumeFormatVersion, "something-else");
  EXPECT_THAT(line_error(), HasSubstr("format is not raywalk-line"));
}

TEST_F(VolumeTest, OtherTypesAndChunksAreRefused) {
  Hdf5File file = Hdf5File::create(file_);
  file.write("rays", std::vector<std::int32_t>{1, 2, 3});
  file.create_deflated("chunks", ElementType::kUint8, {2, 3});
  file.close();
  const Hdf5File written = Hdf5File::open(file_);
  EXPECT_THAT(error_of([&] { MappedDataset(written, "rays", ElementType::kUint8); }),
              HasSubstr("not of the right type"));
  EXPECT_THAT(error_of([&] { MappedDataset(written, "other", ElementType::kUint8); }),
              HasSubstr("'other'"));
  EXPECT_THAT(error_of([&] { MappedDataset(written, "chunks", ElementType::kUint8); }),
              HasSubstr("contiguously"));
}

// HDF5 1.10 does not detect damaged metadata of its older formats, which have no checksums.
TEST_F(VolumeTest, FileWithoutChecksumsIsRefused) {
  const fs::path path = directory_.path() / "old.h5";
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  ASSERT_GE(file, 0);
  H5Fclose(file);
  H5Pclose(access);
  EXPECT_THAT(error_of([&] { LineVolume::open(path, kStations, kSize); }),
              AllOf(HasSubstr("old.h5"), HasSubstr("without checksums")));
}

TEST_F(VolumeTest, DistancesAreWhatWasWritten) {
  write_distances(file_, {0, 2}, {2, 8, 4});
  const DistanceVolume volume = DistanceVolume::open(file_, line_of(kStations));
  EXPECT_THAT(volume.stations(), ::testing::ElementsAre(0, 2));
  EXPECT_EQ(volume.size(), (PanoramaSize{8, 4}));
  EXPECT_TRUE(std::isinf(volume.distance_column(1, 0)[0]));
  EXPECT_THAT(volume.distance_column(1, 2), ::testing::ElementsAre(9.0F, 10.0F, 11.0F, 12.0F));
  EXPECT_EQ(volume.confidence_column(0, 7)[3], 200);
}

TEST_F(VolumeTest, DistancesThatDoNotFitTheLineAreRefused) {
  write_distances(file_, {0, 3}, {2, 8, 4});
  EXPECT_THAT(distance_error(), HasSubstr("station 3 does not exist"));
  write_distances(file_, {-1, 1}, {2, 8, 4});
  EXPECT_THAT(distance_error(), HasSubstr("station -1 does not exist"));
  write_distances(file_, {2, 1}, {2, 8, 4});
  EXPECT_THAT(distance_error(), HasSubstr("does not increase"));
  write_distances(file_, {0, 1}, {2, 8, 5});
  EXPECT_THAT(distance_error(), HasSubstr("twice as many theta as phi"));
  write_distances(file_, {0}, {2, 8, 4});
  EXPECT_THAT(distance_error(), HasSubstr("1 maps"));
}

class RoomTest : public ::testing::Test {
 protected:
  // One line of three stations.
  void SetUp() override {
    fs::create_directories(room_ / "lines");
    fs::create_directories(distances_directory(room_, DistanceKind::kGiven));
    std::vector<StationPose> stations;
    for (int i = 0; i < kStations; ++i) {
      stations.push_back({std::to_string(i) + ".jpg", {0.1 * i, 0.0, 0.0}, ""});
    }
    manifest_ = {kSize, find_grid(stations, {}), {}};
    write_file_atomically(manifest_path(room_), manifest_to_json(manifest_));
    write_line(line_volume_path(room_, "x0"));
  }
  std::string open_error() {
    return error_of([&] { Room::open(room_); });
  }
  void use_given_distances() {
    manifest_.distances = DistanceKind::kGiven;
    write_file_atomically(manifest_path(room_), manifest_to_json(manifest_));
  }

  TestDirectory directory_;
  RoomManifest manifest_;
  fs::path room_ = directory_ / "room.lf";
};

TEST_F(RoomTest, DistancesAreThoseOfTheManifest) {
  write_distances(distance_volume_path(room_, "x0"), {1}, {1, 4, 2});
  EXPECT_FALSE(Room::open(room_).has_distances());
  use_given_distances();
  const Room room = Room::open(room_);
  EXPECT_TRUE(room.has_distances());
  EXPECT_EQ(room.distances(0).maps(), 1);
}

TEST_F(RoomTest, EveryMissingPartIsNamed) {
  EXPECT_THAT(error_of([&] { Room::open(directory_ / "none/a.lf"); }),
              HasSubstr("no such room; `raywalk-build-lf pack` makes one"));
  EXPECT_THAT(error_of([&] { Room::open(directory_ / "rom.lf"); }),
              HasSubstr("no such room; did you mean 'room.lf'?"));
  EXPECT_THAT(error_of([&] { Room::open(room_ / "lines"); }), HasSubstr("no manifest.json"));
  fs::remove(line_volume_path(room_, "x0"));
  EXPECT_THAT(open_error(), AllOf(HasSubstr("x0.h5"), HasSubstr("no such file")));
}

TEST_F(RoomTest, DamagedAndMissingDistancesAreNamed) {
  use_given_distances();
  EXPECT_THAT(open_error(), AllOf(HasSubstr("distances/given/x0.h5: no such file"),
                                  HasSubstr("raywalk-build-lf depth")));
  write_file_atomically(distance_volume_path(room_, "x0"), "damaged");
  EXPECT_THAT(open_error(), HasSubstr("distances/given/x0.h5"));
}

}  // namespace
}  // namespace raywalk
