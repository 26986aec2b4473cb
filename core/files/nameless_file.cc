#include "core/files/nameless_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/base/error.h"
#include "core/files/temporary_names.h"

namespace raywalk {

NamelessFile::NamelessFile(const std::filesystem::path& directory) {
  // Under a name that is known to be left over if the program is killed before the next line.
  const std::filesystem::path path = temporary_beside(directory / "values");
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor_ < 0) {
    throw Error(fmt::format("{}: cannot write there: {}", directory.string(),
                            std::generic_category().message(errno)));
  }
  ::unlink(path.c_str());
}

NamelessFile::~NamelessFile() { ::close(descriptor_); }

}  // namespace raywalk
