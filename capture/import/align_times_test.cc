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

// Slots every `interval_s`, `per_line` of them, then a pause while the rail is moved.
std::vector<ShotSlot> regular_slots(int lines, int per_line, double interval_s) {
  std::vector<ShotSlot> slots;
  double now_s = 1.7e9;
  for (int line = 0; line < lines; ++line) {
    for (int i = 0; i < per_line; ++i) {
      slots.push_back({now_s, now_s});
      now_s += interval_s;
    }
    now_s += 97.0 + 13.0 * line;
  }
  return slots;
}

std::vector<double> pictures_of(const std::vector<ShotSlot>& slots, double offset_s) {
  std::vector<double> pictures_s;
  for (const ShotSlot& slot : slots) {
    pictures_s.push_back(std::floor(slot.from_s + offset_s));
  }
  return pictures_s;
}

void expect_in_order(const TimeAlignment& alignment, std::size_t from, std::size_t to,
                     std::size_t first_picture) {
  for (std::size_t slot = from; slot < to; ++slot) {
    EXPECT_THAT(alignment.picture_of_slot[slot], Optional(first_picture + slot - from))
        << "slot " << slot;
  }
}

TEST(AlignTimes, EqualListsMatchInOrderWhateverTheOffset) {
  const auto slots = regular_slots(1, 60, 4.7);
  for (const double offset_s : {0.0, -3.3e7, 7200.25, 12345.678}) {
    const auto result = align_times(slots, pictures_of(slots, offset_s), kSecondsOfExif_s);
    EXPECT_FALSE(result.rival);
    EXPECT_EQ(result.best.matched, 60U);
    expect_in_order(result.best, 0, 60, 0);
    EXPECT_NEAR(result.best.offset_s, offset_s - 0.5, 0.5);  // floor takes half a second on average
  }
}

TEST(AlignTimes, APictureMissingInTheMiddleOfARegularLineIsFound) {
  const auto slots = regular_slots(1, 60, 4.7);
  auto pictures_s = pictures_of(slots, 3600.3);
  pictures_s.erase(pictures_s.begin() + 31);
  const auto result = align_times(slots, pictures_s, kSecondsOfExif_s);
  EXPECT_FALSE(result.rival);
  EXPECT_EQ(result.best.matched, 59U);
  EXPECT_FALSE(result.best.picture_of_slot[31]);
  expect_in_order(result.best, 0, 31, 0);
  expect_in_order(result.best, 32, 60, 31);
}

TEST(AlignTimes, AMissingEndOfOneRegularLineIsAmbiguous) {
  const auto slots = regular_slots(1, 60, 5.0);
  auto pictures_s = pictures_of(slots, 3600.3);
  pictures_s.pop_back();
  const auto result = align_times(slots, pictures_s, kSecondsOfExif_s);
  ASSERT_TRUE(result.rival);
  EXPECT_NEAR(std::abs(result.rival->offset_s - result.best.offset_s), 5.0, 0.5);
}

TEST(AlignTimes, ThePauseBetweenTwoLinesResolvesWhichEndIsMissing) {
  const auto slots = regular_slots(2, 30, 5.0);
  auto pictures_s = pictures_of(slots, 3600.3);
  pictures_s.pop_back();
  const auto result = align_times(slots, pictures_s, kSecondsOfExif_s);
  EXPECT_FALSE(result.rival);
  EXPECT_FALSE(result.best.picture_of_slot[59]);
  expect_in_order(result.best, 0, 59, 0);
}

TEST(AlignTimes, ASurplusPictureIsLeftUnmatched) {
  const auto slots = regular_slots(2, 30, 5.0);
  auto pictures_s = pictures_of(slots, -86400.0);
  pictures_s.insert(pictures_s.begin() + 12, pictures_s[12] - 2.0);
  pictures_s.insert(pictures_s.begin(), pictures_s.front() - 1e6);
  const auto result = align_times(slots, pictures_s, kSecondsOfExif_s);
  EXPECT_FALSE(result.rival);
  EXPECT_EQ(result.best.matched, 60U);
  expect_in_order(result.best, 0, 12, 1);
  expect_in_order(result.best, 12, 60, 14);
}

TEST(AlignTimes, ExposuresOfABracketKeepTheirOrder) {
  std::vector<ShotSlot> slots;
  std::vector<double> pictures_s;
  for (int station = 0; station < 20; ++station) {
    const double start_s = 6.0 * station + (station % 3) * 0.2;
    for (int exposure = 0; exposure < 3; ++exposure) {
      slots.push_back({start_s, start_s + 1.2});
      pictures_s.push_back(std::floor(500.0 + start_s + 0.4 * exposure));
    }
  }
  const auto result = align_times(slots, pictures_s, kSecondsOfExif_s);
  EXPECT_FALSE(result.rival);
  expect_in_order(result.best, 0, 60, 0);
}

TEST(AlignTimes, WithoutPicturesNothingMatches) {
  const auto slots = regular_slots(1, 3, 5.0);
  const auto result = align_times(slots, {}, kSecondsOfExif_s);
  EXPECT_EQ(result.best.matched, 0U);
  EXPECT_EQ(result.best.picture_of_slot.size(), 3U);
  EXPECT_EQ(align_times({}, std::vector<double>{1.0}, kSecondsOfExif_s).best.matched, 0U);
}

TEST(AlignTimes, PicturesOfAnotherDayMatchFew) {
  const auto slots = regular_slots(3, 30, 5.0);
  std::mt19937 random(7);
  std::vector<double> pictures_s(90);
  for (double& time_s : pictures_s) {
    time_s = std::uniform_real_distribution<double>(0.0, 86400.0)(random);
  }
  std::sort(pictures_s.begin(), pictures_s.end());
  EXPECT_LT(align_times(slots, pictures_s, kSecondsOfExif_s).best.matched, 30U);
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
