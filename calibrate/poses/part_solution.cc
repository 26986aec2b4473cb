#include "calibrate/poses/part_solution.h"

#include <algorithm>
#include <cstdint>

#include "calibrate/base/number_bytes.h"

namespace raywalk::calibrate {
namespace {

// The first number of a file; another where its form changes or the machine orders bytes otherwise.
constexpr std::uint64_t kForm = 0x5261'7950'6172'7401;

void write_counts(const std::map<int, int>& counts, NumberWriter* writer) {
  writer->size(counts.size());
  for (const auto& [frame, count] : counts) {
    writer->number(std::int32_t{frame});
    writer->number(std::int32_t{count});
  }
}

std::map<int, int> read_counts(NumberReader* reader, std::size_t frames) {
  std::map<int, int> counts;
  for (std::size_t left = reader->size(); left > 0; --left) {
    const int frame = reader->index(frames);
    counts[frame] = reader->number<std::int32_t>();
  }
  return counts;
}

void write_poses(const FramePoses& poses, NumberWriter* writer) {
  const auto posed =
      std::count_if(poses.begin(), poses.end(), [](const auto& pose) { return pose.has_value(); });
  writer->size(static_cast<std::size_t>(posed));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    const FramePose& pose = *poses[i];
    writer->number(static_cast<std::int32_t>(i));
    writer->matrix(pose.position_m);
    writer->matrix(pose.world_from_camera);
    writer->number(pose.position_sigma_mm);
    writer->number(pose.rotation_sigma_deg);
    writer->number(std::int32_t{pose.observations});
    writer->number(pose.residual_px);
  }
}

FramePoses read_poses(NumberReader* reader, std::size_t frames) {
  FramePoses poses(frames);
  for (std::size_t left = reader->size(); left > 0; --left) {
    FramePose& pose = poses[static_cast<std::size_t>(reader->index(frames))].emplace();
    pose.position_m = reader->matrix<Eigen::Vector3d>();
    pose.world_from_camera = reader->matrix<Eigen::Matrix3d>();
    pose.origin = PoseOrigin::kSolved;
    pose.position_sigma_mm = reader->number<double>();
    pose.rotation_sigma_deg = reader->number<double>();
    pose.observations = reader->number<std::int32_t>();
    pose.residual_px = reader->number<double>();
  }
  return poses;
}

void write_points(const RefinedPoses& refined, NumberWriter* writer) {
  writer->size(refined.points.points_m.size());
  for (const Eigen::Vector3d& point : refined.points.points_m) writer->matrix(point);
  writer->size(refined.points.observations.size());
  for (const PointObservation& observation : refined.points.observations) {
    writer->number(std::int32_t{observation.frame});
    writer->number(std::int32_t{observation.point});
    writer->matrix(observation.bearing);
    writer->matrix(observation.centre_m);
  }
  for (const double error_px : refined.errors_px) writer->number(error_px);
}

void read_points(NumberReader* reader, std::size_t frames, RefinedPoses* refined) {
  const std::size_t points = reader->size();
  for (std::size_t i = 0; i < points; ++i) {
    refined->points.points_m.push_back(reader->matrix<Eigen::Vector3d>());
  }
  const std::size_t observations = reader->size();
  for (std::size_t i = 0; i < observations; ++i) {
    PointObservation observation;
    observation.frame = reader->index(frames);
    observation.point = reader->index(points);
    observation.bearing = reader->matrix<Eigen::Vector3d>();
    observation.centre_m = reader->matrix<Eigen::Vector3d>();
    if (!refined->poses[static_cast<std::size_t>(observation.frame)]) reader->fail();
    refined->points.observations.push_back(observation);
  }
  for (std::size_t i = 0; i < observations; ++i) {
    refined->errors_px.push_back(reader->number<double>());
  }
}

}  // namespace

std::string bytes_of(const PartSolution& solution) {
  NumberWriter writer;
  writer.number(kForm);
  writer.text(solution.colmap);
  write_counts(solution.features, &writer);
  write_counts(solution.matches, &writer);
  writer.number(std::int32_t{solution.matched_pairs});
  writer.size(solution.evidence.size());
  for (const std::vector<double>& of_line : solution.evidence) {
    writer.size(of_line.size());
    for (const double value : of_line) writer.number(value);
  }
  writer.size(solution.times.size());
  for (const StepTime& time : solution.times) {
    writer.text(time.step);
    writer.number(time.seconds);
    writer.number(std::uint8_t{time.reused});
  }
  writer.number(solution.refined.noise_px);
  writer.number(solution.refined.inlier_px);
  write_poses(solution.refined.poses, &writer);
  write_points(solution.refined, &writer);
  return writer.take();
}

PartSolution read_part_solution(std::string_view bytes, std::size_t frames, std::size_t lines,
                                const std::string& part) {
  NumberReader reader(
      bytes, "the poses of " + part + " are damaged; remove their blocks and make them again");
  if (reader.number<std::uint64_t>() != kForm) reader.fail();
  PartSolution solution;
  solution.colmap = reader.text();
  solution.features = read_counts(&reader, frames);
  solution.matches = read_counts(&reader, frames);
  solution.matched_pairs = reader.number<std::int32_t>();
  solution.evidence.resize(reader.size());
  if (solution.evidence.size() != lines) reader.fail();
  for (std::vector<double>& of_line : solution.evidence) {
    of_line.resize(reader.size());
    for (double& value : of_line) value = reader.number<double>();
  }
  for (std::size_t left = reader.size(); left > 0; --left) {
    StepTime& time = solution.times.emplace_back();
    time.step = reader.text();
    time.seconds = reader.number<double>();
    time.reused = reader.number<std::uint8_t>() != 0;
  }
  solution.refined.noise_px = reader.number<double>();
  solution.refined.inlier_px = reader.number<double>();
  solution.refined.poses = read_poses(&reader, frames);
  read_points(&reader, frames, &solution.refined);
  reader.end();
  return solution;
}

}  // namespace raywalk::calibrate
