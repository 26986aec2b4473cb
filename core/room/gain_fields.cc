#include "core/room/gain_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <span>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/panorama/transposed_border.h"
#include "core/room/distance_volume.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

constexpr double kLeastGain = 1.0 / 16.0;
constexpr double kMostGain = 16.0;

std::string sha256_of(const Grid& grid) {
  std::string text;
  for (const Line& line : grid.lines) text += sha256_of(line);
  return sha256_hex(text);
}

std::string sha256_of(const std::vector<double>& values) {
  return sha256_hex(std::as_bytes(std::span(values)));
}

// The size of the local fields; one patch if no station has any.
cv::Size patches_of(const GainFields& fields) {
  for (const auto& line : fields) {
    for (const GainField& field : line) {
      if (!field.local.empty()) return field.local.size();
    }
  }
  return {1, 1};
}

void append(const GainField& field, cv::Size patches, std::vector<double>* values) {
  const cv::Mat_<cv::Vec3f> local = field.local.empty()
                                        ? cv::Mat_<cv::Vec3f>(patches, cv::Vec3f::all(1.0F))
                                        : cv::Mat_<cv::Vec3f>(field.local);
  for (const cv::Vec3f& patch : local) {
    for (int c = 0; c < 3; ++c) values->push_back(static_cast<double>(field.whole[c] * patch[c]));
  }
}

// The field of one station; without local factors if all its patches are alike.
GainField field_from(std::span<const double> values, int thetas, int phis) {
  cv::Mat local(thetas, phis, CV_32FC3);
  std::ranges::transform(values, local.ptr<float>(),
                         [](double value) { return static_cast<float>(value); });
  GainField field;
  if (std::ranges::equal(values.subspan(3), values.first(values.size() - 3))) {
    field.whole = local.at<cv::Vec3f>(0, 0);
  } else {
    field.local = local;
  }
  return field;
}

Shape shape_of_gains(const Hdf5File& hdf5, std::size_t stations) {
  Shape shape = hdf5.shape_of("gain");
  constexpr std::size_t kMostPatches = 4096;
  if (shape.size() != 4 || shape[0] != stations || shape[1] < 1 || shape[2] < 1 ||
      shape[1] > kMostPatches || shape[2] > kMostPatches || shape[3] != 3) {
    throw Error(fmt::format("{}: 'gain' is not [{} stations][theta][phi][3]", hdf5.path().string(),
                            stations));
  }
  return shape;
}

}  // namespace

void apply_gains(const GainField& gains, cv::Mat* colours) {
  const ColourGain& whole = gains.whole;
  const cv::Scalar factors(whole[0], whole[1], whole[2]);
  if (gains.local.empty()) {
    cv::multiply(*colours, factors, *colours);
    return;
  }
  // With a border of one patch, interpolation crosses the seam and the poles.
  const cv::Mat bordered = with_border(gains.local, 1);
  const double patches_phi = static_cast<double>(gains.local.cols) / colours->cols;
  const double patches_theta = static_cast<double>(gains.local.rows) / colours->rows;
  // From the middle of a pixel to that of a patch, which is 1 more because of the border.
  const cv::Matx23d patch_from_pixel(patches_phi, 0.0, 0.5 * patches_phi + 0.5,  //
                                     0.0, patches_theta, 0.5 * patches_theta + 0.5);
  cv::Mat field;
  cv::warpAffine(bordered, field, patch_from_pixel, colours->size(),
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  cv::Mat levels;
  colours->convertTo(levels, CV_32F);
  cv::multiply(levels, field, levels);
  cv::multiply(levels, factors, levels);
  levels.convertTo(*colours, CV_8U);
}

GainFields unit_gain_fields(const Grid& grid) {
  GainFields fields;
  for (const Line& line : grid.lines) fields.emplace_back(line.stations.size());
  return fields;
}

bool is_one(const GainField& field) {
  return field.whole == ColourGain(1.0F, 1.0F, 1.0F) && field.local.empty();
}

std::filesystem::path gains_path(const std::filesystem::path& room) { return room / "gains.h5"; }

void write_gain_fields(const std::filesystem::path& file, const Grid& grid,
                       const GainFields& fields) {
  const cv::Size patches = patches_of(fields);
  std::vector<double> values;
  for (const auto& line : fields) {
    for (const GainField& field : line) append(field, patches, &values);
  }
  for (double& value : values) value = std::clamp(value, kLeastGain, kMostGain);
  const auto thetas = static_cast<std::size_t>(patches.height);
  const auto phis = static_cast<std::size_t>(patches.width);
  AtomicFile output(file);
  Hdf5File hdf5 = Hdf5File::create(output.temporary_path());
  hdf5.write_format(kGainsFormat);
  hdf5.write_attribute("/", "stations_sha256", sha256_of(grid));
  hdf5.write_attribute("/", "sha256", sha256_of(values));
  hdf5.write("gain", values, {values.size() / (3 * thetas * phis), thetas, phis, 3});
  hdf5.write_attribute("gain", "axes", "station of all lines in order, theta, phi, rgb");
  hdf5.write_attribute("gain", "unit", "factor of the 8-bit levels");
  hdf5.close();
  output.commit();
}

GainFields read_gain_fields(const std::filesystem::path& file, const Grid& grid) {
  const Hdf5File hdf5 = Hdf5File::open(file);
  hdf5.require_format(kGainsFormat);
  if (hdf5.text_attribute("stations_sha256") != sha256_of(grid)) {
    throw Error(file.string() + ": holds the gains of other stations than the room has");
  }
  std::size_t stations = 0;
  for (const Line& line : grid.lines) stations += line.stations.size();
  const Shape shape = shape_of_gains(hdf5, stations);
  const auto values = hdf5.read<double>("gain");
  const auto in_range = [](double value) { return value >= kLeastGain && value <= kMostGain; };
  if (!std::ranges::all_of(values, in_range) ||
      hdf5.text_attribute("sha256") != sha256_of(values)) {
    throw Error(file.string() + ": its gains are damaged");
  }
  const std::size_t of_station = 3 * shape[1] * shape[2];
  GainFields fields;
  std::size_t next = 0;
  for (const Line& line : grid.lines) {
    auto& of_line = fields.emplace_back();
    for (std::size_t i = 0; i < line.stations.size(); ++i, next += of_station) {
      of_line.push_back(field_from(std::span(values).subspan(next, of_station),
                                   static_cast<int>(shape[1]), static_cast<int>(shape[2])));
    }
  }
  return fields;
}

}  // namespace raywalk
