#include "capture/import/match_pictures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

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
    const WallTime at = asked_at(line, i);
    session_.stations.push_back({{line * 100 + i, fmt::format("x{}_{:03}", line, i), 1}, at, at});
    add_shot(at, fmt::format("R{:04}.JPG", session_.stations.size()));
  }
  void add_shot(WallTime time, const std::string& name) {
    card_.shots.push_back({{"card/" + name, camera_time(time)}});
    sort_shots();
  }
  void sort_shots() {
    std::ranges::stable_sort(card_.shots, {}, [](const CardShot& shot) { return shot[0].time; });
  }
  void lose_shot(std::size_t index) {
    card_.shots.erase(card_.shots.begin() + static_cast<std::ptrdiff_t>(index));
  }
  PictureMatch match() const { return match_pictures(session_, card_); }
  PictureMatch match_from(const std::string& station) const {
    return assign_by_name(session_, card_, station);
  }

  static constexpr int kPerLine = 10;
  SessionShots session_;
  CardPictures card_;
};

TEST_F(MatchPicturesTest, EveryStationGetsItsPictureAndTheClocksAreCompared) {
  const PictureMatch found = match();
  EXPECT_THAT(found.mismatches, IsEmpty());
  ASSERT_EQ(found.complete.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(found.complete[i].station, i);
    EXPECT_THAT(found.complete[i].shots, ElementsAre(i));
  }
  EXPECT_NEAR(found.clock.value().offset_s, 3607.3, 0.5);
}

TEST_F(MatchPicturesTest, MissingAndUnassignedPicturesAreListed) {
  lose_shot(13);
  lose_shot(4);
  add_shot(asked_at(0, 7) + 2500ms, "EXTRA.JPG");
  EXPECT_EQ(match().complete.size(), 18U);
  EXPECT_THAT(match().mismatches, AllOf(HasSubstr("2 of 20 stations lack pictures: x0_004, x1_003"),
                                        HasSubstr("1 of 19 pictures belong to no station: EXTRA")));
  for (const std::size_t lost : {17, 15, 13, 12, 11, 6, 5}) lose_shot(lost);
  EXPECT_THAT(match().mismatches, HasSubstr("and 1 more"));
}

TEST_F(MatchPicturesTest, APictureOfAFailedAttemptOrAStationImportedBeforeIsNotAMismatch) {
  session_.failed.push_back({asked_at(0, 9) + 3s, asked_at(0, 9) + 20s});
  add_shot(asked_at(0, 9) + 11s, "AGAIN.JPG");
  lose_shot(4);
  session_.stations[4].imported = true;
  EXPECT_THAT(match().mismatches, IsEmpty());
  EXPECT_EQ(match().from_failed, 1U);
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
  EXPECT_THAT(match().mismatches, IsEmpty());
  lose_shot(16);  // the second of the sixth station
  EXPECT_EQ(match().complete.size(), 19U);
  EXPECT_THAT(match().mismatches, HasSubstr("x0_005 (2 of 3)"));
}

TEST_F(MatchPicturesTest, AMissingEndIsFoundByAPauseBetweenLinesAndAmbiguousWithout) {
  lose_shot(19);
  EXPECT_THAT(match().mismatches, HasSubstr("1 of 20 stations lack pictures: x1_009"));
  session_.stations.resize(kPerLine);  // one line of equal intervals ...
  card_.shots.resize(kPerLine - 1);    // ... of which an end is missing
  EXPECT_THAT([&] { match(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("9 pictures for 10"),
                                         HasSubstr("do not determine the assignment"))));
}

TEST_F(MatchPicturesTest, PicturesOfAnotherSessionAreRefused) {
  for (std::size_t i = 0; i < card_.shots.size(); ++i) {
    card_.shots[i][0].time = kStart + std::chrono::seconds(i * i * 37);
  }
  EXPECT_THAT([&] { match(); }, ThrowsMessage<Error>(HasSubstr("are they of another session?")));
  card_.shots.clear();
  EXPECT_THAT([&] { match(); }, ThrowsMessage<Error>(HasSubstr("0 pic")));
}

TEST_F(MatchPicturesTest, AClockThatJumpsIsNamed) {
  card_.shots[0][0].time += 12h + 39min;
  card_.shots[1][0].time += 12h + 39min;
  sort_shots();
  EXPECT_THAT([&] { match(); },
              ThrowsMessage<Error>(
                  AllOf(HasSubstr("clock jumps by -45540 s between R0002.JPG and R0003.JPG"),
                        HasSubstr("--station x0_000"))));
  const PictureMatch named = match_from("x0_000");
  ASSERT_EQ(named.complete.size(), 20U);
  EXPECT_THAT(named.mismatches, IsEmpty());
  EXPECT_EQ(card_.shots[named.complete[1].shots[0]][0].file, "card/R0002.JPG");
}

TEST_F(MatchPicturesTest, PicturesAreAssignedByHandFromAStationOn) {
  card_.shots.resize(2);
  const PictureMatch found = match_from("x1_003");
  ASSERT_EQ(found.complete.size(), 2U);
  EXPECT_EQ(found.complete[0].station, 13U);
  EXPECT_THAT(found.complete[1].shots, ElementsAre(1U));
  EXPECT_THAT([&] { match_from("x1_009"); },
              ThrowsMessage<Error>(HasSubstr("2 pictures for the 1 stations from x1_009 on")));
  EXPECT_THAT([&] { match_from("x7"); },
              ThrowsMessage<Error>(HasSubstr("'x7' has no pictures on the card")));
}

