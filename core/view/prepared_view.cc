#include "core/view/prepared_view.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/geometry/panorama_pixels.h"
#include "core/view/gpu/gpu_device.h"
#include "core/view/gpu/gpu_renderer.h"
#include "core/view/read_ahead.h"
#include "core/view/station_mixing.h"

namespace raywalk {
namespace {

constexpr int kFillStations = 32;  // searched for what the lines in use do not see
constexpr int kFartherMaps = 32;   // and as many for what masks hide

// Asks for huge pages, which take fewer page faults and TLB misses. Advice only.
void advise_huge_pages(const cv::Mat& image) {
  constexpr std::size_t kHugePage = std::size_t{2} << 20;
  std::size_t left = image.step * static_cast<std::size_t>(image.rows);
  void* first = image.data;
  if (std::align(kHugePage, kHugePage, first, left) == nullptr) return;
  ::madvise(first, left / kHugePage * kHugePage, MADV_HUGEPAGE);
}

// Marks unread rows in an image whose first pixel is that of the part.
void mark_unread(std::span<const UnreadRows> unread, const PanoramaPart& part, int width,
                 const cv::Mat1b& image) {
  for (const UnreadRows& rows : unread) {
    const int column = wrapped_column(rows.column - part.first_column, width);
    image.col(column).rowRange(rows.rows.begin - part.rows.begin, rows.rows.end - part.rows.begin) =
        255;
  }
}

// Eyes' columns mixed by the processor, on several threads.
class ProcessorMixing {
 public:
  // Writes into `image` and `unread`, in which each eye has the part's rows.
  ProcessorMixing(std::span<const MixedView> eyes, const PanoramaPart& part, cv::Mat image,
                  cv::Mat1b* unread)
      : eyes_(eyes), part_(part), image_(std::move(image)), unread_(unread), idle_(eyes.size()) {}

  // At most StationMixing::kColumns columns of the part from `first` on.
  void render(std::size_t eye, int first, int columns, RowRun rows) {
    std::unique_ptr<StationMixing> mixing = take(eye);
    const int top = static_cast<int>(eye) * (part_.rows.end - part_.rows.begin);
    const cv::Rect block(first, top + rows.begin - part_.rows.begin, columns,
                         rows.end - rows.begin);
    mixing->render(part_.first_column + first, columns, rows, image_(block));
    const std::scoped_lock lock(mutex_);
    counts_ += mixing->take_counts();
    const std::vector<UnreadRows> unread_rows = mixing->take_unread();
    idle_[eye].push_back(std::move(mixing));
    if (unread_rows.empty()) return;
    if (unread_->empty()) *unread_ = cv::Mat1b::zeros(image_.size());
    mark_unread(unread_rows, part_, eyes_[eye].output.width,
                unread_->rowRange(top, top + part_.rows.end - part_.rows.begin));
  }

  const PixelCounts& counts() const { return counts_; }

 private:
  std::unique_ptr<StationMixing> take(std::size_t eye) {
    const std::scoped_lock lock(mutex_);
    if (idle_[eye].empty()) return std::make_unique<StationMixing>(eyes_[eye]);
    std::unique_ptr<StationMixing> mixing = std::move(idle_[eye].back());
    idle_[eye].pop_back();
    return mixing;
  }

