#include "capture/import/match_pictures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

const WallTime kStart = std::chrono::sys_days{std::chrono::year{2026} / 5 / 1} + 9h;

// Two lines of stations five seconds apart, with two minutes between the lines. The camera's clock
// is a little over an hour ahead and counts whole seconds.
class MatchPicturesTest : public testing::Test {
 protected:
  MatchPicturesTest() {
    for (int line = 0; line < 2; ++line) {
      for (int i = 0; i < kPerLine; ++i) add_station(line, i);
    }
  }

  static WallTime asked_at(int line, int i) { return kStart + line * 160s + i * 5s; }
  static WallTime camera_time(WallTime time) {
    return std::chrono::floor<std::chrono::seconds>(time + 3607s + 300ms);
  }
  void add_station(int line, int i) {
    ExposedStation station;
    station.attempt = {line * 100 + i, fmt::format("x{}_{:03}", line, i), 1};
    station.from = station.to = asked_at(line, i);
    session_.stations.push_back(station);
    add_shot(asked_at(line, i), fmt::format("R{:04}.JPG", session_.stations.size()));
  }
  void add_shot(WallTime time, const std::string& name) {
    card_.shots.push_back({camera_time(time), {{"card/" + name, FrameLens::kBoth}}});
    std::stable_sort(card_.shots.begin(), card_.shots.end(),
                     [](const CardShot& a, const CardShot& b) { return a.time < b.time; });
  }
  void lose_shot(std::size_t index) {
    card_.shots.erase(card_.shots.begin() + static_cast<std::ptrdiff_t>(index));
  }

  static constexpr int kPerLine = 10;
  SessionShots session_;
  CardPictures card_;
};

TEST_F(MatchPicturesTest, EveryStationGetsItsPictureAndTheClocksAreCompared) {
  const PictureMatch match = match_pictures(session_, card_);
  EXPECT_TRUE(is_complete(match, card_));
  ASSERT_EQ(match.complete.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(match.complete[i].station, i);
    EXPECT_THAT(match.complete[i].shots, ElementsAre(i));
  }
  EXPECT_NEAR(match.clock_offset_s, 3607.3, 0.5);
  EXPECT_THAT(describe_mismatches(match, session_, card_), IsEmpty());
}

TEST_F(MatchPicturesTest, MissingAndUnassignedPicturesAreListed) {
  lose_shot(13);
  lose_shot(4);
  add_shot(asked_at(0, 7) + 2500ms, "EXTRA.JPG");
  const PictureMatch match = match_pictures(session_, card_);
  EXPECT_FALSE(is_complete(match, card_));
  EXPECT_EQ(match.complete.size(), 18U);
  EXPECT_THAT(describe_mismatches(match, session_, card_),
              AllOf(HasSubstr("2 of 20 stations lack pictures: x0_004, x1_003"),
                    HasSubstr("1 of 19 pictures belong to no station: EXTRA.JPG")));
}

TEST_F(MatchPicturesTest, APictureOfAFailedAttemptIsNotAMismatch) {
  session_.failed.push_back({asked_at(0, 9) + 3s, asked_at(0, 9) + 20s});
  add_shot(asked_at(0, 9) + 11s, "AGAIN.JPG");
  const PictureMatch match = match_pictures(session_, card_);
  EXPECT_TRUE(is_complete(match, card_));
  EXPECT_THAT(match.from_failed, ElementsAre(10U));
}

TEST_F(MatchPicturesTest, AStationImportedBeforeIsNotIncomplete) {
  lose_shot(4);
  session_.stations[4].imported = true;
  EXPECT_TRUE(is_complete(match_pictures(session_, card_), card_));
}

TEST_F(MatchPicturesTest, AStationWithTooFewOfItsExposuresIsNotComplete) {
  session_.exposures = 3;
  card_.shots.clear();
  for (ExposedStation& station : session_.stations) {
    station.to = station.from + 1500ms;
    for (int i = 0; i < 3; ++i) {
      add_shot(station.from + i * 500ms, fmt::format("{}_{}.JPG", station.attempt.station, i));
    }
  }
  EXPECT_TRUE(is_complete(match_pictures(session_, card_), card_));
  lose_shot(16);  // the second of the sixth station
  const PictureMatch match = match_pictures(session_, card_);
  EXPECT_EQ(match.complete.size(), 19U);
  EXPECT_THAT(describe_mismatches(match, session_, card_), HasSubstr("x0_005 (2 of 3)"));
}

TEST_F(MatchPicturesTest, AnAmbiguousAssignmentIsRefused) {
  session_.stations.resize(kPerLine);  // one line of equal intervals ...
  card_.shots.resize(kPerLine - 1);    // ... of which an end is missing
  EXPECT_THAT([&] { match_pictures(session_, card_); },
              ThrowsMessage<Error>(AllOf(HasSubstr("9 pictures for 10"),
                                         HasSubstr("do not determine the assignment"))));
}

TEST_F(MatchPicturesTest, PicturesOfAnotherSessionAreRefused) {
  for (std::size_t i = 0; i < card_.shots.size(); ++i) {
    card_.shots[i].time = kStart + std::chrono::seconds(i * i * 37);
  }
  EXPECT_THAT([&] { match_pictures(session_, card_); },
              ThrowsMessage<Error>(HasSubstr("are they of another session?")));
  card_.shots.clear();
  EXPECT_THAT([&] { match_pictures(session_, card_); }, ThrowsMessage<Error>(HasSubstr("0 pic")));
}

TEST_F(MatchPicturesTest, AClockThatJumpsIsNamed) {
  for (CardShot& shot : card_.shots) {
    const std::string name = shot.files[0].file.filename().string();
    if (name <= "R0002.JPG") shot.time += 12h + 39min;
  }
  std::ranges::stable_sort(card_.shots, {}, &CardShot::time);
  EXPECT_THAT([&] { match_pictures(session_, card_); },
              ThrowsMessage<Error>(
                  AllOf(HasSubstr("clock jumps by -45540 s between R0002.JPG and R0003.JPG"),
                        HasSubstr("--station x0_000"))));
  const PictureMatch named = assign_by_name(session_, card_, "x0_000");
  ASSERT_EQ(named.complete.size(), 20U);
  EXPECT_TRUE(is_complete(named, card_));
  EXPECT_EQ(card_.shots[named.complete[1].shots[0]].files[0].file, "card/R0002.JPG");
}

TEST_F(MatchPicturesTest, PicturesAreAssignedByHandFromAStationOn) {
  card_.shots.resize(2);
  const PictureMatch match = assign_by_name(session_, card_, "x1_003");
  ASSERT_EQ(match.complete.size(), 2U);
  EXPECT_EQ(match.complete[0].station, 13U);
  EXPECT_THAT(match.complete[1].shots, ElementsAre(1U));
  EXPECT_THAT([&] { assign_by_name(session_, card_, "x1_009"); },
              ThrowsMessage<Error>(HasSubstr("2 pictures for the 1 stations from x1_009 on")));
  EXPECT_THAT([&] { assign_by_name(session_, card_, "x7"); },
              ThrowsMessage<Error>(HasSubstr("'x7' has no pictures on the card")));
}

TEST_F(MatchPicturesTest, ALongListOfMismatchesIsShortened) {
  for (const std::size_t lost : {17, 15, 13, 12, 11, 6, 5, 4, 3}) lose_shot(lost);
  const PictureMatch match = match_pictures(session_, card_);
  EXPECT_THAT(describe_mismatches(match, session_, card_), HasSubstr("and 1 more"));
}

}  // namespace
}  // namespace raywalk::capture
