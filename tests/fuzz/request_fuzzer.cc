// Whatever a client of `raywalk-render serve` asks for is understood, within the limits that the
// server relies on, or refused with a one-line HttpFault. libmicrohttpd reads the request itself.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>

#include "render/serve/byte_range.h"
#include "render/serve/view_request.h"
#include "render/serve/web_server.h"
#include "tests/fuzz/expect.h"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void check_range(const std::string& value, std::uint64_t size) {
  const auto range = raywalk::render::parse_byte_range(value, size);
  require(!range || range->first > range->last || range->last < size);
}

void check_view(const std::string& text) {
  std::multimap<std::string, std::string> query;
  std::istringstream parameters(text);
  for (std::string parameter; std::getline(parameters, parameter, '&');) {
    const std::size_t equals = parameter.find('=');
    query.emplace(parameter.substr(0, equals),
                  equals == std::string::npos ? "" : parameter.substr(equals + 1));
  }
  try {
    const raywalk::render::ViewRequest request = raywalk::render::parse_view_request(query);
    require(std::isfinite(request.viewpoint.x_m) && std::isfinite(request.viewpoint.z_m));
    require(
        std::isfinite(request.frame.yaw_deg + request.frame.pitch_deg + request.frame.roll_deg));
    require(request.frame.fov_deg >= 0.0 && request.frame.fov_deg <= 170.0);
    require((request.frame.fov_deg == 0.0) == request.frame.size.empty());
    require(request.panorama_width_px >= 0 &&
            request.panorama_width_px <= raywalk::render::kMostServedSide_px);
    require(!request.k_deg || (*request.k_deg >= 45.0 && *request.k_deg <= 90.0));
  } catch (const raywalk::render::HttpFault& fault) {
    raywalk::expect_one_line(fault);
    require(fault.status() >= 400 && fault.status() < 600);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  check_view(text);
  for (const std::uint64_t file : {std::uint64_t{0}, std::uint64_t{1000}, ~std::uint64_t{0}}) {
    check_range(text, file);
  }
  return 0;
}
