#include "core/judge/trade/trade_result.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/judge/trade/pareto_front.h"
#include "core/judge/trade/rank_correlation.h"

namespace raywalk {
namespace {

void find_front(std::vector<MeasuredSetting>* settings, bool TradeFronts::*front,
                const std::function<double(const TradeMeasurement&)>& gain) {
  const bool all_disturbed = disturbed_count(*settings) == settings->size();
  std::vector<TradePoint> points;
  points.reserve(settings->size());
  for (const MeasuredSetting& setting : *settings) {
    const bool counts = all_disturbed || !setting.measured.disturbed;
    points.push_back({counts ? setting.measured.time.ratio : std::nan(""), gain(setting.measured)});
  }
  const std::vector<bool> on_front = pareto_front(points);
  for (std::size_t i = 0; i < settings->size(); ++i) (*settings)[i].pareto.*front = on_front[i];
}

// The rank correlation of one score.
double agreement_of(const std::vector<MeasuredSetting>& settings, double ViewScores::*score) {
  std::vector<double> truth, held_out;
  for (const MeasuredSetting& setting : settings) {
    truth.push_back(setting.measured.scores.*score);
    held_out.push_back(setting.measured.held_out.value().*score);
  }
  return rank_correlation(truth, held_out);
}

}  // namespace

std::string marked_name(const MeasuredSetting& setting) {
  return setting.setting.name + (setting.measured.disturbed ? " (time disturbed)" : "");
}

std::size_t disturbed_count(const std::vector<MeasuredSetting>& settings) {
  return static_cast<std::size_t>(std::ranges::count_if(
      settings, [](const MeasuredSetting& setting) { return setting.measured.disturbed; }));
}

RankAgreement rank_agreement(const std::vector<MeasuredSetting>& settings) {
  return {.psnr_db = agreement_of(settings, &ViewScores::psnr_db),
          .ws_psnr_db = agreement_of(settings, &ViewScores::ws_psnr_db),
          .ssim = agreement_of(settings, &ViewScores::ssim),
          .fsim = agreement_of(settings, &ViewScores::fsim)};
}

void find_fronts(std::vector<MeasuredSetting>* settings) {
  const auto score = [&](bool TradeFronts::*front, double ViewScores::*member) {
    find_front(settings, front,
               [member](const TradeMeasurement& measured) { return measured.scores.*member; });
  };
  score(&TradeFronts::psnr_db, &ViewScores::psnr_db);
  score(&TradeFronts::ws_psnr_db, &ViewScores::ws_psnr_db);
  score(&TradeFronts::ssim, &ViewScores::ssim);
  score(&TradeFronts::fsim, &ViewScores::fsim);
  find_front(settings, &TradeFronts::e_connect,
             [](const TradeMeasurement& measured) { return -measured.e_connect; });
}

std::vector<std::size_t> psnr_front(const Trade& trade) {
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < trade.settings.size(); ++i) {
    if (trade.settings[i].pareto.psnr_db) front.push_back(i);
  }
  std::ranges::sort(front, {},
                    [&](std::size_t i) { return trade.settings[i].measured.time.ratio; });
  return front;
}

}  // namespace raywalk
