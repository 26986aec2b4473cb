#include "render/serve/view_request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string_view>

#include "core/base/error.h"
#include "core/files/words.h"
#include "render/serve/web_server.h"

namespace raywalk::render {
namespace {

constexpr std::array<std::string_view, 12> kParameters{
    "x", "y", "z", "yaw", "pitch", "roll", "fov", "width", "height", "method", "k", "format"};

constexpr std::array<std::string_view, 2> kFormats{"jpg", "png"};

struct Bounds {
  double least = 0.0;
  double most = 0.0;
};

constexpr Bounds kMetres{-1e6, 1e6};
constexpr Bounds kTurns{-36000.0, 36000.0};  // require_viewport's hundred turns

using Query = std::multimap<std::string, std::string>;

[[noreturn]] void refuse(const std::string& sentence) { throw HttpFault(400, sentence); }

// None where it is not given.
std::optional<std::string> query_value(const Query& query, const std::string& name) {
  const auto [first, end] = query.equal_range(name);
  if (first == end) return std::nullopt;
  if (std::next(first) != end) refuse(name + " is given twice; give it once");
  return first->second;
}

std::optional<double> number_of(const Query& query, const char* name, Bounds bounds) {
  const std::optional<std::string> text = query_value(query, name);
  if (!text) return std::nullopt;
  const std::optional<double> value = parse_finite_number(*text);
  if (!value || *value < bounds.least || *value > bounds.most) {
    refuse(fmt::format("{} is {}; it must be a number from {:g} to {:g}", name, excerpt(*text),
                       bounds.least, bounds.most));
  }
  return value;
}

double required_metres(const Query& query, const char* name) {
  const std::optional<double> value = number_of(query, name, kMetres);
  if (!value) refuse(fmt::format("{} is missing; give the viewpoint as x and z in metres", name));
  return *value;
}

std::optional<int> pixels_of(const Query& query, const char* name) {
  const std::optional<std::string> text = query_value(query, name);
  if (!text) return std::nullopt;
  const std::optional<int> value = parse_whole_number(*text);
  if (!value || *value < 1 || *value > kMostServedSide_px) {
    refuse(fmt::format("{} is {}; it must be a whole number of pixels from 1 to {}", name,
                       excerpt(*text), kMostServedSide_px));
  }
  return value;
}

template <typename Names>
std::optional<std::string> choice_of(const Query& query, const char* name, const Names& choices) {
  std::optional<std::string> value = query_value(query, name);
  if (value && std::none_of(choices.begin(), choices.end(),
                            [&](std::string_view choice) { return choice == *value; })) {
    refuse(fmt::format("{} is {}; it must be one of {}", name, excerpt(*value),
                       fmt::join(choices, ", ")));
  }
  return value;
}

void require_known(const Query& query) {
  for (const auto& [name, value] : query) {
    if (std::find(kParameters.begin(), kParameters.end(), name) == kParameters.end()) {
      refuse(fmt::format("{} is not a parameter of views; they are {}", excerpt(name),
                         fmt::join(kParameters, ", ")));
    }
  }
}

void read_size(const Query& query, ViewRequest* request) {
  const std::optional<double> fov_deg = number_of(query, "fov", {0.0, kMaxFovDeg});
  const std::optional<int> width = pixels_of(query, "width");
  const std::optional<int> height = pixels_of(query, "height");
  if (!fov_deg) {
    if (height) refuse("height is for a flat picture; give fov, or the width alone for a panorama");
    if (width && *width % 4 != 0) {
      refuse(fmt::format("width is {}; of a panorama it must be a multiple of 4", *width));
    }
    request->panorama_width_px = width.value_or(0);
    return;
  }
  if (*fov_deg == 0.0) refuse("fov is 0; it must be above 0 degrees");
  const int w = width.value_or(1280);
  const int h = height.value_or(720);
  if (static_cast<std::int64_t>(w) * h > kMostServedPixels) {
    refuse(
        fmt::format("width x height is {} x {}; {} pixels are the most", w, h, kMostServedPixels));
  }
  request->frame.fov_deg = *fov_deg;
  request->frame.size = fmt::format("{}x{}", w, h);
}

}  // namespace

ViewRequest parse_view_request(const Query& query) {
  require_known(query);
  ViewRequest request;
  request.viewpoint = {required_metres(query, "x"), required_metres(query, "z")};
  request.up_m = number_of(query, "y", kMetres).value_or(0.0);
  request.frame.yaw_deg = number_of(query, "yaw", kTurns).value_or(0.0);
  request.frame.pitch_deg = number_of(query, "pitch", kTurns).value_or(0.0);
  request.frame.roll_deg = number_of(query, "roll", kTurns).value_or(0.0);
  read_size(query, &request);
  if (const auto name = choice_of(query, "method", kViewMethodNames)) {
    request.method = method_from_name(*name);
  }
  request.k_deg = number_of(query, "k", {45.0, 90.0});
  request.png = choice_of(query, "format", kFormats).value_or("jpg") == "png";
  return request;
}

}  // namespace raywalk::render
