#include "core/view/gpu/gpu_mixing.h"

#include <algorithm>
#include <array>
#include <bit>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/parallel.h"
#include "core/view/gpu/shader_text.h"

namespace raywalk {
namespace {

constexpr std::size_t kMostFills = 64;  // stations to fill from, as in mixing.glsl
constexpr std::uint32_t kMasked = 1, kEmpty = 2, kHasTrust = 4, kJudged = 8;
constexpr std::uint32_t kNoImage = 15;  // of a column beside
constexpr int kGroup = 8;               // invocations across and down

// As mixing.glsl declares them.
struct GpuColumn {
  std::int32_t first_read = 0, reads = 0;
  std::int32_t nearest = 0, other = 0;
  float right = 0.0f, captured = 0.0f;
  std::uint32_t flags = 0, beside = 0;
  std::array<float, 4> eye_m{};
  std::int32_t first_edge = 0, edges = 0;
  std::array<std::int32_t, 2> unused{};
};
struct GpuRead {
  std::array<float, 4> to_eye{};
  float unreliable = 0.0f, after_part = 0.0f;
  std::int32_t layer = 0, source = 0, image = -1;
  std::uint32_t before = 0, after = 0;
  std::int32_t unused = 0;
};
struct GpuEdge {
  std::int32_t row = 0;
  std::array<float, 4> inverse{};
  std::uint32_t surface = 0;
};
static_assert(sizeof(GpuColumn) == 64 && sizeof(GpuRead) == 48 && sizeof(GpuEdge) == 24);

GpuEdge packed(const EdgePixel& edge) {
  GpuEdge to{.row = edge.row};
  for (std::size_t i = 0; i < to.inverse.size(); ++i) {
    const EdgeQuarter& quarter = edge.quarter[i];
    to.inverse[i] = quarter.inverse;
    const int surface = (quarter.right + 1) | (quarter.down + 1) << 4;
    to.surface |= static_cast<std::uint32_t>(surface) << (8 * i);
  }
  return to;
}

// Of each source, the images of what is occluded in the columns to the left and to the right of the
// nearest one, where their bits mean the same.
std::uint32_t images_beside(const MixedView& view, const MixedColumn& column) {
  const int width = view.distances.size().width;
  std::uint32_t images = 0;
  for (std::size_t source = 0; source < column.sources.count; ++source) {
    const ColumnSource& of = column.sources.source[source];
    for (const int right : {0, 1}) {
      const int theta = (column.nearest + (right == 0 ? width - 1 : 1)) % width;
      const int image = view.visibility.image_of(
          theta, view.visibility.occluded_as(column.nearest, theta, of.at.line, of.behind()));
      images |= (image < 0 ? kNoImage : static_cast<std::uint32_t>(image))
                << (8 * source + 4 * static_cast<std::size_t>(right));
    }
  }
  return images;
}

const Eigen::Vector3d& station_m(const Room& room, StationKey station) {
  return room.grid()
      .lines[static_cast<std::size_t>(station.first)]
      .stations[static_cast<std::size_t>(station.second)]
      .position_m;
}

StationKey key_of(const MapStation& map) { return {map.line, map.station}; }

template <typename Use>
void for_each_bit(std::uint64_t bits, const Use& use) {
  for (; bits != 0; bits &= bits - 1) use(std::countr_zero(bits));
}

std::array<float, 4> four(const Eigen::Vector3d& v, float w) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), w};
}

}  // namespace

struct GpuMixing::Program {
  explicit Program(const char* defines) : program(defines, kMixingShader) {}
  GLint at(const char* name) const { return program.uniform(name); }
  GpuProgram program;
};

struct GpuMixing::Uploads {
  std::vector<MixedColumn> mixed;  // of the part
  std::vector<GpuColumn> columns;
  std::vector<GpuRead> reads;
  std::vector<StationKey> of_reads;  // their stations
  std::vector<GpuEdge> edges;
  std::vector<float> distances;
  std::vector<std::uint8_t> occluded;
  std::vector<std::uint64_t> fills;  // of each column of the distances, bits of the stations
  std::uint64_t shown_fills = 0;     // of the columns whose stations were required last
  std::size_t most_reads = 0;        // of a column
  GpuBuffer columns_there, reads_there, edges_there, distances_there, occluded_there, picture;
};

GpuMixing::GpuMixing(GpuContext* context, std::shared_ptr<StationTextures> stations)
    : context_(context), stations_(std::move(stations)), uploads_(std::make_unique<Uploads>()) {}

GpuMixing::~GpuMixing() {
  try {
    const GpuContext::Turn turn(context_);
    uploads_.reset();
    plain_.reset();
    keeping_.reset();
    stations_.reset();
  } catch (const GpuError&) {  // the card is lost, and with it what it held
  }
}

