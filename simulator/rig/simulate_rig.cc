#include "simulator/rig/simulate_rig.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/base/clock.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/files/file_lock.h"
#include "core/files/json.h"
#include "simulator/rig/rig.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// The file with the rig's addresses. A stale one, left by a killed rig, is removed first.
class RigNotice {
 public:
  explicit RigNotice(fs::path file) : file_(std::move(file)) { remove(); }
  ~RigNotice() { remove(); }
  RigNotice(const RigNotice&) = delete;
  RigNotice& operator=(const RigNotice&) = delete;

  void write(const Rig& rig) const {
    const nlohmann::json notice = {{"slider", fs::absolute(rig.slider_device()).string()},
                                   {"modbus_port", rig.modbus_port()},
                                   {"camera_url", rig.camera_url()},
                                   {"pid", getpid()}};
    write_file_atomically(file_, json_text(notice));
  }

 private:
  void remove() const {
    std::error_code ignored;
    fs::remove(file_, ignored);
  }

  fs::path file_;
};

}  // namespace

void simulate_rig(const RigConfig& config, const fs::path& out) {
  make_directories(out);
  const FileLock lock(out / "rig.lock", "another simulated rig uses it");
  const RigNotice notice(out / "rig.json");
  SystemClock clock;
  const Rig rig(config, out, &clock);
  notice.write(rig);
  fmt::print("{}\n", escaped((out / "rig.json").string()));
  std::fflush(stdout);
  while (!interrupt_requested()) clock.sleep(duration_from_ms(100.0));
}

}  // namespace raywalk::capture
