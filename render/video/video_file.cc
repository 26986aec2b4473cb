#include "render/video/video_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostDescription = std::uint64_t{1} << 30;
constexpr std::size_t kHeader = 8;  // size and type
// SampleEntry (8 bytes) and the further fields of VisualSampleEntry (70) are before the boxes in it
// (8.5.2 and 12.1.3), the size of the pictures among them.
constexpr std::size_t kVisualEntry = 78, kWidthInEntry = 24;
// ffcc8263-f855-4a93-8814-587a02521fdd, of the older RFC.
constexpr std::string_view kUuid =
    "\xff\xcc\x82\x63\xf8\x55\x4a\x93\x88\x14\x58\x7a\x02\x52\x1f\xdd";

// Bytes of a file, or of its description in memory, such as those of a box.
struct Place {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;  // one past the last
};

// Numbers in boxes have their highest byte first. 0 beyond the end.
std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = at; i < at + count; ++i) {
    value = value << 8 | (i < bytes.size() ? static_cast<std::uint8_t>(bytes[i]) : 0U);
  }
  return value;
}

std::string four_bytes(std::size_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(value >> shift));
  return bytes;
}

std::string box(const std::string& type, const std::string& content) {
  return four_bytes(kHeader + content.size()) + type + content;
}

// A "full box": version and flags, both 0, come before the rest.
std::string full_box(const std::string& type, const std::string& content) {
  return box(type, std::string(4, '\0') + content);
}

// Neither turned (prhd: yaw, pitch and roll 0) nor cropped (equi: nothing is missing on four
// sides).
std::string boxes_of_version_2(StereoMode stereo) {
  const std::string projection = box(
      "proj", full_box("prhd", std::string(12, '\0')) + full_box("equi", std::string(16, '\0')));
  return full_box("st3d", std::string(1, stereo == StereoMode::kTopBottom ? '\1' : '\0')) +
         box("sv3d", full_box("svhd", std::string("Raywalk\0", 8)) + projection);
}

std::string box_of_version_1(StereoMode stereo) {
  std::string xml =
      "<?xml version=\"1.0\"?>"
      "<rdf:SphericalVideo xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\" "
      "xmlns:GSpherical=\"http://ns.google.com/videos/1.0/spherical/\">"
      "<GSpherical:Spherical>true</GSpherical:Spherical>"
      "<GSpherical:Stitched>true</GSpherical:Stitched>"
      "<GSpherical:StitchingSoftware>Raywalk</GSpherical:StitchingSoftware>"
      "<GSpherical:ProjectionType>equirectangular</GSpherical:ProjectionType>";
  if (stereo == StereoMode::kTopBottom) {
    xml += "<GSpherical:StereoMode>top-bottom</GSpherical:StereoMode>";
  }
  return box("uuid", std::string(kUuid) + xml + "</rdf:SphericalVideo>");
}

// The description of a video: its box moov, in memory.
class Description {
 public:
  Description(std::string bytes, const std::string& name) : bytes_(std::move(bytes)), name_(name) {
    const Place movie{0, bytes_.size()};
    for (const Place& track : children(content(movie))) {
      around_ = {movie, track};
      if (type_of(track) == "trak" && find_entry()) return;
    }
    throw Error(name_ + ": the video has no track of pictures");
  }

  const std::string& bytes() const { return bytes_; }

  VideoFacts facts() const {
    const Place entry = around_.back();
    VideoFacts facts{.width = static_cast<int>(number_in(entry, kWidthInEntry, 2)),
                     .height = static_cast<int>(number_in(entry, kWidthInEntry + 2, 2)),
                     .by_raywalk = bytes_.find(kVideoComment) != std::string::npos};
    // Version and flags, the size of all samples or 0, the number of samples (8.7.3.2).
    const Place samples = around_[around_.size() - 3];
    if (const auto sizes = child(content(samples), "stsz")) facts.frames = number_in(*sizes, 8, 4);
    const Place of_entry = content(entry, kVisualEntry);
    const auto spherical = child(of_entry, "sv3d");
    if (!spherical || text(*spherical).find("equi") == std::string_view::npos) return facts;
    const auto eyes = child(of_entry, "st3d");
    const bool is_stereo = eyes && number_in(*eyes, 4, 1) == 1;
    facts.stereo = is_stereo ? StereoMode::kTopBottom : StereoMode::kMono;
    return facts;
  }

  void add_spherical(StereoMode stereo) {
    // What is behind first, as it moves nothing before it.
    insert(box_of_version_1(stereo), 2);
    insert(boxes_of_version_2(stereo), around_.size());
  }

 private:
  std::string_view text(Place place) const {
    return std::string_view(bytes_).substr(place.begin, place.end - place.begin);
  }
  std::string_view type_of(Place place) const { return text(place).substr(4, 4); }
  std::int64_t number_in(Place place, std::size_t at, std::size_t count) const {
    return static_cast<std::int64_t>(number(text(place), kHeader + at, count));
  }
  // What is in a box behind the first `skipped` bytes.
  static Place content(Place place, std::size_t skipped = 0) {
    return {std::min(place.begin + kHeader + skipped, place.end), place.end};
  }

