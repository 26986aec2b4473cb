#include "render/serve/file_reply.h"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <system_error>
#include <utility>

#include "core/files/fingerprint.h"
#include "render/serve/byte_range.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

std::string read_part(const fs::path& file, const ByteRange& part) {
  std::string bytes(part.last - part.first + 1, '\0');
  std::ifstream in(file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(part.first));
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!in) throw HttpFault(500, "the file cannot be read");
  return bytes;
}

// `read` reads a part that is not empty.
template <typename Read>
Reply reply_of(std::uint64_t size, const std::string& etag, const std::string& type,
               const Request& request, const Read& read) {
  Reply reply{
      .type = type,
      .fields = {{"ETag", etag}, {"Cache-Control", "no-cache"}, {"Accept-Ranges", "bytes"}}};
  if (value_of(request.fields, "if-none-match").find(etag) != std::string::npos) {
    reply.status = 304;
    return reply;
  }
  const std::string only_if = value_of(request.fields, "if-range");
  const bool is_current = only_if.empty() || only_if == etag;
  const auto range =
      is_current ? parse_byte_range(value_of(request.fields, "range"), size) : std::nullopt;
  if (range && range->first > range->last) {
    reply = refusal(HttpFault(416, fmt::format("the file has {} bytes", size)));
    reply.fields.emplace_back("Content-Range", fmt::format("bytes */{}", size));
  } else if (range) {
    reply.status = 206;
    reply.body = read(*range);
    reply.fields.emplace_back("Content-Range",
                              fmt::format("bytes {}-{}/{}", range->first, range->last, size));
  } else if (size > 0) {
    reply.body = read(ByteRange{0, size - 1});
  }
  return reply;
}

}  // namespace

Reply file_reply(const fs::path& file, const std::string& type, const Request& request) {
  std::error_code failed;
  const bool is_file = fs::symlink_status(file, failed).type() == fs::file_type::regular;
  const std::uint64_t size = is_file ? fs::file_size(file, failed) : 0;
  const auto changed = fs::last_write_time(file, failed);
  if (!is_file || failed) throw HttpFault(404, "the file is gone");
  const std::string etag = fmt::format("\"{:x}-{:x}\"", size, changed.time_since_epoch().count());
  return reply_of(size, etag, type, request,
                  [&file](const ByteRange& part) { return read_part(file, part); });
}

Reply text_reply(std::string text, const std::string& type, const Request& request) {
  const std::string etag = '"' + sha256_hex(text).substr(0, 32) + '"';
  return reply_of(text.size(), etag, type, request, [&text](const ByteRange& part) {
    return text.substr(part.first, part.last - part.first + 1);
  });
}

}  // namespace raywalk::render
