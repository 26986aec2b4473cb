#include "render/serve/private_directory.h"

#include <stdlib.h>

#include <string>
#include <system_error>

#include "core/base/error.h"

namespace raywalk::render {

PrivateDirectory::PrivateDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "raywalk-serve-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw Error("cannot make the directory " + name +
                "; set TMPDIR to a writable one or give --export");
  }
  path_ = name;
}

PrivateDirectory::~PrivateDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace raywalk::render
