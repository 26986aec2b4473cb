// End-to-end test of raywalk-build-lf depth, up to views with the estimated distances, stopped and
// resumed, and in parts.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <vector>

#include "build_lf/depth/depth_test_room.h"
#include "core/evaluate/metrics.h"
#include "core/files/image_file.h"
#include "core/panorama/panorama_rotation.h"
#include "core/room/hdf5_file.h"
#include "core/room/kept_stations.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// A textured box with an obstacle close to the front line.
SyntheticRoomSpec furnished_room(int width) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.scene.texture_wavelength_m = 0.5;
  spec.scene.obstacle = SceneBox{{-0.3, -1.2, 0.9}, {0.3, 0.4, 1.3}};
  spec.width = width;
  return spec;
}

CommandResult build_lf(const std::string& command, const fs::path& room,
                       const std::string& arguments = "") {
  return run_command(
      fmt::format("{} {} {} {}", RAYWALK_BUILD_LF, command, room.string(), arguments));
}

CommandResult depth(const Room& room, const std::string& arguments = "") {
  return build_lf("depth", room.directory(), arguments);
}

nlohmann::json report_of(const Room& room) {
  return nlohmann::json::parse(read_file(room.directory() / "depth.json"));
}

// Mean PSNR of views of the room against ground truth.
double psnr_of(const fs::path& room, const SyntheticRoomSpec& spec,
               const std::string& method = "two-sided") {
  const std::array<PlanPoint, 3> places{{{0.1, 0.2}, {-0.3, -0.1}, {0.2, -0.35}}};
  const TestDirectory directory;
  std::string list = "name,x,z\n";
  for (size_t i = 0; i < places.size(); ++i) {
    list += fmt::format("{},{},{}\n", i, places[i].x_m, places[i].z_m);
  }
  write_file_atomically(directory / "path.csv", list);
  expect_success(run_command(fmt::format("{} path {} {} --method {} --out {}", RAYWALK_RENDER,
                                         room.string(), (directory / "path.csv").string(), method,
                                         (directory / "views").string())));
  double sum_db = 0.0;
  for (size_t i = 0; i < places.size(); ++i) {
    const cv::Mat view = read_panorama(directory / "views" / fmt::format("{}.png", i));
    sum_db += psnr_db(view, render_truth(spec, places[i], spec.width));
  }
  return sum_db / static_cast<double>(places.size());
}

TEST(DepthCommandTest, GivesViewsNearlyAsGoodAsTrueDistances) {
  const SyntheticRoomSpec spec = furnished_room(192);
  DepthTestRoom room(spec);
  room.give_distances(spec.scene, {192, 96}, 4);
  const fs::path directory = room.room().directory();
  const auto given = checksums_of_files(directory / "distances/given");
  const double true_db = psnr_of(directory, spec);
  const double initial_db = psnr_of(directory, spec, "initial");

  EXPECT_THAT(expect_success(depth(room.room(), "--truth")).output,
              AllOf(HasSubstr("distance maps of 192 x 96"), HasSubstr("depth.html"),
                    HasSubstr("low confidence (below 0.25) in "),
                    HasSubstr("compared with the given distances"),
                    HasSubstr("views now use the distances estimated by sweep; the given ones are "
                              "kept in")));
  const double swept_db = psnr_of(directory, spec);
  EXPECT_GT(swept_db, initial_db + 6.0);
  EXPECT_GT(swept_db, true_db - 1.0);
  EXPECT_EQ(checksums_of_files(directory / "distances/given"), given);
  EXPECT_FALSE(fs::exists(directory / "distances.partial"));
  EXPECT_THAT(read_file(directory / "depth.html"), HasSubstr("\"kind\":\"depth\""));
  const auto report = report_of(room.room());
  EXPECT_EQ(report["method"], "sweep");
  EXPECT_GT(report["truth"]["within_2px_share"], 0.9);
  EXPECT_TRUE(report["frame_findings"].empty());
  EXPECT_EQ(report["distances"], "estimated by sweep");
  expect_success(build_lf("verify", directory));
  EXPECT_THAT(build_lf("distances", directory).output,
              HasSubstr("views use the estimated distances"));
  expect_success(build_lf("distances", directory, "--use given"));
  EXPECT_EQ(checksums_of_files(directory / "distances/given"), given);
  EXPECT_NEAR(psnr_of(directory, spec), true_db, 1e-9);
  expect_success(build_lf("distances", directory, "--use estimated"));
  EXPECT_NEAR(psnr_of(directory, spec), swept_db, 1e-9);

  // Estimated distances are replaced, given ones are kept.
  expect_success(depth(room.room(), "--method flow --every 4"));
  EXPECT_EQ(report_of(room.room())["method"], "flow");
  EXPECT_TRUE(report_of(room.room())["truth"].is_null());
  EXPECT_EQ(checksums_of_files(directory / "distances/given"), given);
  EXPECT_GT(psnr_of(directory, spec), initial_db + 3.0);
}

