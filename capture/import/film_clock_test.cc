#include "capture/import/film_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "capture/import/test_film.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

const WallTime kFilmStart = std::chrono::sys_days{std::chrono::year{2026} / 5 / 1};

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

std::vector<Travel> travels_of_passes(const std::vector<TestPass>& passes) {
  std::vector<Travel> travels;
  for (const TestPass& pass : passes) {
    for (Travel& travel : travels_of("x0", pass.journal(kFilmStart), kFilmStart)) {
      travels.push_back(std::move(travel));
    }
  }
  return travels;
}

TEST(FilmClock, TheOffsetIsFoundWithSubFramePrecision) {
  const std::vector<TestPass> passes{{.start_s = 100.0}};
  const auto track = track_of(passes, {.offset_s = 97.654, .length_s = 16.0});
  const FilmClock clock = match_film_clock(track, travels_of_passes(passes), "film");
  EXPECT_NEAR(clock.offset_s, 97.654, 0.008);
  EXPECT_LT(clock.uncertainty_s, 0.04);
}

TEST(FilmClock, AFilmThatEndsBeforeThePassIsMatchedByItsStart) {
  const std::vector<TestPass> passes{{.start_s = 100.0, .to_mm = 1200.0}};
  const auto track = track_of(passes, {.offset_s = 98.2, .length_s = 15.0});
  EXPECT_NEAR(match_film_clock(track, travels_of_passes(passes), "film").offset_s, 98.2, 0.02);
}

TEST(FilmClock, TwoEqualPassesAreRefused) {
  const std::vector<TestPass> passes{{.start_s = 100.0}, {.start_s = 200.0}};
  const auto track = track_of(passes, {.offset_s = 98.0, .length_s = 14.0});
  EXPECT_THAT([&] { match_film_clock(track, travels_of_passes(passes), "film.mp4"); },
              ThrowsMessage<Error>(HasSubstr("at two times, 100.0 s apart")));
}

TEST(FilmClock, TwoPassesInOneFilmAreMatchedByTheirPause) {
  const std::vector<TestPass> passes{{.start_s = 100.0}, {.start_s = 130.0}};
  const auto track = track_of(passes, {.offset_s = 98.0, .length_s = 46.0});
  EXPECT_NEAR(match_film_clock(track, travels_of_passes(passes), "film").offset_s, 98.0, 0.01);
}

TEST(FilmClock, AFilmWithoutMotionIsRefused) {
  const std::vector<TestPass> passes{{.start_s = 100.0}};
  const auto track = track_of(passes, {.offset_s = 0.0, .length_s = 20.0, .noise = 0.02});
  EXPECT_THAT([&] { match_film_clock(track, travels_of_passes(passes), "film.mp4"); },
              ThrowsMessage<Error>(HasSubstr("film.mp4: shows no start or stop of motion")));
}

TEST(FilmClock, AFilmOfSomethingElseIsRefused) {
  const std::vector<TestPass> passes{{.start_s = 100.0, .to_mm = 1200.0}};
  const std::vector<TestPass> others{{.start_s = 103.0, .to_mm = 60.0},
                                     {.start_s = 106.0, .to_mm = 40.0},
                                     {.start_s = 112.0, .to_mm = 100.0},
                                     {.start_s = 122.0, .to_mm = 30.0}};
  const auto track = track_of(others, {.offset_s = 100.0, .length_s = 30.0});
  EXPECT_THAT([&] { match_film_clock(track, travels_of_passes(passes), "film.mp4"); },
              ThrowsMessage<Error>(
                  AnyOf(HasSubstr("does not fit the journal"), HasSubstr("at two times"))));
}

TEST(FilmClock, TooFewFramesAreRefused) {
  const std::vector<TestPass> passes{{.start_s = 100.0}};
  const auto track = track_of(passes, {.offset_s = 98.0, .length_s = 0.3});
  EXPECT_THAT([&] { match_film_clock(track, travels_of_passes(passes), "film.mp4"); },
              ThrowsMessage<Error>(HasSubstr("too few")));
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
      const FilmClock clock =
          match_film_clock(track_of({pass}, settings), travels_of_passes({pass}), "film");
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
