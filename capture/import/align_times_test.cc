#include "capture/import/align_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace raywalk::capture {
namespace {

using testing::Optional;

constexpr double kSecondsOfExif_s = 1.0;

TEST(AlignTimes, ThePauseBetweenTwoLinesResolvesWhichEndIsMissing) {
  std::vector<ShotSlot> slots;
  std::vector<double> pictures_s;
  for (int i = 0; i < 60; ++i) {
    const double at_s = 1.7e9 + 5.0 * i + (i < 30 ? 0.0 : 97.0);
    slots.push_back({at_s, at_s});
    if (i < 59) pictures_s.push_back(std::floor(at_s + 3600.3));
  }
  const auto result = align_times(slots, pictures_s, kSecondsOfExif_s);
  EXPECT_FALSE(result.rival);
  EXPECT_FALSE(result.best.picture_of_slot[59]);
  for (std::size_t i = 0; i < 59; ++i) EXPECT_THAT(result.best.picture_of_slot[i], Optional(i));
}

// A random session: lines of stations at nearly equal intervals, pauses between them, a camera
// clock with offset, drift, steps and varying lag, missing pictures and surplus pictures.
struct RandomSession {
  std::vector<ShotSlot> slots;
  std::vector<double> pictures_s;
  std::vector<std::optional<std::size_t>> truth;
  double offset_s = 0.0;
  double resolution_s = 1.0;
};

double log_uniform(std::mt19937& random, double from, double to) {
  return std::exp(std::uniform_real_distribution<double>(std::log(from), std::log(to))(random));
}

double uniform(std::mt19937& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

RandomSession random_session(std::uint32_t seed) {
  std::mt19937 random(seed);
  RandomSession session;
  session.resolution_s = seed % 3 == 0 ? 0.001 : 1.0;
  const int lines = std::uniform_int_distribution<int>(1, 5)(random);
  const int per_line = static_cast<int>(log_uniform(random, 3.0, 120.0));
  const double interval_s = log_uniform(random, 3.0, 12.0);
  const double interval_jitter_s = log_uniform(random, 1e-3, 1.0);
  double now_s = 1.7e9;
  for (int line = 0; line < lines; ++line) {
    for (int i = 0; i < per_line; ++i) {
      session.slots.push_back({now_s, now_s});
      now_s += interval_s + uniform(random, 0.0, interval_jitter_s);
    }
    now_s += log_uniform(random, 30.0, 3600.0);
  }
  session.offset_s = uniform(random, -1.0, 1.0) * log_uniform(random, 1.0, 1e8);
  const double drift = uniform(random, -1e-4, 1e-4);
  const double drop_share = uniform(random, -0.05, 0.1);
  const double lag_s = log_uniform(random, 0.01, 0.3);
  std::vector<std::pair<double, std::optional<std::size_t>>> taken;
  for (std::size_t slot = 0; slot < session.slots.size(); ++slot) {
    if (uniform(random, 0.0, 1.0) < drop_share) continue;
    const double since_s = session.slots[slot].from_s - session.slots.front().from_s;
    taken.emplace_back(session.slots[slot].from_s + session.offset_s + drift * since_s +
                           uniform(random, 0.0, lag_s),
                       slot);
  }
  const int surplus = std::max(0, std::uniform_int_distribution<int>(-3, 4)(random));
  for (int i = 0; i < surplus; ++i) {
    taken.emplace_back(session.offset_s + uniform(random, session.slots.front().from_s - 1000.0,
                                                  session.slots.back().from_s + 1000.0),
                       std::nullopt);
  }
  std::sort(taken.begin(), taken.end());
  session.truth.resize(session.slots.size());
  for (const auto& [time_s, slot] : taken) {
    if (slot) session.truth[*slot] = session.pictures_s.size();
    session.pictures_s.push_back(std::floor(time_s / session.resolution_s) * session.resolution_s);
  }
  return session;
}

// A surplus picture may be taken so close to a station's time that only the station's own picture
// tells them apart. If that one is missing, or both have the same time, the surplus picture is
// indistinguishable from it. Such slots do not count as wrong.
bool is_indistinguishable(const RandomSession& session, std::size_t slot, std::size_t picture) {
  const double expected_s = session.slots[slot].from_s + session.offset_s;
  const double allowed_s = 0.5 * session.resolution_s + 0.4 + 0.3 + session.resolution_s +
                           1e-4 * (session.slots[slot].from_s - session.slots.front().from_s);
  const bool is_surplus = std::none_of(
      session.truth.begin(), session.truth.end(),
      [&](const auto& true_picture) { return true_picture && *true_picture == picture; });
  return is_surplus && std::abs(session.pictures_s[picture] - expected_s) < allowed_s;
}

TEST(AlignTimesProperty, TheMatchIsCorrectOrAmbiguous) {
  int decided = 0;
  constexpr int kSessions = 250;
  for (std::uint32_t seed = 0; seed < kSessions; ++seed) {
    const RandomSession session = random_session(seed);
    const auto result = align_times(session.slots, session.pictures_s, session.resolution_s);
    if (result.rival) continue;
    ++decided;
    for (std::size_t slot = 0; slot < session.slots.size(); ++slot) {
      const auto& picture = result.best.picture_of_slot[slot];
      if (!picture || picture == session.truth[slot]) continue;
      EXPECT_TRUE(is_indistinguishable(session, slot, *picture))
          << "seed " << seed << ", slot " << slot << " of " << session.slots.size() << ": picture "
          << *picture << " instead of "
          << (session.truth[slot] ? static_cast<long>(*session.truth[slot]) : -1L);
    }
  }
  // Most sessions can be matched: ambiguity must be the exception.
  EXPECT_GT(decided, kSessions * 3 / 4);
}

}  // namespace
}  // namespace raywalk::capture