// Checksums of the maps of each line.
std::vector<std::vector<std::string>> maps_of(const fs::path& room) {
  std::vector<std::vector<std::string>> lines;
  for (const char* line : {"x0", "x1", "z0", "z1"}) {
    lines.push_back(Hdf5File::open(distance_volume_path(room, line, DistanceKind::kEstimated))
                        .read_strings("sha256"));
  }
  return lines;
}

TEST(DepthCommandTest, HeldOutStationsAreNotUsed) {
  const SyntheticRoomSpec spec = furnished_room(64);
  const Grid grid = synthetic_grid(spec);
  const auto left_out = held_out_stations(grid, 4);
  DepthTestRoom room(spec);
  room.give_distances(spec.scene, {64, 32}, 8);
  const DepthTestRoom damaged(spec, [&](StationIndex station, cv::Mat* frame) {
    const auto& of_line = left_out[station.line];
    if (std::ranges::binary_search(of_line, station.station)) frame->setTo(0);
  });
  const auto given = checksums_of_files(room.room().directory() / "distances/given");
  for (const DepthTestRoom* each : {&std::as_const(room), &damaged}) {
    EXPECT_THAT(expect_success(depth(each->room(), "--hold-out 4")).output,
                HasSubstr("held-out/depth.html"));
  }
  const fs::path held_out = held_out_directory(room.room().directory());
  EXPECT_EQ(nlohmann::json::parse(read_file(held_out / "depth.json"))["hold_out"], 4);
  EXPECT_EQ(checksums_of_files(room.room().directory() / "distances/given"), given);
  EXPECT_FALSE(fs::exists(room.room().directory() / "depth.json"));
  EXPECT_THAT(maps_of(held_out), ::testing::Each(::testing::Not(::testing::IsEmpty())));
  EXPECT_EQ(maps_of(held_out), maps_of(held_out_directory(damaged.room().directory())));
}

// The disc of the floor that the dolly hides in every frame.
void paint_dolly(StationIndex, cv::Mat* frame) {
  frame->rowRange(frame->rows * 158 / 180, frame->rows).setTo(cv::Scalar(255, 0, 255));
}

TEST(DepthCommandTest, ViewsThroughMasksShowTheRoomAndNotTheDolly) {
  SyntheticRoomSpec spec = furnished_room(128);
  spec.spacing_m = 0.125;
  spec.overhang_m = 0.25;
  const auto mask = [&](StationIndex) {
    cv::Mat valid(spec.width / 2, spec.width, CV_8UC1, cv::Scalar(255));
    valid.rowRange(valid.rows * 158 / 180, valid.rows).setTo(0);
    return valid;
  };
  const auto psnr_with = [&](const DepthTestRoom& room) {
    expect_success(depth(room.room(), "--every 2"));
    return psnr_of(room.room().directory(), spec);
  };
  const double clean_db = psnr_with(DepthTestRoom(spec));
  const DepthTestRoom masked(spec, paint_dolly, mask);
  const double masked_db = psnr_with(masked);
  EXPECT_GT(masked_db, clean_db - 1.5);
  EXPECT_LT(psnr_with(DepthTestRoom(spec, paint_dolly)), masked_db - 6.0);

  expect_one_error(depth(masked.room(), "--method flow"), 2, "have masks");
}

// In the room of the unmodified frames, views lose little with distances estimated from `captured`
// instead of the true ones.
void expect_distances_as_good_as_true(const DepthTestRoom& captured,
                                      const SyntheticRoomSpec& spec) {
  DepthTestRoom clean(spec);
  const fs::path room = clean.room().directory();
  clean.give_distances(spec.scene, {spec.width, spec.width / 2}, 4);
  const double true_db = psnr_of(room, spec);
  fs::remove_all(room / "distances");
  fs::copy(captured.room().directory() / "distances", room / "distances",
           fs::copy_options::recursive);
  use_distances(room, DistanceKind::kEstimated);
  EXPECT_GT(psnr_of(room, spec), true_db - 1.5);
}

