// Connection errors measured in blocks: each block sums over its share of the viewpoints, and the
// sums of all make the errors, the same to the bit as in one run.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/base/block.h"
#include "core/files/block_results.h"
#include "core/files/checked_json.h"
#include "core/judge/validation/connect_error.h"

namespace raywalk {

// A block's share: the sums of each generation. Throws as measure_connect_error_sums() does.
nlohmann::ordered_json connect_error_share(const Room& room,
                                           std::span<const Generation> generations,
                                           const ConnectErrorOptions& options, Block block);

// The errors of the same generations from the shares of all blocks. Throws Error as CheckedJson
// does.
std::vector<ConnectError> connect_errors_of(std::span<const CheckedJson> shares, const Room& room,
                                            std::span<const Generation> generations,
                                            const ConnectErrorOptions& options);

// All but the room that shares depend on, for fingerprints.
std::string text_of(std::span<const Generation> generations, const ConnectErrorOptions& options);

// Where the blocks of `raywalk-render connect-error` are kept, beside the room.
BlockResults connect_error_blocks(const Room& room, std::span<const Generation> generations,
                                  const ConnectErrorOptions& options);

}  // namespace raywalk
