#include "build_lf/refine/refine_room.h"

#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/exposure/make_gains.h"
#include "build_lf/quality/room_verify.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/room/refined_record.h"
#include "core/room/station_image.h"
#include "core/room/tiled_rays.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class RefineRoomTest : public testing::Test {
 protected:
  // A cell of 1 m with 17 stations a line, every 4th of them with a map. The photographs are half
  // as wide where it does not matter what they show.
  static SyntheticRoomSpec spec(int width = 128) {
    return {.spacing_m = 0.0625, .width = width, .distance_every = 4};
  }
  static SyntheticRoomSpec small_spec() { return spec(64); }
  static RefineOptions options_of(const Room& room) {
    return {.room = room.directory(), .out = refined_room_path(room.directory())};
  }
  static Room refined(const Room& room) {
    const RefineOptions options = options_of(room);
    refine_room(options);
    return Room::open(options.out);
  }
  // Starts a run and stops it when it has stored something in a folder.
  static void stop_once_stored(const RefineOptions& options, const fs::path& stations) {
    std::signal(SIGINT, [](int) {});
    {
      const WatchInterrupts watch;
      std::thread stopper([&] {
        std::error_code none_yet;
        for (int tries = 0; tries < 20'000; ++tries) {
          if (fs::directory_iterator(stations, none_yet) != fs::directory_iterator()) break;
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        std::raise(SIGINT);
      });
      EXPECT_THROW(refine_room(options), Interrupted);
      stopper.join();
    }
    std::signal(SIGINT, SIG_DFL);
  }
  // PSNR of a station's picture against the scene, which shows detail of a pixel of its width.
  static double psnr_of(const Room& room, StationIndex station, const SyntheticScene& scene) {
    const Station& at = room.grid().station(station);
    cv::Mat shown = station_image(room, station, room.panorama()).t();
    cv::cvtColor(shown, shown, cv::COLOR_RGB2BGR);
    return cv::PSNR(shown, render_scene(scene, at.position_m, room.panorama().width));
  }
};

TEST_F(RefineRoomTest, AStationIsBetterThanItsNoisyPhotograph) {
  const SyntheticRoomSpec scene = spec();
  DepthTestRoom captured(
      scene, [](StationIndex station, cv::Mat* frame) { add_noise(station, 8.0, frame); });
  captured.give_distances(scene.scene, {128, 64}, 4);
  const Room room = refined(captured.room());
  EXPECT_EQ(room.panorama().width, 256);
  EXPECT_EQ(room.grid().lines.size(), 4u);
  EXPECT_EQ(room.grid().cells.size(), 1u);
  for (int line = 0; line < 4; ++line) {
    ASSERT_EQ(room.volume(line).stations(), 5);
    EXPECT_EQ(room.distances(line).maps(), 5);
    EXPECT_EQ(room.distances(line).size().width, 256);
    for (const int station : {0, 2}) {
      const double photograph = psnr_of(captured.room(), {line, 4 * station}, scene.scene);
      EXPECT_NEAR(photograph, 30.0, 0.5);
      EXPECT_GT(psnr_of(room, {line, station}, scene.scene), photograph + 7.0);
    }
  }
  EXPECT_NO_THROW(verify_room(room));
}

TEST_F(RefineRoomTest, ExposuresAgreeAfterwards) {
  const SyntheticRoomSpec scene = spec();
  const auto gain_of = [](StationIndex station) { return station.station % 2 == 0 ? 0.8 : 1.0; };
  DepthTestRoom captured(scene, [&](StationIndex station, cv::Mat* frame) {
    frame->convertTo(*frame, CV_8U, gain_of(station));
  });
  captured.give_distances(scene.scene, {128, 64}, 4);
  GainFields gains = unit_gain_fields(captured.grid());
  for (auto& line : gains) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      line[i].whole = ColourGain::all(static_cast<float>(1.0 / gain_of({0, static_cast<int>(i)})));
    }
  }
  replace_gains(captured.room().directory(), gains);
  const Room room = refined(Room::open(captured.room().directory()));
  EXPECT_TRUE(room.gains().empty());
  EXPECT_GT(psnr_of(room, {0, 2}, scene.scene), 38.0);
}

TEST_F(RefineRoomTest, WhatMasksHideIsTakenFromOtherStations) {
  const SyntheticRoomSpec scene = spec();
  // A black patch, elsewhere in each station, masked with what is below it.
  const auto column_of = [](StationIndex station) { return 8 * station.station % 112; };
  DepthTestRoom captured(
      scene,
      [&](StationIndex station, cv::Mat* frame) {
        (*frame)({column_of(station), 40, 16, 24}) = cv::Scalar::all(0);
      },
      [&](StationIndex station) {
        cv::Mat mask(64, 128, CV_8U, cv::Scalar::all(255));
        mask({column_of(station), 40, 16, 24}) = cv::Scalar::all(0);
        return mask;
      });
  captured.give_distances(scene.scene, {128, 64}, 4);
  const Room room = refined(captured.room());
  EXPECT_GT(psnr_of(room, {0, 2}, scene.scene), 34.0);
  for (int theta = 0; theta < 256; ++theta) {
    EXPECT_EQ(room.volume(0).valid_rows(2, theta), (RowRun{0, 128})) << theta;
  }
}

