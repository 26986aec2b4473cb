#include "render/web/truth_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/pick_evenly.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/panorama/panorama_rotation.h"
#include "core/view/renderer.h"
#include "render/web/web_jpeg.h"

namespace raywalk::render {
namespace {

constexpr int kMostTruths = 12;
constexpr int kMostTruthWidth = 4096;  // a texture that every browser can show

bool is_in_cell(const Grid& grid, const Eigen::Vector3d& position_m) {
  return grid.cells.empty() || find_cell(grid, {position_m.x(), position_m.z()}).has_value();
}

cv::Mat truth_picture(const Frame& frame, int width) {
  cv::Mat picture = read_panorama(frame.path);
  if (frame.attitude) picture = rotate_panorama(picture, world_from_camera(*frame.attitude));
  if (picture.cols <= width) return picture;
  cv::Mat scaled;
  cv::resize(picture, scaled, {width, width / 2}, 0.0, 0.0, cv::INTER_AREA);
  return scaled;
}

}  // namespace

std::vector<TruthPair> write_truth_pairs(const Room& room, ViewOptions options,
                                         const std::filesystem::path& list,
                                         const std::filesystem::path& folder) {
  std::vector<Frame> frames = read_frame_list(list, {"distance"});
  std::erase_if(frames,
                [&](const Frame& frame) { return !is_in_cell(room.grid(), frame.position_m); });
  if (frames.empty()) {
    throw Error(list.string() + ": none of the panoramas lies in a cell of the room");
  }
  make_directories(folder / "truth");
  options.width = std::min(size_as_captured(room).width, kMostTruthWidth);
  Renderer renderer(room, options);
  const std::vector<int> picked = pick_evenly(static_cast<int>(frames.size()), kMostTruths);
  Progress progress("comparing", std::ssize(picked), "truths");
  std::vector<TruthPair> pairs;
  for (const int i : picked) {
    const Frame& frame = frames[static_cast<std::size_t>(i)];
    const TruthPair pair{.position_m = frame.position_m,
                         .picture = fmt::format("truth/{:03}.jpg", pairs.size()),
                         .engine = fmt::format("truth/{:03}-engine.jpg", pairs.size())};
    write_jpeg(folder / pair.picture, truth_picture(frame, options.width));
    const PlanPoint place{frame.position_m.x(), frame.position_m.z()};
    const Viewpoint viewpoint = viewpoint_for(options.method, place, frame.position_m.y());
    write_jpeg(folder / pair.engine, renderer.render(viewpoint).image);
    pairs.push_back(pair);
    progress.advance();
  }
  return pairs;
}

}  // namespace raywalk::render
