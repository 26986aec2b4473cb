// The boxes that an MP4 or QuickTime film consists of (ISO/IEC 14496-12, "ISO base media file
// format"): a size, a type of four letters, and a content that for some types is boxes again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk::render {

struct FilmBox {
  std::string type{};               // four bytes
  std::string payload{};            // all of the content, or what is before the boxes in it
  std::vector<FilmBox> children{};  // of "moov" and below: what leads to tracks and their samples
  std::string tail{};               // behind them: QuickTime ends some lists with 4 zero bytes

  // The first child of a type; null if there is none.
  const FilmBox* child(std::string_view wanted) const;
  FilmBox* child(std::string_view wanted);
};

// The box whose bytes, header included, are `bytes`, with the boxes in it. `source` is for
// messages. Throws Error where a size does not fit into what surrounds it.
FilmBox parse_box(std::string_view bytes, const std::string& source);

// The bytes of a box. Throws Error where they are 4 GiB or more.
std::string bytes_of(const FilmBox& box);

// The sample entry of a track of pictures in a "trak" box: how they are coded, their size. Null
// where the track has none.
const FilmBox* visual_sample_entry(const FilmBox& track);
FilmBox* visual_sample_entry(FilmBox& track);

// Numbers in boxes have their highest byte first. get_* throw std::out_of_range beyond the end.
std::uint16_t get_u16(std::string_view bytes, std::size_t at);
std::uint32_t get_u32(std::string_view bytes, std::size_t at);
std::uint64_t get_u64(std::string_view bytes, std::size_t at);
void put_u32(std::uint32_t value, std::string* bytes);
void put_u64(std::uint64_t value, std::string* bytes);

}  // namespace raywalk::render
