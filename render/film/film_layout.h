// Where the boxes of a film go when its description is put before the frames.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/film/film_boxes.h"

namespace raywalk::render {

// A box of the file itself; its content stays in the file.
struct TopBox {
  std::string type{};
  std::uint64_t begin = 0;  // byte in the file
  std::uint64_t end = 0;    // one past its last
};

class FilmLayout {
 public:
  // The movie box ("moov", of movie_size bytes) goes before the first frames ("mdat"), everything
  // else keeps its order.
  FilmLayout(const std::vector<TopBox>& boxes, std::uint64_t movie_size);

  // The size of the whole film.
  std::uint64_t end() const { return end_; }
  // The boxes before the movie box, and those behind it, where they are now.
  std::vector<TopBox> before() const { return {boxes_.begin(), boxes_.begin() + before_movie_}; }
  std::vector<TopBox> behind() const { return {boxes_.begin() + before_movie_, boxes_.end()}; }
  // Where a byte of the file goes. Throws std::out_of_range for one that is in no box.
  std::uint64_t moved(std::uint64_t place) const;

 private:
  std::vector<TopBox> boxes_{};
  std::vector<std::uint64_t> to_{};
  std::ptrdiff_t before_movie_ = 0;
  std::uint64_t end_ = 0;
};

// The bytes of the movie box for this layout: with chunk offsets of where the frames will be, of 64
// bits where the film is 4 GiB or more. Throws Error naming `source` for offsets outside the file.
std::string moved_movie(const std::vector<TopBox>& boxes, FilmBox movie, const std::string& source);

}  // namespace raywalk::render