TEST(DepthCommandTest, NoiseGainsAndPosesCostLittle) {
  const SyntheticRoomSpec spec = furnished_room(192);
  const Grid grid = synthetic_grid(spec);
  const DepthTestRoom captured(spec, [&](StationIndex station, cv::Mat* frame) {
    cv::RNG random(static_cast<std::uint64_t>(100 * station.line + station.station + 7));
    const auto deviate = [&](double deviation) { return random.gaussian(deviation); };
    const Line& line = grid.lines[station.line];
    const Eigen::Vector3d off_m(deviate(0.002), deviate(0.002), deviate(0.002));
    *frame = render_scene(spec.scene, line.stations[station.station].position_m + off_m, spec.width,
                          1.0 + deviate(0.03));
    const double most_rad = radians_from_degrees(0.1);
    *frame = rotate_panorama(
        *frame, world_from_camera({deviate(most_rad), deviate(most_rad), deviate(most_rad)}));
    add_noise(station, 3.0, frame);
  });
  ASSERT_EQ(depth(captured.room()).exit_code, 0);
  const auto report = report_of(captured.room());
  EXPECT_GT(report["gains"]["spread"], 0.015);
  // Some of these gains are visible steps; no other finding is expected.
  for (const auto& finding : report["frame_findings"]) {
    EXPECT_EQ(finding["fault"], "exposure_step") << finding;
  }
  expect_distances_as_good_as_true(captured, spec);
}

TEST(DepthCommandTest, ExposureJumpsAndMovingObjectsAreReportedAndCostLittle) {
  const SyntheticRoomSpec spec = furnished_room(192);
  const DepthTestRoom captured(spec, [&](StationIndex station, cv::Mat* frame) {
    if (station.line == 1 && station.station < 12) *frame *= 1.0 / 1.3;
    const bool passed_by = station == StationIndex{0, 11} || station == StationIndex{2, 7} ||
                           station == StationIndex{3, 16};
    if (passed_by) {
      cv::rectangle(*frame, {30 + 15 * station.line, 24}, {45 + 15 * station.line, 52},
                    cv::Scalar(20, 40, 30), cv::FILLED);
    }
  });
  const CommandResult result = depth(captured.room());
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  std::map<std::string, std::string> faults;
  const auto report = report_of(captured.room());
  for (const auto& finding : report["frame_findings"]) faults[finding["file"]] = finding["fault"];
  const std::map<std::string, std::string> expected{{"x0_011.png", "unlike_neighbours"},
                                                    {"x1_012.png", "exposure_step"},
                                                    {"z0_007.png", "unlike_neighbours"},
                                                    {"z1_016.png", "unlike_neighbours"}};
  EXPECT_EQ(faults, expected);
  EXPECT_NEAR(report["largest_exposure_step"].get<double>(), 1.3, 0.02);
  for (const auto& [file, fault] : expected) EXPECT_THAT(result.errors, HasSubstr(file));
  expect_distances_as_good_as_true(captured, spec);
}

// Expects failure with exactly one error, and an unchanged room.
void expect_error(const Room& room, const std::string& arguments, int exit_code,
                  const std::string& text) {
  expect_one_error(depth(room, arguments), exit_code, text);
  for (const char* name : {"depth.json", "depth.html", "distances"}) {
    EXPECT_FALSE(fs::exists(room.directory() / name)) << arguments;
  }
}

TEST(DepthCommandTest, FailuresGiveOneErrorLineAndLeaveTheRoomUnchanged) {
  const DepthTestRoom room(furnished_room(64));
  const fs::path directory = room.room().directory();
  const auto before = checksums_of_files(directory / "lines");
  const std::string mask = (directory / "mask.png").string();
  write_image(mask, cv::Mat(16, 32, CV_8UC1, cv::Scalar(255)));
  expect_error(room.room(), "--every -1", 2, "--every");
  expect_error(room.room(), "--every 1.5", 2, "--every");
  expect_error(room.room(), "--width 7", 2, "--width 7: give a multiple of 4 from 32 to 64");
  expect_error(room.room(), "--width -32", 2, "--width -32");
  expect_error(room.room(), "--method stereo", 2, "sweep or flow");
  expect_error(room.room(), "--method flow --valid-mask " + mask, 2, "--method sweep");
  expect_error(room.room(), "--valid-mask " + mask, 1, "the mask is 32x16, but 64x32");
  expect_error(room.room(), "--valid-mask missing.png", 1, "missing.png");
  expect_error(room.room(), "--truth", 1, "pack it with --distance");
  expect_error(room.room(), "--hold-out 1", 2, "--hold-out: give 2 or more");
  expect_error(room.room(), "--hold-out 4 --truth", 2, "without --hold-out");
  EXPECT_FALSE(fs::exists(directory / "distances.partial"));
  // A file in place of a directory is an error even for root.
  std::ofstream(directory / "distances.partial") << "in the way";
  expect_error(room.room(), "", 1, "distances.partial");
  EXPECT_EQ(checksums_of_files(directory / "lines"), before);
  const fs::path missing = directory / "no.lf";
  expect_one_error(build_lf("depth", missing), 1, "no.lf");
  EXPECT_FALSE(fs::exists(directory / "no.lf"));
}