  // QuickTime ends some lists with 4 zero bytes.
  std::vector<Place> children(Place place) const {
    std::vector<Place> found;
    for (std::size_t at = place.begin; at + kHeader <= place.end; at = found.back().end) {
      const std::uint64_t size = number(bytes_, at, 4);
      if (size < kHeader || size > place.end - at) {
        throw Error(fmt::format("{}: the video is damaged: a box of {} bytes in {} bytes", name_,
                                size, place.end - at));
      }
      found.push_back({at, at + size});
    }
    return found;
  }
  std::optional<Place> child(Place place, std::string_view type) const {
    for (const Place& found : children(place)) {
      if (type_of(found) == type) return found;
    }
    return std::nullopt;
  }

  // Goes down from the track; false if it is not one of pictures.
  bool find_entry() {
    for (const char* type : {"mdia", "minf", "stbl", "stsd"}) {
      const auto found = child(content(around_.back()), type);
      if (!found) return false;
      around_.push_back(*found);
      // The header of a track's media tells its kind: "vmhd" is that of pictures.
      if (type == std::string_view("minf") && !child(content(*found), "vmhd")) return false;
    }
    // Version, flags and the number of entries (8.5.2.2).
    const std::vector<Place> entries = children(content(around_.back(), 8));
    if (entries.empty()) return false;
    around_.push_back(entries.front());
    return true;
  }

  // At the end of the innermost of the first `depth` boxes, which all grow.
  void insert(const std::string& boxes, std::size_t depth) {
    bytes_.insert(around_[depth - 1].end, boxes);
    for (std::size_t i = 0; i < depth; ++i) {
      around_[i].end += boxes.size();
      bytes_.replace(around_[i].begin, 4, four_bytes(around_[i].end - around_[i].begin));
    }
  }

  std::string bytes_;
  const std::string& name_;
  // moov, trak, mdia, minf, stbl, stsd, and the sample entry: how the pictures are coded.
  std::vector<Place> around_{};
};

// Where the description is in a video, and where what is free behind it ends.
struct FoundDescription {
  Place movie{};
  std::uint64_t free_end = 0;
};

class VideoFile {
 public:
  VideoFile(const fs::path& file, std::ios::openmode mode, std::string name)
      : name_(std::move(name)) {
    require_regular_file(file);
    stream_.open(file, mode | std::ios::binary);
    std::error_code error;
    size_ = fs::file_size(file, error);
    if (!stream_ || error) throw Error("cannot read " + name_);
  }

  std::string read(Place place) {
    std::string bytes(static_cast<std::size_t>(place.end - place.begin), '\0');
    stream_.seekg(static_cast<std::streamoff>(place.begin));
    stream_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!stream_) throw Error("cannot read " + name_ + ": it is cut short");
    return bytes;
  }

  void write(std::uint64_t at, const std::string& bytes) {
    stream_.seekp(static_cast<std::streamoff>(at));
    stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream_.flush();
    if (stream_) return;
    throw Error("cannot write " + name_ + ": " + std::generic_category().message(errno));
  }

  // Looks at all boxes of the file, so that one that is cut short is noticed.
  FoundDescription find() {
    std::optional<FoundDescription> found;
    for (std::uint64_t at = 0; at < size_;) {
      const std::string head = read({at, std::min(at + 16, size_)});
      std::uint64_t size = number(head, 0, 4);
      if (size == 0) size = size_ - at;          // up to the end of the file
      if (size == 1) size = number(head, 8, 8);  // the size is behind the type
      if (head.size() < kHeader || size < kHeader || size > size_ - at) {
        throw Error(fmt::format(
            "{}: not a complete video: byte {} begins no box that ends in the file", name_, at));
      }
      const std::string_view type = std::string_view(head).substr(4, 4);
      if (found && type == "free" && found->movie.end == at) found->free_end = at + size;
      at += size;
      if (!found && type == "moov") found = FoundDescription{{at - size, at}, at};
    }
    if (!found) throw Error(name_ + ": not a complete video: it has no description");
    if (found->movie.end - found->movie.begin > kMostDescription) {
      throw Error(name_ + ": the description of the video is too long");
    }
    return *found;
  }

 private:
  std::string name_;
  std::fstream stream_{};
  std::uint64_t size_ = 0;
};

}  // namespace

VideoFacts read_video(const fs::path& file) {
  const std::string name = file.string();
  VideoFile video(file, std::ios::in, name);
  return Description(video.read(video.find().movie), name).facts();
}

void set_spherical(const fs::path& file, StereoMode stereo, const std::string& name) {
  VideoFile video(file, std::ios::in | std::ios::out, name);
  const FoundDescription found = video.find();
  Description description(video.read(found.movie), name);
  description.add_spherical(stereo);
  const std::uint64_t end = found.movie.begin + description.bytes().size();
  if (end + kHeader > found.free_end) {
    throw Error(name + ": there is no room in the video to say that it is a panorama");
  }
  video.write(found.movie.begin, description.bytes() + four_bytes(found.free_end - end) + "free");
}

}  // namespace raywalk::render
