#include "build_lf/refine/developed_image.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "build_lf/refine/directional_mean.h"
#include "core/base/parallel.h"
#include "core/room/tiled_rays.h"
#include "core/view/column_geometry.h"
#include "core/view/mask_check.h"
#include "core/view/vector_clones.h"

namespace raywalk::build_lf {
namespace {

constexpr float kNearest = 0.02f;  // e of the weights, rad: so near, nearer does not count more
constexpr int kFewest = 4;         // other photographs that say what one would have shown

// The weights of four pixels, at -1, 0, 1 and 2, for a place in [0, 1) (Catmull-Rom, as views have
// it).
struct CubicWeights {
  RAYWALK_INLINE explicit CubicWeights(float t)
      : of{((-0.5f * t + 1.0f) * t - 0.5f) * t, (1.5f * t - 2.5f) * t * t + 1.0f,
           ((-1.5f * t + 2.0f) * t + 0.5f) * t, (0.5f * t - 0.5f) * t * t} {}
  float of[4];  // NOLINT(modernize-avoid-c-arrays): std::array's functions are not of the clone
};

// A place in a photograph, pixels: u in [0, width), v in [0, height - 1].
struct Place {
  float u, v;
};

// Bicubic samples of a photograph, rgb [theta][phi], at places all over it.
RAYWALK_VECTOR_CLONES void sample_photograph(const std::uint8_t* rays, PanoramaSize size,
                                             const Place* places, std::size_t count,
                                             cv::Vec3f* colours) {
  const int width = size.width, height = size.height;
  for (std::size_t n = 0; n < count; ++n) {
    const int left = static_cast<int>(places[n].u), upper = static_cast<int>(places[n].v);
    const CubicWeights across(places[n].u - static_cast<float>(left));
    const CubicWeights down(places[n].v - static_cast<float>(upper));
    // Four columns become one of four pixels, and that one colour.
    float pixels[12] = {};  // NOLINT(modernize-avoid-c-arrays)
    const bool is_inside = upper >= 1 && upper + 2 < height;
    for (int i = 0; i < 4; ++i) {
      int column = left - 1 + i;
      column += column < 0 ? width : 0;
      column -= column >= width ? width : 0;
      const std::uint8_t* const rgb = rays + std::ptrdiff_t{3} * height * column;
      const std::uint8_t* const first = rgb + std::ptrdiff_t{3} * (upper - 1);
      if (is_inside) {
        for (int k = 0; k < 12; ++k) pixels[k] += across.of[i] * static_cast<float>(first[k]);
        continue;
      }
      for (int k = 0; k < 12; ++k) {
        int row = upper - 1 + k / 3;
        row = row < 0 ? 0 : row >= height ? height - 1 : row;
        pixels[k] += across.of[i] * static_cast<float>(rgb[3 * row + k % 3]);
      }
    }
    for (int c = 0; c < 3; ++c) {
      colours[n].val[c] = down.of[0] * pixels[c] + down.of[1] * pixels[3 + c] +
                          down.of[2] * pixels[6 + c] + down.of[3] * pixels[9 + c];
    }
  }
}

// Points of a column as another station sees them.
struct LocatedRows {
  explicit LocatedRows(std::size_t rows) : u(rows), v(rows), length(rows) {}
  std::vector<float> u, v;    // u from -0.5 to below width - 0.5, v from -0.5 to height - 0.5
  std::vector<float> length;  // SeenPoint::length
};

// `turn`: the column's place, in turns from the first one.
RAYWALK_VECTOR_CLONES void locate_rows(const float* sin_phi, const float* cos_phi,
                                       const float* inverse, int rows, Offset to_eye, float turn,
                                       PanoramaSize size, float* u, float* v, float* length) {
  const auto width = static_cast<float>(size.width), height = static_cast<float>(size.height);
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows; ++i) {
    const SeenPoint seen = seen_from(sin_phi[i], cos_phi[i], inverse[i], to_eye);
    float around = turn + seen.turn_rad * static_cast<float>(1.0 / kTwoPi);
    around += around < 0.0f ? 1.0f : 0.0f;
    around -= around >= 1.0f ? 1.0f : 0.0f;
    u[i] = around * width - 0.5f;
    v[i] = (0.5f - seen.phi_rad * static_cast<float>(1.0 / kPi)) * height - 0.5f;
    length[i] = seen.length;
  }
}

// A captured station whose photograph is sampled. Only while the rays of compressed lines are held
// (TileReading).
class Photograph {
 public:
  Photograph(const Room& room, const Exposure* exposure, StationIndex station)
      : exposure_(exposure != nullptr && !exposure->is_one(station.line, station.station)
                      ? exposure
                      : nullptr),
        station_(station),
        size_(room.panorama()),
        rays_(room.volume(station.line).columns(station.station).data()) {
    constexpr int kBeyond = 1;  // bicubic
    if (has_masks(room, station.line, station.station)) {
      masks_.emplace(room, station.line, station.station, kBeyond);
    }
  }

