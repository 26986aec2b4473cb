#include "core/view/gpu/gpu_renderer.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <opencv2/core.hpp>
#include <set>
#include <vector>

#include "core/base/parallel.h"
#include "core/view/flat_view.h"
#include "core/view/gpu/shader_text.h"

namespace raywalk {
namespace {

constexpr std::size_t kMostFills = 64;  // stations to fill from, as in mixing.glsl
constexpr std::size_t kFillWords = kMostFills / 32;
// Words before a picture, among them how many pixels were read how, as in mixing.glsl.
constexpr std::size_t kHeadWords = 8, kCounts = 2;
constexpr std::uint8_t kFilled = 1, kUnread = 2, kOfNoLine = 4, kHow = 3;
constexpr std::uint32_t kMasked = 1, kEmpty = 2, kJudged = 4;
constexpr std::uint32_t kNoImage = 15;  // of a column beside

// As mixing.glsl declares them.
struct GpuColumn {
  std::int32_t first_read = 0, reads = 0;
  std::int32_t nearest = 0, other = 0;
  float right = 0.0f, captured = 0.0f;
  std::uint32_t flags = 0, beside = 0;
};
struct GpuRead {
  std::array<float, 4> to_eye{};
  float unreliable = 0.0f, after_part = 0.0f;
  std::int32_t layer = 0, source = 0, image = -1;
  std::uint32_t before = 0, after = 0;
  std::int32_t unused = 0;
};
static_assert(sizeof(GpuColumn) == 32 && sizeof(GpuRead) == 48);

// Of each source, the images of what is occluded in the columns to the left and to the right of the
// nearest one, where their bits mean the same.
std::uint32_t images_beside(const MixedView& view, const MixedColumn& column) {
  const int width = view.distances.size().width;
  std::uint32_t images = 0;
  for (std::size_t source = 0; source < column.sources.count; ++source) {
    const ColumnSource& of = column.sources.source[source];
    for (const int right : {0, 1}) {
      const int theta = (column.nearest + (right == 0 ? width - 1 : 1)) % width;
      const int image = view.visibility.image_as(column.nearest, theta, of.at.line, of.behind());
      images |= (image < 0 ? kNoImage : static_cast<std::uint32_t>(image))
                << (8 * source + 4 * static_cast<std::size_t>(right));
    }
  }
  return images;
}

const Eigen::Vector3d& station_m(const Room& room, ImageKey station) {
  return room.grid()
      .lines[static_cast<std::size_t>(station.first)]
      .stations[static_cast<std::size_t>(station.second)]
      .position_m;
}

GpuRead gpu_read(const MixedView& view, const MixedColumn& column, const ColumnRead& read) {
  if (view.is_initial()) return {.to_eye = {0.0f, 0.0f, 0.0f, read.share.reliable}};
  const ColumnSource& source = column.sources.source[read.source];
  const Offset to_eye = offset_in_column(
      column.eye_m - station_m(view.room, {read.line, read.station}), column.theta_rad);
  return {.to_eye = {to_eye.ahead, to_eye.aside, to_eye.up, read.share.reliable},
          .unreliable = read.share.unreliable,
          .after_part = read.by.after_part,
          .source = static_cast<std::int32_t>(read.source),
          .image = view.visibility.image_as(column.nearest, column.nearest, source.at.line,
                                            source.behind()),
          .before = read.by.before,
          .after = read.by.after};
}

GpuColumn gpu_column(const MixedView& view, const MixedColumn& column) {
  GpuColumn gpu{.reads = static_cast<std::int32_t>(column.reads.size()),
                .nearest = column.nearest,
                .other = column.other,
                .right = column.right,
                .captured = column.captured};
  const bool judged =
      view.options.interpolation == Interpolation::kCubic ||
      std::ranges::any_of(column.reads, [&](const ColumnRead& read) {
        return view.exposure != nullptr && !view.exposure->is_one(read.line, read.station);
      });
  gpu.flags = (column.any_masks ? kMasked : 0) | (column.sources.count == 0 ? kEmpty : 0) |
              (judged ? kJudged : 0);
  if (!view.is_initial()) gpu.beside = images_beside(view, column);
  return gpu;
}

std::size_t picture_bytes(int columns, int rows) {
  return 4 * (kHeadWords + static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
}

using HeadWords = std::array<std::uint32_t, kHeadWords>;

HeadWords head_of(const std::byte* picture) {
  HeadWords words{};
  std::memcpy(words.data(), picture, sizeof(words));
  return words;
}

// A picture as programs write it: bgr, and how pixels were read where it is wanted.
void unpack(const std::byte* picture, cv::Mat image, cv::Mat1b how) {
  const cv::Mat all(image.size(), CV_8UC4,
                    const_cast<std::byte*>(picture));  // NOLINT: it is only read
  parallel_for(0, image.rows, 64, [&](int begin, int end) {
    constexpr std::array<int, 8> kChannels{0, 0, 1, 1, 2, 2, 3, 3};
    std::vector<cv::Mat> to{image.rowRange(begin, end)};
    if (!how.empty()) to.push_back(how.rowRange(begin, end));
    const cv::Mat of = all.rowRange(begin, end);
    cv::mixChannels(&of, 1, to.data(), to.size(), kChannels.data(), how.empty() ? 3 : 4);
  });
}

}  // namespace

// What the columns of a part are read from, and passes 1 to 3.
struct GpuRenderer::Eye {
  explicit Eye(GpuContext* context) : passes(context) {}