double log_uniform(std::mt19937& random, double from, double to) {
  return std::exp(std::uniform_real_distribution<double>(std::log(from), std::log(to))(random));
}

double uniform(std::mt19937& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

WallTime seconds_in(double seconds) {
  return kStart + std::chrono::microseconds(std::llround(1e6 * seconds));
}

// A random session: lines of stations at nearly equal intervals, pauses between them, a camera
// clock with offset, drift, steps and varying lag, missing pictures and surplus pictures.
struct RandomCard {
  SessionShots session{};
  CardPictures card{};
  double offset_s = 0.0;

  explicit RandomCard(std::uint32_t seed) {
    std::mt19937 random(seed);
    card.resolution_s = seed % 3 == 0 ? 0.001 : 1.0;
    const int lines = std::uniform_int_distribution<int>(1, 5)(random);
    const int per_line = static_cast<int>(log_uniform(random, 3.0, 120.0));
    const double interval_s = log_uniform(random, 3.0, 12.0);
    const double interval_jitter_s = log_uniform(random, 1e-3, 1.0);
    std::vector<double> stations_s;
    double now_s = 0.0;
    for (int line = 0; line < lines; ++line) {
      for (int i = 0; i < per_line; ++i) {
        stations_s.push_back(now_s);
        const WallTime at = seconds_in(now_s);
        const auto station = session.stations.size();
        session.stations.push_back({{1, fmt::format("s{}", station), 1}, at, at});
        now_s += interval_s + uniform(random, 0.0, interval_jitter_s);
      }
      now_s += log_uniform(random, 30.0, 3600.0);
    }
    offset_s = uniform(random, -1.0, 1.0) * log_uniform(random, 1.0, 1e8);
    const double drift = uniform(random, -1e-4, 1e-4);
    const double drop_share = uniform(random, -0.05, 0.1);
    const double lag_s = log_uniform(random, 0.01, 0.3);
    std::vector<std::pair<double, std::string>> taken;  // named after their station
    for (std::size_t i = 0; i < stations_s.size(); ++i) {
      if (uniform(random, 0.0, 1.0) < drop_share) continue;
      taken.emplace_back(
          stations_s[i] + offset_s + drift * stations_s[i] + uniform(random, 0.0, lag_s),
          fmt::format("s{}", i));
    }
    const int surplus = std::max(0, std::uniform_int_distribution<int>(-3, 4)(random));
    for (int i = 0; i < surplus; ++i) {
      taken.emplace_back(offset_s + uniform(random, -1000.0, stations_s.back() + 1000.0),
                         "surplus");
    }
    std::ranges::sort(taken);
    for (const auto& [time_s, name] : taken) {
      const double step = std::floor(time_s / card.resolution_s);
      card.shots.push_back({{name, seconds_in(step * card.resolution_s)}});
    }
  }

  // A surplus picture may be taken so close to a station's time that only the station's own picture
  // tells them apart. If that one is missing, or both have the same time, the surplus picture is
  // indistinguishable from it.
  bool may_be_of(const ExposedStation& station, const CardShot& shot) const {
    if (shot[0].file == station.attempt.station) return true;
    const auto seconds = [](auto time) { return std::chrono::duration<double>(time).count(); };
    const double off_s = seconds(shot[0].time - station.from) - offset_s;
    const double allowed_s = 1.5 * card.resolution_s + 0.4 + 0.3 +
                             1e-4 * seconds(station.from - session.stations[0].from);
    return shot[0].file == "surplus" && std::abs(off_s) < allowed_s;
  }
};

TEST(MatchPicturesOverDays, TheDriftIsFollowedOverNights) {
  for (const double drift : {-9e-5, -5e-5, 2e-5, 5e-5, 9e-5}) {
    std::mt19937 random(1);
    SessionShots session;
    CardPictures card;
    double now_s = 0.0;
    for (int i = 0; i < 400; ++i) {
      now_s += uniform(random, 8.0, 9.0) + (i % 150 == 149 ? 16.0 * 3600.0 : 0.0);
      session.stations.push_back(
          {{1, fmt::format("s{}", i), 1}, seconds_in(now_s), seconds_in(now_s)});
      if (i % 97 == 5) continue;
      card.shots.push_back(
          {{fmt::format("s{}", i), seconds_in(std::floor(now_s * (1.0 + drift)))}});
    }
    const PictureMatch match = match_pictures(session, card);
    EXPECT_EQ(match.complete.size(), card.shots.size()) << drift;
    for (const auto& [station, shots] : match.complete) {
      EXPECT_EQ(card.shots[shots[0]][0].file, session.stations[station].attempt.station) << drift;
    }
  }
}

TEST(MatchPicturesProperty, TheMatchIsCorrectOrRefused) {
  int decided = 0;
  constexpr int kCards = 250;
  for (std::uint32_t seed = 0; seed < kCards; ++seed) {
    const RandomCard random(seed);
    try {
      const PictureMatch match = match_pictures(random.session, random.card);
      ++decided;
      for (const StationPictures& pictures : match.complete) {
        const ExposedStation& station = random.session.stations[pictures.station];
        const CardShot& shot = random.card.shots[pictures.shots[0]];
        EXPECT_TRUE(random.may_be_of(station, shot))
            << "seed " << seed << ": " << station.attempt.station << " of "
            << random.session.stations.size() << " got that of " << shot[0].file;
      }
    } catch (const Error&) {
      continue;
    }
  }
  // Most cards can be matched: ambiguity must be the exception.
  EXPECT_GT(decided, kCards * 3 / 4);
}

}  // namespace
}  // namespace raywalk::capture
