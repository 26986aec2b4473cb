#include "capture/import/film_stations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "capture/import/test_film.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using namespace std::chrono_literals;
using testing::DoubleNear;
using testing::HasSubstr;
using testing::Optional;
using testing::ThrowsMessage;

const WallTime kEpoch = std::chrono::sys_days{std::chrono::year{2026} / 5 / 1};

TEST(Travel, PositionsAreInterpolatedAndRestAtBothEnds) {
  const Travel travel{"x0", {10.0, 11.0, 13.0}, {100.0, 120.0, 200.0}};
  EXPECT_THAT(travel.position_mm(10.5), Optional(DoubleNear(110.0, 1e-9)));
  EXPECT_THAT(travel.position_mm(12.0), Optional(DoubleNear(160.0, 1e-9)));
  EXPECT_THAT(travel.position_mm(9.0), Optional(100.0));
  EXPECT_THAT(travel.position_mm(14.0), Optional(200.0));
  EXPECT_FALSE(travel.position_mm(10.0 - Travel::kRest_s - 0.01));
  EXPECT_FALSE(travel.position_mm(13.0 + Travel::kRest_s + 0.01));
  EXPECT_DOUBLE_EQ(travel.speed_mm_s(10.5, 11.5), 30.0);
  const Travel back{"x0", {0.0, 1.0}, {10.0, 0.0}};
  EXPECT_DOUBLE_EQ(back.speed_mm_s(0.0, 1.0), 10.0);
}

TEST(Travel, AGapSplitsTheJournalAndSamplesOutOfOrderAreDropped) {
  const std::vector<JournalSample> journal{
      {kEpoch, 0.0},       {kEpoch + 500ms, 5.0}, {kEpoch + 200ms, 99.0}, {kEpoch + 500ms, 99.0},
      {kEpoch + 1s, 10.0}, {kEpoch + 40s, 77.0},  {kEpoch + 90s, 0.0},    {kEpoch + 90500ms, 7.0}};
  const auto travels = travels_of("z1", journal, kEpoch);
  ASSERT_EQ(travels.size(), 2U);  // none of a single sample
  EXPECT_EQ(travels[0].line, "z1");
  EXPECT_THAT(travels[0].position_mm(0.25), Optional(DoubleNear(2.5, 1e-9)));
  EXPECT_THAT(travels[0].position_mm(0.75), Optional(DoubleNear(7.5, 1e-9)));
  EXPECT_THAT(travels[1].position_mm(90.25), Optional(DoubleNear(3.5, 1e-9)));
  EXPECT_FALSE(travels[0].position_mm(45.0));
  EXPECT_TRUE(travels_of("x0", {}, kEpoch).empty());
}

// The track of a film of some passes, without pictures: activity is proportional to the distance
// between two frames and varies along the line with the scene.
struct TrackSettings {
  double offset_s = 0.0;  // journal time minus film time
  double length_s = 20.0;
  double rate_hz = 25.0;
  double noise = 0.1;      // of the activity, in grey levels
  double variation = 0.0;  // relative variation of activity with the scene
  std::uint32_t seed = 1;
};

FilmTrack track_of(const std::vector<TestPass>& passes, const TrackSettings& settings) {
  std::mt19937 random(settings.seed);
  std::normal_distribution<double> noise(0.0, settings.noise);
  FilmTrack track;
  const double step_s = 1.0 / settings.rate_hz;
  for (int i = 0; i * step_s < settings.length_s; ++i) {
    const double now_s = i * step_s + settings.offset_s;
    double moved_mm = 0.0;
    double along_mm = 0.0;
    for (const TestPass& pass : passes) {
      moved_mm += pass.position_mm(now_s) - pass.position_mm(now_s - step_s);
      along_mm += pass.position_mm(now_s);
    }
    const double scene = 1.0 + settings.variation * std::sin(0.05 * along_mm + settings.seed);
    track.frames.push_back(
        {i * step_s, std::max(0.0, 1.5 + 8.0 * moved_mm * scene + noise(random)), 100.0});
  }
  return track;
}

FilmClock match(const FilmTrack& track, const std::vector<TestPass>& passes) {
  std::vector<Travel> travels;
  for (const TestPass& pass : passes) {
    for (const Travel& each : travels_of("x0", pass.journal(kEpoch), kEpoch)) {
      travels.push_back(each);
    }
  }
  return match_film_clock(track, travels, "film.mp4");
}

