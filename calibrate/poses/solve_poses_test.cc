#include "calibrate/poses/solve_poses.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "calibrate/poses/colmap_program.h"
#include "calibrate/poses/colmap_workspace.h"
#include "calibrate/poses/match_pairs.h"
#include "calibrate/poses/poses_figures.h"
#include "calibrate/poses/seen_points.h"
#include "calibrate/poses/test_rail_scene.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ContainsRegex;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

// --- Which stations are matched with each other, and which of the points found are used ---------

std::vector<std::size_t> all_frames(const CaptureSet& set) {
  return choose_keyframes(set, {}, 0.0);
}

TEST(CellSide, IsTheDistanceOfNeighbouringIntersections) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    const CaptureSet set = test_grid(61, size);
    EXPECT_NEAR(cell_side_m(set, intersections_of(set)), size, 1e-9 * size);
  }
  // Without intersections it is estimated from the longest line.
  EXPECT_NEAR(cell_side_m(test_line(7, 1.5), {}), 1.0, 1e-12);
}

TEST(HeldOutFrames, AreKeyframesMatchedWithTheStationsAroundThem) {
  CaptureSet set = test_grid(61);  // 25 mm apart
  const std::vector<LineIntersection> intersections = intersections_of(set);
  const std::vector<std::size_t> before = choose_keyframes(set, intersections, 150.0);
  const std::vector<FramePair> pairs_before = choose_pairs(set, intersections, before);
  const std::size_t held_out = set.frames.size();
  set.frames.push_back({.name = "t", .line = kHeldOut, .nominal_m = {0.1, 0.0, -0.3}});
  std::vector<std::size_t> expected = before;
  expected.push_back(held_out);
  const std::vector<std::size_t> keyframes = choose_keyframes(set, intersections, 150.0);
  ASSERT_EQ(keyframes, expected);
  // The stations are matched as without it, and none but keyframes.
  std::vector<FramePair> pairs = choose_pairs(set, intersections, keyframes);
  for (const auto& [first, second] : pairs) {
    EXPECT_THAT(keyframes, AllOf(Contains(first), Contains(second)));
  }
  std::vector<std::size_t> partners;
  std::erase_if(pairs, [&](const FramePair& pair) {
    if (pair.second == held_out) partners.push_back(pair.first);
    return pair.second == held_out;
  });
  EXPECT_EQ(pairs, pairs_before);
  // x0 at z = -0.5 and z1 at x = 0.5 are nearest.
  int left = 0, right = 0;
  for (const std::size_t partner : partners) {
    const CaptureFrame& station = set.frames[partner];
    EXPECT_THAT(set.line_id(station.line), ::testing::AnyOf("x0", "z1"));
    EXPECT_LT((station.nominal_m - Eigen::Vector3d(0.1, 0.0, -0.3)).norm(), 0.5);
    if (station.line == 0) ++(station.nominal_m.x() < 0.1 ? left : right);
  }
  EXPECT_GT(left, 0);
  EXPECT_GT(right, 0);
  EXPECT_GE(partners.size(), 6U);
}

TEST(Keyframes, HaveTheRequestedSpacingAndIncludeEndsAndIntersections) {
  const CaptureSet set = test_grid(61);  // 25 mm apart; intersections at stations 10 and 50
  const std::vector<LineIntersection> intersections = intersections_of(set);
  ASSERT_EQ(intersections.size(), 4U);
  for (const double apart_mm : {25.0, 60.0, 150.0, 400.0, 5000.0}) {
    const std::vector<std::size_t> keyframes = choose_keyframes(set, intersections, apart_mm);
    EXPECT_TRUE(std::is_sorted(keyframes.begin(), keyframes.end()));
    for (int line = 0; line < 4; ++line) {
      const int first = 61 * line;
      // The intersection lies on a station: that one and the one before it, up to rounding.
      for (const int station : {0, 60}) EXPECT_THAT(keyframes, Contains(first + station));
      for (const int intersection : {10, 50}) {
        const auto close =
            std::count_if(keyframes.begin(), keyframes.end(), [&](std::size_t frame) {
              return std::abs(static_cast<int>(frame) - first - intersection) <= 1;
            });
        EXPECT_GE(close, 2);
      }
    }
    for (std::size_t i = 1; i < keyframes.size(); ++i) {
      if (keyframes[i] / 61 != keyframes[i - 1] / 61) continue;
      const double gap_mm = 1e3 * (set.rail_m(keyframes[i]) - set.rail_m(keyframes[i - 1]));
      EXPECT_LE(gap_mm, std::max(apart_mm, 25.0) * 1.01);
    }
  }
  EXPECT_EQ(choose_keyframes(set, intersections, 5000.0).size(), 4U * 6U);
}

