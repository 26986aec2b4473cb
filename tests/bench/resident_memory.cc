#include "tests/bench/resident_memory.h"

#include <malloc.h>

#include <fstream>
#include <string>

#include "core/base/error.h"

namespace raywalk {
namespace {

double status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0.0;
    if (word == key && status >> kilobytes) return kilobytes * 1024.0;
  }
  throw Error("/proc/self/status has no " + key + "; measuring memory needs Linux");
}

}  // namespace

double resident_bytes() { return status_bytes("VmRSS:"); }

double mapped_resident_bytes() { return status_bytes("RssFile:"); }

double peak_resident_bytes() { return status_bytes("VmHWM:"); }

void reset_peak_resident() {
  std::ofstream("/proc/self/clear_refs") << "5";  // 5: reset the peak resident set size
}

void release_free_memory() { malloc_trim(0); }

}  // namespace raywalk
