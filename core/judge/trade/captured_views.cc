#include "core/judge/trade/captured_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/files/image_file.h"

namespace raywalk {
namespace {

constexpr double kSamePlace_m = 1e-3;

Eigen::Vector3d place_on(const Line& line, double along_m) {
  return {line.origin.x_m + along_m * line.direction.x_m, line.height_m,
          line.origin.z_m + along_m * line.direction.z_m};
}

double largest_shift_m(const Line& a, const Line& b) {
  return std::max((place_on(a, a.first_m()) - place_on(b, b.first_m())).norm(),
                  (place_on(a, a.last_m()) - place_on(b, b.last_m())).norm());
}

}  // namespace

std::string depth_name(const Room& room) {
  for (std::size_t i = 0; i < room.grid().lines.size(); ++i) {
    const DistanceVolume& distances = room.distances(static_cast<int>(i));
    if (distances.maps() == 0) continue;
    return fmt::format("{}, {} px", room.distances_origin(), distances.size().width);
  }
  return kNoDepth;
}

std::vector<TradeView> captured_views(const Room& room, const std::vector<TruthView>& truths,
                                      std::size_t most) {
  for (const TruthView& truth : truths) {
    if (truth.width == truths.front().width) continue;
    throw Error(fmt::format(
        "{} is {} pixels wide and {} is {}; give truths of one width, as the time of a view "
        "depends on it",
        truth.file.string(), truth.width, truths.front().file.string(), truths.front().width));
  }
  std::vector<TradeView> views;
  for (const std::size_t i : spread_over_distance(truths, most)) {
    const TruthView& truth = truths[i];
    views.push_back({.name = truth.name,
                     .room = &room,
                     .viewpoint = truth.viewpoint,
                     .height_m = truth.height_m,
                     .line_distance_m = truth.line_distance_m,
                     .truth = read_panorama(truth.file),
                     .mask = truth.mask.empty()
                                 ? cv::Mat()
                                 : read_mask(truth.mask, {truth.width, truth.width / 2})});
  }
  return views;
}

TradeRoom trade_room(const Room& room, std::span<const TradeView> views) {
  TradeRoom same{.room = &room, .depth = depth_name(room), .views = {views.begin(), views.end()}};
  for (TradeView& view : same.views) view.room = &room;
  return same;
}

void require_same_lines(const Room& room, const Room& other) {
  const std::vector<Line>& lines = room.grid().lines;
  const std::vector<Line>& others = other.grid().lines;
  const auto refuse = [&](const std::string& how) {
    throw Error(fmt::format("{}: {} {}; --also needs another room of the same place",
                            other.directory().string(), how, room.directory().string()));
  };
  if (lines.size() != others.size()) {
    refuse(fmt::format("has {} lines and not the {} of", others.size(), lines.size()));
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double shift_m = largest_shift_m(lines[i], others[i]);
    if (shift_m <= kSamePlace_m) continue;
    refuse(fmt::format("line {} lies {:.3g} m away from that of", others[i].id, shift_m));
  }
}

}  // namespace raywalk