TEST(Pairs, OfASparseLineAreTheTwoNext) {
  const CaptureSet set = test_line(5);
  EXPECT_THAT(choose_pairs(set, {}, all_frames(set)),
              ElementsAre(FramePair{0, 1}, FramePair{0, 2}, FramePair{1, 2}, FramePair{1, 3},
                          FramePair{2, 3}, FramePair{2, 4}, FramePair{3, 4}));
}

TEST(Pairs, OfADenseLineReachAQuarterOfACell) {
  const CaptureSet set = test_line(61);
  const std::vector<FramePair> pairs = choose_pairs(set, {}, all_frames(set));
  EXPECT_THAT(pairs, Contains(FramePair{10, 11}));
  EXPECT_THAT(pairs, Contains(FramePair{10, 14}));
  for (const FramePair& pair : pairs) EXPECT_LE(pair.second - pair.first, 10);
  // The last ones have no 4th and are paired with the second next.
  EXPECT_EQ(pairs.size(), 60U + 57U + 2U);
}

TEST(Pairs, CrossBetweenLinesOnlyWhereTheyCross) {
  const CaptureSet set = test_grid(61);
  const std::vector<LineIntersection> intersections = intersections_of(set);
  std::array<int, 4> across{};
  for (const FramePair& pair : choose_pairs(set, intersections, all_frames(set))) {
    const CaptureFrame& first = set.frames[pair.first];
    const CaptureFrame& second = set.frames[pair.second];
    EXPECT_LT(pair.first, pair.second);
    if (first.line == second.line) continue;
    EXPECT_NE(set.lines[first.line].axis, set.lines[second.line].axis);
    bool near_one = false;
    for (std::size_t i = 0; i < intersections.size(); ++i) {
      const Eigen::Vector3d at(intersections[i].at.x_m, 0, intersections[i].at.z_m);
      if ((first.nominal_m - at).norm() > 0.201 || (second.nominal_m - at).norm() > 0.201) continue;
      near_one = true;
      ++across[i];
    }
    EXPECT_TRUE(near_one);
  }
  EXPECT_THAT(across, ElementsAre(25, 25, 25, 25));
}

TEST(Pairs, JoinThePlacementsOfALine) {
  CaptureSet set = test_line(8);
  CaptureLine behind = set.lines[0];
  behind.id += "-2";
  behind.frames.assign(set.lines[0].frames.begin() + 5, set.lines[0].frames.end());
  set.lines[0].frames.resize(5);
  for (const int frame : behind.frames) set.frames[frame].line = 1;
  set.lines.push_back(behind);
  EXPECT_EQ(choose_pairs(set, {}, all_frames(set)),
            choose_pairs(test_line(8), {}, all_frames(test_line(8))));
  set.lines[1].across_m += 1.0;  // another line
  for (const FramePair& pair : choose_pairs(set, {}, all_frames(set))) {
    EXPECT_EQ(pair.first < 5, pair.second < 5);
  }
}

