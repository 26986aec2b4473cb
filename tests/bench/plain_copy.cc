#include "tests/bench/plain_copy.h"

#include <fcntl.h>
#include <unistd.h>

#include "core/base/error.h"

namespace raywalk::bench {
namespace {

namespace fs = std::filesystem;

void flush_to_disk(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  const bool flushed = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!flushed) throw Error("cannot flush " + file.string());
}

}  // namespace

void copy_to_disk(const fs::path& from, const fs::path& to) {
  fs::copy(from, to, fs::copy_options::recursive);
  if (!fs::is_directory(to)) {
    flush_to_disk(to);
    return;
  }
  for (const auto& entry : fs::recursive_directory_iterator(to)) {
    if (entry.is_regular_file()) flush_to_disk(entry.path());
  }
}

}  // namespace raywalk::bench