  PanoramaSize size() const { return size_; }

  // The place of a position on its sphere, pixels.
  Place place_of(float u, float v) const {
    return {u < 0.0f ? u + static_cast<float>(size_.width) : u,
            std::clamp(v, 0.0f, static_cast<float>(size_.height - 1))};
  }

  // Whether what a sample reads may be used.
  bool is_usable(Place place) {
    if (!masks_) return true;
    const int column = static_cast<int>(place.u) % size_.width;
    const int row = static_cast<int>(place.v);
    const int right = column + 1 == size_.width ? 0 : column + 1;
    return masks_->usable(3 * (size_.height * column + row), 3 * (size_.height * right + row));
  }

  void sample(const std::vector<Place>& places, std::vector<cv::Vec3f>* colours) const {
    colours->resize(places.size());
    sample_photograph(rays_, size_, places.data(), places.size(), colours->data());
    if (exposure_ == nullptr) return;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const cv::Vec4f gain =
          exposure_->at(station_.line, station_.station, places[i].u, places[i].v);
      for (int c = 0; c < 3; ++c) (*colours)[i][c] *= gain[c];
    }
  }

 private:
  const Exposure* exposure_;
  StationIndex station_;
  PanoramaSize size_;
  const std::uint8_t* rays_;
  std::optional<MaskCheck> masks_{};  // none: all may be used
};

// A column that is developed, and what is worked on for it.
struct DevelopedColumn {
  explicit DevelopedColumn(const Latitudes& of)
      : latitudes(of), located(static_cast<std::size_t>(of.rows())) {}

  const Latitudes& latitudes;
  double theta_rad = 0.0;
  std::span<const float> inverse{};  // of its rows
  std::vector<DirectionalMean> samples{};
  std::vector<int> others{};  // samples of other stations

  LocatedRows located;
  std::vector<std::size_t> rows{};  // that a photograph shows
  std::vector<Place> places{};      // where
  std::vector<cv::Vec3f> colours{};
};

// Adds what another station shows of the points of a column.
void add_samples(const SourceView& view, const Eigen::Vector3d& station_m, Photograph* photograph,
                 DevelopedColumn* column) {
  const Eigen::Vector3d to_eye_m = station_m - view.position_m();
  const Offset to_eye = offset_in_column(to_eye_m, column->theta_rad);
  const PanoramaSize size = photograph->size();
  const float share = static_cast<float>(view.size().width) / static_cast<float>(size.width);
  const auto slack = static_cast<float>(0.5 * kTwoPi / view.size().width / to_eye_m.norm());
  const float* const sin_phi = column->latitudes.sin_phi.data();
  const float* const cos_phi = column->latitudes.cos_phi.data();
  LocatedRows& located = column->located;
  locate_rows(sin_phi, cos_phi, column->inverse.data(), column->latitudes.rows(), to_eye,
              static_cast<float>((column->theta_rad + kPi) / kTwoPi), size, located.u.data(),
              located.v.data(), located.length.data());
  column->rows.clear();
  column->places.clear();
  for (std::size_t row = 0; row < column->inverse.size(); ++row) {
    const float w = column->inverse[row], u = located.u[row], v = located.v[row];
    if (w < 0.0f || !view.sees({.u = (u + 0.5f) * share - 0.5f,
                                .v = (v + 0.5f) * share - 0.5f,
                                .inverse = w / located.length[row],
                                .slack = slack})) {
      continue;
    }
    const Place place = photograph->place_of(u, v);
    if (!photograph->is_usable(place)) continue;
    column->rows.push_back(row);
    column->places.push_back(place);
  }
  photograph->sample(column->places, &column->colours);
  for (std::size_t i = 0; i < column->rows.size(); ++i) {
    const std::size_t row = column->rows[i];
    // The cosine of the angle between the ray and (ray + w (P - S)) / length.
    const float along =
        1.0f + column->inverse[row] * (cos_phi[row] * to_eye.ahead + sin_phi[row] * to_eye.up);
    const float angle = std::sqrt(std::max(0.0f, 2.0f - 2.0f * along / located.length[row]));
    column->samples[row].add(column->colours[i], 1.0f / (angle + kNearest), angle);
    ++column->others[row];
  }
}