TEST(SeenPoints, KeepsPointsOfEnoughFrames) {
  SeenPoints points;
  points.points_m = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  // The second is seen twice by the same frame, which counts as one.
  points.observations = {{0, 0, {0, 0, 1}, {0, 0, 0}}, {1, 0, {0, 0, 1}, {0, 0, 0}},
                         {2, 1, {0, 0, 1}, {0, 0, 0}}, {2, 1, {0, 0, 1}, {0, 0, 0}},
                         {0, 2, {0, 0, 1}, {0, 0, 0}}, {2, 2, {0, 0, 1}, {0, 0, 0}}};
  const SeenPoints kept = widely_seen(points, 2);
  ASSERT_EQ(kept.points_m.size(), 2U);
  EXPECT_EQ(kept.points_m[1].x(), 3.0);
  ASSERT_EQ(kept.observations.size(), 4U);
  EXPECT_EQ(kept.observations[3].point, 1);
}

TEST(SeenPoints, StrongestGivesEveryFrameItsShareOfLongTracks) {
  const CaptureSet set = test_grid(5);
  const FramePoses truth = test_truth(set, {}, 30);
  SeenPoints points = test_points(set, truth, 2000, 1.0, 0.1, 31);
  // Half of the points are seen only twice.
  std::erase_if(points.observations,
                [last = ~std::size_t{0}, count = 0](const PointObservation& one) mutable {
                  count = one.point == last ? count + 1 : 1;
                  last = one.point;
                  return one.point % 2 == 1 && count > 2;
                });
  const SeenPoints kept = strongest(points, 50);
  std::vector<int> seen(set.frames.size(), 0);
  std::vector<int> length(kept.points_m.size(), 0);
  for (const PointObservation& observation : kept.observations) {
    ++seen[observation.frame];
    ++length[observation.point];
  }
  EXPECT_GE(*std::min_element(seen.begin(), seen.end()), 50);
  EXPECT_LT(kept.points_m.size(), 600U);
  EXPECT_GE(*std::min_element(length.begin(), length.end()), 8);
  EXPECT_EQ(strongest(points, 1000000).observations.size(), points.observations.size());
}

// `count` points that all of the frames see.
void add_shared(SeenPoints* points, const std::vector<std::size_t>& frames, int count) {
  for (int i = 0; i < count; ++i) {
    const std::size_t point = points->points_m.size();
    points->points_m.emplace_back(0, 0, 1);
    for (const std::size_t frame : frames) points->observations.push_back({frame, point});
  }
}

TEST(LinkedGroup, HasTheFramesThatShareEnough) {
  SeenPoints points;
  add_shared(&points, {0, 1}, 10);
  add_shared(&points, {1, 2}, 10);
  add_shared(&points, {2, 3}, 9);  // too few
  add_shared(&points, {3, 4}, 10);
  EXPECT_THAT(largest_linked_group(6, points, 10),
              ElementsAre(true, true, true, false, false, false));
  EXPECT_THAT(largest_linked_group(6, points, 11), Each(false));
}

TEST(LinkedGroup, CountsPointsOfManyFrames) {
  SeenPoints points;
  add_shared(&points, {0, 1, 2}, 6);
  add_shared(&points, {0, 2, 5}, 6);
  // 0 and 2 share 12, 1 shares 6 with each.
  EXPECT_THAT(largest_linked_group(6, points, 10),
              ElementsAre(true, false, true, false, false, false));
}

// --- The solution -------------------------------------------------------------------------------

// Two lines of four stations that cross at a corner of the room's cell, between the second and the
// third of each.
CaptureSet corner_set() {
  CaptureSet set;
  set.source = "corner";
  set.frame = {512, 256};
  add_test_line(&set, "x0", LineAxis::kX, 0.0, 0.3, 4);
  add_test_line(&set, "z0", LineAxis::kZ, 0.0, 0.3, 4);
  for (CaptureLine& line : set.lines) line.across_m = -0.5;
  for (CaptureFrame& frame : set.frames) frame.nominal_m += Eigen::Vector3d(-0.5, 0.0, -0.5);
  return set;
}

