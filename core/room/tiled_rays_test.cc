#include "core/room/tiled_rays.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/room/hdf5_file.h"
#include "core/room/line_volume.h"
#include "core/room/mapped_dataset.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr PanoramaSize kTiledSize{96, 48};
constexpr int kTiledStations = 3;
constexpr int kTileColumns = 12;

std::vector<std::uint8_t> tiled_station_rays(int station) {
  std::vector<std::uint8_t> rays;
  for (int u = 0; u < kTiledSize.width; ++u) {
    for (int v = 0; v < kTiledSize.height; ++v) {
      for (int c = 0; c < 3; ++c) {
        rays.push_back(
            static_cast<std::uint8_t>(3 * u + 5 * v * (c + 1) + u * v / 7 + 40 * station));
      }
    }
  }
  return rays;
}

class TiledRaysTest : public testing::Test {
 protected:
  // Writes a line and returns what each station decodes to.
  std::vector<std::vector<std::uint8_t>> write(const RayForm& form) {
    std::vector<std::vector<std::uint8_t>> decoded;
    Hdf5File hdf5 = Hdf5File::create(file_);
    hdf5.write_format(kLineVolumeFormat);
    {
      TiledRaysWriter writer(&hdf5, form, kTiledStations, kTiledSize, {kTiledSize, kTileColumns});
      for (const int station : {2, 0, 1}) {
        std::vector<std::uint8_t> rays = tiled_station_rays(station);
        const TiledRaysWriter::Encoded tiles = writer.encode(rays);
        writer.write(station, tiles);
        tiles_.insert(tiles_.end(), tiles.begin(), tiles.end());
        decoded.push_back(rays);
      }
      writer.complete();
    }
    hdf5.close();
    std::rotate(decoded.begin(), decoded.begin() + 1, decoded.end());
    return decoded;
  }

  // Overwrites a byte of the first encoded tile, which is of station 2.
  void damage() const {
    std::string content = read_file(file_);
    const std::string tile(tiles_[0].begin(), tiles_[0].end());
    content[content.find(tile) + tile.size() / 2] ^= 0x55;
    write_file_atomically(file_, content);
  }

  LineVolume open() const { return LineVolume::open(file_, kTiledStations, kTiledSize); }

  TestDirectory directory_;
  fs::path file_ = directory_ / "line.h5";
  TiledRaysWriter::Encoded tiles_;
};

class TiledFormsTest : public TiledRaysTest, public testing::WithParamInterface<RayForm> {};

TEST_P(TiledFormsTest, DecodeToWhatWasWritten) {
  const auto written = write(GetParam());
  const LineVolume volume = open();
  EXPECT_EQ(volume.form(), GetParam());
  const std::vector<int> order{2, 0};
  const LineVolume part = volume.subset(order);
  for (int station = 0; station < kTiledStations; ++station) {
    const TileReading reading;
    EXPECT_TRUE(
        std::ranges::equal(volume.columns(station), written[static_cast<std::size_t>(station)]));
    if (GetParam().kind == RayForm::Kind::kLossless) {
      EXPECT_EQ(written[static_cast<std::size_t>(station)], tiled_station_rays(station));
    }
  }
  const TileReading reading;
  EXPECT_TRUE(std::ranges::equal(part.column(0, 95), volume.column(2, 95)));
}

TEST_P(TiledFormsTest, ReportDamage) {
  write(GetParam());
  damage();
  const LineVolume volume = open();
  const TileReading reading;
  EXPECT_NO_THROW(volume.columns(0));
  // It can be asked for again, and its neighbours are there.
  for (int attempt = 0; attempt < 2; ++attempt) {
    EXPECT_THAT(error_of([&] { volume.columns(2); }),
                testing::AllOf(HasSubstr("line.h5: tile "),
                               HasSubstr("of station 2 cannot be decoded; restore the file")));
  }
}

TEST_P(TiledFormsTest, TilesThatAreCutShortAreDamaged) {
  write(GetParam());
  const TileLayout layout(kTiledSize, kTileColumns);
  std::vector<std::uint8_t> rgb(layout.tile_bytes(), 99);
  for (std::size_t bytes = 0; bytes < tiles_[0].size(); bytes += 1 + bytes / 8) {
    EXPECT_FALSE(
        decode_tile(GetParam().kind, layout.tile(), std::span(tiles_[0]).first(bytes), rgb.data()))
        << bytes;
  }
}

INSTANTIATE_TEST_SUITE_P(Forms, TiledFormsTest,
                         testing::Values(RayForm{RayForm::Kind::kLossless, 0},
                                         RayForm{RayForm::Kind::kJpeg, 80}));

TEST_F(TiledRaysTest, CannotBeReadWithoutATileReading) {
  write({RayForm::Kind::kLossless, 0});
  const LineVolume volume = open();
  EXPECT_THROW(volume.column(0, 0), std::logic_error);
}

TEST_F(TiledRaysTest, TablesThatPointElsewhereAreRejected) {
  write({RayForm::Kind::kLossless, 0});
  const std::vector<std::uint64_t> places = Hdf5File::open(file_).read<std::uint64_t>("tiles");
  std::string content = read_file(file_);
  const std::string first(reinterpret_cast<const char*>(places.data()), 16);
  const std::size_t at = content.find(first);
  for (const std::uint64_t place : {std::uint64_t{0}, std::uint64_t{1} << 60, places[2]}) {
    content.replace(at, sizeof(place), reinterpret_cast<const char*>(&place), sizeof(place));
    write_file_atomically(file_, content);
    const LineVolume volume = open();
    const TileReading reading;
    EXPECT_THROW(volume.column(0, 0), Error) << place;
    EXPECT_NO_THROW(volume.column(0, 95));
  }
}