  void prepare(const MixedView& view, const PanoramaPart& part);
  // The stations of columns from `first` on, at most `most`; sets the end of these columns.
  std::set<ImageKey> stations(int first, std::size_t most, int* end) const;
  std::size_t first_read(int column) const {
    const auto at = static_cast<std::size_t>(column);
    return at == columns.size() ? reads.size() : static_cast<std::size_t>(columns[at].first_read);
  }

  std::vector<MixedColumn> mixed;
  std::vector<GpuColumn> columns;
  std::vector<GpuRead> reads;
  std::vector<ImageKey> of_reads;  // their stations
  std::size_t most_reads = 0;      // of a column
  GpuView passes;
};

struct GpuRenderer::OnCard {
  explicit OnCard(GpuContext* context) : eyes{Eye(context), Eye(context)} {}
  ViewMaps maps;
  std::array<Eye, 2> eyes;
  GpuBuffer columns, reads, picture, flat;
};

// Columns whose stations fit, and what is searched to fill from.
struct GpuRenderer::Block {
  int first = 0, end = 0;
  bool again = false;              // only pixels that wait for a station
  std::vector<ImageKey> stations;  // that are there
  std::vector<GLint> fill_layers;
};

GpuRenderer::GpuRenderer(GpuContext* context, std::shared_ptr<RoomTextures> textures)
    : context_(context),
      textures_(std::move(textures)),
      on_card_(std::make_unique<OnCard>(context)) {}

GpuRenderer::~GpuRenderer() {
  try {
    const GpuContext::Turn turn(context_);
    on_card_.reset();
    textures_.reset();
  } catch (const GpuError&) {  // the card is lost, and with it what it held
  }
}

void GpuRenderer::plan(std::span<const MixedView> eyes) {
  if (eyes.front().is_initial()) return;
  OnCard& card = *on_card_;
  card.maps.plan(eyes.front());
  for (std::size_t i = 0; i < eyes.size(); ++i) card.eyes[i].passes.plan(eyes[i], &card.maps);
}

void GpuRenderer::prepare(std::span<const MixedView> eyes) {
  if (eyes.front().is_initial()) return;
  OnCard& card = *on_card_;
  card.maps.require(eyes.front(), textures_.get());
  textures_->bind();
  for (std::size_t i = 0; i < eyes.size(); ++i) card.eyes[i].passes.gather(eyes[i], card.maps);
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    card.eyes[i].passes.see(eyes[i], card.maps, card.eyes[eyes.size() - 1 - i].passes);
  }
  glFlush();  // so that the card begins
}

bool GpuRenderer::render(std::span<const MixedView> eyes, const PanoramaPart& part,
                         const FlatPicture* flat, cv::Mat image, cv::Mat1b* unread,
                         PixelCounts* counts) {
  plan(eyes);
  GpuContext::Turn turn(context_);
  prepare(eyes);
  const int rows = part.rows.end - part.rows.begin;
  const std::size_t bytes = picture_bytes(part.columns, rows);
  PixelCounts all;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const cv::Range of_eye(static_cast<int>(i) * rows, static_cast<int>(i + 1) * rows);
    const auto use = [&](const std::byte* picture) {
      const bool some_unread = head_of(picture)[kCounts + kUnread] > 0;
      cv::Mat1b how;
      if (some_unread) how.create(rows, part.columns);
      unpack(picture + 4 * kHeadWords, image.rowRange(of_eye), how);
      if (!some_unread) return;
      if (unread->empty()) *unread = cv::Mat1b::zeros(image.size());
      unread->rowRange(of_eye).setTo(255, (how & kHow) == kUnread);
    };
    Eye* const eye = &on_card_->eyes[i];
    if (flat == nullptr) {
      all += mix(eyes[i], eye, part, bytes, &turn, use);
      continue;
    }
    all = mix(eyes[i], eye, part, 4 * kHeadWords, &turn, [](const std::byte*) {});
    if (all.unseen == 0) {
      draw_flat(eyes[i], part, *flat, &turn);
    } else {
      on_card_->picture.read(bytes, use, &turn);
    }
  }
  *counts += all;
  return flat != nullptr && all.unseen == 0;
}

