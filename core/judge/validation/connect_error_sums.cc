#include "core/judge/validation/connect_error_sums.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace raywalk {
namespace {

using nlohmann::ordered_json;

constexpr int kLowBits = 32;
constexpr std::uint64_t kLowMask = (std::uint64_t{1} << kLowBits) - 1;

ordered_json json_of(const OverlapSum& sum) {
  return {sum.squared_difference.high, sum.squared_difference.low, sum.columns};
}

std::int64_t count_from(const CheckedJson& json) {
  return static_cast<std::int64_t>(json.unsigned_integer());
}

OverlapSum overlap_sum_from(const CheckedJson& json) {
  const std::vector<CheckedJson> numbers = json.items(3);
  return {.squared_difference = {numbers[0].unsigned_integer(), numbers[1].unsigned_integer()},
          .columns = count_from(numbers[2])};
}

}  // namespace

void WideSum::add(std::uint64_t value) { add(WideSum{value >> kLowBits, value & kLowMask}); }

void WideSum::add(const WideSum& other) {
  low += other.low;
  high += other.high + (low >> kLowBits);
  low &= kLowMask;
}

double WideSum::value() const {
  return std::ldexp(static_cast<double>(high), kLowBits) + static_cast<double>(low);
}

void OverlapSum::add_column(std::uint64_t squared_difference_of_it) {
  squared_difference.add(squared_difference_of_it);
  ++columns;
}

void OverlapSum::add(const OverlapSum& other) {
  squared_difference.add(other.squared_difference);
  columns += other.columns;
}

double OverlapSum::mean(int samples_per_column) const {
  if (columns == 0) return std::numeric_limits<double>::quiet_NaN();
  return squared_difference.value() / (static_cast<double>(columns) * samples_per_column);
}

void ConnectErrorSums::add_pair(std::span<const OverlapSum> pair) {
  ++pairs;
  const bool common =
      std::ranges::all_of(pair, [](const OverlapSum& sum) { return sum.columns > 0; });
  if (common) ++common_pairs;
  for (std::size_t k = 0; k < pair.size(); ++k) {
    at_k[k].all.add(pair[k]);
    if (common) at_k[k].common.add(pair[k]);
    if (pair[k].columns > 0) ++at_k[k].pairs;
  }
}

void ConnectErrorSums::add(const ConnectErrorSums& other) {
  pairs += other.pairs;
  common_pairs += other.common_pairs;
  for (std::size_t k = 0; k < at_k.size(); ++k) {
    at_k[k].all.add(other.at_k[k].all);
    at_k[k].common.add(other.at_k[k].common);
    at_k[k].pairs += other.at_k[k].pairs;
  }
}

ordered_json json_of(const ConnectErrorSums& sums) {
  ordered_json list = ordered_json::array();
  for (const ConnectErrorSums::AtK& at_k : sums.at_k) {
    list.push_back(
        {{"all", json_of(at_k.all)}, {"common", json_of(at_k.common)}, {"pairs", at_k.pairs}});
  }
  return {{"pairs", sums.pairs}, {"common_pairs", sums.common_pairs}, {"at_k", std::move(list)}};
}

ConnectErrorSums connect_error_sums_from(const CheckedJson& json, std::size_t k_count) {
  ConnectErrorSums sums(k_count);
  sums.pairs = count_from(json.at("pairs"));
  sums.common_pairs = count_from(json.at("common_pairs"));
  const std::vector<CheckedJson> list = json.at("at_k").items(k_count);
  for (std::size_t k = 0; k < k_count; ++k) {
    sums.at_k[k] = {.all = overlap_sum_from(list[k].at("all")),
                    .common = overlap_sum_from(list[k].at("common")),
                    .pairs = count_from(list[k].at("pairs"))};
  }
  return sums;
}

}  // namespace raywalk
