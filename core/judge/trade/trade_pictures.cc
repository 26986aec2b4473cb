#include "core/judge/trade/trade_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "core/base/interrupt.h"
#include "core/judge/trade/measure_setting.h"
#include "core/judge/validation/comparison_pictures.h"

namespace raywalk {
namespace {

constexpr std::size_t kMaxPictures = 60;
constexpr int kPictureWidth_px = 560;  // sharp at half the page's width

// The PSNR that a setting lacks to the best setting that takes no longer; 0 on the front.
double below_front_db(const Trade& trade, const MeasuredSetting& setting) {
  double gap_db = 0.0;
  for (const MeasuredSetting& other : trade.settings) {
    if (other.measured.time.ratio > setting.measured.time.ratio) continue;
    gap_db = std::max(gap_db, other.measured.scores.psnr_db - setting.measured.scores.psnr_db);
  }
  return gap_db;
}

std::vector<std::size_t> settings_shown(const Trade& trade) {
  std::vector<double> gaps_db;
  gaps_db.reserve(trade.settings.size());
  for (const MeasuredSetting& setting : trade.settings) {
    gaps_db.push_back(below_front_db(trade, setting));
  }
  std::vector<std::size_t> order(trade.settings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return gaps_db[i]; });
  order.resize(std::min(order.size(), kMaxPictures));
  return order;
}

}  // namespace

std::vector<ReportImage> trade_images(const Trade& trade, std::span<const TradeRoom> rooms) {
  const std::size_t shown = pictured_view(trade.views.size());
  const cv::Mat truth = shrunk_to(rooms.front().views[shown].truth, kPictureWidth_px);
  const std::string truth_name = fmt::format("true view {}", trade.views[shown]);
  std::vector<ReportImage> images;
  for (const std::size_t i : settings_shown(trade)) {
    throw_if_interrupted();
    const TradeSetting& setting = trade.settings[i].setting;
    const TradeView& view = rooms[setting.room].views[shown];
    const cv::Mat picture = picture_of(setting, view);
    const cv::Mat error = error_of(picture, truth_completed_by(picture, view.truth, view.mask));
    const std::string row = fmt::format("setting {}: {}", i + 1, setting.name);
    images.push_back(report_image("settings", row, truth_name, truth));
    images.push_back(report_image("settings", row, fmt::format("error, times {:g}", kErrorGain),
                                  shrunk_to(error, kPictureWidth_px)));
  }
  return images;
}

}  // namespace raywalk
