#include "build_lf/distance_sets.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "build_lf/pack_room.h"
#include "build_lf/room_info.h"
#include "build_lf/room_verify.h"
#include "build_lf/test_capture.h"
#include "build_lf/volume_writer.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/room/connection_errors.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr PanoramaSize kMapSize{32, 16};

template <typename Work>
std::string error_of(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "no error";
}

// A room of four lines packed with distances at every station.
class DistanceSetsTest : public ::testing::Test {
 protected:
  DistanceSetsTest() {
    for (int frame = 0; frame < TestCapture::kStations; ++frame) {
      capture_.write_distance_map(frame, {kMapSize.width, kMapSize.height});
    }
    pack(room_);
  }

  void pack(const fs::path& room) const {
    PackOptions options;
    options.frames = capture_.list();
    options.out = room;
    options.distances = capture_.distances();
    pack_room(options);
  }
  fs::path volume(const std::string& line, const std::string& directory = "distances") const {
    return room_ / directory / (line + ".h5");
  }
  std::string open_error() const {
    return error_of([&] { Room::open(room_); });
  }
  std::string verify_error() const {
    return error_of([&] { verify_room(Room::open(room_)); });
  }
  std::string origin() const { return Room::open(room_).distances_origin(); }
  nlohmann::json manifest() const {
    return nlohmann::json::parse(read_file(room_ / "manifest.json"));
  }
  void write_manifest(const nlohmann::json& json) const {
    write_file_atomically(room_ / "manifest.json", json.dump());
  }

  // Writes volumes of constant distance, as `depth` does before it puts them in use.
  fs::path estimate(float metres,
                    const std::vector<std::string>& lines = {"x0", "x1", "z0"}) const {
    const fs::path directory = capture_.root() / "volumes";
    fs::create_directories(directory);
    const Room room = Room::open_rays(room_);
    Progress progress("writing", 1, "maps");
    for (const Line& line : room.grid().lines) {
      if (std::ranges::find(lines, line.id) == lines.end()) continue;
      const auto map = [&](std::size_t) {
        StationDistances distances{
            std::vector<float>(512, metres), std::vector<std::uint8_t>(512, 200), {}};
        distances.sha256 = checksum_of_distances(distances.distance_m, distances.confidence);
        return distances;
      };
      write_distance_volume(directory / (line.id + ".h5"), line,
                            {{0, 6}, kMapSize, "estimated by sweep", map}, &progress);
    }
    return directory;
  }
  void replace(float metres) const {
    const fs::path volumes = estimate(metres);
    replace_estimated(room_, volumes, [&](const std::string& keep_as) {
      if (!keep_as.empty()) fs::rename(room_ / "distances", room_ / keep_as);
      fs::remove_all(room_ / "distances");
      fs::rename(volumes, room_ / "distances");
    });
  }

  TestCapture capture_;
  const fs::path room_ = capture_.room();
};

TEST_F(DistanceSetsTest, PackRecordsEveryVolume) {
  const auto sets = manifest()["distances"];
  ASSERT_EQ(sets.size(), 1U);
  EXPECT_EQ(sets[0]["origin"], "given");
  ASSERT_EQ(sets[0]["volumes"].size(), 4U);
  const auto& x0 = sets[0]["volumes"][0];
  EXPECT_EQ(x0["line"], "x0");
  EXPECT_EQ(x0["maps"], TestCapture::kStationsPerLine);
  EXPECT_EQ(x0["width"], kMapSize.width);
  EXPECT_EQ(x0["bytes"], fs::file_size(volume("x0")));
  EXPECT_EQ(x0["sha256"], sha256_of_file(volume("x0")));
  EXPECT_EQ(origin(), "given");
  EXPECT_EQ(verify_room(Room::open(room_)).distance_maps, TestCapture::kStations);
}

TEST_F(DistanceSetsTest, ACopyOfTheRoomIsValid) {
  const fs::path copy = capture_.root() / "copy.lf";
  fs::copy(room_, copy, fs::copy_options::recursive);
  EXPECT_EQ(verify_room(Room::open(copy)).distance_maps, TestCapture::kStations);
}

