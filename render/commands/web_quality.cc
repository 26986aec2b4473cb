#include "render/commands/web_quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/number_text.h"
#include "core/base/pick_evenly.h"
#include "core/base/progress.h"
#include "core/evaluate/held_out.h"
#include "core/evaluate/metrics.h"
#include "core/room/kept_stations.h"
#include "core/view/renderer.h"
#include "render/web/station_pictures.h"

namespace raywalk::render {
namespace {

constexpr int kMostViews = 24;

PlanPoint viewpoint_of(const Grid& grid, StationIndex station) {
  const Eigen::Vector3d& at_m = grid.station(station).position_m;
  return {at_m.x(), at_m.z()};
}

double psnr_at(const Room& room, StationIndex station, Renderer* renderer, int width) {
  const cv::Mat captured = captured_picture_at(room, station.line, station.station, width);
  const cv::Mat hidden = hidden_in_views(room, station.line, station.station, width);
  const cv::Mat view = renderer->render(viewpoint_of(room.grid(), station)).image;
  const cv::Mat compared = hidden.empty() ? cv::Mat() : cv::Mat(~hidden);
  if (!compared.empty() && cv::countNonZero(compared) == 0) return kMaxPsnrDb;
  return std::min(psnr_db(view, captured, compared), kMaxPsnrDb);
}

}  // namespace

std::optional<WebQuality> measure_web_quality(const Room& room, const KeptStations& kept,
                                              const ViewOptions& options) {
  const std::vector<StationIndex> left_out =
      stations_with_views(room.grid(), stations_except(room.grid(), kept));
  if (left_out.empty()) return std::nullopt;
  const Room part = room.subset(kept);
  Renderer renderer(part, options);
  const std::vector<int> picked = pick_evenly(static_cast<int>(left_out.size()), kMostViews);
  WebQuality quality{.worst_psnr_db = kMaxPsnrDb, .views = static_cast<int>(picked.size())};
  Progress progress("re-creating", quality.views, "stations");
  for (const int i : picked) {
    const double db =
        psnr_at(room, left_out[static_cast<std::size_t>(i)], &renderer, options.width);
    quality.psnr_db += db / quality.views;
    quality.worst_psnr_db = std::min(quality.worst_psnr_db, db);
    progress.advance();
  }
  quality.text = fmt::format(
      "{} that {} left out, rendered from the others {} pixels wide, {} what was "
      "captured there at {:.1f} dB, at worst {:.1f} dB",
      counted(picked.size(), "station"), picked.size() == 1 ? "is" : "are", options.width,
      picked.size() == 1 ? "matches" : "match", quality.psnr_db, quality.worst_psnr_db);
  return quality;
}

}  // namespace raywalk::render
