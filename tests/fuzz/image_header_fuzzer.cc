// Any bytes are parsed as an image header or rejected with a one-line Error.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "core/base/error.h"
#include "core/files/image_file.h"
#include "tests/fuzz/expect.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  try {
    const auto header = raywalk::parse_image_header(bytes, "frame.jpg");
    if (header.size.width < 1 || header.size.height < 1) std::abort();
  } catch (const raywalk::Error& e) {
    raywalk::expect_one_line(e);
  }
  return 0;
}
