#include "build_lf/refine/developed_station.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "build_lf/pack/volume_writer.h"
#include "build_lf/refine/developed_image.h"
#include "build_lf/refine/refine_plan.h"
#include "build_lf/refine/sharpening.h"
#include "core/files/atomic_output.h"
#include "core/geometry/sphere.h"
#include "core/panorama/transposed_border.h"
#include "core/room/distance_maps.h"
#include "core/room/hdf5_file.h"
#include "core/room/station_image.h"
#include "core/view/distance_view.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// A station's distances, negative where views would not use them, with their confidences.
struct OwnDistances {
  InverseMap inverse;
  std::vector<std::uint8_t> confidence;  // [theta][phi]
};

// Single pixels of low confidence in the midst of confident ones are more often right than what
// views would put in their place; where most are of low confidence, views know better
// (smooth_distances.h).
void believe_single_pixels(PanoramaSize size, std::vector<std::uint8_t>* confidence) {
  constexpr int kAround = 15;  // pixels
  cv::Mat all(size.width, size.height, CV_8U, confidence->data());
  cv::Mat share;
  cv::Mat(all >= kMinConfidence).convertTo(share, CV_32F, 1.0 / 255.0);
  share = with_border(share, kAround / 2);
  cv::blur(share, share, {kAround, kAround});
  share = without_border(share, kAround / 2);
  const cv::Mat believed = (all > 0) & (all < kMinConfidence) & (share > 0.5);
  all.setTo(kMinConfidence, believed);
}

// Its own map; without one, what the maps around it show.
OwnDistances distances_of(const Room& room, StationIndex station, const SourceView& view) {
  const DistanceVolume& volume = room.distances(station.line);
  const std::optional<int> map = volume.map_of(station.station);
  if (!map) {
    OwnDistances gathered{InverseMap(view.size()), {}};
    std::ranges::copy(view.inverse(), gathered.inverse.values().begin());
    gathered.confidence.assign(view.inverse().size(), kMinConfidence);
    return gathered;
  }
  OwnDistances distances{inverse_map_of(volume, *map), {}};
  for (int theta = 0; theta < volume.size().width; ++theta) {
    const auto column = volume.confidence_column(*map, theta);
    distances.confidence.insert(distances.confidence.end(), column.begin(), column.end());
  }
  believe_single_pixels(volume.size(), &distances.confidence);
  for (std::size_t pixel = 0; pixel < distances.confidence.size(); ++pixel) {
    if (distances.confidence[pixel] < kMinConfidence) distances.inverse.values()[pixel] = -1.0f;
  }
  return distances;
}

// What is stored of distances and confidences has fewer bits than there are: those would be the
// most of what a compressed room holds. A distance of `bits` is wrong by 2^-bits of it at most. A
// point at 1 m, seen from 1 m aside, then moves by a quarter of a pixel at most.
int bits_of_distances(int width) {
  return std::bit_width(static_cast<unsigned>(4 * width / kTwoPi));
}

float rounded(float value, int bits) {
  const int dropped = std::numeric_limits<float>::digits - bits;
  const auto up = std::bit_cast<std::uint32_t>(value) + (1u << (dropped - 1));
  return std::bit_cast<float>(up & ~((1u << dropped) - 1));
}

// Down to one of 16 levels.
std::uint8_t rounded(std::uint8_t confidence) {
  static_assert(kMinConfidence % 16 == 0);  // what views use they use still
  return confidence & 0xf0;
}

StationDistances stored_distances_of(const OwnDistances& own, const InverseMap& fine) {
  const PanoramaSize size = fine.size(), coarse = own.inverse.size();
  const int bits = bits_of_distances(size.width);
  StationDistances stored;
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      const float inverse = fine.at(theta, phi);
      const auto pixel = static_cast<std::size_t>(theta * coarse.width / size.width) *
                             static_cast<std::size_t>(coarse.height) +
                         static_cast<std::size_t>(phi * coarse.height / size.height);
      stored.distance_m.push_back(inverse < 0.0f   ? 0.0f
                                  : inverse > 0.0f ? rounded(1.0f / inverse, bits)
                                                   : std::numeric_limits<float>::infinity());
      stored.confidence.push_back(inverse < 0.0f ? std::uint8_t{0}
                                                 : rounded(own.confidence[pixel]));
    }
  }
  stored.sha256 = checksum_of_distances(stored.distance_m, stored.confidence);
  return stored;
}

// A station's photograph with the room's gains, and which of its pixels are neither masked nor,
// maybe, clipped.
struct OwnPhotograph {
  cv::Mat colours;
  cv::Mat1b comparable;
};

