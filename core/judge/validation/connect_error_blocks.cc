#include "core/judge/validation/connect_error_blocks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "core/files/sha256.h"
#include "core/room/room_fingerprint.h"

namespace raywalk {

using nlohmann::ordered_json;

ordered_json connect_error_share(const Room& room, std::span<const Generation> generations,
                                 const ConnectErrorOptions& options, Block block) {
  ordered_json share = ordered_json::array();
  for (const Generation generation : generations) {
    share.push_back(json_of(measure_connect_error_sums(room, generation, options, block)));
  }
  return share;
}

std::vector<ConnectError> connect_errors_of(std::span<const CheckedJson> shares, const Room& room,
                                            std::span<const Generation> generations,
                                            const ConnectErrorOptions& options) {
  const std::size_t k_count = options.k_list_deg.size();
  std::vector<ConnectErrorSums> sums(generations.size(), ConnectErrorSums(k_count));
  for (const CheckedJson& share : shares) {
    const std::vector<CheckedJson> parts = share.items(generations.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
      sums[i].add(connect_error_sums_from(parts[i], k_count));
    }
  }
  std::vector<ConnectError> errors;
  for (std::size_t i = 0; i < generations.size(); ++i) {
    errors.push_back(connect_error_of(sums[i], room, generations[i], options));
  }
  return errors;
}

std::string text_of(std::span<const Generation> generations, const ConnectErrorOptions& options) {
  std::string text =
      fmt::format("{} {} {}", options.viewpoints, options.overlap_deg, options.k_list_deg);
  for (const Generation generation : generations) text += " " + generation_name(generation);
  return text;
}

BlockResults connect_error_blocks(const Room& room, std::span<const Generation> generations,
                                  const ConnectErrorOptions& options) {
  return {blocks_beside(room.directory()), "connect-error",
          sha256_hex(room_fingerprint(room) + " " + text_of(generations, options))};
}

}  // namespace raywalk
