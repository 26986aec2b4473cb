#include <fmt/chrono.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "capture/import/card_pictures.h"
#include "capture/import/import.h"
#include "capture/import/match_pictures.h"
#include "capture/import/test_pictures.h"
#include "capture/session/test_session.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/test_support.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Tags = std::map<int, std::string>;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

// --- What the card holds -------------------------------------------------------------------------

constexpr int kDate = 0x9003;
constexpr int kOffset = 0x9011;
constexpr int kSubSeconds = 0x9291;

const WallTime kNoon = std::chrono::sys_days{std::chrono::year{2026} / 3 / 7} + 12h + 30min + 5s;
const std::string kNoonText = "2026:03:07 12:30:05";

class CardPicturesTest : public testing::Test {
 protected:
  fs::path picture(const std::string& name, const Tags& tags) {
    const fs::path file = card_ / name;
    fs::create_directories(file.parent_path());
    write_test_picture(file);
    if (!tags.empty()) write_test_exif(file, tags);
    return file;
  }
  // A picture taken `second` seconds after noon.
  fs::path picture(const std::string& name, int second) {
    return picture(name, {{kDate, fmt::format("2026:03:07 12:00:{:02}", second)}});
  }
  static CardPictures read(const std::vector<fs::path>& files) { return read_card(files); }
  static std::vector<std::string> names(const CardPictures& card) {
    std::vector<std::string> names;
    for (const CardShot& shot : card.shots) names.push_back(shot[0].file.filename().string());
    return names;
  }

  TestDirectory card_;
};

TEST_F(CardPicturesTest, TheTimeIsThatOfExifElseOfTheFile) {
  struct Case {
    Tags tags;
    Duration off;  // from noon
    std::string source;
    double resolution_s;
  };
  const std::vector<Case> cases{
      {{}, 0s, "Exif local time", 1.0},
      {{{kSubSeconds, "7"}}, 700ms, "Exif local time", 0.1},
      {{{kSubSeconds, "070"}}, 70ms, "Exif local time", 0.001},
      {{{kOffset, "+02:00"}}, -2h, "Exif time", 1.0},
      {{{kOffset, "-05:30"}}, 5h + 30min, "Exif time", 1.0},
      {{{kOffset, ""}}, 0s, "Exif local time", 1.0},
      {{{kOffset, "   :  "}}, 0s, "Exif local time", 1.0},
      {{{kOffset, "+2:00"}}, 0s, "Exif local time", 1.0},
      {{{kOffset, "+99:00"}}, 0s, "Exif local time", 1.0},
      {{{kOffset, "0200"}}, 0s, "Exif local time", 1.0},
  };
  for (const auto& [tags, off, source, resolution_s] : cases) {
    Tags all = tags;
    all[kDate] = kNoonText;
    const CardPictures card = read({picture("a.jpg", all)});
    const std::string shown = testing::PrintToString(tags);
    EXPECT_EQ(card.shots.at(0)[0].time, kNoon + off) << shown;
    EXPECT_EQ(card.time_source, source) << shown;
    EXPECT_DOUBLE_EQ(card.resolution_s, resolution_s) << shown;
  }
  for (const char* const nonsense :
       {"0000:00:00 00:00:00", "    :  :     :  :  ", "2026:02:30 12:00:00", "2026:03:07 24:00:00",
        "2026-03-07 12:30:05", "2026:03:07", "", "2026:03:07 12:30:-5"}) {
    const fs::path file = picture("a.jpg", {{kDate, nonsense}});
    const CardPictures card = read({file});
    EXPECT_EQ(card.time_source, "file time") << nonsense;
    EXPECT_EQ(card.resolution_s, 2.0) << nonsense;
    const auto written = std::chrono::file_clock::to_sys(fs::last_write_time(file));
    EXPECT_LT(std::chrono::abs(card.shots.at(0)[0].time - written), 1ms) << nonsense;
  }
}

TEST_F(CardPicturesTest, ADamagedFileNeverThrows) {
  const auto whole = picture("a.jpg", {{kDate, kNoonText}, {kOffset, "+02:00"}});
  const std::string bytes = read_file(whole);
  const auto damaged = card_ / "damaged.jpg";
  for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 300); at += 3) {
    std::ofstream(damaged, std::ios::binary) << bytes.substr(0, at);
    EXPECT_NO_THROW(read({damaged})) << "cut at " << at;
    std::string changed = bytes;
    changed[at] = static_cast<char>(~changed[at]);
    std::ofstream(damaged, std::ios::binary) << changed;
    EXPECT_NO_THROW(read({damaged})) << "changed at " << at;
  }
}

