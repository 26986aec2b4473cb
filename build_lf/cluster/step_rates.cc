#include "build_lf/cluster/step_rates.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "core/base/error.h"
#include "core/files/words.h"

namespace raywalk::build_lf {
namespace {

const StepRate* find_rate(std::string_view step) {
  const auto* found = std::ranges::find(kStepRates, step, &StepRate::step);
  return found == kStepRates.end() ? nullptr : found;
}

std::string all_steps() {
  std::string names;
  for (const StepRate& rate : kStepRates) {
    names += (names.empty() ? "" : ", ") + std::string(rate.step);
  }
  return names;
}

}  // namespace

double rate_of(std::string_view step, const GivenRates& given) {
  if (const auto own = given.find(std::string(step)); own != given.end()) return own->second;
  const StepRate* rate = find_rate(step);
  if (rate == nullptr) throw std::logic_error("no rate of " + std::string(step));
  return rate->mpx_per_s;
}

GivenRates parse_rates(const std::string& text) {
  GivenRates rates;
  std::istringstream stream(text);
  for (std::string item; std::getline(stream, item, ',');) {
    const size_t equals = item.find('=');
    const std::string step = item.substr(0, equals);
    if (find_rate(step) == nullptr) {
      throw UsageError("--rates: unknown step " + excerpt(step) + "; use " + all_steps());
    }
    const auto rate =
        equals == std::string::npos ? std::nullopt : parse_finite_number(item.substr(equals + 1));
    if (!rate || *rate <= 0.0) {
      throw UsageError("--rates: give " + step + "=MEGAPIXELS, a number above 0 per second");
    }
    rates[step] = *rate;
  }
  return rates;
}

}  // namespace raywalk::build_lf