TEST_F(DistanceSetsTest, VolumesSwappedBetweenLinesAreRefused) {
  fs::rename(volume("x0"), volume("q"));
  fs::rename(volume("x1"), volume("x0"));
  fs::rename(volume("q"), volume("x1"));
  EXPECT_THAT(open_error(), AllOf(HasSubstr("distances/x0.h5: holds the distances of line x1"),
                                  HasSubstr("raywalk-build-lf depth")));
}

TEST_F(DistanceSetsTest, AVolumeOfAnotherRoomIsRefused) {
  for (int frame = 0; frame < TestCapture::kStations; ++frame) {
    cv::imwrite((capture_.distances() / capture_.path(frame).filename()).string(),
                cv::Mat(kMapSize.height, kMapSize.width, CV_16UC1, cv::Scalar(1234)));
  }
  const fs::path other = capture_.root() / "other.lf";
  pack(other);
  fs::copy_file(other / "distances" / "z1.h5", volume("z1"), fs::copy_options::overwrite_existing);
  EXPECT_THAT(open_error(),
              HasSubstr("distances/z1.h5: not the distances that the room's manifest"));
}

TEST_F(DistanceSetsTest, DeletedVolumesAreNamed) {
  fs::remove(volume("z0"));
  EXPECT_THAT(open_error(), HasSubstr("distances/z0.h5: the recorded distances are missing"));
  fs::remove_all(room_ / "distances");
  EXPECT_THAT(open_error(), HasSubstr("distances: the recorded distances are missing"));
}

TEST_F(DistanceSetsTest, TruncatedAndExtendedVolumesAreRefused) {
  fs::resize_file(volume("z0"), fs::file_size(volume("z0")) - 1);
  EXPECT_THAT(open_error(), HasSubstr("distances/z0.h5"));
  fs::resize_file(volume("z0"), fs::file_size(volume("z0")) + 2);
  EXPECT_THAT(open_error(), HasSubstr("distances/z0.h5"));
}

TEST_F(DistanceSetsTest, VerifyFindsEveryFlippedByte) {
  const auto size = static_cast<std::streamoff>(fs::file_size(volume("x1")));
  for (std::streamoff at = 5; at < size; at += size / 40) {
    const std::string bytes = read_file(volume("x1"));
    std::fstream(volume("x1"), std::ios::in | std::ios::out | std::ios::binary)
        .seekp(at)
        .put(static_cast<char>(bytes[static_cast<size_t>(at)] ^ 1));
    EXPECT_THAT(verify_error(), HasSubstr("x1")) << at;
    write_file_atomically(volume("x1"), bytes);
  }
  EXPECT_EQ(verify_error(), "no error");
}

TEST_F(DistanceSetsTest, AVolumeOfNoLineFailsVerifyAndAnUnrecordedOneIsRefused) {
  fs::copy_file(volume("x1"), volume("x7"));
  EXPECT_EQ(open_error(), "no error");
  EXPECT_THAT(verify_error(), HasSubstr("x7.h5: belongs to no line of the room"));
  fs::remove(volume("x7"));
  nlohmann::json json = manifest();
  json["distances"][0]["volumes"].erase(1);
  write_manifest(json);
  EXPECT_THAT(open_error(), HasSubstr("x1.h5: not recorded in the room's manifest"));
}

TEST_F(DistanceSetsTest, AnEditedManifestIsNoticed) {
  const nlohmann::json good = manifest();
  for (const auto& [key, value] : std::map<std::string, nlohmann::json>{
           {"bytes", 17}, {"maps", 3}, {"header_sha256", std::string(64, 'a')}}) {
    nlohmann::json json = good;
    json["distances"][0]["volumes"][2][key] = value;
    write_manifest(json);
    EXPECT_THAT(open_error(), HasSubstr("z0.h5")) << key;
  }
  nlohmann::json json = good;
  json["distances"][0]["volumes"][2]["sha256"] = std::string(64, 'a');
  write_manifest(json);
  EXPECT_THAT(verify_error(), HasSubstr("z0.h5: the file does not match"));
  json = good;
  json["distances"][0]["origin"] = "estimated by sweep";
  write_manifest(json);
  EXPECT_THAT(open_error(), HasSubstr("the maps are given"));
  json = good;
  json.erase("distances");
  write_manifest(json);
  EXPECT_THAT(open_error(), HasSubstr("has no 'distances'"));
}

