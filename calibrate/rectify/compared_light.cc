#include "calibrate/rectify/compared_light.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/rectify/compared_panorama.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

// Position of a frame's pose in the x-z plane.
Eigen::Vector2d plan_position(const FramePoses& poses, int frame) {
  const Eigen::Vector3d& at = poses[static_cast<std::size_t>(frame)]->position_m;
  return {at.x(), at.z()};
}

std::vector<int> posed_frames(const CaptureLine& line, const FramePoses& poses) {
  std::vector<int> frames;
  for (const int frame : line.frames) {
    if (poses[static_cast<std::size_t>(frame)]) frames.push_back(frame);
  }
  return frames;
}

std::vector<int> nearest_two(const CaptureLine& line, const FramePoses& poses, PlanPoint at) {
  std::vector<int> frames = posed_frames(line, poses);
  const Eigen::Vector2d place(at.x_m, at.z_m);
  const std::size_t count = std::min<std::size_t>(2, frames.size());
  std::partial_sort(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count),
                    frames.end(), [&](int a, int b) {
                      return (plan_position(poses, a) - place).norm() <
                             (plan_position(poses, b) - place).norm();
                    });
  frames.resize(count);
  return frames;
}

// Neighbours on each line (next and next but one) and at crossings the two nearest frames of either
// line. Only frames with a pose.
std::vector<FrameLink> links_of(const CaptureSet& set, const FramePoses& poses) {
  std::vector<FrameLink> links;
  for (const CaptureLine& line : set.lines) {
    const std::vector<int> frames = posed_frames(line, poses);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      for (std::size_t j = i + 1; j < std::min(i + 3, frames.size()); ++j) {
        links.push_back({frames[i], frames[j]});
      }
    }
  }
  for (const LineCrossing& crossing : crossings_of(set)) {
    const auto near = [&](int line) {
      return nearest_two(set.lines[static_cast<std::size_t>(line)], poses, crossing.at);
    };
    const std::vector<int> along_z = near(crossing.along_z);
    for (const int from : near(crossing.along_x)) {
      for (const int to : along_z) links.push_back({from, to});
    }
  }
  return links;
}

constexpr std::size_t kNeighbours = 4;

void extend(Eigen::VectorXd* values, Eigen::Index size) {
  const Eigen::Index before = values->size();
  values->conservativeResize(size);
  values->tail(size - before).setZero();
}

// What is left of the stations' measured light after their correction, mean.
double corrected_level(const ExposureResult& stations, const ExposureDecision& of_stations,
                       const ExposureDecision& of_all) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < stations.measured.size(); ++i) {
    if (!stations.measured[i]) continue;
    const auto at = static_cast<Eigen::Index>(i);
    sum += of_all.measured[at] - of_stations.correction[at];
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

// Every held-out frame with a pose, with the four stations nearest to it.
std::vector<FrameLink> held_out_links(const CaptureSet& set, const FramePoses& poses) {
  std::vector<int> posed;
  for (std::size_t i = 0; i < set.stations(); ++i) {
    if (poses[i]) posed.push_back(static_cast<int>(i));
  }
  std::vector<FrameLink> links;
  for (std::size_t held_out = set.stations(); held_out < set.frames.size(); ++held_out) {
    if (!poses[held_out]) continue;
    const auto away_m = [&](int station) {
      return (poses[static_cast<std::size_t>(station)]->position_m - poses[held_out]->position_m)
          .norm();
    };
    const std::size_t count = std::min(kNeighbours, posed.size());
    std::partial_sort(posed.begin(), posed.begin() + static_cast<std::ptrdiff_t>(count),
                      posed.end(), [&](int a, int b) { return away_m(a) < away_m(b); });
    for (std::size_t i = 0; i < count; ++i) {
      links.push_back({posed[i], static_cast<int>(held_out)});
    }
  }
  return links;
}

// Adds to `stations`, the result of the stations alone, the held-out frames that follow them, up to
// `frames` in all. A held-out frame is corrected if it differs significantly from the mean of the
// corrected stations; nothing of the stations changes. `links` are those of the stations and
// held_out_links; `lines` and `centre_m` as for measure_exposures.
void add_held_out_light(std::span<const LinkPatches> links, int frames,
                        std::span<const PictureLine> lines, const Eigen::Vector3d& centre_m,
                        ExposureResult* stations) {
  const std::size_t first = stations->gains.size();
  // A held-out frame is like a line of its own: nothing is assumed about its exposure.
  std::vector<PictureLine> with_held_out(lines.begin(), lines.end());
  for (int i = static_cast<int>(first); i < frames; ++i) {
    with_held_out.push_back({.pictures = {i}, .along_m = {0.0}});
  }
  const ExposureResult all = measure_exposures(links, frames, with_held_out, centre_m);
  for (std::size_t kind = 0; kind < stations->light.size(); ++kind) {
    ExposureDecision& decision = stations->light[kind].decision;
    const ExposureDecision& of_all = all.light[kind].decision;
    const double level = corrected_level(*stations, decision, of_all);
    for (Eigen::VectorXd* values :
         {&decision.measured, &decision.fitted, &decision.error, &decision.correction}) {
      extend(values, frames);
    }
    for (Eigen::Index i = static_cast<Eigen::Index>(first); i < frames; ++i) {
      if (!all.measured[static_cast<std::size_t>(i)]) continue;
      const double value = of_all.measured[i] - level;
      decision.measured[i] = decision.fitted[i] = value;
      decision.error[i] = of_all.error[i];
      const double limit = of_all.t_limit_single * of_all.error[i];
      if (limit > 0.0 && std::abs(value) > limit) decision.correction[i] = value;
    }
  }
  for (std::size_t i = first; i < static_cast<std::size_t>(frames); ++i) {
    const auto correction = [&](std::size_t kind) {
      return stations->light[kind].decision.correction[static_cast<Eigen::Index>(i)];
    };
    stations->gains.push_back(gain_of(correction(0), correction(1), correction(2)));
    stations->measured.push_back(all.measured[i]);
  }
}

// By frame; those that are not of `frames` stay empty.
std::vector<ComparedPanorama> compared_panoramas(const CaptureSet& panoramas,
                                                 const FramePoses& poses, const cv::Mat& mask,
                                                 const std::vector<int>& frames) {
  std::vector<ComparedPanorama> pictures(poses.size());
  Progress progress("Reading panoramas", static_cast<std::int64_t>(frames.size()), "frames");
  parallel_for(0, static_cast<int>(frames.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto frame = static_cast<std::size_t>(frames[static_cast<std::size_t>(i)]);
      const CaptureFrame& of = panoramas.frames[frame];
      pictures[frame] = ComparedPanorama(read_panorama(of.file),
                                         joint_mask(panoramas, static_cast<int>(frame), mask),
                                         of.mask.has_value(), *poses[frame]);
      progress.advance();
    }
  });
  return pictures;
}

