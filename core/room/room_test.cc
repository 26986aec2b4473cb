#include "core/room/room.h"

#include <gmock/gmock.h>
#include <hdf5.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/test_support.h"
#include "core/room/hdf5_file.h"
#include "core/room/requirements.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr int kStations = 3;
constexpr PanoramaSize kSize{8, 4};

// A line volume; its valid rows, if they have a shape, are each {station + theta - 1, 4 + theta}.
void write_line(const fs::path& path, const Shape& valid_rows = {},
                int version = kVolumeFormatVersion, const std::string& format = kLineVolumeFormat) {
  Hdf5File file = Hdf5File::create(path);
  file.write_format(format, version);
  file.create_contiguous("rays", ElementType::kUint8, {kStations, 8, 4, 3});
  if (!valid_rows.empty()) {
    std::vector<std::int32_t> rows;
    for (int station = 0; station < kStations; ++station) {
      for (int theta = 0; theta < static_cast<int>(valid_rows[1]); ++theta) {
        rows.insert(rows.end(), {station + theta - 1, 4 + theta});
      }
    }
    rows.resize(valid_rows[0] * valid_rows[1] * valid_rows[2]);
    file.write("valid_rows", rows, valid_rows);
  }
  file.close();
}

class VolumeTest : public ::testing::Test {
 protected:
  // It names the file.
  std::string line_error(int stations = kStations, PanoramaSize size = kSize) {
    std::string error = error_of([&] { LineVolume::open(file_, stations, size); });
    EXPECT_THAT(error, HasSubstr(file_.string()));
    return error;
  }

  TestDirectory directory_;
  fs::path file_ = directory_ / "x0.h5";
};

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

TEST_F(VolumeTest, FileThatIsMissingCutShortOrNotHdf5IsNamed) {
  EXPECT_THAT(line_error(), HasSubstr("no such file"));
  write_file_atomically(file_, "not a volume");
  EXPECT_THAT(line_error(), HasSubstr("not an HDF5 file"));
  write_line(file_);
  const std::string whole = read_file(file_);
  for (size_t length = 0; length < whole.size(); length += 37) {
    std::ofstream(file_, std::ios::binary) << whole.substr(0, length);
    EXPECT_THAT(line_error(), AllOf(Not("no error"), Not(HasSubstr("\n")))) << length;
  }
}

TEST_F(VolumeTest, OtherShapesThanTheManifestsVersionsAndFormatsAreRefused) {
  write_line(file_);
  EXPECT_THAT(line_error(kStations + 1), HasSubstr("[3, 8, 4, 3], the manifest says [4, 8, 4, 3]"));
  EXPECT_THAT(line_error(kStations, {16, 8}), HasSubstr("[3, 16, 8, 3]"));
  write_line(file_, {kStations, 7, 2});
  EXPECT_THAT(line_error(),
              AllOf(HasSubstr("'valid_rows'"), HasSubstr("[3, 7, 2]"), HasSubstr("[3, 8, 2]")));
  write_line(file_, {kStations, 8, 3});
  EXPECT_THAT(line_error(), HasSubstr("'valid_rows'"));
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
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18);
  const hid_t file = H5Fcreate(file_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  ASSERT_GE(file, 0);
  H5Fclose(file);
  H5Pclose(access);
  EXPECT_THAT(line_error(), HasSubstr("without checksums"));
}

TEST_F(VolumeTest, DistancesThatDoNotFitTheLineAreRefused) {
  const struct {
    std::vector<std::int32_t> stations;
    Shape shape;
    const char* message;
  } cases[] = {{{0, 3}, {2, 8, 4}, "station 3 does not exist"},
               {{-1, 1}, {2, 8, 4}, "station -1 does not exist"},
               {{2, 1}, {2, 8, 4}, "does not increase"},
               {{0, 1}, {2, 8, 5}, "twice as many theta as phi"},
               {{0}, {2, 8, 4}, "1 maps"}};
  Line line;
  line.id = "x0";
  line.stations.resize(kStations);
  for (const auto& [stations, shape, message] : cases) {
    Hdf5File file = Hdf5File::create(file_);
    file.write_format(kDistanceVolumeFormat);
    file.write("station", stations);
    file.create_contiguous("distance_m", ElementType::kFloat32, shape);
    file.create_contiguous("confidence", ElementType::kUint8, shape);
    file.close();
    EXPECT_THAT(error_of([&] { DistanceVolume::open(file_, line); }), HasSubstr(message));
  }
}

class RoomTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, room_);
    return Room::open(room_);
  }
  std::string open_error() {
    return error_of([&] { Room::open(room_); });
  }

  TestDirectory directory_;
  fs::path room_ = directory_ / "room.lf";
};