TEST_F(DistanceSetsTest, EstimatedDistancesComeInUseAndGivenOnesAreKept) {
  replace(2.0F);
  EXPECT_EQ(origin(), "estimated by sweep");
  EXPECT_THAT(distances_text(room_),
              AllOf(HasSubstr("views use the estimated distances"), HasSubstr("--use given")));
  const VerifiedCounts counts = verify_room(Room::open(room_));
  EXPECT_EQ(counts.distance_maps, 6);
  EXPECT_EQ(counts.kept_distances, "given");
  // Estimated again: only the new ones stay recorded.
  replace(3.0F);
  EXPECT_EQ(Room::open(room_).distances(0).distance_column(0, 0)[0], 3.0F);
  EXPECT_EQ(manifest()["distances"].size(), 2U);
  EXPECT_EQ(verify_error(), "no error");
}

TEST_F(DistanceSetsTest, UseSwitchesThereAndBack) {
  replace(2.0F);
  const std::string estimated = sha256_of_file(volume("x0"));
  write_file_atomically(connection_errors_path(room_), "{}");
  EXPECT_THAT(use_distances(room_, DistanceKind::kGiven), HasSubstr("connect-error.json"));
  EXPECT_EQ(origin(), "given");
  EXPECT_FALSE(fs::exists(connection_errors_path(room_)));
  EXPECT_FALSE(fs::exists(room_ / "distances-given"));
  EXPECT_EQ(sha256_of_file(volume("x0", "distances-estimated")), estimated);
  EXPECT_EQ(verify_room(Room::open(room_)).kept_distances, "estimated by sweep");
  EXPECT_THAT(use_distances(room_, DistanceKind::kGiven), HasSubstr("already"));
  use_distances(room_, DistanceKind::kEstimated);
  EXPECT_EQ(sha256_of_file(volume("x0")), estimated);
  EXPECT_FALSE(fs::exists(room_ / "distances-estimated"));
  EXPECT_FALSE(fs::exists(room_ / "distances.lock"));
  // Estimating while given ones are in use leaves no older estimate behind.
  use_distances(room_, DistanceKind::kGiven);
  replace(4.0F);
  EXPECT_FALSE(fs::exists(room_ / "distances-estimated"));
  EXPECT_EQ(verify_error(), "no error");
}

TEST_F(DistanceSetsTest, InfoNamesThoseInUseAndTheOthers) {
  replace(2.0F);
  const RoomInfo info = info_of(Room::open(room_));
  EXPECT_THAT(text_of(info, "room.lf"), AllOf(HasSubstr("distances in use: estimated by sweep"),
                                              HasSubstr("not in use: given")));
  const auto json = nlohmann::json::parse(json_of(info));
  EXPECT_EQ(json["distances"], "estimated by sweep");
  EXPECT_EQ(json["distance_sets"].size(), 2U);
  fs::remove(volume("z0", "distances-given"));
  EXPECT_THAT(text_of(info_of(Room::open(room_)), "room.lf"),
              HasSubstr("not usable: " + volume("z0", "distances-given").string()));
}

TEST_F(DistanceSetsTest, ASetThatIsNotThereCannotBeUsed) {
  EXPECT_THAT(error_of([&] { use_distances(room_, DistanceKind::kEstimated); }),
              HasSubstr("raywalk-build-lf depth"));
  replace(2.0F);
  fs::remove(volume("z0", "distances-given"));
  EXPECT_THAT(error_of([&] { use_distances(room_, DistanceKind::kGiven); }),
              HasSubstr("distances-given/z0.h5: the recorded distances are missing"));
  EXPECT_THAT(verify_error(), HasSubstr("distances-given/z0.h5"));
  EXPECT_EQ(origin(), "estimated by sweep");
  EXPECT_THROW(distance_kind_from_name("both"), UsageError);
}