  std::span<const MixedView> eyes_;
  const PanoramaPart& part_;
  cv::Mat image_;
  cv::Mat1b* unread_;
  std::mutex mutex_;                                               // of what follows, and unread_
  std::vector<std::vector<std::unique_ptr<StationMixing>>> idle_;  // of each eye
  PixelCounts counts_;
};

// Calls `render`, for a card, if there is one that has not failed; whether it could.
template <typename Render>
bool rendered_by(GpuRenderer* gpu, const Render& render) {
  if (gpu == nullptr || gpu->gave_up()) return false;
  try {
    render();
    return true;
  } catch (const GpuError& error) {
    warn_of_gpu(error.what());
    gpu->give_up();
    return false;
  }
}

}  // namespace

void PreparedView::plan_eye(const Viewpoint& viewpoint, double eye_radius_m) {
  const ConnectionRule rule{radians_from_degrees(options_.k_deg),
                            radians_from_degrees(options_.overlap_deg)};
  plan_ = std::make_unique<ViewPlan>(room_.grid(), viewpoint, rule, eye_radius_m);
}

std::vector<MapStation> PreparedView::choose_maps() {
  const PlanPoint viewpoint = plan_->viewpoint();
  const Eigen::Vector3d& viewpoint_m = plan_->eye().centre_m;
  const MapSpread spread = map_spread(room_.grid(), viewpoint);
  const auto lines = plan_->lines();
  std::vector<MapStation> maps = nearest_maps(room_, lines, viewpoint_m, spread.gap_m,
                                              spread.most_per_line, options_.distance_maps);
  if (maps.empty()) {
    throw Error(
        fmt::format("{}: no line around viewpoint {},{} m has distances; estimate them with "
                    "raywalk-build-lf depth, or give more to raywalk-build-lf pack --distance DIR",
                    room_.directory().string(), viewpoint.x_m, viewpoint.z_m));
  }
  std::vector<MapStation> fill =
      nearest_maps(room_, lines, viewpoint_m, spread.gap_m, kFillStations, kFillStations);
  if (room_.masked()) {
    const auto farther = farther_maps(room_, fill, viewpoint_m, kFartherMaps);
    fill.insert(fill.end(), farther.begin(), farther.end());
  }
  fill_ = FillStations(room_, std::move(fill));
  return maps;
}

void PreparedView::prepare(const Viewpoint& viewpoint) {
  plan_eye(viewpoint, 0.0);
  if (options_.method == ViewMethod::kInitial) return;
  distances_.begin(choose_maps(), plan_->eye());
  gathered_ = false;
}

void PreparedView::prepare_stereo(const Viewpoint& viewpoint, double eyes_apart_m,
                                  PreparedView* left, PreparedView* right) {
  left->plan_eye(viewpoint, 0.5 * eyes_apart_m);
  right->plan_eye(viewpoint, -0.5 * eyes_apart_m);
  if (left->options_.method == ViewMethod::kInitial) return;
  const auto maps = left->choose_maps();
  right->fill_ = left->fill_;
  DistanceView::begin_stereo(maps, left->plan_->eye(), &left->distances_, &right->distances_);
  left->gathered_ = right->gathered_ = false;
}

void PreparedView::look_at(const PanoramaPart& part, Visibility::Sources sources) {
  const bool fills_empty = !sources;
  sources_ = sources ? std::move(sources) : [this](double theta_rad) {
    return column_sources(plan_->column(theta_rad), options_);
  };
  if (options_.method == ViewMethod::kInitial) return;
  constexpr int kMargin = 2;  // columns around are looked at too
  const int width = distances_.size().width;
  const double per_output = static_cast<double>(width) / output_.width;
  const int first = static_cast<int>(std::floor(part.first_column * per_output)) - kMargin;
  const int end =
      static_cast<int>(std::ceil((part.first_column + part.columns) * per_output)) + kMargin;
  const int count = std::min(end - first, width);
  visibility_.plan(distances_, {wrapped_column(first, width), count, fills_empty}, sources_,
                   plan_->lines(), plan_->above_lines_m(), station_mix(options_), fill_);
}

void PreparedView::gather() {
  if (options_.method == ViewMethod::kInitial || gathered_) return;
  distances_.gather();
  gathered_ = true;
}

void PreparedView::see() {
  if (options_.method == ViewMethod::kInitial) return;
  visibility_.see();
  edges_.compute(distances_, visibility_.columns().first, visibility_.columns().count);
}

MixedView PreparedView::mixed_view() {
  return {.room = room_,
          .options = options_,
          .distances = distances_,
          .visibility = visibility_,
          .edges = edges_,
          .fill = fill_,
          .exposure = exposure_,
          .sources = sources_,
          .output = output_,
          .rows = RowMap(output_.height, distances_.size().height),
          .latitudes = Latitudes(output_.height)};
}

bool PreparedView::render(std::span<PreparedView* const> eyes, const PanoramaPart& part,
                          GpuRenderer* gpu, const FlatPicture* flat, cv::Mat* image,
                          cv::Mat1b* unread, PixelCounts* counts) {
  const int rows = part.rows.end - part.rows.begin;
  image->create(static_cast<int>(eyes.size()) * rows, part.columns, CV_8UC3);
  advise_huge_pages(*image);
  unread->release();
  std::vector<MixedView> mixed;
  for (PreparedView* eye : eyes) mixed.push_back(eye->mixed_view());
  bool flat_made = false;
  const auto render = [&] { flat_made = gpu->render(mixed, part, flat, *image, unread, counts); };
  if (!rendered_by(gpu, render)) {
    unread->release();
    for (PreparedView* eye : eyes) eye->gather();
    for (PreparedView* eye : eyes) eye->see();
    for (const MixedView& view : mixed) read_ahead(view, part);
    ProcessorMixing mixing(mixed, part, *image, unread);
    parallel_for(0, part.columns, StationMixing::kColumns, [&](int begin, int end) {
      for (std::size_t eye = 0; eye < mixed.size(); ++eye) {
        mixing.render(eye, begin, end - begin, part.rows);
      }
    });
    *counts += mixing.counts();
  }
  if (!unread->empty()) counts->unseen = cv::countNonZero(*unread);
  return flat_made;
}

}  // namespace raywalk