TEST_F(RoomTest, DistancesAreThoseOfTheManifest) {
  EXPECT_EQ(room_of({.width = 16, .distance_every = 4}).distances(0).maps(), 3);
  const fs::path volume = distance_volume_path(room_, "x0");
  write_file_atomically(volume, "damaged");
  EXPECT_THAT(open_error(), HasSubstr("distances/given/x0.h5"));
  fs::remove(volume);
  EXPECT_THAT(open_error(), AllOf(HasSubstr("distances/given/x0.h5: no such file"),
                                  HasSubstr("raywalk-build-lf depth")));
  RoomManifest manifest = read_manifest(room_);
  manifest.distances = DistanceKind::kNone;
  write_file_atomically(manifest_path(room_), manifest_to_json(manifest));
  EXPECT_FALSE(Room::open(room_).has_distances());
}

TEST_F(RoomTest, EveryMissingPartIsNamed) {
  room_of({.width = 16});
  EXPECT_THAT(error_of([&] { Room::open(directory_ / "none/a.lf"); }),
              HasSubstr("no such room; `raywalk-build-lf pack` makes one"));
  EXPECT_THAT(error_of([&] { Room::open(directory_ / "rom.lf"); }),
              HasSubstr("no such room; did you mean 'room.lf'?"));
  EXPECT_THAT(error_of([&] { Room::open(room_ / "lines"); }), HasSubstr("no manifest.json"));
  fs::remove(line_volume_path(room_, "x0"));
  EXPECT_THAT(open_error(), AllOf(HasSubstr("x0.h5"), HasSubstr("no such file")));
}

using Json = nlohmann::json;

// The four lines of a square of side 1 around the origin, five stations each.
RoomManifest square_manifest() {
  const Grid grid = synthetic_grid({.spacing_m = 0.25, .height_m = 0.1});
  return {{64, 32}, grid, std::vector<std::string>(4, std::string(64, 'a'))};
}

std::string manifest_error(const std::string& text) {
  return error_of([&] { manifest_from_json(text, "manifest.json"); });
}

// The error after setting the value at a JSON pointer of a good manifest.
std::string error_with(const std::string& pointer, const Json& value) {
  Json json = Json::parse(manifest_to_json(square_manifest()));
  json[Json::json_pointer(pointer)] = value;
  return manifest_error(json.dump());
}

TEST(Manifest, ReadsBackExactlyWhatItWrote) {
  RoomManifest written = square_manifest();
  written.refined = {.source = "../hall.lf",
                     .source_fingerprint = "abc",
                     .source_stations = 244,
                     .hold_out = 5,
                     .sharpening = {0.75, 1.5}};
  const std::string text = manifest_to_json(written);
  const RoomManifest read = manifest_from_json(text, "manifest.json");
  EXPECT_EQ(manifest_to_json(read), text);
  EXPECT_EQ(read.panorama, written.panorama);
  EXPECT_EQ(read.rays_sha256, written.rays_sha256);
  EXPECT_EQ(read.grid.lines[2].id, "z0");
  EXPECT_EQ(read.grid.lines[2].stations[1].file, written.grid.lines[2].stations[1].file);
  EXPECT_EQ(read.grid.lines[2].stations[1].position_m,
            written.grid.lines[2].stations[1].position_m);
  EXPECT_EQ(read.grid.cells[0].line, written.grid.cells[0].line);
  EXPECT_EQ(read.grid.cells[0].x_max_m, written.grid.cells[0].x_max_m);
  EXPECT_EQ(read.refined->source_stations, 244);
  EXPECT_EQ(read.refined->hold_out, 5);
}

TEST(Manifest, EveryMissingKeyIsNamed) {
  const Json good = Json::parse(manifest_to_json(square_manifest()));
  for (const char* pointer :
       {"/format", "/format_version", "/panorama", "/panorama/width", "/lines", "/cells",
        "/distances", "/gains", "/lines/0/id", "/lines/0/axis", "/lines/0/origin_m",
        "/lines/0/direction", "/lines/0/height_m", "/lines/0/stations", "/lines/0/stations/0/file",
        "/lines/0/stations/0/position_m", "/lines/0/stations/0/along_m", "/cells/0/x_min_m",
        "/cells/0/front"}) {
    const Json::json_pointer place(pointer);
    Json json = good;
    json[place.parent_pointer()].erase(place.back());
    EXPECT_THAT(manifest_error(json.dump()), HasSubstr("has no '" + place.back() + "'")) << pointer;
  }
}

