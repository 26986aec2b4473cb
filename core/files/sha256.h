// SHA-256 checksums, as lower-case hexadecimal.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace raywalk {

std::string sha256_hex(std::span<const std::byte> bytes);

}  // namespace raywalk
