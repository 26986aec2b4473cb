#include "build_lf/require/held_out.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/interrupt.h"
#include "core/base/pick_evenly.h"
#include "core/base/progress.h"
#include "core/evaluate/metrics.h"
#include "core/files/output_folder.h"
#include "core/geometry/panorama_pixels.h"
#include "core/room/kept_stations.h"

namespace raywalk::build_lf {
namespace {

constexpr int kViewsPerStride = 12;
constexpr int kViewsOfThinned = 48;

// 2, 3, 4, 6, 8, 12, 16, ...
std::vector<int> strides_up_to(int longest) {
  std::vector<int> strides;
  for (int power = 2; power <= longest; power *= 2) {
    strides.push_back(power);
    if (power + power / 2 <= longest) strides.push_back(power + power / 2);
  }
  return strides;
}

// The stations that --thin keeps for a spacing, and a sample of the others.
struct Thinned {
  int stride = 0;
  double step_m = 0.0;  // between the stations kept, at most
  KeptStations kept{};
  std::vector<StationIndex> middles{};
};

Thinned thinned(const Room& room, int stride, double captured_step_m) {
  constexpr double kUneven = 0.25;  // stations are not captured at exactly equal steps
  constexpr double kWide = 0.75;
  Thinned thinned{.stride = stride,
                  .kept = needed_stations(room, (stride + kUneven) * captured_step_m,
                                          Preferred::kWithDistances)};
  const auto along_m = [&](std::size_t line, int station) {
    return room.grid().lines[line].stations[static_cast<std::size_t>(station)].along_m;
  };
  for (std::size_t line = 0; line < thinned.kept.size(); ++line) {
    const std::vector<int>& kept = thinned.kept[line];
    for (std::size_t i = 1; i < kept.size(); ++i) {
      thinned.step_m =
          std::max(thinned.step_m, along_m(line, kept[i]) - along_m(line, kept[i - 1]));
    }
  }
  KeptStations middles(thinned.kept.size());
  for (std::size_t line = 0; line < thinned.kept.size(); ++line) {
    const std::vector<int>& kept = thinned.kept[line];
    for (std::size_t i = 1; i < kept.size(); ++i) {
      const double step_m = along_m(line, kept[i]) - along_m(line, kept[i - 1]);
      // What is left before a corner or the end of a line may be narrower, and easier.
      if (kept[i] - kept[i - 1] < 2 || step_m < kWide * thinned.step_m) continue;
      middles[line].push_back((kept[i - 1] + kept[i]) / 2);
    }
  }
  const std::vector<StationIndex> all = stations_with_views(room.grid(), middles);
  for (const int i : pick_evenly(static_cast<int>(all.size()), kViewsPerStride)) {
    thinned.middles.push_back(all[static_cast<std::size_t>(i)]);
  }
  return thinned;
}

// Mean squared difference between a panorama and itself displaced by the angle of `tolerance_px`
// rows, along rows and along columns; towards a pole that angle spans more columns.
double displacement_error(const TrueView& captured, double tolerance_px) {
  const PanoramaSize size{captured.image.cols, captured.image.rows};
  cv::Mat along_row(captured.image.size(), CV_32FC2), along_column = along_row.clone();
  for (int v = 0; v < size.height; ++v) {
    const double phi_rad = angles_from_pixel({0.0, static_cast<double>(v)}, size).phi_rad;
    const double columns = tolerance_px / std::max(std::cos(phi_rad), tolerance_px / size.width);
    const double row = std::min(v + tolerance_px, size.height - 1.0);
    for (int u = 0; u < size.width; ++u) {
      along_row.at<cv::Vec2f>(v, u) = cv::Vec2d(u + columns, v);
      along_column.at<cv::Vec2f>(v, u) = cv::Vec2d(u, row);
    }
  }
  double error = 0.0;
  for (const cv::Mat& places : {along_row, along_column}) {
    cv::Mat displaced;
    cv::remap(captured.image, displaced, places, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_WRAP);
    error += 0.5 * mean_squared_error(captured.image, displaced, captured.mask);
  }
  return error;
}

double tolerance_db(const TrueView& captured, double tolerance_px) {
  const bool masked = !captured.mask.empty() && cv::countNonZero(captured.mask) == 0;
  if (masked) return kMaxPsnrDb;
  return std::min(psnr_db(displacement_error(captured, tolerance_px)), kMaxPsnrDb);
}

// An initial view on a single line shows nothing on one side of a station that is off the line.
PlanPoint on_line(const Line& line, PlanPoint place) {
  const double along_m = along_line(line, place);
  return {line.origin.x_m + along_m * line.direction.x_m,
          line.origin.z_m + along_m * line.direction.z_m};
}

HeldOutFacts facts_of(const Room& room, const Thinned& thinned, double tolerance_px,
                      Progress* progress) {
  HeldOutFacts facts{.stride = thinned.stride,
                     .step_m = thinned.step_m,
                     .views = static_cast<int>(thinned.middles.size())};
  const Room part = room.subset(thinned.kept);
  Renderer initial(part, {.method = ViewMethod::kInitial, .gains = false});
  std::unique_ptr<Renderer> corrected;
  if (part.has_distances()) {
    corrected = std::make_unique<Renderer>(part, ViewOptions{.gains = false});
  }
  const double share = 1.0 / facts.views;
  for (const StationIndex middle : thinned.middles) {
    throw_if_interrupted();
    const TrueView captured = true_view_of(room, middle);
    const Line& line = room.grid().lines[static_cast<std::size_t>(middle.line)];
    const PlanPoint place =
        room.grid().cells.empty() ? on_line(line, captured.viewpoint) : captured.viewpoint;
    const double without_db = psnr_of_view(initial.render(place).image, captured);
    double with_db = without_db;
    if (corrected) {
      const RenderedView view = corrected->render({captured.viewpoint, captured.height_m});
      with_db = psnr_of_view(view.image, captured);
      facts.hidden_share += share * (view.report.filled_share + view.report.unseen_share);
    }
    facts.psnr_with_distances_db += share * with_db;
    facts.psnr_without_depth_db += share * without_db;
    facts.psnr_of_tolerance_db += share * tolerance_db(captured, tolerance_px);
    progress->advance();
  }
  return facts;
}

}  // namespace

double psnr_of_view(const cv::Mat& view, const TrueView& captured) {
  cv::Mat image = captured.image, mask = captured.mask;
  if (image.size() != view.size()) {
    cv::resize(captured.image, image, view.size(), 0.0, 0.0, cv::INTER_AREA);
    if (!mask.empty()) cv::resize(captured.mask, mask, view.size(), 0.0, 0.0, cv::INTER_NEAREST);
  }
  if (!mask.empty() && cv::countNonZero(mask) == 0) return kMaxPsnrDb;
  return std::min(psnr_db(view, image, mask), kMaxPsnrDb);
}

std::vector<HeldOutFacts> measure_strides(const Room& room, double captured_step_m,
                                          double tolerance_px) {
  std::size_t longest = 1;
  for (const Line& line : room.grid().lines) longest = std::max(longest, line.stations.size());
  std::vector<Thinned> strides;
  std::int64_t stations = 0;
  for (const int stride : strides_up_to(static_cast<int>(longest) - 1)) {
    Thinned of_stride = thinned(room, stride, captured_step_m);
    const bool same = !strides.empty() && of_stride.kept == strides.back().kept;
    if (same || of_stride.middles.empty()) continue;
    stations += std::ssize(of_stride.middles);
    strides.push_back(std::move(of_stride));
  }
  Progress progress("re-creating", stations, "stations");
  std::vector<HeldOutFacts> facts;
  facts.reserve(strides.size());
  for (const Thinned& of_stride : strides) {
    facts.push_back(facts_of(room, of_stride, tolerance_px, &progress));
  }
  return facts;
}

double measured_up_to_m(std::span<const HeldOutFacts> strides) {
  double step_m = 0.0;
  for (const HeldOutFacts& facts : strides) {
    if (facts.psnr_with_distances_db < facts.psnr_of_tolerance_db) break;
    step_m = facts.step_m;
  }
  return step_m;
}

ThinnedFacts thinned_facts(const Room& room, const KeptStations& kept,
                           const std::filesystem::path& out) {
  const Room thinned = Room::open(out);
  ThinnedFacts facts{.room = out.string(), .bytes = bytes_in(out)};
  for (size_t line = 0; line < kept.size(); ++line) {
    facts.stations += static_cast<int>(kept[line].size());
    facts.distance_maps += thinned.distances(static_cast<int>(line)).maps();
  }
  const std::vector<StationIndex> dropped =
      stations_with_views(room.grid(), stations_except(room.grid(), kept));
  const std::vector<int> views = pick_evenly(static_cast<int>(dropped.size()), kViewsOfThinned);
  facts.views = static_cast<int>(views.size());
  facts.psnr_db = facts.worst_psnr_db = kMaxPsnrDb;
  if (views.empty()) return facts;
  facts.psnr_db = 0.0;
  Progress progress("re-creating", std::ssize(views), "stations");
  Renderer renderer(thinned, {.gains = false});
  for (const int i : views) {
    const TrueView captured = true_view_of(room, dropped[static_cast<size_t>(i)]);
    const cv::Mat view = renderer.render({captured.viewpoint, captured.height_m}).image;
    const double db = psnr_of_view(view, captured);
    facts.psnr_db += db / static_cast<double>(views.size());
    facts.worst_psnr_db = std::min(facts.worst_psnr_db, db);
    progress.advance();
  }
  return facts;
}

}  // namespace raywalk::build_lf