void GpuRenderer::draw_flat(const MixedView& view, const PanoramaPart& part,
                            const FlatPicture& flat, GpuContext::Turn* turn) {
  OnCard& card = *on_card_;
  const Viewport& viewport = flat.viewport;
  const GpuProgram& program = context_->program("flat", "", {kGeometryShader, kFlatShader});
  program.use();
  const FlatRays rays = flat_rays(viewport);
  program.set("first_ray", rays.first);
  program.set("right_step", rays.right);
  program.set("down_step", rays.down);
  program.set("flat_size", viewport.width, viewport.height);
  program.set("part_size", part.columns, part.rows.end - part.rows.begin);
  program.set("middle_u", static_cast<float>(0.5 * view.output.width - 0.5 - part.first_column));
  program.set("middle_v", static_cast<float>(0.5 * view.output.height - 0.5 - part.rows.begin));
  program.set("panorama_width", static_cast<float>(view.output.width));
  program.set("is_whole", part.columns == view.output.width);
  program.set("is_cubic", view.options.interpolation == Interpolation::kCubic);
  flat.image->create(viewport.height, viewport.width, CV_8UC3);
  const std::size_t bytes = 4 * flat.image->total();
  card.flat.reserve(bytes);
  card.flat.bind(kReadsBinding);
  card.picture.bind(kPictureBinding);
  run(viewport.width, viewport.height);
  check_gpu("a flat picture");
  card.flat.read(
      bytes, [&](const std::byte* picture) { unpack(picture, *flat.image, {}); }, turn);
}

void GpuRenderer::Eye::prepare(const MixedView& view, const PanoramaPart& part) {
  mixed.resize(static_cast<std::size_t>(part.columns));
  columns.resize(mixed.size());
  parallel_for(0, part.columns, 16, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      MixedColumn& column = mixed[static_cast<std::size_t>(i)];
      prepare_column(view, (part.first_column + i) % view.output.width, &column);
      columns[static_cast<std::size_t>(i)] = gpu_column(view, column);
    }
  });
  of_reads.clear();
  most_reads = 0;
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    columns[i].first_read = static_cast<std::int32_t>(of_reads.size());
    for (const ColumnRead& read : mixed[i].reads) of_reads.emplace_back(read.line, read.station);
    most_reads = std::max(most_reads, mixed[i].reads.size());
  }
  reads.resize(of_reads.size());
  parallel_for(0, part.columns, 16, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      auto at = static_cast<std::size_t>(columns[i].first_read);
      for (const ColumnRead& read : mixed[i].reads) reads[at++] = gpu_read(view, mixed[i], read);
    }
  });
}

std::set<ImageKey> GpuRenderer::Eye::stations(int first, std::size_t most, int* end) const {
  std::set<ImageKey> all;
  for (*end = first; *end < static_cast<int>(columns.size()); ++*end) {
    const GpuColumn& column = columns[static_cast<std::size_t>(*end)];
    std::vector<ImageKey> added;
    for (int i = column.first_read; i < column.first_read + column.reads; ++i) {
      const ImageKey& station = of_reads[static_cast<std::size_t>(i)];
      if (all.insert(station).second) added.push_back(station);
    }
    if (all.size() <= most) continue;
    for (const ImageKey& station : added) all.erase(station);
    break;
  }
  if (*end == first) throw GpuError("the stations of a column do not fit into --gpu-mb");
  return all;
}

const GpuProgram& GpuRenderer::mixing_program(const MixedView& view, const Eye& eye) {
  constexpr std::size_t kMany = 6;  // samples that are judged by each other (sampler.cc)
  const bool keep =
      (view.options.interpolation == Interpolation::kCubic || view.exposure != nullptr) &&
      eye.most_reads >= kMany;
  return context_->program(
      "mixing", keep ? "#define KEEP_SAMPLES\n" : "",
      {kGeometryShader, kMapsShader, kLookupShader, kQuartersShader, kFillShader, kMixingShader});
}