TEST_F(DistanceSetsTest, UseReplacesMissingOrDamagedOnes) {
  replace(2.0F);
  fs::remove(volume("x0"));
  use_distances(room_, DistanceKind::kGiven);
  EXPECT_EQ(origin(), "given");
  EXPECT_THAT(verify_error(), HasSubstr("distances-estimated/x0.h5"));  // kept as it was
  fs::remove_all(room_ / "distances-estimated");
  fs::rename(room_ / "distances", room_ / "distances-given");
  use_distances(room_, DistanceKind::kGiven);
  EXPECT_EQ(origin(), "given");
}

// A switch that was killed between its two renames.
TEST_F(DistanceSetsTest, AnInterruptedSwitchLeavesAValidRoom) {
  replace(2.0F);
  fs::rename(room_ / "distances", room_ / "q");
  fs::rename(room_ / "distances-given", room_ / "distances");
  fs::rename(room_ / "q", room_ / "distances-given");
  EXPECT_EQ(verify_room(Room::open(room_)).kept_distances, "estimated by sweep");
  use_distances(room_, DistanceKind::kEstimated);
  EXPECT_EQ(verify_room(Room::open(room_)).kept_distances, "given");
  EXPECT_EQ(origin(), "estimated by sweep");
}

// Estimating that is killed before or after the volumes are moved.
TEST_F(DistanceSetsTest, AnInterruptedEstimateLeavesAValidRoom) {
  replace(2.0F);
  const fs::path volumes = estimate(3.0F);
  const auto killed = [](const std::string&) { throw Interrupted("killed"); };
  EXPECT_THROW(replace_estimated(room_, volumes, killed), Interrupted);
  EXPECT_EQ(verify_error(), "no error");
  EXPECT_EQ(Room::open(room_).distances(0).distance_column(0, 0)[0], 2.0F);
  fs::rename(room_ / "distances", room_ / "replaced");
  fs::rename(volumes, room_ / "distances");
  EXPECT_EQ(verify_error(), "no error");
  EXPECT_EQ(Room::open(room_).distances(0).distance_column(0, 0)[0], 3.0F);
}

TEST_F(DistanceSetsTest, DamagedGivenDistancesAreNotReplaced) {
  fs::remove(volume("z0"));
  EXPECT_THAT(error_of([&] { require_distances_replaceable(room_); }),
              AllOf(HasSubstr("z0.h5"), HasSubstr("remove " + (room_ / "distances").string())));
  fs::remove_all(room_ / "distances");
  replace(2.0F);
  EXPECT_EQ(origin(), "estimated by sweep");
  EXPECT_EQ(manifest()["distances"].size(), 1U);
  // Estimated ones can be estimated again.
  fs::remove(volume("x0"));
  replace(2.5F);
  EXPECT_EQ(verify_error(), "no error");
}

TEST_F(DistanceSetsTest, RecordAcceptsWhatIsThere) {
  fs::remove(volume("z0"));
  EXPECT_THAT(record_distances(room_), HasSubstr("(given)"));
  EXPECT_EQ(verify_room(Room::open(room_)).distance_maps, 3 * TestCapture::kStationsPerLine);
  fs::remove_all(room_ / "distances");
  EXPECT_THAT(record_distances(room_), HasSubstr("none"));
  EXPECT_EQ(origin(), "none");
  EXPECT_EQ(verify_error(), "no error");
}

// Manifests of format 1 say nothing about distances.
TEST_F(DistanceSetsTest, ARoomOfAnOlderProgramOpensAndCanBeRecorded) {
  nlohmann::json json = manifest();
  json["format_version"] = 1;
  json.erase("distances");
  write_manifest(json);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  EXPECT_EQ(origin(), "given");
  const std::string warning =
      testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
  EXPECT_THAT(warning, HasSubstr("--record"));
  EXPECT_EQ(verify_error(), "no error");
  record_distances(room_);
  EXPECT_EQ(manifest()["format_version"], 2);
  // Estimating records both sets.
  write_manifest(json);
  replace(2.0F);
  EXPECT_EQ(manifest()["distances"].size(), 2U);
  EXPECT_EQ(verify_room(Room::open(room_)).kept_distances, "given");
}

}  // namespace
}  // namespace raywalk::build_lf
