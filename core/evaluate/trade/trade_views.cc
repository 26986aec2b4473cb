#include "core/evaluate/trade/trade_views.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/image_file.h"

namespace raywalk {

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
                     .truth = read_panorama(truth.file),
                     .mask = truth.mask.empty()
                                 ? cv::Mat()
                                 : read_mask(truth.mask, {truth.width, truth.width / 2})});
  }
  return views;
}

}  // namespace raywalk
