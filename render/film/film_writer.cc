#include "render/film/film_writer.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/output_folder.h"
#include "render/film/film_file.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

cv::Size even(cv::Size size) {
  require_film_size(size);
  return size;
}

bool is_film_of_raywalk(const fs::path& file) {
  try {
    return read_film(file).by_raywalk;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

void require_writable_film(const fs::path& file, bool replace) {
  if (!replace) require_absent(file, "--video");
  std::error_code none;
  if (fs::exists(file, none) && !is_film_of_raywalk(file)) {
    throw Error(file.string() + " is not a film of Raywalk's, so --force does not replace it");
  }
  const AtomicFile probe(file);
}

void require_film_size(cv::Size size) {
  if (size.width % 2 == 0 && size.height % 2 == 0) return;
  throw UsageError(
      fmt::format("a film of {}x{} pixels is not possible: give --size with two even "
                  "numbers",
                  size.width, size.height));
}

FilmWriter::FilmWriter(const FilmSettings& settings, cv::Size size,
                       std::optional<StereoMode> stereo, const fs::path& file)
    : target_(file),
      size_(even(size)),
      stereo_(stereo),
      encoded_(file),
      complete_(file),
      encoder_(settings, size, encoded_.temporary_path(), file.string()) {}

void FilmWriter::finish() {
  encoder_.finish();
  complete_film(encoded_.temporary_path(), stereo_, complete_.temporary_path(), target_.string());
  const FilmFacts written = read_film(complete_.temporary_path());
  const bool spherical = written.spherical && written.spherical->is_equirectangular;
  if (written.frames != encoder_.frames() || written.width != size_.width ||
      written.height != size_.height || spherical != stereo_.has_value() ||
      (stereo_ && written.spherical->stereo != *stereo_)) {
    throw Error(
        fmt::format("cannot write {}: read again, the film has {} frames of {}x{}, not {} "
                    "of {}x{}; is the disk full?",
                    target_.string(), written.frames, written.width, written.height,
                    encoder_.frames(), size_.width, size_.height));
  }
  complete_.commit();
}

}  // namespace raywalk::render