TEST(DepthCommandTest, AFullDiskLeavesTheOldDistances) {
  const SyntheticRoomSpec spec = furnished_room(64);
  DepthTestRoom room(spec);
  room.give_distances(spec.scene, {64, 32}, 8);
  const fs::path directory = room.room().directory();
  const auto given = checksums_of_files(directory / "distances/given");
  // A file size limit simulates a full disk: maps fit, volumes do not.
  const CommandResult stopped =
      run_command(fmt::format("ulimit -f 40; {} depth {}", RAYWALK_BUILD_LF, directory.string()));
  expect_one_error(stopped, 1, "cannot write");
  EXPECT_THAT(stopped.errors, HasSubstr("x0."));
  EXPECT_EQ(checksums_of_files(directory / "distances/given"), given);
  EXPECT_EQ(depth(room.room()).exit_code, 0);
  EXPECT_EQ(checksums_of_files(directory / "distances/given"), given);
}

TEST(DepthCommandTest, MapsOfTwoStationsAreWarnedOfOrRefused) {
  SyntheticRoomSpec spec = furnished_room(64);
  spec.cells_z = 0;
  spec.spacing_m = spec.side_m = 0.25;
  const DepthTestRoom room(spec);
  ASSERT_EQ(room.grid().lines.front().stations.size(), 2U);
  // Flow compares two pictures at a time, so that it finds something.
  for (const auto& [method, exit_code] : {std::pair("sweep", 1), std::pair("flow", 0)}) {
    const CommandResult result = depth(room.room(), fmt::format("--method {}", method));
    EXPECT_THAT(result.errors, HasSubstr("line x0 has a gap of 0.250 m"));
    EXPECT_EQ(result.exit_code, exit_code) << result.errors;
    const bool refused = result.errors.find("not usable between stations") != std::string::npos;
    EXPECT_EQ(refused, exit_code == 1) << result.errors;
    const auto report = report_of(room.room());
    EXPECT_FALSE(report["warnings"].empty());
    ASSERT_EQ(report["maps"].size(), 2U);
    for (const auto& map : report["maps"]) EXPECT_LT(map["mean_confidence"], 0.4);
  }
}

// All frames are identical, or identical up to noise.
TEST(DepthCommandTest, ACameraThatNeverMovedIsReported) {
  const SyntheticRoomSpec spec = furnished_room(64);
  const cv::Mat standing = render_scene(spec.scene, {0, 0, 0}, spec.width);
  const DepthTestRoom copies(spec, [&](StationIndex, cv::Mat* frame) { *frame = standing; });
  expect_error(copies.room(), "", 1, "no line has two left");
  EXPECT_FALSE(fs::exists(copies.room().directory() / "distances.partial"));

  const DepthTestRoom noisy(spec, [&](StationIndex station, cv::Mat* frame) {
    *frame = standing.clone();
    add_noise(station, 2.0, frame);
  });
  for (const char* method : {"sweep", "flow"}) {
    const CommandResult result = depth(noisy.room(), fmt::format("--method {}", method));
    for (const char* line : {"x0", "x1", "z0", "z1"}) {
      EXPECT_THAT(result.errors, HasSubstr(fmt::format("line {} shows no parallax", line)));
    }
    EXPECT_EQ(report_of(noisy.room())["warnings"].size(), 4U);
  }
}

size_t swept_maps(const fs::path& room) {
  std::error_code error;
  size_t count = 0;
  for (const auto& entry : fs::directory_iterator(room / "distances.partial", error)) {
    if (entry.path().filename().string().starts_with("swept-")) ++count;
  }
  return count;
}

int exit_code_of_interrupted(const fs::path& room, size_t maps) {
  return exit_code_when_stopped({RAYWALK_BUILD_LF, "depth", room.string(), "--threads", "1"},
                                SIGINT, [&] { return swept_maps(room) >= maps; });
}

std::map<fs::path, fs::file_time_type> finished_maps(const fs::path& room) {
  std::map<fs::path, fs::file_time_type> times;
  for (const auto& entry : fs::directory_iterator(room / "distances.partial")) {
    if (entry.path().extension() == ".map") times[entry.path()] = fs::last_write_time(entry.path());
  }
  return times;
}

