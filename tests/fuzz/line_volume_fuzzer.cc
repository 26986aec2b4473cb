// Any file is either a line volume with all columns readable, or rejected with a one-line Error.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/base/error.h"
#include "core/files/test_support.h"
#include "core/room/line_volume.h"
#include "core/room/tiled_rays.h"
#include "tests/fuzz/expect.h"

namespace {

// The shape of the seed volumes.
constexpr int kStations = 2;
constexpr raywalk::PanoramaSize kPanorama = {4, 2};

// Reads every byte of the volume, to detect bytes outside the mapping.
unsigned sum_of(const raywalk::LineVolume& volume) {
  const raywalk::TileReading reading;  // of compressed volumes
  unsigned sum = 0;
  for (int station = 0; station < kStations; ++station) {
    for (int theta = 0; theta < kPanorama.width; ++theta) {
      for (const std::uint8_t value : volume.column(station, theta)) sum += value;
      const raywalk::RowRun rows = volume.valid_rows(station, theta);
      if (!rows.empty() && (rows.begin < 0 || rows.end > kPanorama.height)) std::abort();
    }
  }
  return sum;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const raywalk::TestDirectory directory;
  const std::filesystem::path file = directory / "line.h5";
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const unsigned sum = sum_of(raywalk::LineVolume::open(file, kStations, kPanorama));
    if (sum > 255U * 3 * kStations * kPanorama.width * kPanorama.height) std::abort();
  } catch (const raywalk::Error& e) {
    raywalk::expect_one_line(e);
  }
  return 0;
}