TEST_F(TiledRaysTest, AreInMemoryUntilTheyAreEvicted) {
  write({RayForm::Kind::kLossless, 0});
  const LineVolume volume = open();
  const std::size_t column_bytes = 3 * static_cast<std::size_t>(kTiledSize.height);
  volume.fetch(1, 0, column_bytes);
  EXPECT_FALSE(volume.in_memory(1, 0));
  {
    const TileReading reading;
    const std::vector<std::uint8_t> expected = tiled_station_rays(1);
    EXPECT_TRUE(std::ranges::equal(volume.column(1, 0), std::span(expected).first(column_bytes)));
  }
  EXPECT_TRUE(volume.in_memory(1, kTileColumns - 1));
  EXPECT_FALSE(volume.in_memory(1, kTileColumns));
  EXPECT_FALSE(volume.in_memory(0, 0));
  TileCache::of_process().set_limit_bytes(0);
  EXPECT_FALSE(volume.in_memory(1, 0));
  TileCache::of_process().set_limit_bytes(TileCache::default_limit_bytes());
}

TEST_F(TiledRaysTest, ThreadsShareACacheThatHoldsNextToNothing) {
  write({RayForm::Kind::kLossless, 0});
  const LineVolume volume = open();
  TileCache& cache = TileCache::of_process();
  cache.set_limit_bytes(10'000);
  const TileCounts before = cache.counts();
  set_thread_count(4);
  parallel_for(0, 400, 1, [&](int begin, int) {
    const TileReading reading;
    for (int i = 0; i < 5; ++i) {
      const int station = (begin + i) % kTiledStations;
      const int theta = (begin * 37 + i * 11) % kTiledSize.width;
      const auto column = volume.column(station, theta);
      const std::vector<std::uint8_t> expected = tiled_station_rays(station);
      EXPECT_TRUE(std::equal(column.begin(), column.end(),
                             expected.begin() + theta * 3 * kTiledSize.height));
    }
  });
  set_thread_count(0);
  const TileCounts after = cache.counts();
  cache.set_limit_bytes(TileCache::default_limit_bytes());
  EXPECT_GT(after.evicted, before.evicted + 50);
  EXPECT_LE(after.bytes, 10'000U);
}

TEST(RayFormTest, NamesAreReadAsTheyAreWritten) {
  for (const char* name : {"none", "lossless", "jpeg:1", "jpeg:100"}) {
    EXPECT_EQ(name_of(ray_form_from_name(name)), name);
  }
  for (const char* name :
       {"", "jpeg", "jpeg:", "jpeg:0", "jpeg:101", "jpeg:9x", "zstd", "Lossless"}) {
    EXPECT_THROW(ray_form_from_name(name), UsageError) << name;
  }
}

TEST(TileLayoutTest, TilesOfUsualSizeCoverAStation) {
  for (const int width : {1000, 4096, 5760, 7040, 11008}) {
    const TileLayout layout = TileLayout::usual({width, width / 2});
    EXPECT_EQ(layout.tiles() * layout.tile().columns, width);
    EXPECT_LE(layout.tile_bytes(), 3U * 16U * static_cast<unsigned>(std::max(1024, width / 2)));
    EXPECT_EQ(layout.tile_of(layout.bytes_of(1).begin), 1);
    EXPECT_EQ(layout.tile_of(layout.bytes_of(1).begin - 1), 0);
    EXPECT_EQ(layout.tile_of(layout.station_bytes() + 15), layout.tiles() - 1);
  }
}

// Advice to the page cache; room_test.cc covers opening datasets.
TEST(MappedDataset, FetchesLittleMoreThanRequested) {
  const TestDirectory directory;
  const fs::path path = directory / "cold.h5";
  constexpr std::size_t kRowBytes = std::size_t{1} << 20;
  Hdf5File file = Hdf5File::create(path);
  const std::vector<std::uint8_t> values(4 * kRowBytes, 7);
  file.create_contiguous("rays", ElementType::kUint8, {1, values.size()});
  file.write_slab("rays", 0, values.data());
  file.close();
  // Dropped from the page cache if the file system supports it.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  EXPECT_EQ(::fsync(descriptor), 0);
  EXPECT_EQ(::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED), 0);
  ::close(descriptor);
  const MappedDataset mapped(Hdf5File::open(path), "rays", ElementType::kUint8);
  mapped.expect_scattered_reads();
  const auto* rays = static_cast<const std::uint8_t*>(mapped.data());
  const std::uint8_t* const middle = rays + 2 * kRowBytes + kRowBytes / 2;
  if (mapped.in_memory(middle)) GTEST_SKIP() << "this file system does not drop cached pages";
  // More than the system reads per call.
  mapped.fetch(rays + 2 * kRowBytes, kRowBytes);
  for (int i = 0; i < 1000 && !mapped.in_memory(rays + 3 * kRowBytes - 1); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(mapped.in_memory(rays + 2 * kRowBytes));
  EXPECT_TRUE(mapped.in_memory(middle));
  EXPECT_TRUE(mapped.in_memory(rays + 3 * kRowBytes - 1));
  EXPECT_FALSE(mapped.in_memory(rays + kRowBytes / 2));
}

}  // namespace
}  // namespace raywalk