void GpuMixing::upload(const MixedView& view, const PanoramaPart& part) {
  Uploads& to = *uploads_;
  const auto count = static_cast<std::size_t>(part.columns);
  to.mixed.resize(count);
  parallel_for(0, part.columns, 16, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      prepare_column(view, (part.first_column + i) % view.output.width,
                     &to.mixed[static_cast<std::size_t>(i)]);
    }
  });
  to.columns.assign(count, {});
  to.reads.clear();
  to.of_reads.clear();
  to.edges.clear();
  to.most_reads = 0;
  const Eigen::Vector3d& centre_m = view.distances.eye().centre_m;
  bool any_trust = false;
  int edges_nearest = -1;
  for (std::size_t i = 0; i < count; ++i) {
    const MixedColumn& from = to.mixed[i];
    GpuColumn& column = to.columns[i];
    column.first_read = static_cast<std::int32_t>(to.reads.size());
    column.reads = static_cast<std::int32_t>(from.reads.size());
    to.most_reads = std::max(to.most_reads, from.reads.size());
    column.captured = from.captured;
    column.flags = (from.any_masks ? kMasked : 0) | (from.sources.count == 0 ? kEmpty : 0) |
                   (from.trust != nullptr ? kHasTrust : 0);
    if (view.options.interpolation == Interpolation::kCubic) column.flags |= kJudged;
    for (const ColumnRead& read : from.reads) {
      if (view.exposure != nullptr && !view.exposure->is_one(read.line, read.station)) {
        column.flags |= kJudged;
      }
      GpuRead& gpu = to.reads.emplace_back();
      to.of_reads.emplace_back(read.line, read.station);
      gpu.to_eye[3] = read.share.reliable;
      if (view.is_initial()) continue;
      const Offset to_eye =
          offset_in_column(from.eye_m - station_m(view.room, to.of_reads.back()), from.theta_rad);
      gpu = {.to_eye = {to_eye.ahead, to_eye.aside, to_eye.up, read.share.reliable},
             .unreliable = read.share.unreliable,
             .after_part = read.by.after_part,
             .source = static_cast<std::int32_t>(read.source),
             .image = view.visibility.image_of(from.nearest, from.occluded[read.source]),
             .before = read.by.before,
             .after = read.by.after};
    }
    if (view.is_initial()) continue;
    any_trust |= from.trust != nullptr;
    column.nearest = from.nearest;
    column.other = from.other;
    column.right = from.right;
    column.beside = images_beside(view, from);
    column.eye_m = four(from.eye_m - centre_m, 0.0f);
    // Output columns of one column of the distances have the same edges.
    if (from.nearest != edges_nearest) {
      edges_nearest = from.nearest;
      column.first_edge = static_cast<std::int32_t>(to.edges.size());
      for (const EdgePixel& edge : from.edges) to.edges.push_back(packed(edge));
    } else {
      column.first_edge = to.columns[i - 1].first_edge;
    }
    column.edges = static_cast<std::int32_t>(from.edges.size());
  }
  to.fills.clear();
  to.distances.clear();
  to.occluded.clear();
  if (view.is_initial()) return;
  const PanoramaSize size = view.distances.size();
  const auto rows = static_cast<std::size_t>(size.height);
  const std::size_t pixels = rows * static_cast<std::size_t>(size.width);
  to.distances.resize(any_trust ? 2 * pixels : pixels);
  std::copy_n(view.distances.column(0), pixels, to.distances.begin());
  to.occluded.resize((Visibility::kImages * pixels + 3) / 4 * 4);
  for (std::size_t i = 0; i < Visibility::kImages; ++i) {
    std::copy_n(view.visibility.image(i).begin(), pixels,
                to.occluded.begin() + static_cast<std::ptrdiff_t>(i * pixels));
  }
  to.fills.assign(static_cast<std::size_t>(size.width), 0);
  for (int theta = 0; theta < size.width; ++theta) {
    if (const float* const trust = view.distances.trust(theta); any_trust && trust != nullptr) {
      std::copy_n(trust, rows,
                  to.distances.begin() +
                      static_cast<std::ptrdiff_t>(pixels + static_cast<std::size_t>(theta) * rows));
    }
    for (const std::uint8_t fill : std::span(view.visibility.fill(theta), rows)) {
      if (fill != 0 && fill <= kMostFills) {
        to.fills[static_cast<std::size_t>(theta)] |= std::uint64_t{1} << (fill - 1);
      }
    }
  }
}

int GpuMixing::require_stations(const MixedView& view, int first, int columns) {
  Uploads& from = *uploads_;
  std::set<StationKey> wanted;
  from.shown_fills = 0;
  int end = first;
  for (; end < columns; ++end) {
    const GpuColumn& column = from.columns[static_cast<std::size_t>(end)];
    std::vector<StationKey> added;
    const auto want = [&](StationKey station) {
      if (wanted.insert(station).second) added.push_back(station);
    };
    const auto reads = std::span(from.of_reads)
                           .subspan(static_cast<std::size_t>(column.first_read),
                                    static_cast<std::size_t>(column.reads));
    std::ranges::for_each(reads, want);
    const std::uint64_t fills =
        from.fills.empty() ? 0 : from.fills[static_cast<std::size_t>(column.nearest)];
    for_each_bit(fills, [&](int index) { want(key_of(view.fill.station(index))); });
    if (wanted.size() > stations_->layers()) {
      for (const StationKey& station : added) wanted.erase(station);
      break;
    }
    from.shown_fills |= fills;
  }
  if (end == first) throw GpuError("the stations of a column do not fit into --gpu-mb");
  const std::vector<StationKey> stations(wanted.begin(), wanted.end());
  stations_->require(stations);
  const auto begin_read =
      static_cast<std::size_t>(from.columns[static_cast<std::size_t>(first)].first_read);
  const GpuColumn& last = from.columns[static_cast<std::size_t>(end - 1)];
  const auto end_read =
      static_cast<std::size_t>(last.first_read) + static_cast<std::size_t>(last.reads);
  for (std::size_t i = begin_read; i < end_read; ++i) {
    from.reads[i].layer = stations_->layer(from.of_reads[i]);
  }
  from.reads_there.write(
      begin_read * sizeof(GpuRead),
      std::as_bytes(std::span(from.reads).subspan(begin_read, end_read - begin_read)));
  return end;
}