TEST_F(CardPicturesTest, TheTimesOfAllAreFromOneSource) {
  const fs::path utc = picture("utc.jpg", {{kDate, kNoonText}, {kOffset, "+02:00"}});
  const fs::path local = picture("local.jpg", {{kDate, "2026:03:07 12:30:07"}});
  const CardPictures card = read({utc, local});
  EXPECT_EQ(card.time_source, "Exif local time");
  EXPECT_EQ(card.shots.at(1)[0].time - card.shots.at(0)[0].time, 2s);
  const fs::path odd = picture("odd.jpg", Tags{});
  for (const auto& files : {std::vector{local, odd}, std::vector{odd, local}}) {
    EXPECT_THAT([&] { read(files); }, ThrowsMessage<Error>(HasSubstr("odd.jpg: no Exif time")));
  }
}

TEST_F(CardPicturesTest, ShotsComeInOrderOfTimeThenNameFromADirectoryAndThoseInIt) {
  picture("DCIM/100RICOH/R2.JPG", 7);
  picture("DCIM/100RICOH/R9.JPG", 3);
  picture("DCIM/R1.jpg", 7);
  picture("DCIM/._R2.jpg", 2);
  write_test_picture(card_ / "DCIM/thumb.bmp");
  const CardPictures card = read({card_ / "DCIM"});
  EXPECT_THAT(names(card), ElementsAre("R9.JPG", "R1.jpg", "R2.JPG"));
  EXPECT_EQ(card.shots[0][0].lens, FrameLens::kBoth);
}

TEST_F(CardPicturesTest, FrontAndBackFilesOfAShotArePairedIfAllAreNamedAsHalves) {
  const CardPictures card =
      read({picture("100GBACK/GPBK0002.JPG", 6), picture("100GFRNT/GPFR0001.JPG", 1),
            picture("100GFRNT/GPFR0002.JPG", 6), picture("100GBACK/GPBK0001.JPG", 2),
            // The same number in another folder is another shot.
            picture("101GFRNT/GF010001.JPG", 9), picture("101GBACK/GB010001.JPG", 9),
            picture("102GFRNT/GF010001.JPG", 11), picture("102GBACK/GB010001.JPG", 11),
            picture("102GFRNT/GF010003.JPG", 20)});
  EXPECT_THAT(names(card),
              ElementsAre("GPFR0001.JPG", "GPFR0002.JPG", "GF010001.JPG", "GF010001.JPG"));
  EXPECT_EQ(card.shots[1][0].lens, FrameLens::kFront);
  EXPECT_EQ(card.shots[1][1].lens, FrameLens::kBack);
  EXPECT_EQ(card.shots[1][1].file.filename(), "GPBK0002.JPG");
  EXPECT_THAT(card.unpaired, ElementsAre(card_ / "102GFRNT/GF010003.JPG"));
  const CardPictures mixed = read({picture("GPFR0001.JPG", 1), picture("R0001.JPG", 3)});
  EXPECT_THAT(names(mixed), ElementsAre("GPFR0001.JPG", "R0001.JPG"));
  EXPECT_EQ(mixed.shots[0][0].lens, FrameLens::kBoth);
}

TEST_F(CardPicturesTest, InvalidArgumentsAreNamed) {
  EXPECT_THAT([] { read({}); }, ThrowsMessage<UsageError>(HasSubstr("no pictures given")));
  EXPECT_THAT([&] { read({card_.path()}); }, ThrowsMessage<UsageError>(HasSubstr("no .jpg")));
  const std::vector<fs::path> twice{picture("R1.JPG", 1), card_ / "./R1.JPG"};
  EXPECT_THAT([&] { read(twice); }, ThrowsMessage<UsageError>(HasSubstr("given twice")));
  EXPECT_THAT([&] { read({card_ / "gone.jpg"}); }, ThrowsMessage<Error>(HasSubstr("gone.jpg")));
}

// --- Which picture is whose ----------------------------------------------------------------------

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
  std::string error_of_match() const {
    return error_of([this] { match(); });
  }

  static constexpr int kPerLine = 10;
  SessionShots session_;
  CardPictures card_;
};

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
  EXPECT_THAT(error_of_match(),
              AllOf(HasSubstr("9 pictures for 10"), HasSubstr("do not determine the assignment")));
}

TEST_F(MatchPicturesTest, PicturesOfAnotherSessionAreRefused) {
  for (std::size_t i = 0; i < card_.shots.size(); ++i) {
    card_.shots[i][0].time = kStart + std::chrono::seconds(i * i * 37);
  }
  EXPECT_THAT(error_of_match(), HasSubstr("are they of another session?"));
  card_.shots.clear();
  EXPECT_THAT(error_of_match(), HasSubstr("0 pic"));
}

