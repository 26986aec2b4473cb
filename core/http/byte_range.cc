#include "core/http/byte_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "core/http/field_text.h"

namespace raywalk {
namespace {

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

// What one range asks for, before it meets the file.
struct RangeSpec {
  std::optional<std::uint64_t> first{};  // none: the last `last` bytes
  std::uint64_t last = kMost;
};

// Of decimal digits; what is too large for the type is its largest value.
std::optional<std::uint64_t> parse_position(std::string_view digits) {
  if (digits.empty()) return std::nullopt;
  std::uint64_t value = 0;
  for (const char c : digits) {
    if (c < '0' || c > '9') return std::nullopt;
    const auto digit = static_cast<std::uint64_t>(c - '0');
    value = value > (kMost - digit) / 10 ? kMost : value * 10 + digit;
  }
  return value;
}

std::optional<RangeSpec> parse_spec(std::string_view text) {
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view first = text.substr(0, dash);
  const std::string_view last = text.substr(dash + 1);
  RangeSpec spec;
  if (!first.empty()) {
    spec.first = parse_position(first);
    if (!spec.first) return std::nullopt;
  }
  if (!last.empty()) {
    const std::optional<std::uint64_t> position = parse_position(last);
    if (!position) return std::nullopt;
    spec.last = *position;
  }
  const bool is_valid = spec.first ? *spec.first <= spec.last : !last.empty();
  return is_valid ? std::optional(spec) : std::nullopt;
}

// The part of the file; none where it has no byte of it.
std::optional<ByteRange> part_of(const RangeSpec& spec, std::uint64_t size) {
  if (!spec.first) {
    if (spec.last == 0 || size == 0) return std::nullopt;
    return ByteRange{size - std::min(spec.last, size), size - 1};
  }
  if (*spec.first >= size) return std::nullopt;
  return ByteRange{*spec.first, std::min(spec.last, size - 1)};
}

// The ranges of the list; none where it is malformed or too long.
std::optional<std::vector<RangeSpec>> parse_specs(std::string_view list) {
  std::vector<RangeSpec> specs;
  while (!list.empty()) {
    const std::string_view text = trimmed_field(next_part(&list, ","));
    if (text.empty()) continue;  // recipients accept empty elements (RFC 9110, 5.6.1)
    const std::optional<RangeSpec> spec = parse_spec(text);
    if (!spec || specs.size() == kMostByteRanges) return std::nullopt;
    specs.push_back(*spec);
  }
  return specs.empty() ? std::nullopt : std::optional(specs);
}

// The parts with those that overlap or touch merged.
std::vector<ByteRange> merged(const std::vector<ByteRange>& parts) {
  std::vector<ByteRange> ascending = parts;
  std::sort(ascending.begin(), ascending.end(),
            [](const ByteRange& a, const ByteRange& b) { return a.first < b.first; });
  std::vector<ByteRange> result;
  for (const ByteRange& part : ascending) {
    if (!result.empty() && part.first <= result.back().last + 1) {
      result.back().last = std::max(result.back().last, part.last);
    } else {
      result.push_back(part);
    }
  }
  return result.size() == parts.size() ? parts : result;
}

}  // namespace

RequestedRanges parse_byte_ranges(std::string_view value, std::uint64_t size) {
  const std::size_t equals = value.find('=');
  if (equals == std::string_view::npos) return {};
  const bool is_bytes = lower_case(value.substr(0, equals)) == "bytes";
  const auto specs = is_bytes ? parse_specs(value.substr(equals + 1)) : std::nullopt;
  if (!specs) return {};
  std::vector<ByteRange> parts;
  for (const RangeSpec& spec : *specs) {
    if (const std::optional<ByteRange> part = part_of(spec, size)) parts.push_back(*part);
  }
  if (parts.empty()) return {RangeAnswer::kUnsatisfiable, {}};
  return {RangeAnswer::kParts, merged(parts)};
}

std::string content_range(const ByteRange& part, std::uint64_t size) {
  return fmt::format("bytes {}-{}/{}", part.first, part.last, size);
}

}  // namespace raywalk
