#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"
#include "core/view/column_rows.h"
#include "core/view/mixing_scratch.h"

namespace raywalk {

void StationMixing::render_edges(const Column& column, RowRun rows, std::uint8_t* bgr) {
  if (column.edges.empty() || column.reads.empty()) return;
  Scratch& s = *scratch_;
  const double per_distance = view_.rows.per_distance;
  const bool four = per_distance < 1.5;
  const bool on_left = column.right < 0.0f;  // of the middle of the pixel of the distances
  // Samples in a row of the quarters; two for each output pixel if it has four.
  std::array<const EdgeQuarter*, kRows> quarters;
  std::array<float, kRows> places;
  std::array<int, kRows> output;
  std::size_t count = 0, pixels = 0;
  const auto sample = [&] {
    std::fill_n(s.sum.begin(), count, cv::Vec4i());
    const std::span used(quarters.data(), count);
    const std::span used_places(places.data(), count);
    if (four) {
      sample_quarters(column, column.u - 0.25, used, used_places);
      for (const EdgeQuarter*& quarter : used) quarter += 2;  // those on the right
      sample_quarters(column, column.u + 0.25, used, used_places);
      for (std::size_t i = 0; i < pixels; ++i) s.sum[i] = s.sum[2 * i] + s.sum[2 * i + 1];
    } else {
      sample_quarters(column, column.u, used, used_places);
    }
    for (std::size_t i = 0; i < pixels; ++i) {
      const cv::Vec4i& sum = s.sum[i];
      if (sum[3] == 0) continue;
      std::uint8_t* const pixel = bgr + (output[i] - rows.begin) * kStride;
      for (int c = 0; c < 3; ++c) {
        pixel[c] = static_cast<std::uint8_t>((pixel[c] * sum[3] + sum[c] + sum[3]) / (2 * sum[3]));
      }
    }
    count = pixels = 0;
  };
  const int first = view_.rows.nearest[static_cast<std::size_t>(rows.begin)];
  for (auto edge = std::ranges::lower_bound(column.edges, first, {}, &EdgePixel::row);
       edge != column.edges.end(); ++edge) {
    const auto distance_row = static_cast<std::size_t>(edge->row);
    const int end = std::min(view_.rows.first[distance_row + 1], rows.end);
    for (int row = std::max(view_.rows.first[distance_row], rows.begin); row < end; ++row) {
      if (count + 2 > kRows) sample();
      output[pixels++] = row;
      if (four) {
        for (const std::size_t lower : {0, 1}) {
          quarters[count] = &edge->quarter[lower];
          places[count++] = static_cast<float>(row) + (lower == 0 ? -0.25f : 0.25f);
        }
      } else {
        const bool upper = (row + 0.5) / per_distance - 0.5 < edge->row;
        quarters[count] = &edge->quarter[(on_left ? 0U : 2U) + (upper ? 0U : 1U)];
        places[count++] = static_cast<float>(row);
      }
    }
  }
  if (count > 0) sample();
}

// Adds samples of quarters to Scratch::sum. `u`, `rows`: their places in the output.
void StationMixing::sample_quarters(const Column& column, double u,
                                    std::span<const EdgeQuarter* const> quarters,
                                    std::span<const float> rows) {
  Scratch& s = *scratch_;
  const int captured = view_.room.panorama().width;
  std::array<int, kRows> distance_rows;
  for (std::size_t i = 0; i < quarters.size(); ++i) {
    const auto row = static_cast<int>(std::lround(rows[i]));
    const Latitude latitude = view_.latitudes.beside(row, rows[i] - static_cast<float>(row));
    s.sin_phi[i] = latitude.sin_phi;
    s.cos_phi[i] = latitude.cos_phi;
    s.point_inverse[i] = quarters[i]->inverse;
    distance_rows[i] =
        std::clamp(static_cast<int>(std::floor((rows[i] + 0.5) / view_.rows.per_distance)), 0,
                   view_.distances.size().height - 1);
  }
  find_shares(column, quarters, std::span(distance_rows).first(quarters.size()));
  const auto count = static_cast<int>(quarters.size());
  const Points points{.theta_rad = theta_of_column(u, view_.output.width),
                      .eye_m = column.eye_m,
                      .captured = column.captured + static_cast<float>((u - column.u) * captured /
                                                                       view_.output.width),
                      .count = count,
                      .sin_phi = s.sin_phi.data(),
                      .cos_phi = s.cos_phi.data(),
                      .inverse = s.point_inverse.data()};
  s.points.count = 0;
  for (std::size_t k = 0; k < column.reads.size(); ++k) {
    if (!normalise(s.weight[k].data(), s.total.data(), count, s.row_weight.data())) continue;
    place_points(points, s.row_weight.data(), column.reads[k], &s.points);
  }
  // Whole groups of four are faster; the last ones are of earlier points.
  mix(column.any_masks, (count + 3) / 4 * 4, &s.points, nullptr, s.colour.data(), 4);
  for (std::size_t i = 0; i < quarters.size(); ++i) {
    constexpr float kUnseen = 1e-6f;  // a trace (add_share()): stations show something else there
    if (s.total[i] < kUnseen || (column.any_masks && s.points.total[i] == 0.0f)) continue;
    const std::uint8_t* const bgr = s.colour.data() + 4 * i;
    s.sum[i] += cv::Vec4i(bgr[0], bgr[1], bgr[2], 1);
  }
}

// The weights of all stations for quarters, which are seen as the pixels are whose surfaces they
// are on, and their totals.
void StationMixing::find_shares(const Column& column, std::span<const EdgeQuarter* const> quarters,
                                std::span<const int> distance_rows) {
  Scratch& s = *scratch_;
  const PanoramaSize size = view_.distances.size();
  for (std::size_t source = 0; source < column.sources.count; ++source) {
    const ColumnSource& of = column.sources.source[source];
    std::array<const std::uint8_t*, 3> around;
    std::size_t i = 0;
    for (const int beside : {-1, 0, 1}) {
      const std::uint8_t* const other = view_.visibility.occluded_as(
          column.nearest, wrapped_column(column.nearest + beside, size.width), of.at.line,
          of.behind());
      around[i++] = other == nullptr ? column.occluded[source] : other;
    }
    for (std::size_t q = 0; q < quarters.size(); ++q) {
      const int row = std::clamp(distance_rows[q] + quarters[q]->down, 0, size.height - 1);
      const int beside = quarters[q]->right + 1;
      s.occluded[source][q] = around[static_cast<std::size_t>(beside)][row];
    }
  }
  for (std::size_t i = 0; i < quarters.size() && column.trust != nullptr; ++i) {
    s.trust[i] = column.trust[distance_rows[i]];
  }
  std::array<const std::uint8_t*, kMaxSources> occluded{};
  for (std::size_t i = 0; i < column.sources.count; ++i) occluded[i] = s.occluded[i].data();
  find_weights(column, occluded, column.trust == nullptr ? nullptr : s.trust.data(),
               static_cast<int>(quarters.size()));
}

}  // namespace raywalk