TEST(DepthCommandTest, CtrlCKeepsFinishedMapsAndTheSameCommandResumes) {
  const SyntheticRoomSpec spec = furnished_room(128);
  DepthTestRoom room(spec);
  room.give_distances(spec.scene, {64, 32}, 8);
  const fs::path directory = room.room().directory();
  const auto given = checksums_of_files(directory / "distances/given");
  EXPECT_EQ(exit_code_of_interrupted(directory, 2), 130);
  const auto first = finished_maps(directory);
  EXPECT_GE(first.size(), 2U);
  EXPECT_EQ(exit_code_of_interrupted(directory, swept_maps(directory) + 2), 130);
  const auto second = finished_maps(directory);
  EXPECT_GT(second.size(), first.size());
  for (const auto& [file, time] : first) EXPECT_EQ(second.at(file), time) << file;
  // The room is unchanged until the command completes.
  EXPECT_EQ(checksums_of_files(directory / "distances/given"), given);
  EXPECT_FALSE(fs::exists(directory / "depth.json"));

  expect_success(depth(room.room()));
  EXPECT_EQ(checksums_of_files(directory / "distances/given"), given);
  EXPECT_FALSE(fs::exists(directory / "distances.partial"));
  // The result of three interrupted runs equals that of a single run.
  const auto in_parts = maps_of(directory);
  ASSERT_EQ(depth(room.room()).exit_code, 0);
  EXPECT_EQ(maps_of(directory), in_parts);
}

// Parts, which a cluster may start twice. Two copies of a room: one for a single run, one for them.
class DepthPartCommandTest : public ::testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec spec = furnished_room(96);
    spec.spacing_m = 0.125;
    return spec;
  }

  DepthPartCommandTest() {
    fs::copy(room_.room().directory(), parts_, fs::copy_options::recursive);
  }

  BackgroundProcess start(const std::string& step, const std::string& part,
                          const std::string& log) const {
    return {{RAYWALK_BUILD_LF, "depth", parts_.string(), "--every", "3", "--threads", "1", "--step",
             step, "--part", part},
            directory_ / log};
  }

  std::string log(const std::string& name) const { return read_file(directory_ / name); }

  // Two processes at the same part.
  void make_twice_at_a_time(const std::string& step, const std::string& part) const {
    BackgroundProcess first = start(step, part, "first");
    BackgroundProcess second = start(step, part, "second");
    EXPECT_EQ(first.wait(), 0) << step << " " << part << ": " << log("first");
    EXPECT_EQ(second.wait(), 0) << step << " " << part << ": " << log("second");
  }

  void wait_for_swept_map() const {
    constexpr auto kLongest = std::chrono::seconds(20);
    const auto end = std::chrono::steady_clock::now() + kLongest;
    while (swept_maps(parts_) == 0 && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_GT(swept_maps(parts_), 0U);
  }

  // A process stands still with some of its maps made while another makes the whole part.
  void sweep_beside_one_that_stands(const std::string& part) const {
    BackgroundProcess standing = start("sweep", part, "standing");
    wait_for_swept_map();
    standing.signal(SIGSTOP);
    BackgroundProcess other = start("sweep", part, "other");
    EXPECT_EQ(other.wait(), 0) << log("other");
    standing.signal(SIGCONT);
    EXPECT_EQ(standing.wait(), 0) << log("standing");
  }

  void expect_result_of_one_run() const {
    expect_success(build_lf("depth", parts_, "--every 3"));
    expect_success(depth(room_.room(), "--every 3"));
    EXPECT_EQ(result_files_of(parts_), result_files_of(room_.room().directory()));
    EXPECT_FALSE(fs::exists(parts_ / "distances.partial"));
  }

  DepthTestRoom room_{spec()};
  TestDirectory directory_;
  fs::path parts_ = directory_ / "parts.lf";
};

TEST_F(DepthPartCommandTest, TwoProcessesAtAPartLeaveTheRoomOfOneRun) {
  expect_success(build_lf("depth", parts_, "--every 3 --step prepare"));
  for (const std::string step : {"sweep", "choose", "fuse", "volumes"}) {
    if (step == "sweep") {
      sweep_beside_one_that_stands("1/2");
    } else {
      make_twice_at_a_time(step, "1/2");
    }
    make_twice_at_a_time(step, "2/2");
  }
  expect_result_of_one_run();
}

}  // namespace
}  // namespace raywalk::build_lf
