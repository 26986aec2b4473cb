#include "build_lf/exposure/make_gains.h"

#include <gmock/gmock.h>

#include <fstream>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

class MakeGainsTest : public ::testing::Test {
 protected:
  void write(double gain_of_z1, bool distances = true) {
    SyntheticRoomSpec spec;
    spec.spacing_m = 0.5;
    spec.distances = distances;
    spec.line_gain["z1"] = gain_of_z1;
    write_synthetic_room(spec, room_);
  }

  bool has_file() const { return fs::exists(gains_path(room_)); }

  TestDirectory directory_;
  fs::path room_ = directory_ / "room.lf";
};

TEST_F(MakeGainsTest, AreStoredWithTheRoom) {
  write(0.8);
  const GainsSummary summary = make_gains(room_);
  EXPECT_EQ(summary.stations, 12);
  EXPECT_EQ(summary.local, 0);
  EXPECT_NEAR(summary.largest, std::pow(0.8, -0.75), 0.02);  // the mean of the logarithms is 0
  const Room room = Room::open(room_);
  ASSERT_FALSE(room.gains().empty());
  for (int station = 0; station < 3; ++station) {
    const auto i = static_cast<size_t>(station);
    EXPECT_NEAR(room.gains()[3][i].whole[1] / room.gains()[0][i].whole[1], 1.25, 0.02);
  }
  EXPECT_THAT(text_of(summary), HasSubstr("gains to 12 of 12 stations, 0 of them locally"));
}

TEST_F(MakeGainsTest, AreTheSameWhenSolvedAgain) {
  write(0.8);
  make_gains(room_);
  const GainFields before = Room::open(room_).gains();
  make_gains(room_);
  const GainFields after = Room::open(room_).gains();
  for (std::size_t line = 0; line < before.size(); ++line) {
    for (std::size_t i = 0; i < before[line].size(); ++i) {
      EXPECT_EQ(after[line][i].whole, before[line][i].whole);
    }
  }
  EXPECT_TRUE(read_manifest(room_).gains);
}

TEST_F(MakeGainsTest, LeaveNoTraceInARoomThatNeedsNone) {
  write(1.0);
  const std::string manifest = read_file(manifest_path(room_));
  const GainsSummary summary = make_gains(room_);
  EXPECT_EQ(summary.corrected, 0);
  EXPECT_THAT(text_of(summary), HasSubstr("need no gains"));
  EXPECT_FALSE(has_file());
  EXPECT_EQ(read_file(manifest_path(room_)), manifest);
}

TEST_F(MakeGainsTest, CanBeRemoved) {
  write(0.8);
  EXPECT_FALSE(remove_gains(room_));
  make_gains(room_);
  EXPECT_TRUE(remove_gains(room_));
  EXPECT_FALSE(has_file());
  EXPECT_THAT(Room::open(room_).gains(), IsEmpty());
}

TEST_F(MakeGainsTest, TakeThePlaceOfDamagedOnes) {
  write(0.8);
  make_gains(room_);
  std::ofstream(gains_path(room_)) << "not HDF5";
  EXPECT_THROW(Room::open(room_), Error);
  make_gains(room_);
  EXPECT_FALSE(Room::open(room_).gains().empty());
  std::ofstream(gains_path(room_)) << "not HDF5";
  EXPECT_TRUE(remove_gains(room_));
  EXPECT_THAT(Room::open(room_).gains(), IsEmpty());
}

TEST_F(MakeGainsTest, NeedDistances) {
  write(0.8, false);
  EXPECT_THAT([&] { make_gains(room_); },
              ThrowsMessage<Error>(HasSubstr("raywalk-build-lf depth")));
  EXPECT_FALSE(has_file());
}

}  // namespace
}  // namespace raywalk::build_lf