FramePoses corner_truth() { return test_truth(corner_set(), {0.01, 1.0, 0.001, 0.1}, 3); }

// Ray-traced from the true poses, once for all tests.
const std::vector<cv::Mat>& corner_pictures() {
  static const std::vector<cv::Mat> pictures = [] {
    const simulator::VirtualRoom room({.scene = {.file = "study"}});
    std::vector<cv::Mat> rendered;
    for (const auto& pose : corner_truth()) {
      const Attitude attitude = attitude_from_world_from_camera(pose->world_from_camera);
      rendered.push_back(
          room.render(simulator::PanoramaRays(corner_set().frame), {pose->position_m, attitude}));
    }
    return rendered;
  }();
  return pictures;
}

// Writes the pictures of the set; `change` may modify each of them.
template <typename Change>
CaptureSet captured(const std::filesystem::path& directory, const Change& change) {
  CaptureSet set = corner_set();
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    cv::Mat picture = corner_pictures()[i].clone();
    change(static_cast<int>(i), &picture);
    set.frames[i].file = directory / (set.frames[i].name + ".png");
    cv::imwrite(set.frames[i].file.string(), picture);
  }
  return set;
}

PosesOptions options_in(const TestDirectory& directory) {
  PosesOptions options;
  options.out = directory / "out";
  options.face_px = 256;
  options.threads = 2;
  return options;
}

// Error of the relative pose of two stations, in the first one's frame.
PoseDifference relative_error(const FramePoses& poses, const FramePoses& truth, int from, int to) {
  const auto relative = [&](const FramePoses& of) {
    const FramePose& a = *of[from];
    const FramePose& b = *of[to];
    return std::pair(
        Eigen::Vector3d(a.world_from_camera.transpose() * (b.position_m - a.position_m)),
        Eigen::Matrix3d(a.world_from_camera.transpose() * b.world_from_camera));
  };
  const auto [position, rotation] = relative(poses);
  const auto [true_position, true_rotation] = relative(truth);
  return {(position - true_position).norm(), angle_between(rotation, true_rotation)};
}

class SolvePoses : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string error = error_of([] { ColmapProgram::find(); });
    if (error != "no error") GTEST_SKIP() << error;
  }
};

TEST_F(SolvePoses, RecoversHowTwoRailsCross) {
  const TestDirectory directory;
  const FramePoses truth = corner_truth();
  // One picture does not show the room.
  const CaptureSet set = captured(directory.path(), [](int frame, cv::Mat* picture) {
    if (frame == 3) cv::randu(*picture, 0, 255);
  });
  testing::internal::CaptureStderr();
  const PosesResult result = solve_poses(set, options_in(directory));
  // All that takes long shows how far it is.
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(ContainsRegex("matching features: [0-9]+ of [0-9]+ pairs \\(100 %\\)"),
                    ContainsRegex("triangulating: [0-9]+ of [0-9]+ faces"),
                    HasSubstr("adjusting poses: 63 of 63 steps (100 %)")));
  // Stations 1 and 5 are at the intersection.
  const PoseDifference error = relative_error(result.poses, truth, 1, 5);
  EXPECT_LT(error.position_m, 0.5e-3);
  EXPECT_LT(error.rotation_rad * kResidualPx_per_rad, 0.5);
  EXPECT_GT(relative_error(nominal_poses(set), truth, 1, 5).position_m, 2e-3);
  ASSERT_TRUE(result.poses[3]);
  EXPECT_EQ(result.poses[3]->origin, PoseOrigin::kRail);
  ASSERT_EQ(result.unposed.size(), 1U);
  EXPECT_EQ(result.unposed[0].frame, 3U);
  EXPECT_THAT(result.warnings, Contains(HasSubstr("line x0: 1 of 4 stations are predicted")));
  ASSERT_EQ(result.intersections.size(), 1U);
  EXPECT_GT(result.intersections[0].check.points, 25);
  EXPECT_LT(result.intersections[0].check.motion_m.norm(), 1e-3);

  const auto json = nlohmann::json::parse(read_file(directory / "out/poses.json"));
  EXPECT_EQ(json["posed"], 7);
  EXPECT_EQ(json["unposed"][0]["name"], "x0_3");
  EXPECT_TRUE(json["held_out"].is_null());
  const FramePoses read = read_frame_poses(directory / "out/poses.json", set);
  EXPECT_LT(largest_difference(read, result.poses).position_m, 1e-9);

  // A second run matches nothing again.
  const PosesResult again = solve_poses(set, options_in(directory));
  const auto reused = std::count_if(again.times.begin(), again.times.end(),
                                    [](const StepTime& time) { return time.reused; });
  EXPECT_EQ(reused, 3);
  EXPECT_LT(relative_error(again.poses, truth, 1, 5).position_m, 0.5e-3);
}

