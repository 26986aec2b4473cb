#include "render/film/film_boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"

namespace raywalk::render {
namespace {

constexpr int kMostDepth = 16;  // moov, trak, mdia, minf, stbl, stsd, sample entry and its boxes
constexpr std::size_t kHeader = 8;        // size and type
constexpr std::size_t kLargeHeader = 16;  // and a size of 64 bits
constexpr std::size_t kFullHeader = 4;    // version and flags of a "full box"
// SampleEntry (8 bytes) and the further fields of VisualSampleEntry (70), ISO/IEC 14496-12, 8.5.2
// and 12.1.3.
constexpr std::size_t kVisualEntry = 78;
constexpr std::size_t kWidthInEntry = 24;  // a sample entry that reaches up to there has a size

std::uint64_t get(std::string_view bytes, std::size_t at, std::size_t count) {
  if (at > bytes.size() || bytes.size() - at < count) {
    throw std::out_of_range("beyond the end of a box");
  }
  std::uint64_t value = 0;
  for (std::size_t i = at; i < at + count; ++i) {
    value = value << 8 | static_cast<std::uint8_t>(bytes[i]);
  }
  return value;
}

void put(std::uint64_t value, int count, std::string* bytes) {
  for (int i = count - 1; i >= 0; --i) {
    bytes->push_back(static_cast<char>(static_cast<std::uint8_t>(value >> (8 * i))));
  }
}

// Boxes that only hold boxes.
bool is_container(std::string_view type) {
  constexpr std::array<std::string_view, 5> kContainers = {"moov", "trak", "mdia", "minf", "stbl"};
  return std::find(kContainers.begin(), kContainers.end(), type) != kContainers.end();
}

class BoxParser {
 public:
  explicit BoxParser(const std::string& source) : source_(source) {}

  FilmBox box(std::string_view bytes, std::string_view parent, int depth = 0) const {
    if (depth > kMostDepth) throw Error(source_ + ": the film is damaged: boxes in boxes in boxes");
    const std::size_t header = header_size(bytes);
    FilmBox box{.type = std::string(bytes.substr(4, 4))};
    const std::string_view content = bytes.substr(header);
    if (is_container(box.type)) {
      children(content, 0, box.type, depth, &box);
    } else if (box.type == "stsd" && content.size() >= kFullHeader + 4) {
      children(content, kFullHeader + 4, box.type, depth, &box);
    } else if (parent == "stsd" && content.size() >= kVisualEntry && is_visual(content)) {
      children(content, kVisualEntry, box.type, depth, &box);
    } else {
      box.payload = content;
    }
    return box;
  }

  // The size of the box that `bytes` begin with.
  std::size_t size(std::string_view bytes) const {
    std::uint64_t size = get_u32(bytes, 0);
    if (size == 1 && bytes.size() >= kLargeHeader) size = get_u64(bytes, kHeader);
    if (size < header_size(bytes) || size > bytes.size()) {
      throw Error(fmt::format("{}: the film is damaged: a box '{}' of {} bytes in {} bytes",
                              source_, one_line(bytes.substr(4, 4)), size, bytes.size()));
    }
    return static_cast<std::size_t>(size);
  }

 private:
  static std::size_t header_size(std::string_view bytes) {
    return get_u32(bytes, 0) == 1 ? kLargeHeader : kHeader;
  }

  // Sample entries of sound and of text are shorter, or have no picture size there.
  static bool is_visual(std::string_view content) {
    return get_u16(content, kWidthInEntry) > 0 && get_u16(content, kWidthInEntry + 2) > 0;
  }

  void children(std::string_view content, std::size_t from, std::string_view parent, int depth,
                FilmBox* box) const {
    box->payload = content.substr(0, from);
    content.remove_prefix(from);
    while (content.size() >= kHeader) {
      const std::size_t bytes = size(content);
      box->children.push_back(this->box(content.substr(0, bytes), parent, depth + 1));
      content.remove_prefix(bytes);
    }
    box->tail = content;
  }

  const std::string& source_;
};

template <typename Box>
Box* entry_of(Box& track) {
  Box* box = &track;
  for (const char* type : {"mdia", "minf"}) {
    box = box->child(type);
    if (box == nullptr) return nullptr;
  }
  // The header of a track's media tells its kind: "vmhd" is that of pictures.
  if (box->child("vmhd") == nullptr) return nullptr;
  for (const char* type : {"stbl", "stsd"}) {
    box = box->child(type);
    if (box == nullptr) return nullptr;
  }
  return box->children.empty() ? nullptr : &box->children.front();
}

}  // namespace

const FilmBox* FilmBox::child(std::string_view wanted) const {
  const auto found = std::find_if(children.begin(), children.end(),
                                  [&](const FilmBox& box) { return box.type == wanted; });
  return found == children.end() ? nullptr : &*found;
}

FilmBox* FilmBox::child(std::string_view wanted) {
  return const_cast<FilmBox*>(std::as_const(*this).child(wanted));
}

FilmBox parse_box(std::string_view bytes, const std::string& source) {
  const BoxParser parser(source);
  try {
    return parser.box(bytes.substr(0, parser.size(bytes)), "");
  } catch (const std::out_of_range&) {
    throw Error(source + ": the film is damaged: it ends within a box");
  }
}

std::string bytes_of(const FilmBox& box) {
  std::string content = box.payload;
  for (const FilmBox& child : box.children) content += bytes_of(child);
  content += box.tail;
  if (content.size() > std::numeric_limits<std::uint32_t>::max() - kHeader) {
    throw Error(fmt::format("a box '{}' of {} bytes is more than a film can hold", box.type,
                            content.size()));
  }
  std::string bytes;
  put_u32(static_cast<std::uint32_t>(content.size() + kHeader), &bytes);
  return bytes + box.type + content;
}

const FilmBox* visual_sample_entry(const FilmBox& track) { return entry_of(track); }
FilmBox* visual_sample_entry(FilmBox& track) { return entry_of(track); }

std::uint16_t get_u16(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint16_t>(get(bytes, at, 2));
}
std::uint32_t get_u32(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint32_t>(get(bytes, at, 4));
}
std::uint64_t get_u64(std::string_view bytes, std::size_t at) { return get(bytes, at, 8); }
void put_u32(std::uint32_t value, std::string* bytes) { put(value, 4, bytes); }
void put_u64(std::uint64_t value, std::string* bytes) { put(value, 8, bytes); }

}  // namespace raywalk::render
