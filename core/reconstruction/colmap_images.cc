#include "core/reconstruction/colmap_images.h"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string_view>

#include "core/files/atomic_output.h"
#include "core/files/words.h"
#include "core/reconstruction/colmap_bytes.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::numeric_limits<std::uint32_t>::max();
constexpr std::int32_t kEquirectangularModel = 17;  // COLMAP's number of EQUIRECTANGULAR

void require_images(const std::vector<ColmapImagePose>& images, const std::string& source) {
  if (images.empty()) throw Error(source + ": holds no image; COLMAP has not registered any");
  std::set<std::string> names;
  for (const ColmapImagePose& image : images) {
    if (image.name.empty()) throw Error(source + ": an image has no name");
    if (!names.insert(image.name).second) {
      throw Error(fmt::format("{}: image {} is there twice", source, excerpt(image.name)));
    }
  }
}

// A line of a text and its number, counted from 1.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  std::optional<std::string_view> next() {
    if (rest_.empty()) return std::nullopt;
    ++number_;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }
  int number() const { return number_; }

 private:
  std::string_view rest_;
  int number_ = 0;
};

// The next word of a line; empty at its end.
std::string_view take_word(std::string_view* line) {
  line->remove_prefix(std::min(line->find_first_not_of(" \t"), line->size()));
  const std::size_t end = std::min(line->find_first_of(" \t"), line->size());
  const std::string_view word = line->substr(0, end);
  line->remove_prefix(end);
  return word;
}

// IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME; the name may hold spaces.
ColmapImagePose image_of(std::string_view line, const std::string& where) {
  const auto number = [&] {
    const std::string_view word = take_word(&line);
    const std::optional<double> value = parse_finite_number(word);
    if (!value) {
      throw Error(fmt::format(
          "{}: {} is not a number; expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", where,
          excerpt(word)));
    }
    return *value;
  };
  number();  // id
  const double w = number(), x = number(), y = number(), z = number();
  const Eigen::Quaterniond rotation(w, x, y, z);
  if (!(rotation.norm() > 0.5 && rotation.norm() < 2.0)) {
    throw Error(where + ": the rotation is not a quaternion; the model is damaged");
  }
  const double tx = number(), ty = number(), tz = number();
  number();  // camera
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  return {std::string(line), {rotation.normalized(), {tx, ty, tz}}};
}

}  // namespace

std::vector<ColmapImagePose> colmap_images_of_bytes(std::string bytes, const std::string& source) {
  ColmapByteReader in(std::move(bytes), source);
  std::vector<ColmapImagePose> images(in.take_count(73));
  for (ColmapImagePose& image : images) {
    in.take<std::uint32_t>();  // id
    image.pose = in.take_pose();
    in.take<std::uint32_t>();  // camera
    image.name = in.take_text();
    in.skip(24 * in.take_count(24));  // features
  }
  in.require_end();
  require_images(images, source);
  return images;
}

std::vector<ColmapImagePose> colmap_images_of_text(const std::string& text,
                                                   const std::string& source) {
  std::vector<ColmapImagePose> images;
  Lines lines(text);
  while (const std::optional<std::string_view> line = lines.next()) {
    if (line->empty() || line->starts_with('#')) continue;
    images.push_back(image_of(*line, fmt::format("{}:{}", source, lines.number())));
    lines.next();  // its features, perhaps none
  }
  require_images(images, source);
  return images;
}

std::vector<ColmapImagePose> read_colmap_images(const fs::path& directory) {
  const fs::path binary = directory / "images.bin";
  if (fs::exists(binary))
    return colmap_images_of_bytes(read_file(binary, kMostBytes), binary.string());
  const fs::path text = directory / "images.txt";
  if (fs::exists(text)) return colmap_images_of_text(read_file(text, kMostBytes), text.string());
  throw Error(directory.string() +
              ": holds neither images.bin nor images.txt; give the folder of a COLMAP model, such "
              "as sparse/0");
}

// A camera is ID MODEL WIDTH HEIGHT PARAMETERS.
bool images_are_panoramas(const fs::path& directory) {
  const fs::path binary = directory / "cameras.bin";
  if (fs::exists(binary)) {
    ColmapByteReader in(read_file(binary, kMostBytes), binary.string());
    if (in.take<std::uint64_t>() == 0) return false;
    in.take<std::uint32_t>();
    return in.take<std::int32_t>() == kEquirectangularModel;
  }
  if (!fs::exists(directory / "cameras.txt")) return false;
  const std::string text = read_file(directory / "cameras.txt", kMostBytes);
  Lines lines(text);
  while (std::optional<std::string_view> line = lines.next()) {
    if (line->empty() || line->starts_with('#')) continue;
    take_word(&*line);
    return take_word(&*line) == "EQUIRECTANGULAR";
  }
  return false;
}

}  // namespace raywalk
