#include "core/view/gain_rows.h"

#include <algorithm>
#include <opencv2/core.hpp>

#include "core/panorama/transposed_border.h"
#include "core/view/sample_reader.h"

namespace raywalk {
namespace {

// Gains vary slowly over a picture: they are looked up at every eighth row and linear in between.
constexpr int kRowsPerNode = 8;

std::array<StationShare, 2> shares_of(const RowSamples& samples) {
  const float second = static_cast<float>(samples.share) / 32768.0F;
  return {{{samples.line, samples.station[0], samples.count == 2 ? 1.0F - second : 1.0F},
           {samples.line, samples.station[1], second}}};
}

void interpolate(const float* from, const float* to, int rows, float* factors) {
  for (int row = 0; row < rows; ++row) {
    const float share = static_cast<float>(row) / static_cast<float>(rows);
    for (int c = 0; c < 3; ++c) factors[3 * row + c] = from[c] + share * (to[c] - from[c]);
  }
}

}  // namespace

RoomGains::RoomGains(const Room& room) : panorama_(room.panorama()), polar_part_(room.panorama()) {
  for (const auto& line : room.gains()) {
    auto& fields = fields_.emplace_back();
    for (const GainField& field : line) {
      fields.emplace_back();
      if (raywalk::is_one(field)) continue;
      const cv::Scalar whole(field.whole[0], field.whole[1], field.whole[2]);
      cv::Mat factors =
          field.local.empty() ? cv::Mat(1, 1, CV_32FC3, cv::Scalar::all(1.0)) : field.local.clone();
      cv::multiply(factors, whole, factors);
      fields.back() = with_border(factors, 1);
    }
  }
}

void RoomGains::add(int line, int station, float share, float u, float v, float* rgb) const {
  const cv::Mat& factors = field(line, station);
  if (factors.empty()) {
    for (int c = 0; c < 3; ++c) rgb[c] += share;
    return;
  }
  // From the middle of a pixel to that of a patch, which is 1 more because of the border.
  const float theta = u * static_cast<float>(factors.rows - 2) + 0.5F;
  const float phi = v * static_cast<float>(factors.cols - 2) + 0.5F;
  const int column = std::clamp(static_cast<int>(theta), 0, factors.rows - 2);
  const int row = std::clamp(static_cast<int>(phi), 0, factors.cols - 2);
  const float right = theta - static_cast<float>(column);
  const float lower = phi - static_cast<float>(row);
  const auto* left_column = factors.ptr<cv::Vec3f>(column) + row;
  const auto* right_column = factors.ptr<cv::Vec3f>(column + 1) + row;
  for (int c = 0; c < 3; ++c) {
    const float at_left = left_column[0][c] + lower * (left_column[1][c] - left_column[0][c]);
    const float at_right = right_column[0][c] + lower * (right_column[1][c] - right_column[0][c]);
    rgb[c] += share * (at_left + right * (at_right - at_left));
  }
}

bool GainRows::change(std::span<const StationShare> shares) const {
  if (gains_ == nullptr) return false;
  return std::ranges::any_of(shares, [&](const StationShare& share) {
    return !gains_->is_one(share.line, share.station);
  });
}

bool GainRows::change(const RowSamples& samples) const {
  if (gains_ == nullptr) return false;
  const auto shares = shares_of(samples);
  return change(std::span(shares).first(static_cast<std::size_t>(samples.count)));
}

template <typename Place>
void GainRows::multiply(std::span<const StationShare> shares, int rows, const Place& place,
                        std::uint8_t* rgb) {
  if (!change(shares) || rows == 0) return;
  const PanoramaSize size = gains_->panorama();
  const auto gain_at = [&](int row) {
    std::array<float, 3> gain{};
    for (std::size_t i = 0; i < shares.size(); ++i) {
      const cv::Point at = place(i, row);
      gains_->add(shares[i].line, shares[i].station, shares[i].share,
                  (static_cast<float>(at.x) + 0.5F) / static_cast<float>(size.width),
                  (static_cast<float>(at.y) + 0.5F) / static_cast<float>(size.height), gain.data());
    }
    return gain;
  };
  factors_.resize(3 * static_cast<std::size_t>(rows));
  std::array<float, 3> gain = gain_at(0);
  std::copy(gain.begin(), gain.end(), factors_.end() - 3);
  for (int row = 0; row < rows - 1;) {
    const int next = std::min(row + kRowsPerNode, rows - 1);
    const std::array<float, 3> gain_next = gain_at(next);
    interpolate(gain.data(), gain_next.data(), next - row, factors_.data() + 3 * row);
    std::copy(gain_next.begin(), gain_next.end(), factors_.data() + 3 * next);
    gain = gain_next;
    row = next;
  }
  const float* const factors = factors_.data();
  // Not lround(), which is not vectorised; levels are not negative.
  constexpr float kToNearest = 0.5F;
  for (int i = 0; i < 3 * rows; ++i) {
    const int level = static_cast<int>(static_cast<float>(rgb[i]) * factors[i] + kToNearest);
    rgb[i] = static_cast<std::uint8_t>(std::min(level, 255));
  }
}

void GainRows::apply(const RowSamples& samples, std::uint8_t* rgb) {
  if (gains_ == nullptr) return;
  const auto shares = shares_of(samples);
  const auto place = [&](std::size_t i, int row) {
    const RayPlace at = gains_->place_of(samples.at[i].positions.offset_left[row]);
    return cv::Point(at.column, at.row);
  };
  multiply(std::span(shares).first(static_cast<std::size_t>(samples.count)), samples.rows, place,
           rgb);
}

void GainRows::apply_stored(std::span<const StationShare> shares, int u, int first_row, int rows,
                            std::uint8_t* rgb) {
  multiply(
      shares, rows, [=](std::size_t, int row) { return cv::Point(u, first_row + row); }, rgb);
}

}  // namespace raywalk