cv::Vec3w stored(const cv::Vec3f& colour) {
  cv::Vec3w levels;
  for (int c = 0; c < 3; ++c) {
    levels[c] = static_cast<std::uint16_t>(
        std::lround(std::clamp(colour[c], 0.0f, 255.0f) * static_cast<float>(kLevel)));
  }
  return levels;
}

// Adds what the station's own photograph shows, and stores the means.
void finish_column(int u, PanoramaSize developed, Photograph* own, DevelopedColumn* column,
                   DevelopedImage* image) {
  const auto scale = static_cast<float>(own->size().width) / static_cast<float>(developed.width);
  column->places.clear();
  for (int row = 0; row < developed.height; ++row) {
    column->places.push_back(own->place_of((static_cast<float>(u) + 0.5f) * scale - 0.5f,
                                           (static_cast<float>(row) + 0.5f) * scale - 0.5f));
  }
  own->sample(column->places, &column->colours);
  for (int row = 0; row < developed.height; ++row) {
    const auto i = static_cast<std::size_t>(row);
    DirectionalMean& samples = column->samples[i];
    if (column->others[i] >= kFewest) image->others.at<cv::Vec3w>(u, row) = stored(samples.value());
    if (own->is_usable(column->places[i])) samples.add(column->colours[i], 1.0f / kNearest, 0.0f);
    image->is_known(u, row) = samples.empty() ? 0 : 255;
    // Something is shown even where nothing may be used.
    image->colour.at<cv::Vec3w>(u, row) =
        stored(samples.empty() ? column->colours[i] : samples.value());
  }
}

}  // namespace

DevelopedImage develop_image(const Room& room, const Exposure* exposure, StationIndex station,
                             const InverseMap& distances,
                             std::span<const std::shared_ptr<const SourceView>> sources) {
  const PanoramaSize size = distances.size();
  const auto rows = static_cast<std::size_t>(size.height);
  const Latitudes latitudes(size.height);
  const Eigen::Vector3d station_m = room.grid().station(station).position_m;
  DevelopedImage image{cv::Mat(size.width, size.height, CV_16UC3),
                       cv::Mat(size.width, size.height, CV_16UC3, cv::Scalar::all(0)),
                       cv::Mat1b(size.width, size.height)};
  parallel_for(0, size.width, 8, [&](int begin, int end) {
    const TileReading reading;
    Photograph own(room, exposure, station);
    std::vector<Photograph> photographs;
    for (const auto& source : sources) photographs.emplace_back(room, exposure, source->station());
    DevelopedColumn column(latitudes);
    for (int u = begin; u < end; ++u) {
      column.theta_rad = theta_of_column(u, size.width);
      column.inverse = distances.values().subspan(static_cast<std::size_t>(u) * rows, rows);
      column.samples.assign(rows, {});
      column.others.assign(rows, 0);
      for (std::size_t i = 0; i < sources.size(); ++i) {
        add_samples(*sources[i], station_m, &photographs[i], &column);
      }
      finish_column(u, size, &own, &column, &image);
    }
  });
  return image;
}

}  // namespace raywalk::build_lf
