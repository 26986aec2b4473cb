#include "render/film/film_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "render/film/film_layout.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostDescription = std::uint64_t{1} << 30;
constexpr std::size_t kBlock = std::size_t{4} << 20;

class FilmReader {
 public:
  explicit FilmReader(const fs::path& file) : name_(file.string()) {
    require_regular_file(file);
    stream_.open(file, std::ios::binary);
    if (!stream_) throw Error("cannot read " + name_);
    std::error_code error;
    size_ = fs::file_size(file, error);
    if (error) throw Error("cannot read " + name_ + ": " + error.message());
  }

  const std::string& name() const { return name_; }

  std::string read(std::uint64_t from, std::uint64_t count) {
    std::string bytes(static_cast<std::size_t>(count), '\0');
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(from));
    stream_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!stream_) throw Error("cannot read " + name_ + ": it is cut short");
    return bytes;
  }

  std::vector<TopBox> boxes() {
    std::vector<TopBox> found;
    for (std::uint64_t at = 0; at < size_;) {
      const std::string head = read(at, std::min<std::uint64_t>(16, size_ - at));
      if (head.size() < 8) throw_damaged(at);
      std::uint64_t size = get_u32(head, 0);
      if (size == 0) size = size_ - at;  // up to the end of the file
      if (size == 1) size = head.size() == 16 ? get_u64(head, 8) : 0;
      if (size < 8 || size > size_ - at) throw_damaged(at);
      found.push_back({head.substr(4, 4), at, at + size});
      at += size;
    }
    return found;
  }

 private:
  [[noreturn]] void throw_damaged(std::uint64_t at) const {
    throw Error(fmt::format("{}: not a complete film: byte {} begins no box that ends in the file",
                            name_, at));
  }

  std::string name_;
  std::ifstream stream_{};
  std::uint64_t size_ = 0;
};

TopBox movie_of(const std::vector<TopBox>& boxes, const std::string& name) {
  const auto found = std::find_if(boxes.begin(), boxes.end(),
                                  [](const TopBox& box) { return box.type == "moov"; });
  if (found == boxes.end()) throw Error(name + ": not a complete film: it has no description");
  if (found->end - found->begin > kMostDescription) {
    throw Error(name + ": the description of the film is too long");
  }
  return *found;
}

FilmBox read_movie(const TopBox& box, FilmReader* reader) {
  return parse_box(reader->read(box.begin, box.end - box.begin), reader->name());
}

class FilmFile {
 public:
  FilmFile(const fs::path& file, const std::string& name) : name_(name) {
    stream_.open(file, std::ios::binary);
    check();
  }

  void write(const std::string& bytes) {
    throw_if_interrupted();
    stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    check();
  }
  void copy(const std::vector<TopBox>& boxes, FilmReader* from) {
    for (const TopBox& box : boxes) {
      for (std::uint64_t at = box.begin; at < box.end; at += kBlock) {
        write(from->read(at, std::min<std::uint64_t>(kBlock, box.end - at)));
      }
    }
  }
  void close() {
    stream_.close();
    check();
  }

 private:
  void check() const {
    if (stream_) return;
    throw Error("cannot write " + name_ + ": " + std::generic_category().message(errno));
  }

  std::string name_;
  std::ofstream stream_{};
};

}  // namespace

FilmFacts read_film(const fs::path& file) {
  FilmReader reader(file);
  const FilmBox movie = read_movie(movie_of(reader.boxes(), reader.name()), &reader);
  FilmFacts facts;
  facts.by_raywalk = bytes_of(movie).find(kFilmComment) != std::string::npos;
  for (const FilmBox& track : movie.children) {
    const FilmBox* entry = track.type == "trak" ? visual_sample_entry(track) : nullptr;
    if (entry == nullptr) continue;
    try {
      facts.width = get_u16(entry->payload, 24);
      facts.height = get_u16(entry->payload, 26);
      const FilmBox* sizes = track.child("mdia")->child("minf")->child("stbl")->child("stsz");
      if (sizes != nullptr) facts.frames = get_u32(sizes->payload, 8);
    } catch (const std::out_of_range&) {
      throw Error(reader.name() + ": the film is damaged: its track of pictures is cut short");
    }
    if (entry->child("sv3d") != nullptr) facts.spherical = spherical_metadata_of(track);
  }
  return facts;
}

void complete_film(const fs::path& encoded, std::optional<StereoMode> stereo, const fs::path& to,
                   const std::string& name) {
  FilmReader reader(encoded);
  const std::vector<TopBox> boxes = reader.boxes();
  FilmBox movie = read_movie(movie_of(boxes, name), &reader);
  if (stereo) add_spherical_metadata(*stereo, name, &movie);
  const std::string description = moved_movie(boxes, std::move(movie), name);
  const FilmLayout layout(boxes, description.size());
  FilmFile file(to, name);
  file.copy(layout.before(), &reader);
  file.write(description);
  file.copy(layout.behind(), &reader);
  file.close();
}

}  // namespace raywalk::render
