#include "build_lf/depth/station_links.h"

#include <algorithm>
#include <list>
#include <utility>

#include "build_lf/depth/station_image.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace raywalk::build_lf {
namespace {

constexpr int kFlowMaskMarginPx = kFlowWindow / 2 + 1;

StationLink compare(const StationPair& pair, const ComparedPicture& from,
                    const ComparedPicture& to) {
  const ColourComparison compared = compare_colours(from, to);
  return {.pair = pair,
          .comparable = compared.comparable,
          .log_ratio = compared.log_ratio,
          .log_ratio_error = compared.log_ratio_error,
          .change = compared.change,
          .unexplained_change = compared.unexplained_change};
}

// A small cache of images, as consecutive pairs share stations.
class RecentImages {
 public:
  explicit RecentImages(const Room& room) : room_(room) {
    const int width = std::min(kLinkWidth, room.panorama().width);
    size_ = {width, width / 2};
  }
  ComparedPicture get(StationIndex station) {
    const auto found = std::find_if(images_.begin(), images_.end(),
                                    [&](const auto& held) { return held.first == station; });
    if (found != images_.end()) return found->second;
    constexpr size_t kCapacity = 4;
    if (images_.size() == kCapacity) images_.pop_front();
    images_.emplace_back(
        station, ComparedPicture{station_image(room_, station, size_),
                                 station_validity(room_, station, size_, kFlowMaskMarginPx)});
    return images_.back().second;
  }

 private:
  const Room& room_;
  PanoramaSize size_;
  std::list<std::pair<StationIndex, ComparedPicture>> images_;
};

}  // namespace

std::vector<StationLink> measure_links(const Room& room, std::span<const StationPair> pairs) {
  std::vector<StationLink> links(pairs.size());
  Progress progress("comparing neighbours", static_cast<std::int64_t>(pairs.size()), "pairs");
  constexpr int kPairsPerTask = 16;
  parallel_for(0, static_cast<int>(pairs.size()), kPairsPerTask, [&](int begin, int end) {
    RecentImages images(room);
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      links[i] = compare(pairs[i], images.get(pairs[i].from), images.get(pairs[i].to));
      progress.advance();
    }
  });
  return links;
}

}  // namespace raywalk::build_lf