TEST_F(RefineRoomTest, WhatMovedIsTakenFromOtherStations) {
  const TestDirectory directory;
  SyntheticRoomSpec scene = spec();
  scene.cells_z = 0;
  // A visitor in every third photograph, next to the station that is looked at.
  scene.companion = CameraCompanion{
      .hides =
          [](const std::string&, int station, const Eigen::Vector3d& direction) {
            return station % 3 == 2 &&
                   direction.dot(Eigen::Vector3d(0.0, -0.2, 1.0).normalized()) > 0.97;
          },
      .masked = false,
      .left_out = true};
  write_synthetic_room(scene, directory / "room.lf");
  const Room room = refined(Room::open(directory / "room.lf"));
  EXPECT_GT(psnr_of(room, {0, 2}, scene.scene), 34.0);  // that of station 8
}

TEST_F(RefineRoomTest, AStoppedRunIsResumed) {
  DepthTestRoom captured(spec());
  captured.give_distances(spec().scene, {64, 32}, 8);
  const RefineOptions options = options_of(captured.room());
  const fs::path stations = options.out.string() + ".partial/stations";
  stop_once_stored(options, stations);
  ASSERT_FALSE(fs::is_empty(stations));
  const fs::path first = *fs::directory_iterator(stations);
  const auto written = fs::last_write_time(first);
  // Another width is another room.
  RefineOptions other = options;
  other.width = 128;
  EXPECT_THAT(error_of([&] { refine_room(other); }), HasSubstr("holds an unfinished room"));
  EXPECT_EQ(fs::last_write_time(first), written);
  // So is one of other gains.
  const std::string manifest = read_file(manifest_path(options.room));
  GainFields gains = unit_gain_fields(captured.grid());
  gains[0][0].whole = ColourGain::all(1.5f);
  replace_gains(options.room, gains);
  EXPECT_THAT(error_of([&] { refine_room(options); }), HasSubstr("holds an unfinished room"));
  remove_gains(options.room);
  EXPECT_EQ(read_file(manifest_path(options.room)), manifest);
  refine_room(options);
  EXPECT_EQ(Room::open(options.out).panorama().width, 256);
}

TEST_F(RefineRoomTest, PartsMakeTheRoomOfOneRun) {
  DepthTestRoom captured(small_spec());
  captured.give_distances(spec().scene, {64, 32}, 8);
  RefineOptions options = options_of(captured.room());
  refine_room(options);
  const auto expected = checksums_of_files(options.out);
  options.out = options.out.string() + "-of-parts";
  EXPECT_THAT(refine_part(options, {3, 3}), HasSubstr("part 3/3"));
  EXPECT_THAT(refine_part(options, {1, 3}), HasSubstr("developed"));
  EXPECT_FALSE(fs::exists(options.out));
  options.hold_out = 4;
  EXPECT_THROW(refine_part(options, {2, 3}), Error) << "others have other options";
  options.hold_out = 0;
  refine_room(options);
  EXPECT_EQ(checksums_of_files(options.out), expected);
}

TEST_F(RefineRoomTest, KnowsWhatItWasMadeFrom) {
  DepthTestRoom captured(small_spec());
  captured.give_distances(spec().scene, {64, 32}, 8);
  const Room room = refined(captured.room());
  EXPECT_THAT(refined_text(room), HasSubstr("developed from 68 photographs of ../"));
  EXPECT_THAT(refined_text(room), Not(HasSubstr("changed")));
  const auto record = room.manifest().refined;
  ASSERT_TRUE(record);
  EXPECT_GT(record->sharpening[0], 0.0);
  const auto shown = current_refined_room(captured.room());
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->directory(), room.directory());
  EXPECT_FALSE(current_refined_room(room));
  captured.give_distances(spec().scene, {64, 32}, 4);
  EXPECT_FALSE(current_refined_room(captured.room()));
  EXPECT_THAT(refined_text(room), HasSubstr("has changed since: refine it again"));
  EXPECT_EQ(refined_text(captured.room()), "");
  EXPECT_THAT(error_of([&] { refine_room(options_of(room)); }), HasSubstr("is a refined room"));
}

TEST_F(RefineRoomTest, HeldOutStationsAreNotUsed) {
  DepthTestRoom captured(small_spec());
  captured.give_distances(spec().scene, {64, 32}, 2);
  RefineOptions options = options_of(captured.room());
  options.hold_out = 4;
  refine_room(options);
  const auto record = read_manifest(options.out).refined;
  EXPECT_EQ(record->hold_out, 4);
  // Of 17 stations the 3rd, 7th, 11th and 15th of every line.
  EXPECT_EQ(record->source_stations, 4 * 13);
  EXPECT_FALSE(current_refined_room(captured.room()));
  options.hold_out = 1;
  EXPECT_THAT(error_of([&] { refine_room(options); }), HasSubstr("exists"));
  options.replace = true;
  EXPECT_THROW(refine_room(options), UsageError);
}

TEST_F(RefineRoomTest, NeedsDistances) {
  const DepthTestRoom captured(spec());
  EXPECT_THAT(error_of([&] { refine_room(options_of(captured.room())); }),
              HasSubstr("has no distances; run raywalk-build-lf depth"));
}

}  // namespace
}  // namespace raywalk::build_lf
