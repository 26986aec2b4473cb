#include "core/view/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/huge_pages.h"
#include "core/base/parallel.h"
#include "core/room/kept_stations.h"
#include "core/view/column_arrays.h"
#include "core/view/column_worker.h"
#include "core/view/depth_layers.h"
#include "core/view/sample_reader.h"

namespace raywalk {
namespace {

constexpr int kMaxFartherMaps = 32;  // more maps for points that masks hide
constexpr size_t kReadable = 2;      // bytes before the first sample of a part and after the last

// The largest distance from an eye to the point that its column is acquired at.
double farthest_acquisition_m(const ViewPlan& plan) {
  double largest = 0.0;
  for (int degree = 0; degree < 360; ++degree) {
    const ColumnPlan column = plan.column(radians_from_degrees(degree + 0.5));
    for (int i = 0; i < column.front_count; ++i) {
      largest = std::max(largest, column.front[static_cast<size_t>(i)].d_p_m);
    }
  }
  return std::hypot(largest, plan.above_lines_m());
}

std::optional<Room> part_of(const Room& room, int stride) {
  if (stride <= 1) return std::nullopt;  // values below 1 are rejected with the other options
  return room.subset(every_nth_station(room, stride));
}

}  // namespace

PanoramaSize size_as_captured(const Room& room) {
  constexpr int kWidthStep = 4;
  const int width = room.panorama().width / kWidthStep * kWidthStep;
  return {width, width / 2};
}

void require_viewpoint(const Viewpoint& viewpoint, Generation generation) {
  const double height_m = viewpoint.height_m.value_or(0.0);
  if (!std::isfinite(viewpoint.plan.x_m) || !std::isfinite(viewpoint.plan.z_m) ||
      !std::isfinite(height_m)) {
    throw UsageError("the viewpoint must be finite numbers in metres");
  }
  if (viewpoint.height_m && generation == Generation::kInitial) {
    throw UsageError(
        "initial views do not know distances and cannot be moved up or down; leave the height out, "
        "or use --generation hlf-vd or two-sided");
  }
}

Viewpoint viewpoint_for(Generation generation, PlanPoint plan, std::optional<double> height_m) {
  return generation == Generation::kInitial ? Viewpoint(plan) : Viewpoint(plan, height_m);
}

Renderer::Renderer(const Room& room, const ViewOptions& options)
    : part_of_room_(part_of(room, options.station_stride)),
      room_(part_of_room_ ? *part_of_room_ : room),
      options_(options),
      view_(room_) {
  if (options_.width == 0) options_.width = size_as_captured(room).width;
  require_view_options(options_);
  if (options.generation != Generation::kInitial && !room_.has_distances()) {
    throw Error(fmt::format(
        "{}: the room has no distances, which {} needs; estimate them with raywalk-build-lf depth, "
        "give them to raywalk-build-lf pack --distance DIR, or use --generation initial",
        room.directory().string(), generation_name(options.generation)));
  }
  if (options_.gains && !room_.gains().empty()) gains_ = std::make_unique<RoomGains>(room_);
  // A panorama much smaller than the captured ones is rendered larger and averaged down, so that
  // fine texture does not alias.
  supersampling_ = std::max(
      1,
      static_cast<int>(std::lround(static_cast<double>(room.panorama().width) / options_.width)));
}

Renderer::~Renderer() = default;

PanoramaSize Renderer::render_size() const {
  const int width = options_.width * supersampling_;
  return {width, width / 2};
}

std::vector<RaySource> Renderer::sources(const ColumnPlan& column) const {
  std::vector<RaySource> sources(column.front.begin(), column.front.begin() + column.front_count);
  if (options_.generation == Generation::kTwoSided) {
    sources.insert(sources.end(), column.behind.begin(),
                   column.behind.begin() + column.behind_count);
  }
  return sources;
}

OmegaRange Renderer::range_of(std::span<const MapStation> maps) {
  OmegaRange range{std::numeric_limits<double>::infinity(), 0.0};
  for (const MapStation& map : maps) {
    auto known = map_ranges_.find({map.line, map.map});
    if (known == map_ranges_.end()) {
      known = map_ranges_.emplace(std::pair(map.line, map.map), omega_range(room_, map)).first;
    }
    range.min = std::min(range.min, known->second.min);
    range.max = std::max(range.max, known->second.max);
  }
  return range;
}

void Renderer::count_bytes(bool wanted) {
  touched_ = wanted ? std::make_unique<TouchedRays>(room_) : nullptr;
}

void Renderer::plan_eye(const Viewpoint& viewpoint, double eye_radius_m, PreparedView* eye) {
  require_viewpoint(viewpoint, options_.generation);
  const ConnectionRule rule{radians_from_degrees(options_.k_deg),
                            radians_from_degrees(options_.overlap_deg)};
  eye->plan_ = std::make_unique<ViewPlan>(room_.grid(), viewpoint, rule, eye_radius_m);
  eye->inputs_.reset(new ViewInputs{.room = room_,
                                    .plan = *eye->plan_,
                                    .output = render_size(),
                                    .rows = {0, render_size().height},
                                    .layers = std::nullopt,
                                    .arithmetic = options_.arithmetic,
                                    .fill_maps = {},
                                    .interpolation = options_.interpolation,
                                    .stations_mixed = options_.stations_mixed,
                                    .second_side = options_.second_side,
                                    .skip_px = options_.skip_px,
                                    .gains = gains_.get(),
                                    .touched = touched_.get()});
  eye->layers_ = 0;
}

void Renderer::choose_maps(PreparedView* eye) const {
  const PlanPoint viewpoint = eye->plan_->viewpoint();
  const Eigen::Vector3d& viewpoint_m = eye->plan_->eye().centre_m;
  const MapSpread spread = map_spread(room_.grid(), viewpoint);
  const auto lines = eye->plan_->lines();
  eye->maps_ = nearest_maps(room_, lines, viewpoint_m, spread.gap_m, spread.most_per_line,
                            options_.distance_maps);
  eye->fill_maps_ = nearest_maps(room_, lines, viewpoint_m, spread.gap_m, options_.fill_stations,
                                 options_.fill_stations);
  if (room_.masked() && options_.fill_stations > 0) {
    const auto farther = farther_maps(room_, eye->fill_maps_, viewpoint_m, kMaxFartherMaps);
    eye->fill_maps_.insert(eye->fill_maps_.end(), farther.begin(), farther.end());
  }
  if (eye->maps_.empty()) {
    throw Error(
        fmt::format("{}: no line around viewpoint {},{} m has distances; estimate them with "
                    "raywalk-build-lf depth, or give more to raywalk-build-lf pack --distance DIR",
                    room_.directory().string(), viewpoint.x_m, viewpoint.z_m));
  }
}

void Renderer::use_distances(PreparedView* eye) {
  // An explicit number of layers spans the distances around the view.
  const OmegaRange range =
      options_.scene && options_.layers == 0 ? *options_.scene : range_of(eye->maps_);
  const double tolerance_rad = options_.tolerance_px * kTwoPi / options_.width;
  eye->layers_ =
      options_.layers > 0
          ? options_.layers
          : layers_for_tolerance(range, farthest_acquisition_m(*eye->plan_), tolerance_rad);
  eye->inputs_->distances = &eye->distances_;
  // With automatic layers the picture is the same within the tolerance as with exact distances,
  // which are cheaper.
  if (options_.layers > 0) eye->inputs_->layers = layer_spacing(range, options_.layers);
  eye->inputs_->fill_maps = eye->fill_maps_;
}

const PreparedView& Renderer::prepare(const Viewpoint& viewpoint) {
  plan_eye(viewpoint, 0.0, &view_);
  if (options_.generation == Generation::kInitial) return view_;
  choose_maps(&view_);
  view_.distances_.compute(view_.maps_, view_.plan_->eye().centre_m);
  use_distances(&view_);
  return view_;
}

Renderer::Eyes Renderer::prepare_stereo(const Viewpoint& viewpoint, double eyes_apart_m) {
  if (!right_eye_) right_eye_.reset(new PreparedView(room_));
  PreparedView& right = *right_eye_;
  plan_eye(viewpoint, 0.5 * eyes_apart_m, &view_);
  plan_eye(viewpoint, -0.5 * eyes_apart_m, &right);
  if (options_.generation == Generation::kInitial) return {&view_, &right};
  choose_maps(&view_);
  right.maps_ = view_.maps_;
  right.fill_maps_ = view_.fill_maps_;
  DistanceView::compute_stereo(view_.maps_, view_.plan_->eye(), &view_.distances_,
                               &right.distances_);
  for (PreparedView* eye : {&view_, &right}) use_distances(eye);
  return {&view_, &right};
}

void Renderer::render_columns(const Eyes& eyes, int first, int count, const ColumnSink& sink,
                              ViewReport* report) {
  const PanoramaSize size = eyes.front()->inputs_->output;
  const size_t column_bytes = spread_column_bytes(size.height);
  const auto sources_of = [&](size_t eye) {
    return [this, &size, &plan = *eyes[eye]->plan_](int u) {
      return sources(plan.column(angles_from_pixel({double(u), 0.0}, size).theta_rad));
    };
  };
  std::deque<ColumnWorkers> workers;
  unknown_.resize(eyes.size());
  for (size_t eye = 0; eye < eyes.size(); ++eye) {
    workers.emplace_back(*eyes[eye]->inputs_);
    unknown_[eye].resize(static_cast<size_t>(count));
  }
  parallel_for(0, count, kColumnsPerTask, [&](int begin, int end) {
    // Both eyes read nearly the same columns of the stations, which are then still cached.
    for (size_t eye = 0; eye < eyes.size(); ++eye) {
      auto worker = workers[eye].take();
      worker->render(first, begin, end, sources_of(eye));
      sink(eye, begin, end - begin, worker->columns(), column_bytes);
      std::ranges::copy(worker->unknown(), unknown_[eye].begin() + begin);
      workers[eye].give_back(std::move(worker));
    }
  });
  PixelCounts total;
  for (const ColumnWorkers& of_eye : workers) total += of_eye.counts();
  report->pixels = total.all;
  report->work = total.work;
  const auto share = [&](std::int64_t part) {
    return static_cast<double>(part) / static_cast<double>(total.all);
  };
  report->filled_share = share(total.filled);
  report->stretched_share = share(total.stretched);
  report->empty_share = share(total.empty);
}

void Renderer::render_panoramas(const Eyes& eyes, cv::Mat* image, ViewReport* report) {
  const PanoramaSize size = eyes.front()->inputs_->output;
  const int count = static_cast<int>(eyes.size());
  cv::Mat& rendered = supersampling_ > 1 ? oversized_ : *image;
  rendered.create(count * size.height, size.width, CV_8UC3);
  advise_huge_pages(rendered.data, rendered.step * static_cast<size_t>(rendered.rows));
  const auto first_row = [&](size_t eye) { return static_cast<int>(eye) * size.height; };
  render_columns(
      eyes, 0, size.width,
      [&](size_t eye, int begin, int columns_count, const std::uint8_t* columns,
          size_t column_bytes) {
        column_kernels().write_rows(columns, column_bytes, columns_count, size.height,
                                    rendered.ptr<std::uint8_t>(first_row(eye)) + 3 * begin,
                                    rendered.step);
      },
      report);
  for (size_t eye = 0; eye < eyes.size(); ++eye) {
    cv::Mat of_eye = rendered.rowRange(first_row(eye), first_row(eye) + size.height);
    fill_picture({unknown_[eye], Seam::kJoined, {0, size.height}, size.height}, &of_eye);
  }
  if (supersampling_ > 1) {
    cv::resize(oversized_, *image, cv::Size(options_.width, count * options_.width / 2), 0, 0,
               cv::INTER_AREA);
  }
}

UnknownPixels Renderer::render_part(const PanoramaPart& part, ViewReport* report) {
  const PanoramaSize panorama = view_.inputs_->output;
  // An initial view fills masked rows from the whole column.
  if (!room_.masked()) view_.inputs_->rows = part.rows;
  const size_t column = 3 * static_cast<size_t>(panorama.height);
  part_.resize(2 * kReadable + column * static_cast<size_t>(part.columns));
  std::uint8_t* const rays = part_.data() + kReadable;
  render_columns(
      {&view_}, part.first_column, part.columns,
      [&](size_t, int begin, int count, const std::uint8_t* columns, size_t column_bytes) {
        const size_t from = 3 * static_cast<size_t>(part.rows.begin);
        for (int i = 0; i < count; ++i) {
          std::copy_n(columns + column_bytes * static_cast<size_t>(i) + from,
                      3 * static_cast<size_t>(part.rows.end - part.rows.begin),
                      rays + column * static_cast<size_t>(begin + i) + from);
        }
      },
      report);
  const Seam seam = part.columns == panorama.width ? Seam::kJoined : Seam::kOpen;
  return {unknown_.front(), seam, part.rows, panorama.height};
}

void Renderer::fill_part(const UnknownPixels& unknown) {
  if (std::ranges::all_of(unknown.columns, &UnknownRows::empty)) return;
  cv::Mat columns(static_cast<int>(unknown.columns.size()), unknown.height, CV_8UC3,
                  part_.data() + kReadable);
  cv::Mat picture;
  cv::transpose(columns, picture);
  fill_picture(unknown, &picture);
  cv::transpose(picture, columns);
}

void Renderer::render_flat(const Viewport& viewport, cv::Mat* image, ViewReport* report) {
  const PanoramaSize panorama = view_.inputs_->output;
  // A picture much coarser than the panorama is rendered finer and averaged down, up to the largest
  // picture size.
  const double coarser = panorama.width / (kTwoPi * focal_length_px(viewport));
  const int most_fold = kMaxViewport_px / std::max(viewport.width, viewport.height);
  const int fold = std::max(1, std::min(most_fold, static_cast<int>(std::lround(coarser))));
  Viewport fine = viewport;
  fine.width *= fold;
  fine.height *= fold;
  PanoramaPart part = part_shown(fine, panorama);
  UnknownPixels unknown = render_part(part, report);
  // What surrounds a large unknown place may lie beyond the part: then it is filled as in the
  // panorama, so that it looks the same from every direction.
  if (is_unknown_at_border(unknown, panorama.width / 64)) {
    part = {.first_column = 0, .columns = panorama.width, .rows = {0, panorama.height}};
    ViewReport of_all;
    unknown = render_part(part, &of_all);
  }
  fill_part(unknown);

  cv::Mat& rendered = fold > 1 ? oversized_ : *image;
  rendered.create(fine.height, fine.width, CV_8UC3);
  advise_huge_pages(rendered.data, rendered.step * static_cast<size_t>(fine.height));
  const ColumnBlock block{panorama, part.first_column, part.columns};
  const auto block_column = static_cast<std::int32_t>(3 * panorama.height);
  const RayExtent extent{block_column, block_column * part.columns};
  const SampleReaders& readers = readers_of(options_.interpolation);
  const size_t column_bytes = spread_column_bytes(fine.height);
  parallel_for(0, fine.width, kColumnsPerTask, [&](int begin, int end) {
    PositionArrays positions(fine.height);
    std::vector<std::uint8_t> columns(column_bytes * static_cast<size_t>(end - begin));
    for (int i = begin; i < end; ++i) {
      column_kernels().aim(rays_of_column(fine, i), fine.height, block, positions.positions());
      readers.sample_each({part_.data() + kReadable, positions.positions(), extent}, fine.height,
                          columns.data() + column_bytes * static_cast<size_t>(i - begin));
    }
    column_kernels().write_rows(columns.data(), column_bytes, end - begin, fine.height,
                                rendered.ptr<std::uint8_t>(0) + 3 * begin, rendered.step);
  });
  if (fold > 1) {
    cv::resize(oversized_, *image, cv::Size(viewport.width, viewport.height), 0, 0, cv::INTER_AREA);
  }
}

RenderedView Renderer::render(const Viewpoint& viewpoint) {
  RenderedView view;
  render(viewpoint, view);
  return view;
}

void Renderer::render(const Viewpoint& viewpoint, RenderedView& view) {
  const auto start = std::chrono::steady_clock::now();
  prepare(viewpoint);
  render_prepared({&view_}, nullptr, start, &view);
}

RenderedView Renderer::render_stereo(const Viewpoint& viewpoint, double eyes_apart_m) {
  RenderedView view;
  render_stereo(viewpoint, eyes_apart_m, view);
  return view;
}

void Renderer::render_stereo(const Viewpoint& viewpoint, double eyes_apart_m, RenderedView& view) {
  const auto start = std::chrono::steady_clock::now();
  render_prepared(prepare_stereo(viewpoint, eyes_apart_m), nullptr, start, &view);
}

RenderedView Renderer::render(const Viewpoint& viewpoint, const Viewport& viewport) {
  RenderedView view;
  render(viewpoint, viewport, view);
  return view;
}

void Renderer::render(const Viewpoint& viewpoint, const Viewport& viewport, RenderedView& view) {
  require_viewport(viewport);
  const auto start = std::chrono::steady_clock::now();
  prepare(viewpoint);
  render_prepared({&view_}, &viewport, start, &view);
}

void Renderer::render_prepared(const Eyes& eyes, const Viewport* viewport,
                               std::chrono::steady_clock::time_point start, RenderedView* view) {
  if (touched_) touched_->clear();
  view->report.layers = view_.layers_;
  view->report.limited_corners = view_.plan_->limited_corners();
  if (viewport != nullptr) {
    render_flat(*viewport, &view->image, &view->report);
  } else {
    render_panoramas(eyes, &view->image, &view->report);
  }
  view->report.bytes_touched = touched_ ? touched_->bytes() : 0;
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  view->report.render_ms = elapsed.count();
}

}  // namespace raywalk
