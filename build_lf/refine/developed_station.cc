#include "build_lf/refine/developed_station.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "core/room/station_image.h"
#include "build_lf/refine/developed_image.h"
#include "build_lf/refine/refine_plan.h"
#include "build_lf/refine/sharpening.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/geometry/sphere.h"
#include "core/panorama/transposed_border.h"
#include "core/room/distance_maps.h"
#include "core/view/distance_view.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// A station's distances, negative where views would not use them, with their confidences.
struct OwnDistances {
  OmegaMap omega;
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
  const auto maps = volume.stations();
  const auto own = std::ranges::lower_bound(maps, station.station);
  if (own == maps.end() || *own != station.station) {
    OwnDistances gathered{OmegaMap(view.size()), {}};
    std::ranges::copy(view.inverse(), gathered.omega.values().begin());
    gathered.confidence.assign(view.inverse().size(), kMinConfidence);
    return gathered;
  }
  const auto map = static_cast<int>(own - maps.begin());
  OwnDistances distances{omega_map_of(volume, map), {}};
  for (int theta = 0; theta < volume.size().width; ++theta) {
    const auto column = volume.confidence_column(map, theta);
    distances.confidence.insert(distances.confidence.end(), column.begin(), column.end());
  }
  believe_single_pixels(volume.size(), &distances.confidence);
  for (std::size_t pixel = 0; pixel < distances.confidence.size(); ++pixel) {
    if (distances.confidence[pixel] < kMinConfidence) distances.omega.values()[pixel] = -1.0f;
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

StationDistances stored_distances_of(const OwnDistances& own, const OmegaMap& fine) {
  const PanoramaSize size = fine.size(), coarse = own.omega.size();
  const int bits = bits_of_distances(size.width);
  StationDistances stored;
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      const float omega = fine.at(theta, phi);
      const auto pixel = static_cast<std::size_t>(theta * coarse.width / size.width) *
                             static_cast<std::size_t>(coarse.height) +
                         static_cast<std::size_t>(phi * coarse.height / size.height);
      stored.distance_m.push_back(omega < 0.0f   ? 0.0f
                                  : omega > 0.0f ? rounded(1.0f / omega, bits)
                                                 : std::numeric_limits<float>::infinity());
      stored.confidence.push_back(omega < 0.0f ? std::uint8_t{0} : rounded(own.confidence[pixel]));
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

void read_into(std::string_view* text, void* to, std::size_t bytes, const fs::path& file) {
  if (text->size() < bytes) {
    throw Error(fmt::format("{}: is cut off; remove it and run the command again", file.string()));
  }
  std::memcpy(to, text->data(), bytes);
  text->remove_prefix(bytes);
}

template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

}  // namespace

DevelopedStation develop_station(const Room& room, const Exposure* exposure, StationIndex station,
                                 int width, SourceViews* views) {
  const OwnDistances own = distances_of(room, station, *views->of(station));
  const OmegaMap fine = enlarged(own.omega, width);
  std::vector<std::shared_ptr<const SourceView>> sources;
  for (const StationIndex source :
       sources_of(room.grid(), station, median_distance_m(own.omega.values()))) {
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

void store_developed(const fs::path& file, const DevelopedStation& station) {
  std::string text(reinterpret_cast<const char*>(&station.sharpening), sizeof(double));
  text += bytes_of(station.rays.rays);
  text += bytes_of(station.distances.distance_m);
  text += bytes_of(station.distances.confidence);
  text += bytes_of(station.rays.valid_rows);
  write_file_atomically(file, text);
}

DevelopedStation load_developed(const fs::path& file, int width) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(width / 2);
  const std::string text =
      read_file(file, sizeof(double) + 8 * pixels + 8 * static_cast<std::size_t>(width));
  std::string_view left = text;
  DevelopedStation station;
  station.rays.rays.resize(3 * pixels);
  station.distances.distance_m.resize(pixels);
  station.distances.confidence.resize(pixels);
  read_into(&left, &station.sharpening, sizeof(double), file);
  read_into(&left, station.rays.rays.data(), 3 * pixels, file);
  read_into(&left, station.distances.distance_m.data(), sizeof(float) * pixels, file);
  read_into(&left, station.distances.confidence.data(), pixels, file);
  if (!left.empty()) {
    station.rays.valid_rows.resize(2 * static_cast<std::size_t>(width));
    read_into(&left, station.rays.valid_rows.data(), left.size(), file);
  }
  station.distances.sha256 =
      checksum_of_distances(station.distances.distance_m, station.distances.confidence);
  return station;
}

double stored_sharpening(const fs::path& file) {
  double sharpening = 0.0;
  std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(&sharpening), sizeof(double));
  return sharpening;
}

OmegaMap enlarged(const OmegaMap& map, int width) {
  OmegaMap fine = resized(map, width);
  const int factor = width / map.size().width;
  if (factor < 2) return fine;
  // Of n x n pixels a line of `factor` pixels is more than half for n = 2 factor - 1; of floats
  // OpenCV has medians of up to 5 x 5.
  const int window = factor == 2 ? 3 : 5;
  constexpr int kBorder = 2;
  const PanoramaSize size = fine.size();
  cv::Mat omega(size.width, size.height, CV_32F, fine.values().data());
  cv::Mat smooth = with_border(omega, kBorder);
  cv::medianBlur(smooth, smooth, window);
  without_border(smooth, kBorder).copyTo(omega);
  return fine;
}

}  // namespace raywalk::build_lf