// All is set anew, because others may have had their turns.
void GpuRenderer::mix_block(const MixedView& view, Eye* eye, const PanoramaPart& part,
                            const Block& block) {
  OnCard& card = *on_card_;
  if (!view.is_initial()) card.maps.require(view, textures_.get());
  const std::size_t first = eye->first_read(block.first), end = eye->first_read(block.end);
  for (std::size_t i = first; i < end; ++i) {
    eye->reads[i].layer = textures_->station_layer(eye->of_reads[i]);
  }
  card.reads.write(first * sizeof(GpuRead),
                   std::as_bytes(std::span(eye->reads).subspan(first, end - first)));
  const std::array<std::uint32_t, kFillWords> none{};
  card.picture.write(0, std::as_bytes(std::span(none)));
  const GpuProgram& program = mixing_program(view, *eye);
  program.use();
  program.set("stations", static_cast<int>(RoomTextures::kStations));
  eye->passes.bind(view, card.maps, program);
  program.set("output_size", view.output);
  program.set("first_column", part.first_column);
  program.set("first_row", part.rows.begin);
  program.set("is_initial", view.is_initial());
  program.set("is_cubic", view.options.interpolation == Interpolation::kCubic);
  program.set("again", block.again);
  glUniform1iv(program.at("fill_layers"), static_cast<GLsizei>(kMostFills),
               block.fill_layers.data());
  const int rows = part.rows.end - part.rows.begin;
  glUniform4i(program.at("part"), block.first, block.end - block.first, part.columns, rows);
  card.columns.bind(kColumnsBinding);
  card.reads.bind(kReadsBinding);
  card.picture.bind(kPictureBinding);
  textures_->bind();
  run(block.end - block.first, rows);
  check_gpu("a picture");
}

PixelCounts GpuRenderer::mix(const MixedView& view, Eye* eye, const PanoramaPart& part,
                             std::size_t bytes, GpuContext::Turn* turn, const Use& use) {
  OnCard& card = *on_card_;
  const int rows = part.rows.end - part.rows.begin;
  const auto fills = view.is_initial() ? std::span<const MapStation>() : view.fill.maps();
  // One more may be needed to fill from.
  const std::size_t most = textures_->most_stations() - (view.is_initial() ? 0 : 1);
  eye->prepare(view, part);
  card.columns.write(std::span<const GpuColumn>(eye->columns));
  card.reads.reserve(std::max(eye->reads.size(), std::size_t{1}) * sizeof(GpuRead));
  card.picture.reserve(picture_bytes(part.columns, rows));
  HeadWords head{};
  card.picture.write(0, std::as_bytes(std::span(head)));
  Block block;
  while (block.end < part.columns) {
    block.first = block.end;
    const std::set<ImageKey> of_lines = eye->stations(block.first, most, &block.end);
    block.stations.assign(of_lines.begin(), of_lines.end());
    block.again = false;
    for (bool waiting = true; waiting; block.again = true) {
      textures_->require_stations(block.stations);
      block.fill_layers.assign(kMostFills, -1);
      for (std::size_t i = 0; i < fills.size(); ++i) {
        block.fill_layers[i] = textures_->station_layer({fills[i].line, fills[i].station});
      }
      mix_block(view, eye, part, block);
      const bool is_last = block.end == part.columns;
      const auto look = [&](const std::byte* picture) {
        head = head_of(picture);
        // Those that are missing are uploaded as far as they fit.
        block.stations.resize(of_lines.size());
        for (std::size_t i = 0; i < fills.size(); ++i) {
          const bool is_wanted = (head[i / 32] >> (i % 32) & 1) != 0;
          if (!is_wanted || block.fill_layers[i] >= 0) continue;
          if (block.stations.size() == textures_->most_stations()) break;
          block.stations.emplace_back(fills[i].line, fills[i].station);
        }
        waiting = block.stations.size() > of_lines.size();
        if (is_last && !waiting) use(picture);
      };
      card.picture.read(is_last ? bytes : sizeof(head), look, turn);
    }
  }
  return {.all = static_cast<std::int64_t>(part.columns) * rows,
          .filled = head[kCounts + kFilled],
          .unseen = head[kCounts + kUnread],
          .empty = head[kCounts + kOfNoLine]};
}

}  // namespace raywalk