TEST_F(MatchPicturesTest, AClockThatJumpsIsNamed) {
  card_.shots[0][0].time += 12h + 39min;
  card_.shots[1][0].time += 12h + 39min;
  sort_shots();
  EXPECT_THAT(error_of_match(),
              AllOf(HasSubstr("clock jumps by -45540 s between R0002.JPG and R0003.JPG"),
                    HasSubstr("--station x0_000")));
  const PictureMatch named = assign_by_name(session_, card_, "x0_000");
  ASSERT_EQ(named.complete.size(), 20U);
  EXPECT_THAT(named.mismatches, IsEmpty());
  EXPECT_EQ(card_.shots[named.complete[1].shots[0]][0].file, "card/R0002.JPG");
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

// --- The import ----------------------------------------------------------------------------------

// Four lines of five stations, captured with a camera that keeps its pictures on its card and whose
// clock is a little over two hours ahead.
class ImportPicturesTest : public SessionCase {
 protected:
  void SetUp() override {
    capture_.plan.lines.clear();
    for (const std::string id : {"x0", "x1", "z0", "z1"}) {
      const LineAxis axis = id[0] == 'x' ? LineAxis::kX : LineAxis::kZ;
      capture_.plan.lines.push_back(test_line(id, axis, id[1] - '0' - 0.5, -1.0, 0.5, 5));
    }
    capture_.config.camera.kind = CameraKind::kGpio;
    const auto session = capture_.open();
    for (const CaptureLine& line : capture_.plan.lines) {
      capture_.clock.sleep(120s);
      for (const CaptureStation& station : line.stations) {
        capture_.capture(session.get(), station);
        taken_.emplace_back(station.name, capture_.clock.wall_now());
      }
    }
    fs::create_directories(card_);
  }

  // The default card: one picture per station.
  void fill_card(const std::string& prefix = "R_") {
    for (const auto& [station, time] : taken_) write_picture(prefix + station + ".JPG", time);
  }
  void write_picture(const std::string& name, WallTime time, int width = 64) {
    write_test_picture(card_ / name, width, width / 2, 40 + next_level_++);
    write_test_exif(card_ / name, {{0x9003, exif_text(time)}});
  }
  static std::string exif_text(WallTime time) {
    return fmt::format("{:%Y:%m:%d %H:%M:%S}",
                       std::chrono::floor<std::chrono::seconds>(time + 7203s));
  }
  ImportResult import(bool allow_missing = false, const std::string& first_station = "") {
    return import_pictures(capture_.directory, {&card_, 1}, allow_missing, &capture_.clock,
                           first_station);
  }
  std::string error_of_import() {
    return error_of([&] { import(); });
  }
  std::size_t captured() { return contents().frames.size(); }

  fs::path card_ = directory_ / "card";
  std::vector<std::pair<std::string, WallTime>> taken_;
  int next_level_ = 0;
};

TEST_F(ImportPicturesTest, EveryStationGetsItsOwnPictureWithItsChecksum) {
  fill_card();
  const ImportResult result = import();
  EXPECT_EQ(result.imported, 20U);
  EXPECT_THAT(result.summary, AllOf(HasSubstr("20 stations imported"), HasSubstr("+7203.")));
  const SessionContents imported = contents();
  ASSERT_EQ(imported.frames.size(), 20U);
  for (const SessionFrame& frame : imported.frames) {
    const std::string bytes = read_file(capture_.directory / frame.file);
    EXPECT_EQ(bytes, read_file(card_ / ("R_" + imported.station_of(frame).name + ".JPG")));
    EXPECT_EQ(frame.sha256, sha256_hex(bytes));
  }
  const ImportResult again = import();
  EXPECT_EQ(again.imported, 0U);
  EXPECT_EQ(again.already_there, 20U);
  EXPECT_EQ(captured(), 20U);
  fs::remove(card_ / "R_x0_004.JPG");
  EXPECT_EQ(import().imported, 0U) << "a station imported before lacks no picture";
  write_picture("R_x1_000.JPG", taken_[5].second);
  EXPECT_THAT(error_of_import(), HasSubstr("R_x1_000.JPG: is assigned to x1_000, which already"));
}

TEST_F(ImportPicturesTest, APictureOfAnotherKindThanTheFramesIsRefusedBeforeAnyIsImported) {
  fill_card();
  write_test_circles(card_ / "R_z0_000.JPG");
  write_test_exif(card_ / "R_z0_000.JPG", {{0x9003, exif_text(taken_[10].second)}});
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("R_z0_000.JPG shows two fisheye circles"),
                                       HasSubstr("camera.frames is panorama")));
  EXPECT_EQ(captured(), 0U);
}

TEST_F(ImportPicturesTest, AnImportInterruptedBetweenFileAndRowResumes) {
  fill_card();
  fs::copy(card_ / "R_x0_000.JPG", capture_.directory / "frames" / "x0_000.jpg");
  EXPECT_EQ(import().imported, 20U);
  EXPECT_EQ(captured(), 20U);
}

