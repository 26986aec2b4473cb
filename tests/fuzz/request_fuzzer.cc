// Any bytes that a client of `raywalk-render serve` may send are either understood, within the
// limits that the server relies on, or refused with a one-line HttpFault.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/http/byte_range.h"
#include "core/http/http_fault.h"
#include "core/http/reply.h"
#include "core/http/request_head.h"
#include "core/http/request_target.h"
#include "render/serve/view_request.h"
#include "tests/fuzz/expect.h"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

// Runs a step; a refusal has to be a reply of one head.
template <typename Step>
void run(const Step& step) {
  try {
    step();
  } catch (const raywalk::HttpFault& fault) {
    raywalk::expect_one_line(fault);
    require(fault.status() >= 400 && fault.status() < 600);
    const std::string head = raywalk::head_text(raywalk::refusal(fault), {});
    require(head.find("\r\n\r\n") == head.size() - 4);
  }
}

// Parts lie in the file and are no longer than it altogether.
void check_ranges(std::string_view value, std::uint64_t size) {
  const raywalk::RequestedRanges ranges = raywalk::parse_byte_ranges(value, size);
  require(ranges.parts.empty() == (ranges.answer != raywalk::RangeAnswer::kParts));
  require(ranges.parts.size() <= raywalk::kMostByteRanges);
  std::uint64_t left = size;
  for (const raywalk::ByteRange& part : ranges.parts) {
    require(part.first <= part.last && part.last < size && part.size() <= left);
    left -= part.size();
  }
}

void check_view(const raywalk::RequestTarget& target) {
  run([&] {
    const raywalk::render::ViewRequest request = raywalk::render::parse_view_request(target);
    require(std::isfinite(request.viewpoint.x_m) && std::isfinite(request.viewpoint.z_m));
    require(
        std::isfinite(request.frame.yaw_deg + request.frame.pitch_deg + request.frame.roll_deg));
    require(request.frame.fov_deg >= 0.0 && request.frame.fov_deg <= 170.0);
    require((request.frame.fov_deg == 0.0) == request.frame.size.empty());
    require(request.panorama_width_px >= 0 &&
            request.panorama_width_px <= raywalk::render::kMostServedSide_px);
    require(!request.k_deg || (*request.k_deg >= 45.0 && *request.k_deg <= 90.0));
  });
}

// The path stays below the root, also that of a redirection.
void check_target(std::string_view text) {
  run([&] {
    const raywalk::RequestTarget target = raywalk::parse_request_target(text);
    require(target.path.starts_with('/') && !target.path.starts_with("//"));
    require((target.path + '/').find("/../") == std::string::npos);
    require(std::none_of(target.path.begin(), target.path.end(),
                         [](char c) { return c == '\\' || static_cast<unsigned char>(c) < 0x20; }));
    const std::string rest = raywalk::target_without(target, "token");
    require(raywalk::parse_request_target(rest).path == target.path);
    check_view(target);
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  run([&] {
    const raywalk::RequestHead head = raywalk::parse_request_head(text);
    require(head.fields.size() <= raywalk::kMostRequestFields);
    raywalk::keeps_alive(head);
    raywalk::cookie_of(head, "raywalk_token");
    check_target(head.target);
    for (const raywalk::RequestField& field : head.fields) check_ranges(field.value, 1000);
  });
  check_target(text);
  for (const std::uint64_t file : {std::uint64_t{0}, std::uint64_t{1000}, ~std::uint64_t{0}}) {
    check_ranges(text, file);
  }
  return 0;
}
