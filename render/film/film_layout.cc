#include "render/film/film_layout.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "core/base/error.h"

namespace raywalk::render {
namespace {

constexpr std::uint64_t kMost32 = std::numeric_limits<std::uint32_t>::max();

// Calls change(box) for every table of chunk offsets: "stco" (32 bits) or "co64" (64 bits).
template <typename Change>
void for_each_offsets(FilmBox* box, const Change& change) {
  for (FilmBox& child : box->children) {
    if (child.type == "stco" || child.type == "co64") change(&child);
    for_each_offsets(&child, change);
  }
}

// The same table with offsets of 64 bits.
void widen(FilmBox* table) {
  if (table->type == "co64") return;
  const std::uint32_t count = get_u32(table->payload, 4);
  std::string wide = table->payload.substr(0, 8);
  for (std::uint32_t i = 0; i < count; ++i) {
    put_u64(get_u32(table->payload, 8 + std::size_t{4} * i), &wide);
  }
  table->type = "co64";
  table->payload = wide;
}

void move_offsets(const FilmLayout& layout, FilmBox* table) {
  const bool is_wide = table->type == "co64";
  const std::uint32_t count = get_u32(table->payload, 4);
  std::string moved = table->payload.substr(0, 8);
  for (std::size_t i = 0; i < count; ++i) {
    if (is_wide) {
      put_u64(layout.moved(get_u64(table->payload, 8 + 8 * i)), &moved);
    } else {
      put_u32(static_cast<std::uint32_t>(layout.moved(get_u32(table->payload, 8 + 4 * i))), &moved);
    }
  }
  table->payload = moved;
}

std::string moved_bytes(const std::vector<TopBox>& boxes, FilmBox* movie) {
  // The size of the movie box depends on the width of the offsets, not on their values.
  if (FilmLayout(boxes, bytes_of(*movie).size()).end() > kMost32) for_each_offsets(movie, widen);
  const FilmLayout layout(boxes, bytes_of(*movie).size());
  for_each_offsets(movie, [&](FilmBox* table) { move_offsets(layout, table); });
  return bytes_of(*movie);
}

}  // namespace

FilmLayout::FilmLayout(const std::vector<TopBox>& boxes, std::uint64_t movie_size) {
  std::copy_if(boxes.begin(), boxes.end(), std::back_inserter(boxes_),
               [](const TopBox& box) { return box.type != "moov"; });
  const auto frames = std::find_if(boxes_.begin(), boxes_.end(),
                                   [](const TopBox& box) { return box.type == "mdat"; });
  before_movie_ = frames - boxes_.begin();
  for (auto box = boxes_.begin(); box != boxes_.end(); ++box) {
    if (box == frames) end_ += movie_size;
    to_.push_back(end_);
    end_ += box->end - box->begin;
  }
  if (frames == boxes_.end()) end_ += movie_size;
}

std::uint64_t FilmLayout::moved(std::uint64_t place) const {
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    if (place >= boxes_[i].begin && place < boxes_[i].end) return to_[i] + place - boxes_[i].begin;
  }
  throw std::out_of_range("a byte in no box");
}

std::string moved_movie(const std::vector<TopBox>& boxes, FilmBox movie,
                        const std::string& source) {
  try {
    return moved_bytes(boxes, &movie);
  } catch (const std::out_of_range&) {
    throw Error(source + ": the film is damaged: its frames are not where its description says");
  }
}

}  // namespace raywalk::render
