#include "render/serve/file_reply.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>

#include "core/files/fingerprint.h"
#include "core/http/byte_range.h"
#include "core/http/field_text.h"

namespace raywalk::render {
namespace {

// What is served: its size, an ETag of this very content, and how its bytes are read.
struct Content {
  std::uint64_t size = 0;
  std::string etag{};
  std::string type{};
  std::function<std::string(const ByteRange&)> read{};
};

class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& file)
      : descriptor_(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK)) {
    if (descriptor_ < 0) throw HttpFault(404, "the file is gone");
    if (fstat(descriptor_, &state_) != 0 || !S_ISREG(state_.st_mode)) {
      close(descriptor_);
      throw HttpFault(404, "the file is gone");
    }
  }
  ~OpenFile() { close(descriptor_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  std::uint64_t size() const { return static_cast<std::uint64_t>(state_.st_size); }
  std::string etag() const {
    return fmt::format("\"{:x}-{:x}-{:x}\"", state_.st_size, state_.st_mtim.tv_sec,
                       state_.st_mtim.tv_nsec);
  }
  std::string read(const ByteRange& part) const {
    std::string bytes(part.size(), '\0');
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t count = pread(descriptor_, bytes.data() + done, bytes.size() - done,
                                  static_cast<off_t>(part.first + done));
      if (count <= 0) throw HttpFault(500, "the file cannot be read");
      done += static_cast<std::size_t>(count);
    }
    return bytes;
  }

 private:
  int descriptor_;
  struct stat state_ = {};
};

// Whether If-None-Match names the content (RFC 9110, 13.1.2).
bool client_has(const RequestHead& head, const std::string& etag) {
  const std::string* field = field_of(head, "if-none-match");
  if (field == nullptr) return false;
  if (*field == "*") return true;
  std::string_view tags = *field;
  while (!tags.empty()) {
    std::string_view tag = trimmed_field(next_part(&tags, ","));
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == etag) return true;
  }
  return false;
}

RequestedRanges ranges_of(const RequestHead& head, const Content& content) {
  const std::string* range = field_of(head, "range");
  const std::string* only_if = field_of(head, "if-range");
  const bool is_current = only_if == nullptr || *only_if == content.etag;
  if (range == nullptr || head.method != "GET" || !is_current) return {};
  return parse_byte_ranges(*range, content.size);
}

void add_parts(const std::vector<ByteRange>& parts, const Content& content, Reply* reply) {
  reply->status = 206;
  if (parts.size() == 1) {
    reply->body = content.read(parts.front());
    reply->fields.emplace_back("Content-Range", content_range(parts.front(), content.size));
    return;
  }
  std::string body;
  for (const ByteRange& part : parts) {
    body += content.read(part);
  }
  // No part holds it but by a chance of 2^-128.
  const std::string boundary = sha256_hex(content.etag + body).substr(0, 32);
  std::string_view rest = body;
  for (const ByteRange& part : parts) {
    reply->body += fmt::format("--{}\r\nContent-Type: {}\r\nContent-Range: {}\r\n\r\n", boundary,
                               content.type, content_range(part, content.size));
    reply->body.append(rest.substr(0, part.size())).append("\r\n");
    rest.remove_prefix(part.size());
  }
  reply->body += "--" + boundary + "--\r\n";
  reply->type = "multipart/byteranges; boundary=" + boundary;
}

Reply reply_with(const Content& content, const RequestHead& head) {
  Reply reply{
      .type = content.type,
      .fields = {
          {"ETag", content.etag}, {"Cache-Control", "no-cache"}, {"Accept-Ranges", "bytes"}}};
  if (client_has(head, content.etag)) {
    reply.status = 304;
    reply.type.clear();
    return reply;
  }
  const RequestedRanges ranges = ranges_of(head, content);
  switch (ranges.answer) {
    case RangeAnswer::kUnsatisfiable:
      reply = refusal(HttpFault(416, fmt::format("the file has {} bytes", content.size)));
      reply.fields.emplace_back("Content-Range", fmt::format("bytes */{}", content.size));
      break;
    case RangeAnswer::kParts:
      add_parts(ranges.parts, content, &reply);
      break;
    case RangeAnswer::kWhole:
      if (content.size > 0) reply.body = content.read({0, content.size - 1});
      break;
  }
  return reply;
}

}  // namespace

Reply file_reply(const ServedFile& served, const RequestHead& head) {
  const OpenFile file(served.file);
  return reply_with({file.size(), file.etag(), served.type,
                     [&file](const ByteRange& part) { return file.read(part); }},
                    head);
}

Reply text_reply(const std::string& text, const std::string& type, const RequestHead& head) {
  return reply_with(
      {text.size(), '"' + sha256_hex(text).substr(0, 32) + '"', type,
       [&text](const ByteRange& part) { return text.substr(part.first, part.size()); }},
      head);
}

}  // namespace raywalk::render