// The patches of pairs of frames; reads the panoramas of their frames.
std::vector<LinkPatches> matched_links(const CaptureSet& panoramas, const FramePoses& poses,
                                       const cv::Mat& mask, const std::vector<FrameLink>& pairs) {
  std::vector<LinkPatches> links;
  std::vector<int> frames;
  for (const FrameLink& pair : pairs) {
    links.push_back({.link = pair, .patches = {}});
    frames.insert(frames.end(), {pair.from, pair.to});
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  const std::vector<ComparedPanorama> pictures = compared_panoramas(panoramas, poses, mask, frames);
  Progress progress("Comparing exposures", static_cast<std::int64_t>(links.size()), "pairs");
  parallel_for(0, static_cast<int>(links.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      auto& [link, patches] = links[static_cast<std::size_t>(i)];
      patches = match_patches(pictures[static_cast<std::size_t>(link.from)],
                              pictures[static_cast<std::size_t>(link.to)]);
      progress.advance();
    }
  });
  return links;
}

std::vector<PictureLine> posed_lines(const CaptureSet& set, const FramePoses& poses) {
  std::vector<PictureLine> lines;
  for (const CaptureLine& line : set.lines) {
    PictureLine posed;
    for (const int frame : line.frames) {
      if (!poses[static_cast<std::size_t>(frame)]) continue;
      posed.pictures.push_back(frame);
      posed.along_m.push_back(set.rail_m(frame));
    }
    lines.push_back(std::move(posed));
  }
  return lines;
}

Eigen::Vector3d middle_m(const FramePoses& poses) {
  Eigen::Vector3d sum(0.0, 0.0, 0.0);
  const std::vector<int> frames = posed_frames(poses);
  for (const int frame : frames) sum += poses[static_cast<std::size_t>(frame)]->position_m;
  return sum / static_cast<double>(std::max<std::size_t>(1, frames.size()));
}

}  // namespace

std::vector<int> posed_frames(const FramePoses& poses) {
  std::vector<int> frames;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) frames.push_back(static_cast<int>(i));
  }
  return frames;
}

ExposureResult compare_light(const CaptureSet& panoramas, const FramePoses& poses,
                             const cv::Mat& mask) {
  std::vector<FrameLink> pairs = links_of(panoramas, poses);
  const std::size_t of_stations = pairs.size();
  for (const FrameLink link : held_out_links(panoramas, poses)) pairs.push_back(link);
  const std::vector<LinkPatches> links = matched_links(panoramas, poses, mask, pairs);
  const auto count = static_cast<int>(panoramas.frames.size());
  const auto stations = static_cast<int>(panoramas.stations());
  const std::vector<PictureLine> lines = posed_lines(panoramas, poses);
  const Eigen::Vector3d centre_m =
      middle_m({poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(stations)});
  ExposureResult result =
      measure_exposures(std::span(links).first(of_stations), stations, lines, centre_m);
  if (count > stations) add_held_out_light(links, count, lines, centre_m, &result);
  return result;
}

}  // namespace raywalk::calibrate