TEST(FilmClock, TheOffsetIsFoundFromStartsAndStops) {
  struct Case {
    const char* what;
    std::vector<TestPass> passes;
    TrackSettings film;
    double within_s;
  };
  const std::vector<Case> cases{
      {"one pass", {{.start_s = 100.0}}, {.offset_s = 97.654, .length_s = 16.0}, 0.008},
      {"a film that ends before the pass",
       {{.start_s = 100.0, .to_mm = 1200.0}},
       {.offset_s = 98.2, .length_s = 15.0},
       0.02},
      {"two passes told apart by their pause",
       {{.start_s = 100.0}, {.start_s = 130.0}},
       {.offset_s = 98.0, .length_s = 46.0},
       0.01},
  };
  for (const auto& [what, passes, film, within_s] : cases) {
    const FilmClock clock = match(track_of(passes, film), passes);
    EXPECT_NEAR(clock.offset_s, film.offset_s, within_s) << what;
    EXPECT_LT(clock.uncertainty_s, 0.04) << what;
  }
}

TEST(FilmClock, AFilmOfSomethingElseOrTooShortIsRefused) {
  const std::vector<TestPass> passes{{.start_s = 100.0, .to_mm = 1200.0}};
  const std::vector<TestPass> others{{.start_s = 103.0, .to_mm = 60.0},
                                     {.start_s = 106.0, .to_mm = 40.0},
                                     {.start_s = 112.0, .to_mm = 100.0},
                                     {.start_s = 122.0, .to_mm = 30.0}};
  const FilmTrack other = track_of(others, {.offset_s = 100.0, .length_s = 30.0});
  EXPECT_THAT([&] { match(other, passes); },
              ThrowsMessage<Error>(HasSubstr("film.mp4: the motion, with 8 starts and stops, does "
                                             "not fit the journal")));
  const FilmTrack glimpse = track_of(passes, {.offset_s = 98.0, .length_s = 0.3});
  EXPECT_THAT([&] { match(glimpse, passes); }, ThrowsMessage<Error>(HasSubstr("too few")));
}

TEST(FilmStations, AClockTooUncertainToTellStationsApartIsRefused) {
  const TestPass pass{.start_s = 100.0};
  SessionContents contents{.lines = {{.id = "x0"}}};
  for (const double planned_mm : {100.0, 104.0, 108.0}) {
    contents.stations.push_back({.name = "x0", .planned_mm = planned_mm});
  }
  const auto travels = travels_of("x0", pass.journal(kEpoch), kEpoch);
  const FilmTrack track = track_of({pass}, {.offset_s = 98.0, .length_s = 14.0});
  const auto found = [&](double uncertainty_s) {
    return find_station_frames(contents, track, travels, {98.0, uncertainty_s}, "film.mp4").found;
  };
  EXPECT_EQ(found(0.04).size(), 3U);  // at 40 mm/s
  EXPECT_THAT([&] { found(0.06); },
              ThrowsMessage<Error>(HasSubstr("known to 0.06 s, or 2.4 mm of travel")));
}

TEST(FilmClockProperty, TheOffsetLiesWithinItsUncertaintyOrIsRefused) {
  int found = 0;
  constexpr int kFilms = 40;
  for (std::uint32_t seed = 0; seed < kFilms; ++seed) {
    std::mt19937 random(seed);
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    TestPass pass{.start_s = between(0.0, 1e4)};
    pass.to_mm = between(200.0, 1500.0);
    pass.speed_mm_s = std::exp(between(std::log(10.0), std::log(80.0)));
    const double before_s = between(0.5, 4.0);
    TrackSettings settings{.offset_s = pass.start_s - before_s, .seed = seed};
    settings.length_s = before_s + pass.end_s() - pass.start_s + between(0.5, 4.0);
    settings.rate_hz = seed % 2 == 0 ? 24.0 : 29.97;
    settings.noise = std::exp(between(std::log(0.01), std::log(0.5)));
    settings.variation = between(0.0, 0.6);
    try {
      const FilmClock clock = match(track_of({pass}, settings), {pass});
      ++found;
      // 95 % of errors are within the uncertainty; one more frame interval of margin is still far
      // from a wrong match.
      EXPECT_NEAR(clock.offset_s, settings.offset_s, 2.0 * clock.uncertainty_s + 0.01)
          << "seed " << seed;
    } catch (const Error&) {
      continue;
    }
  }
  EXPECT_GT(found, kFilms * 3 / 4);
}

}  // namespace
}  // namespace raywalk::capture