// Written beside the pictures; `masked` is 0 in the mask.
void add_mask(CaptureFrame* frame, const cv::Rect& masked) {
  cv::Mat mask(corner_set().frame.height, corner_set().frame.width, CV_8UC1, cv::Scalar(255));
  mask(masked).setTo(0);
  frame->mask = frame->file.string() + "_mask.png";
  cv::imwrite(frame->mask->string(), mask);
}

TEST_F(SolvePoses, HeldOutFramesArePosedWithTheStations) {
  const TestDirectory directory;
  CaptureSet set = captured(directory.path(), [](int, cv::Mat*) {});
  FramePoses truth = corner_truth();
  const simulator::VirtualRoom room({.scene = {.file = "study"}});
  FramePose pose{.position_m = {-0.44, 0.02, -0.42},
                 .world_from_camera = world_from_camera({0.03, -0.02, 0.01})};
  const auto add = [&](const std::string& name, const cv::Mat& picture) {
    set.frames.push_back({.name = name,
                          .line = kHeldOut,
                          .file = directory / (name + ".png"),
                          .nominal_m = pose.position_m + Eigen::Vector3d(0.01, 0.02, -0.01),
                          .where = "gt.csv:2"});
    cv::imwrite(set.frames.back().file.string(), picture);
    truth.emplace_back(pose);
  };
  add("true", room.render(simulator::PanoramaRays(set.frame),
                          {pose.position_m, Attitude{0.03, -0.02, 0.01}}));
  cv::Mat noise(set.frame.height, set.frame.width, CV_8UC3);
  cv::randu(noise, 0, 255);
  add("noise", noise);
  PosesOptions options = options_in(directory);
  options.threads = 1;  // what several do in another order moves the place by a tenth of its bound
  const PosesResult result = solve_poses(set, options);
  EXPECT_EQ(std::count(result.poses.begin(), result.poses.end(), std::nullopt), 1);
  ASSERT_TRUE(result.poses[8]);
  const PoseDifference error = relative_error(result.poses, truth, 1, 8);
  EXPECT_LT(error.position_m, 1e-3);
  EXPECT_LT(error.rotation_rad * kResidualPx_per_rad, 0.7);
  EXPECT_THAT(result.notes,
              Contains(AllOf(HasSubstr("held-out frame noise (gt.csv:2)"), HasSubstr("left out"))));
  const auto json = nlohmann::json::parse(read_file(directory / "out/poses.json"));
  EXPECT_EQ(json["stations"], 8);
  EXPECT_EQ(json["posed"], 8);
  EXPECT_EQ(json["held_out"]["frames"], 2);
  EXPECT_EQ(json["held_out"]["posed"], 1);
}