TEST(Manifest, InconsistentValuesAreRejected) {
  const struct {
    const char* pointer;
    Json value;
    const char* message;
  } cases[] = {{"/format", "other", "is not raywalk-room"},
               {"/format_version", kRoomFormatVersion - 1, "pack the room again"},
               {"/format_version", kRoomFormatVersion + 1, "use a newer Raywalk"},
               {"/distances", 3, "distances"},
               {"/distances", "swept", "is not none, given or estimated"},
               {"/gains", 1, "gains"},
               {"/refined", Json::object(), "has no 'source'"},
               {"/panorama/width", 63, "twice the height"},
               {"/panorama/width", 1e9, "is not an integer"},
               {"/panorama/width", 4000000000U, "is not between"},
               {"/panorama/width", -64, "is not between"},
               {"/lines", Json::array(), "is empty"},
               {"/lines", "x", "is not a list"},
               {"/lines/0/axis", "y", "neither x nor z"},
               {"/lines/0/id", "../x0", "followed by a number"},
               {"/lines/0/id", "z7", "followed by a number"},
               {"/lines/0/id", "x1", "occurs twice"},
               {"/lines/0/direction", {2.0, 0.0}, "unit vector"},
               {"/lines/0/direction", {0.0, 1.0}, "axis"},
               {"/lines/0/direction", {1.0}, "2 elements"},
               {"/lines/0/origin_m/0", 1e7, "is not between"},
               {"/lines/0/height_m", "high", "is not a number"},
               {"/lines/0/stations/1/along_m", 0.3, "contradicts"},
               {"/lines/0/stations/1/position_m/0", 0.3, "contradicts"},
               {"/lines/0/stations", Json::array(), "fewer than two"},
               {"/lines/0/rays_sha256", "abc", "SHA-256"},
               {"/cells/0/x_min_m", 9.0, "has no area"},
               {"/cells/0/x_min_m", -0.7, "bounds"},
               {"/cells/0/front", "x9", "does not exist"},
               {"/cells/0/front", "z0", "wrong axis"},
               {"/cells/0/front", "x0", "bounds"}};
  for (const auto& [pointer, value, message] : cases) {
    EXPECT_THAT(error_with(pointer, value), AllOf(HasSubstr("manifest.json"), HasSubstr(message)));
  }
  EXPECT_EQ(error_with("/note", "hand-made"), "no error") << "unknown keys are ignored";
}

TEST(Manifest, StationsMustFollowEachOther) {
  Json json = Json::parse(manifest_to_json(square_manifest()));
  std::swap(json["/lines/0/stations/1"_json_pointer], json["/lines/0/stations/2"_json_pointer]);
  EXPECT_THAT(manifest_error(json.dump()), HasSubstr("does not increase"));
}

class RequirementsTest : public RoomTest {
 protected:
  static Json measured_on(const Room& room) {
    return {{"format", kRequirementsFormat},
            {"format_version", kRequirementsVersion},
            {"distances_sha256", distances_sha256(room)},
            {"layers", {{"inverse_max_per_m", 2.0}}},
            {"spacing", {{"needed_with_distances_m", 0.09}}},
            {"storage", {{"worth_width_px", nullptr}, {"needed_distance_width_px", 256}}}};
  }
  void keep(const std::string& text) const {
    write_file_atomically(requirements_path(room_), text);
  }
};

TEST_F(RequirementsTest, AreThoseOfTheRoomsDistances) {
  Room room = room_of({.width = 32});
  EXPECT_FALSE(current_requirements(room));
  const std::string measured = measured_on(room).dump();
  keep(measured);
  const auto required = current_requirements(room);
  ASSERT_TRUE(required);
  EXPECT_EQ(required->inverse_max_per_m, 2.0);
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
  const auto with = [&](const char* pointer, const Json& value) {
    Json other = measured_on(room);
    other[Json::json_pointer(pointer)] = value;
    return other.dump();
  };
  for (const std::string& text : std::vector<std::string>{
           "", "null", "[]", "{}", measured_on(room).dump().substr(0, 60), with("/format", "other"),
           with("/format_version", "1"), with("/format_version", 2),
           with("/layers/inverse_max_per_m", nullptr), with("/layers/inverse_max_per_m", -1.0),
           with("/spacing/needed_with_distances_m", "0.09"),
           with("/storage/needed_distance_width_px", 2.5),
           with("/storage/needed_distance_width_px", 0)}) {
    keep(text);
    EXPECT_THAT(
        error_of([&] { current_requirements(room); }),
        AllOf(HasSubstr("room.lf/require.json: "), HasSubstr("run raywalk-build-lf require")))
        << text;
  }
}

}  // namespace
}  // namespace raywalk