OwnPhotograph photograph_of(const Room& room, StationIndex station) {
  const PanoramaSize size = room.panorama();
  OwnPhotograph own{station_image(room, station, size), {}};
  cv::inRange(own.colours, cv::Scalar::all(2), cv::Scalar::all(253), own.comparable);
  const cv::Mat valid = station_validity(room, station, size, 2);
  if (!valid.empty()) own.comparable &= valid;
  if (!room.gains().empty()) {
    apply_gains(room.gains()[static_cast<std::size_t>(station.line)]
                            [static_cast<std::size_t>(station.station)],
                &own.colours);
  }
  return own;
}

// The values of a stored station are slabs of datasets of one slab.
template <typename T>
void write_values(Hdf5File* file, const char* name, ElementType type,
                  const std::vector<T>& values) {
  file->create_contiguous(name, type, {1, values.size()});
  file->write_slab(name, 0, values.data());
}

template <typename T>
std::vector<T> read_values(const Hdf5File& file, const char* name, ElementType type) {
  std::vector<T> values(file.shape_of(name).back());
  file.read_slab(name, 0, type, std::as_writable_bytes(std::span(values)));
  return values;
}

}  // namespace

DevelopedStation develop_station(const Room& room, const Exposure* exposure, StationIndex station,
                                 int width, SourceViews* views) {
  const OwnDistances own = distances_of(room, station, *views->of(station));
  const InverseMap fine = enlarged(own.inverse, width);
  std::vector<std::shared_ptr<const SourceView>> sources;
  for (const StationIndex source :
       sources_of(room.grid(), station, median_distance_m(own.inverse.values()))) {
    sources.push_back(views->of(source));
  }
  const DevelopedImage image = develop_image(room, exposure, station, fine, sources);
  DevelopedStation developed;
  const OwnPhotograph photograph = photograph_of(room, station);
  developed.sharpening =
      measured_sharpening(image.others, photograph.colours, photograph.comparable);
  const cv::Mat rays = sharpened(image.colour, room.panorama().width, developed.sharpening);
  developed.rays.rays.assign(rays.datastart, rays.dataend);
  if (room.masked()) developed.rays.valid_rows = valid_rows_of(image.is_known.t());
  developed.distances = stored_distances_of(own, fine);
  return developed;
}

void store_developed(const fs::path& file, const DevelopedStation& station,
                     const std::string& inputs) {
  AtomicFile output(file);
  Hdf5File hdf5 = Hdf5File::create(output.temporary_path());
  hdf5.write_attribute("/", kInputsAttribute, inputs);
  hdf5.write("sharpening", std::vector{station.sharpening});
  write_values(&hdf5, "rays", ElementType::kUint8, station.rays.rays);
  write_values(&hdf5, "distance_m", ElementType::kFloat32, station.distances.distance_m);
  write_values(&hdf5, "confidence", ElementType::kUint8, station.distances.confidence);
  if (!station.rays.valid_rows.empty()) {
    write_values(&hdf5, "valid_rows", ElementType::kInt32, station.rays.valid_rows);
  }
  hdf5.close();
  output.commit();
}

StationRays developed_rays(const fs::path& file) {
  const Hdf5File hdf5 = Hdf5File::open(file);
  StationRays rays{read_values<std::uint8_t>(hdf5, "rays", ElementType::kUint8)};
  if (hdf5.has_dataset("valid_rows")) {
    rays.valid_rows = read_values<std::int32_t>(hdf5, "valid_rows", ElementType::kInt32);
  }
  return rays;
}

StationDistances developed_distances(const fs::path& file) {
  const Hdf5File hdf5 = Hdf5File::open(file);
  StationDistances distances{read_values<float>(hdf5, "distance_m", ElementType::kFloat32),
                             read_values<std::uint8_t>(hdf5, "confidence", ElementType::kUint8),
                             {}};
  distances.sha256 = checksum_of_distances(distances.distance_m, distances.confidence);
  return distances;
}

double developed_sharpening(const fs::path& file) {
  return Hdf5File::open(file).read<double>("sharpening").at(0);
}

InverseMap enlarged(const InverseMap& map, int width) {
  InverseMap fine = resized(map, width);
  const int factor = width / map.size().width;
  if (factor < 2) return fine;
  // Of n x n pixels a line of `factor` pixels is more than half for n = 2 factor - 1; of floats
  // OpenCV has medians of up to 5 x 5.
  const int window = factor == 2 ? 3 : 5;
  constexpr int kBorder = 2;
  const PanoramaSize size = fine.size();
  cv::Mat inverse(size.width, size.height, CV_32F, fine.values().data());
  cv::Mat smooth = with_border(inverse, kBorder);
  cv::medianBlur(smooth, smooth, window);
  without_border(smooth, kBorder).copyTo(inverse);
  return fine;
}

}  // namespace raywalk::build_lf