// Half of a picture is of somewhere else, and its mask says so; of another one all but a corner is
// masked.
TEST_F(SolvePoses, MaskedPixelsGiveNoFeatures) {
  const TestDirectory directory;
  const cv::Rect right(256, 0, 256, 256);
  CaptureSet set = captured(directory.path(), [&](int frame, cv::Mat* picture) {
    if (frame == 1) corner_pictures()[6](right).copyTo((*picture)(right));
  });
  add_mask(&set.frames[1], right);
  add_mask(&set.frames[3], cv::Rect(0, 0, 512, 250));
  const ColmapProgram colmap = ColmapProgram::find();
  const FramePoses start = nominal_poses(set);
  ColmapWorkspace workspace(set, {0, 1, 2, 3, 5, 6}, colmap,
                            {.directory = directory / "colmap", .face_px = 256, .threads = 2});
  workspace.cut_faces();
  workspace.find_features();
  const std::vector<FramePair> pairs{{0, 1}, {1, 2}, {1, 5}, {1, 6}, {2, 3}};
  workspace.match(pairs, start);
  EXPECT_EQ(workspace.feature_counts().at(3), 0);
  EXPECT_GT(workspace.feature_counts().at(1), 20);
  EXPECT_LT(workspace.feature_counts().at(1), 0.7 * workspace.feature_counts().at(0));
  std::size_t matches = 0;
  for (const auto& [frames, pair] : workspace.matches()) {
    for (const BearingMatch& match : pair.matches) {
      // Of the one that is half masked.
      EXPECT_TRUE(frames.first != 1 || match.in_first.x() < 0.0);
      EXPECT_TRUE(frames.second != 1 || match.in_second.x() < 0.0);
      ++matches;
    }
  }
  EXPECT_GT(matches, 30U);
  // Another mask is other work.
  add_mask(&set.frames[3], cv::Rect(0, 0, 10, 10));
  ColmapWorkspace changed(set, {0, 1, 2, 3, 5, 6}, colmap,
                          {.directory = directory / "colmap", .face_px = 256, .threads = 2});
  EXPECT_FALSE(changed.cut_faces());
}

TEST_F(SolvePoses, ReportsMirroredAndPlainPictures) {
  const TestDirectory directory;
  const auto error_for = [&](const auto& change) {
    return error_of(
        [&] { solve_poses(captured(directory.path(), change), options_in(directory)); });
  };
  EXPECT_THAT(error_for([](int, cv::Mat* picture) { cv::flip(picture->clone(), *picture, 1); }),
              AllOf(HasSubstr("corner"), HasSubstr("mirrored")));
  EXPECT_THAT(error_for([](int, cv::Mat* picture) { picture->setTo(cv::Scalar(90, 90, 90)); }),
              AllOf(HasSubstr("no pose could be solved"), HasSubstr("too plain")));
  EXPECT_FALSE(std::filesystem::exists(directory / "out/poses.json"));
}

TEST(SolvePosesInput, IsChecked) {
  const TestDirectory directory;
  CaptureSet set = corner_set();
  PosesOptions options = options_in(directory);
  const auto refusal = [&] { return error_of([&] { solve_poses(set, options); }); };
  options.face_px = 8;
  EXPECT_THAT(refusal(), HasSubstr("a face's side is 8 px"));
  options.face_px = 0;
  options.keyframes_mm = -1.0;
  EXPECT_THAT(refusal(), HasSubstr("distance of keyframes"));
  options.keyframes_mm = 0.0;
  options.start.resize(3);
  EXPECT_THAT(refusal(), HasSubstr("3 poses to start from, but 8 stations"));
  options.start.clear();
  options.mask = cv::Mat(10, 20, CV_8UC1);
  EXPECT_THAT(refusal(), HasSubstr("the mask is 20x10"));
  options.mask.reset();
  set.layout = FrameLayout::kDualFisheye;
  EXPECT_THAT(refusal(), HasSubstr("run raywalk-calibrate stitch first"));
  // COLMAP would abort.
  set = test_line(2);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("test: 2 of its 2 stations"), HasSubstr("more")));
}

}  // namespace
}  // namespace raywalk::calibrate