TEST_F(ImportPicturesTest, AMissingPictureIsRefusedUnlessAllowed) {
  fill_card();
  fs::remove(card_ / "R_x1_004.JPG");
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("1 of 20 stations lack pictures: x1_004"),
                                       HasSubstr("--allow-missing")));
  EXPECT_EQ(captured(), 0U);
  const ImportResult result = import(true);
  EXPECT_EQ(result.imported, 19U);
  EXPECT_THAT(result.summary, HasSubstr("x1_004"));
  write_picture("R_x1_004.JPG", taken_[9].second);
  EXPECT_EQ(taken_[9].first, "x1_004");
  EXPECT_EQ(import().imported, 1U);
}

TEST_F(ImportPicturesTest, APictureIsAssignedByHandWhateverItsTime) {
  write_picture("LATER.jpg", taken_[9].second + 12h);
  fs::rename(card_ / "LATER.jpg", card_ / "LATER.insp");
  const ImportResult result = import(false, "x1_004");
  EXPECT_THAT(result.summary, AllOf(HasSubstr("1 stations imported"), HasSubstr("by the names")));
  const SessionContents imported = contents();
  ASSERT_EQ(imported.frames.size(), 1U);
  EXPECT_EQ(imported.station_of(imported.frames[0]).name, "x1_004");
  EXPECT_TRUE(imported.frames[0].file.ends_with(".jpg"));
  EXPECT_THAT(error_of([&] { import(false, "x7"); }),
              HasSubstr("'x7' has no pictures on the card"));
  write_picture("LATER2.JPG", taken_[9].second + 13h);
  EXPECT_THAT(error_of([&] { import(false, "z1_004"); }),
              HasSubstr("2 pictures for the 1 stations from z1_004 on"));
}

TEST_F(ImportPicturesTest, APictureOfAnInterruptedAttemptIsLeftOut) {
  fill_card();
  {
    const auto session = capture_.open();
    capture_.clock.sleep(60s);
    EXPECT_TRUE(session->is_captured("x0_000"));
    session->fail_attempt(session->begin_attempt("x0_000", 50.0), "interrupted", "Ctrl-C");
  }
  write_picture("TRY.JPG", capture_.clock.wall_now());
  const ImportResult result = import();
  EXPECT_EQ(result.imported, 20U);
  EXPECT_THAT(result.summary, HasSubstr("pictures of failed attempts left out: 1"));
}

TEST_F(ImportPicturesTest, FrontAndBackBecomeTwoFramesOfAStation) {
  fill_card("GPFR_");
  fill_card("GPBK_");
  EXPECT_EQ(import().imported, 20U);
  const SessionContents imported = contents();
  const std::vector<SessionFrame>& frames = imported.frames;
  ASSERT_EQ(frames.size(), 40U);
  EXPECT_NE(frames[0].lens, frames[1].lens);
  EXPECT_EQ(frames[0].station, frames[1].station);
  const bool front = frames[0].lens == FrameLens::kFront;
  EXPECT_EQ(frames[front ? 0 : 1].file, "frames/x0_000_front.jpg");
  EXPECT_EQ(frames[front ? 1 : 0].file, "frames/x0_000_back.jpg");
  EXPECT_EQ(read_file(capture_.directory / frames[0].file),
            read_file(card_ / ((front ? "GPFR_" : "GPBK_") + imported.station_of(frames[0]).name +
                               ".JPG")));
}

TEST_F(ImportPicturesTest, ATruncatedPictureOrOneOfAnotherSizeIsNamedAndTheImportCanResume) {
  fill_card();
  const std::string name = "R_x0_003.JPG";
  const std::string whole = read_file(card_ / name);
  std::ofstream(card_ / name, std::ios::binary) << whole.substr(0, whole.size() - 20);
  EXPECT_THAT(error_of_import(), HasSubstr(name));
  EXPECT_EQ(captured(), 3U);
  std::ofstream(card_ / name, std::ios::binary) << whole;
  write_picture("R_x1_000.JPG", taken_[5].second, 128);
  EXPECT_THAT(error_of_import(), AllOf(HasSubstr("R_x1_000.JPG"), HasSubstr("128")));
  write_picture("R_x1_000.JPG", taken_[5].second);
  EXPECT_EQ(import().imported, 15U);
}

TEST_F(ImportPicturesTest, ASessionWhoseCameraSentItsPicturesIsRefused) {
  fill_card();
  capture_.directory = directory_ / "none";
  EXPECT_THAT(error_of_import(), HasSubstr("none"));
  capture_.config.camera.kind = CameraKind::kOsc;
  capture_.open();
  EXPECT_THAT(error_of_import(), HasSubstr("osc camera sent its pictures during the run"));
}

}  // namespace
}  // namespace raywalk::capture