const GpuMixing::Program& GpuMixing::program_for(const MixedView& view) {
  constexpr std::size_t kMany = 6;  // samples that are judged by each other (sampler.cc)
  const bool keep =
      (view.options.interpolation == Interpolation::kCubic || view.exposure != nullptr) &&
      uploads_->most_reads >= kMany;
  std::unique_ptr<Program>& program = keep ? keeping_ : plain_;
  if (!program) program = std::make_unique<Program>(keep ? "#define KEEP_SAMPLES\n" : "");
  return *program;
}

void GpuMixing::set_uniforms(const MixedView& view, const PanoramaPart& part,
                             const Program& program) {
  const PanoramaSize captured = view.room.panorama(), distances = view.distances.size();
  glUniform1i(program.at("stations"), 0);
  glUniform2i(program.at("captured"), captured.width, captured.height);
  glUniform2i(program.at("output_size"), view.output.width, view.output.height);
  glUniform2i(program.at("distance_size"), distances.width, distances.height);
  glUniform1i(program.at("first_column"), part.first_column);
  glUniform1i(program.at("first_row"), part.rows.begin);
  glUniform1i(program.at("is_initial"), view.is_initial() ? 1 : 0);
  glUniform1i(program.at("is_cubic"), view.options.interpolation == Interpolation::kCubic ? 1 : 0);
  glUniform1f(program.at("tolerance"), view.distances.surface_tolerance());
}

void GpuMixing::render(const MixedView& view, const PanoramaPart& part, cv::Mat image,
                       cv::Mat1b how) {
  upload(view, part);
  Uploads& from = *uploads_;
  const GpuContext::Turn turn(context_);
  const Program& program = program_for(view);
  program.program.use();
  set_uniforms(view, part, program);
  from.columns_there.write(std::span<const GpuColumn>(from.columns));
  from.reads_there.reserve(std::max(from.reads.size(), std::size_t{1}) * sizeof(GpuRead));
  from.edges_there.write(std::span<const GpuEdge>(from.edges));
  from.distances_there.write(std::span<const float>(from.distances));
  from.occluded_there.write(std::span<const std::uint8_t>(from.occluded));
  const std::size_t bytes = 4 * image.total();
  from.picture.reserve(bytes);
  const std::array buffers{&from.columns_there,   &from.reads_there,    &from.edges_there,
                           &from.distances_there, &from.occluded_there, &from.picture};
  for (std::size_t i = 0; i < buffers.size(); ++i) buffers[i]->bind(static_cast<GLuint>(i));
  for (int first = 0, end = 0; first < part.columns; first = end) {
    end = require_stations(view, first, part.columns);
    stations_->bind(0);
    std::vector<std::array<float, 4>> fills(kMostFills);
    for_each_bit(from.shown_fills, [&](int index) {
      const StationKey station = key_of(view.fill.station(index));
      fills[static_cast<std::size_t>(index)] =
          four(station_m(view.room, station) - view.distances.eye().centre_m,
               static_cast<float>(stations_->layer(station)));
    });
    glUniform4fv(program.at("fill_m"), static_cast<GLsizei>(fills.size()), fills.front().data());
    const int rows = part.rows.end - part.rows.begin;
    glUniform4i(program.at("part"), first, end - first, part.columns, rows);
    glDispatchCompute(static_cast<GLuint>((end - first + kGroup - 1) / kGroup),
                      static_cast<GLuint>((rows + kGroup - 1) / kGroup), 1);
  }
  check_gpu("a picture");
  from.picture.read(bytes, [&](const std::byte* pixels) {
    const cv::Mat bgra(image.size(), CV_8UC4,
                       const_cast<std::byte*>(pixels));  // NOLINT: it is only read
    parallel_for(0, image.rows, 64, [&](int begin, int end) {
      std::array<cv::Mat, 2> to{image.rowRange(begin, end), how.rowRange(begin, end)};
      constexpr std::array<int, 8> kChannels{0, 0, 1, 1, 2, 2, 3, 3};
      const cv::Mat of = bgra.rowRange(begin, end);
      cv::mixChannels(&of, 1, to.data(), to.size(), kChannels.data(), 4);
    });
  });
}

}  // namespace raywalk
