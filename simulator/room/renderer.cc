// The picture of a virtual room, with adaptive supersampling.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/base/parallel.h"
#include "core/panorama/srgb.h"
#include "simulator/room/bodies.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {
namespace {

// A pixel is divided into 4 x 4 strata of 4 x 4 parts each. The first four rays sample one stratum
// of each quarter, the others the remaining twelve strata.
constexpr int kStrata = 16;
constexpr int kFirst = 4;
constexpr float kTolerance_levels = 10.0F;  // larger differences of the first rays trigger the rest
// Light is clamped to this level, which is white. Otherwise edges of overexposed objects would be
// aliased, as a small share of very bright light makes a whole pixel white.
constexpr float kWhite = 1.3F;

constexpr double kKnee = 0.8;
constexpr double kBrightest = 16.0;  // above it every level rounds to 255
constexpr int kTableSize = 4096;

double soft_highlight(double light) {
  if (light <= kKnee) return light;
  const double room = 1.0 - kKnee;
  return kKnee + room * (1.0 - std::exp((kKnee - light) / room));
}

// Lookup table over the square root of light, which is nearly perceptually uniform and so needs few
// entries.
std::array<float, kTableSize + 1> make_table(bool clip) {
  std::array<float, kTableSize + 1> table{};
  for (int i = 0; i <= kTableSize; ++i) {
    const double root = std::sqrt(kBrightest) * i / kTableSize;
    table[static_cast<std::size_t>(i)] = static_cast<float>(
        srgb_level_from_linear(clip ? std::min(root * root, 1.0) : soft_highlight(root * root)));
  }
  return table;
}

struct Stratum {
  int column;
  int row;
};

// Numbers 0..3 are one stratum in each quarter, 4..15 the others, in a random order given by the
// hash.
Stratum stratum(int number, std::uint64_t hash) {
  const int quarter = number % kFirst;
  const auto choice = static_cast<int>((hash >> (2 * quarter)) & 3);
  const int within = (choice + number / kFirst) % 4;
  return {2 * (quarter % 2) + within % 2, 2 * (quarter / 2) + within / 2};
}

class PictureRenderer {
 public:
  PictureRenderer(const VirtualRoom& room, const PixelRays& camera, const CameraPose& pose,
                  const Bodies* bodies)
      : room_(room),
        light_(room.settings().light),
        bodies_(bodies),
        camera_(camera),
        origin_(pose.position_m),
        world_from_camera_(world_from_camera(pose.attitude)) {}

  void render_row(int row, cv::Vec3b* out) const {
    for (int column = 0; column < camera_.width(); ++column) {
      Pixel pixel;
      trace(row, column, 0, kFirst, &pixel);
      if (pixel.contrast() > kTolerance_levels) trace(row, column, kFirst, kStrata, &pixel);
      *out++ = pixel.rounded(light_.clip);
    }
  }

 private:
  // Accumulated rays of a pixel.
  struct Pixel {
    Color sum{0, 0, 0};
    int rays = 0;
    Color lowest{255, 255, 255};  // levels
    Color highest{0, 0, 0};

    void add(const Color& seen, const LightSettings& settings) {
      const Color light =
          (static_cast<float>(settings.exposure) * seen).cwiseMin(settings.clip ? 1.0F : kWhite);
      sum += light;
      ++rays;
      const Color level =
          light.unaryExpr([&](float part) { return level_from_light(part, settings.clip); });
      lowest = lowest.cwiseMin(level);
      highest = highest.cwiseMax(level);
    }
    float contrast() const { return (highest - lowest).maxCoeff(); }
    // Averages linear light, as a sensor does.
    cv::Vec3b rounded(bool clip) const {
      const Color mean = sum / static_cast<float>(std::max(rays, 1));
      const auto level = [&](int channel) {
        return static_cast<unsigned char>(std::lround(level_from_light(mean[channel], clip)));
      };
      return {level(2), level(1), level(0)};
    }
  };

  // Adds rays first..last-1 of the pixel.
  void trace(int row, int column, int first, int last, Pixel* pixel) const {
    const std::uint64_t hash =
        hash_bits(static_cast<std::uint64_t>(row), static_cast<std::uint64_t>(column));
    for (int number = first; number < last; ++number) {
      const std::optional<CameraRay> ray = ray_of(row, column, number, hash);
      pixel->add(ray ? room_.look(in_room(*ray), camera_.pixel_rad(), bodies_) : Color(0, 0, 0),
                 light_);
    }
  }

  std::optional<CameraRay> ray_of(int row, int column, int number, std::uint64_t hash) const {
    const Stratum in_pixel = stratum(number, hash);
    // Four random bits per ray for its position in the stratum.
    const std::uint64_t jitter = hash_bits(hash) >> (4 * number);
    const int part_u = 4 * in_pixel.column + static_cast<int>(jitter & 3);
    const int part_v = 4 * in_pixel.row + static_cast<int>((jitter >> 2) & 3);
    return camera_.at_part(column * kPixelParts + part_u, row * kPixelParts + part_v);
  }

  Ray in_room(const CameraRay& ray) const {
    return {origin_ + world_from_camera_ * ray.origin_m, world_from_camera_ * ray.direction};
  }

  const VirtualRoom& room_;
  const LightSettings& light_;
  const Bodies* bodies_;
  const PixelRays& camera_;
  Eigen::Vector3d origin_;
  Eigen::Matrix3d world_from_camera_;
};

}  // namespace

float level_from_light(float light, bool clip) {
  static const std::array<float, kTableSize + 1> soft = make_table(false);
  static const std::array<float, kTableSize + 1> clipped = make_table(true);
  const auto& table = clip ? clipped : soft;
  const float root = std::sqrt(std::clamp(light, 0.0F, static_cast<float>(kBrightest))) *
                     (static_cast<float>(kTableSize) / std::sqrt(static_cast<float>(kBrightest)));
  const int index = std::min(static_cast<int>(root), kTableSize - 1);
  const auto entry = static_cast<std::size_t>(index);
  return table[entry] + (root - static_cast<float>(index)) * (table[entry + 1] - table[entry]);
}

cv::Mat VirtualRoom::render(const PixelRays& camera, const CameraPose& pose,
                            const RenderOptions& options) const {
  require_free(pose.position_m);
  const std::unique_ptr<const Bodies> bodies = bodies_of(options, in_scene(pose));
  const PictureRenderer renderer(*this, camera, in_scene(pose), bodies.get());
  cv::Mat picture(camera.height(), camera.width(), CV_8UC3);
  parallel_for(0, picture.rows, 4, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) renderer.render_row(row, picture.ptr<cv::Vec3b>(row));
  });
  return picture;
}

}  // namespace raywalk::simulator
