#include "host/cli/sensor/checks.h"

#include <chrono>
#include <functional>

#include <gtest/gtest.h>

#include "firmware/wire/messages/conditions.h"

namespace stof::host {
namespace {

using namespace std::chrono_literals;

void add_frames(CheckFacts& facts, int frames) {
  for (int i = 0; i < frames; ++i) {
    client::Frame frame;
    frame.stamp.number = static_cast<std::uint32_t>(i);
    frame.stamp.exposure_middle_ns = i * 100'000'000LL;
    facts.stats.figures.take(frame, i * 0.1);
    ++facts.stats.counts.frames_complete;
    facts.stats.counts.packets_ok += 100;
  }
}

// Everything is in order.
CheckFacts good() {
  CheckFacts facts{
      .sensor = "front",
      .identity = client::FoundSensor{.serial = "00000001", .version = "1.2.3"},
      .subscribed = true,
      .beacon_heard = true,
      .health = HealthState{.age = 200ms},
      .calibration = wire::CalibrationPacket{},
      .network = {.interface = "eth0", .mtu = 1500, .speed_mbit = 1000, .clock_synchronised = true},
      .buffer = 4 << 20,
      .asked_buffer = 4 << 20,
      .version = "1.2.3"};
  add_frames(facts, 50);
  return facts;
}

Check check_of(const CheckFacts& facts, const std::string& name) {
  for (const Check& check : judge_checks(facts)) {
    if (check.name == name) {
      return check;
    }
  }
  ADD_FAILURE() << "no check " << name;
  return {};
}

void set_condition(CheckFacts& facts, wire::Condition condition) {
  facts.health->report.active |= 1U << static_cast<unsigned>(condition);
}

TEST(Checks, FindNothingWhereAllIsInOrder) {
  for (const Check& check : judge_checks(good())) {
    EXPECT_EQ(check.verdict, CheckVerdict::kOk) << check.name << ": " << check.found;
    EXPECT_EQ(check.fix, "");
    EXPECT_NE(check.found, "");
  }
  EXPECT_EQ(worst_of(judge_checks(good())), CheckVerdict::kOk);
}

struct Wrong {
  const char* name;
  CheckVerdict verdict;
  const char* fix;  // part of it
  std::function<void(CheckFacts&)> make;
};

TEST(Checks, SayWhatIsWrongAndWhatToDoInOneLine) {
  const Wrong all[] = {
      {"firewall", CheckVerdict::kNote, "7561", [](CheckFacts& f) { f.beacon_heard = false; }},
      {"firewall", CheckVerdict::kFix, "output", [](CheckFacts& f) { f.sending_refused = true; }},
      {"mtu", CheckVerdict::kFix, "ip link set dev eth0 mtu 1500",
       [](CheckFacts& f) { f.network.mtu = 1279; }},
      {"mtu", CheckVerdict::kNote, "", [](CheckFacts& f) { f.network.mtu.reset(); }},
      {"buffers", CheckVerdict::kFix, "sysctl -w net.core.rmem_max=4194304",
       [](CheckFacts& f) { f.buffer = 212'992; }},
      {"buffers", CheckVerdict::kFix, "too slow",
       [](CheckFacts& f) { f.stats.counts.socket_drops = 1; }},
      {"link", CheckVerdict::kFix, "streams.parity",
       [](CheckFacts& f) { f.stats.counts.frames_lost = 1; }},  // 1 of 51
      {"link", CheckVerdict::kNote, "streams.parity",
       [](CheckFacts& f) {
         f.stats.counts.frames_complete = 1000;
         f.stats.counts.frames_incomplete = 1;
       }},
      {"link", CheckVerdict::kFix, "damaged",
       [](CheckFacts& f) {
         f.stats.counts.frames_lost = 5;
         f.stats.counts.bad_crc = 9;
       }},
      {"link", CheckVerdict::kFix, "no frame was lost on the way",
       [](CheckFacts& f) { f.stats.silences = 1; }},
      {"link", CheckVerdict::kFix, "streams.parity",
       [](CheckFacts& f) {
         f.stats.silences = 1;
         f.stats.counts.frames_lost = 1;
       }},
      {"link", CheckVerdict::kFix, "--signed", [](CheckFacts& f) { f.forged_traffic = true; }},
      {"link", CheckVerdict::kFix, "nearly full",  // 50,000 packets in 4.9 s: 104 Mbit/s
       [](CheckFacts& f) {
         f.stats.counts.packets_ok = 50'000;
         f.network.speed_mbit = 100;
       }},
      {"clock", CheckVerdict::kNote, "timedatectl",
       [](CheckFacts& f) { f.network.clock_synchronised = false; }},
      {"clock", CheckVerdict::kNote, "",
       [](CheckFacts& f) { f.clock = wire::ClockState::kRecorded; }},
      {"clock", CheckVerdict::kFix, "two senders",
       [](CheckFacts& f) { f.stats.figures.take(client::Frame{}, 6); }},
      {"calibration", CheckVerdict::kFix, "stof calib install",
       [](CheckFacts& f) { f.calibration.reset(); }},
      {"calibration", CheckVerdict::kFix, "restart",
       [](CheckFacts& f) { f.other_calibration = true; }},
      {"calibration", CheckVerdict::kFix, "--signed",
       [](CheckFacts& f) { f.lenses_contradict = true; }},
      {"calibration", CheckVerdict::kFix, "docs/CALIBRATION.md",
       [](CheckFacts& f) { f.drift = ", drift: pitch 0.1 +- 0.01 deg"; }},
      {"calibration", CheckVerdict::kFix, "docs/CALIBRATION.md",
       [](CheckFacts& f) { set_condition(f, wire::Condition::kDrift); }},
      {"calibration", CheckVerdict::kFix, "stof calib install FILE front",
       [](CheckFacts& f) { set_condition(f, wire::Condition::kCalibrationDropped); }},
      {"health", CheckVerdict::kFix, "stof health front",
       [](CheckFacts& f) { f.health->report.severity = wire::Severity::kMajor; }},
      {"health", CheckVerdict::kNote, "", [](CheckFacts& f) { f.health.reset(); }},
      {"key", CheckVerdict::kNote, "stof pair front",
       [](CheckFacts& f) { set_condition(f, wire::Condition::kUnpaired); }},
      {"key", CheckVerdict::kFix, "stof pair front",
       [](CheckFacts& f) { set_condition(f, wire::Condition::kKeysLost); }},
      {"version", CheckVerdict::kNote, "stof update",
       [](CheckFacts& f) { f.identity->version = "1.2.2"; }},
      {"version", CheckVerdict::kNote, "",
       [](CheckFacts& f) {
         f.identity.reset();
         f.no_identity = "no answer";
       }},
  };
  for (const Wrong& wrong : all) {
    CheckFacts facts = good();
    wrong.make(facts);
    const Check check = check_of(facts, wrong.name);
    EXPECT_EQ(check.verdict, wrong.verdict) << wrong.name << ": " << check.found;
    EXPECT_NE(check.fix.find(wrong.fix), std::string::npos) << check.fix;
    EXPECT_EQ((check.found + check.fix).find('\n'), std::string::npos);
    EXPECT_TRUE(check.verdict != CheckVerdict::kFix || !check.fix.empty()) << check.name;
  }
}

TEST(Checks, SayWhyNothingComes) {
  const auto without_frames = [](const std::function<void(CheckFacts&)>& make) {
    CheckFacts facts = good();
    facts.stats = {};
    facts.comes = Comes::kNothing;
    facts.subscribed = false;
    facts.health.reset();
    make(facts);
    return facts;
  };
  EXPECT_NE(check_of(without_frames([](CheckFacts& f) { f.nobody_listens = true; }), "reach")
                .fix.find("start stofd"),
            std::string::npos);
  EXPECT_NE(check_of(without_frames([](CheckFacts& f) { f.all_places_taken = true; }), "reach")
                .found.find("as many subscribers"),
            std::string::npos);
  EXPECT_NE(check_of(without_frames([](CheckFacts& f) { f.identity.reset(); }), "reach")
                .fix.find("power, cable and address"),
            std::string::npos);
  const Check passed =
      check_of(without_frames([](CheckFacts& f) { f.nobody_listens = true; }), "firewall");
  EXPECT_EQ(passed.verdict, CheckVerdict::kOk) << passed.found;
  const Check other_port = check_of(without_frames([](CheckFacts& f) {
                                      f.subscribed = true;
                                      f.stats.source = "UDP 192.168.1.20:7800";
                                    }),
                                    "firewall");
  EXPECT_NE(other_port.fix.find("udp sport 7800 accept"), std::string::npos) << other_port.fix;
  const Check wall =
      check_of(without_frames([](CheckFacts& f) { f.subscribed = true; }), "firewall");
  EXPECT_EQ(wall.verdict, CheckVerdict::kFix);
  EXPECT_NE(wall.fix.find("udp sport 7560 accept"), std::string::npos) << wall.fix;
  // What nobody can know without a frame is not judged.
  EXPECT_EQ(judge_checks(without_frames([](CheckFacts& /*facts*/) {})).size(), 4U);
}

// Health passes the firewall: it is not to blame, and it says what is.
TEST(Checks, LetHealthSayWhyNoFrameComes) {
  for (const bool before : {false, true}) {
    CheckFacts facts = good();
    if (!before) {
      facts.stats = {};
    }
    facts.comes = Comes::kHealthAlone;
    facts.silent_since = 4s;
    facts.health->report.severity = wire::Severity::kCritical;
    set_condition(facts, wire::Condition::kTriggerLost);
    EXPECT_EQ(check_of(facts, "reach").verdict, CheckVerdict::kFix);
    EXPECT_EQ(check_of(facts, "reach").fix, "see health");
    EXPECT_EQ(check_of(facts, "firewall").verdict, CheckVerdict::kOk);
    EXPECT_EQ(check_of(facts, "health").verdict, CheckVerdict::kFix);
    EXPECT_NE(check_of(facts, "health").found.find("trigger_lost"), std::string::npos);
  }
}

TEST(Checks, SayThatASensorStopped) {
  CheckFacts facts = good();
  facts.comes = Comes::kNothing;
  facts.silent_since = 4s;
  facts.beacon_heard = false;
  const Check reach = check_of(facts, "reach");
  EXPECT_EQ(reach.verdict, CheckVerdict::kFix);
  EXPECT_EQ(reach.found, "50 frames came, the last one 4.0 s ago; nothing comes any more");
  EXPECT_EQ(check_of(facts, "firewall").verdict, CheckVerdict::kOk);
  EXPECT_EQ(check_of(facts, "link").verdict, CheckVerdict::kOk);
  facts.nobody_listens = true;
  EXPECT_NE(check_of(facts, "reach").found.find("it was stopped"), std::string::npos);
  facts.clock = wire::ClockState::kRecorded;
  EXPECT_EQ(check_of(facts, "reach").verdict, CheckVerdict::kNote);
  EXPECT_NE(check_of(facts, "reach").found.find("is over"), std::string::npos);
}

TEST(Checks, NameWhatCanBeAsked) {
  CheckFacts facts = good();
  facts.stats.counts.frames_lost = 1;
  EXPECT_NE(check_of(facts, "link").fix.find("stof config front set"), std::string::npos);
  facts.clock = wire::ClockState::kRecorded;  // who plays a recording takes neither
  EXPECT_NE(check_of(facts, "link").fix.find("stof config SENSOR set"), std::string::npos);
  set_condition(facts, wire::Condition::kUnpaired);
  EXPECT_EQ(check_of(facts, "key").verdict, CheckVerdict::kNote);
  EXPECT_EQ(check_of(facts, "key").fix, "");
}

TEST(Checks, SayThatAFileIsDamaged) {
  CheckFacts facts = good();
  facts.recorded = true;
  facts.stats.counts.frames_lost = 5;
  facts.stats.damage = Damage{};
  EXPECT_EQ(check_of(facts, "file").verdict, CheckVerdict::kOk);
  facts.stats.damage = Damage{.records = 2, .bytes = 4096};
  EXPECT_EQ(check_of(facts, "file").verdict, CheckVerdict::kFix);
  EXPECT_NE(check_of(facts, "file").found.find("2 records"), std::string::npos);
  EXPECT_EQ(check_of(facts, "link").fix.find("parity"), std::string::npos);
  facts.stats.counts.frames_lost = 0;
  facts.stats.silences = 1;
  EXPECT_NE(check_of(facts, "link").fix.find("stood still"), std::string::npos);
}

TEST(Checks, SayThatAFileWasCutOrIsBeingWritten) {
  CheckFacts facts = good();
  facts.recorded = true;
  Damage cut;
  cut.state = {.indexed = false, .end = mcap::StreamReader::End::kCut};
  facts.stats.damage = cut;
  EXPECT_EQ(check_of(facts, "file").verdict, CheckVerdict::kNote);
  EXPECT_NE(check_of(facts, "file").found.find("it was cut"), std::string::npos);
  EXPECT_NE(check_of(facts, "file").fix.find("stof recover FILE"), std::string::npos);
  facts.stats.damage->state.being_written = true;
  EXPECT_EQ(check_of(facts, "file").verdict, CheckVerdict::kNote);
  EXPECT_NE(check_of(facts, "file").found.find("another program writes it"), std::string::npos);
  EXPECT_EQ(check_of(facts, "file").fix, "") << "recover is refused meanwhile";
  facts.stats.damage->state = {.indexed = false};
  EXPECT_NE(check_of(facts, "file").found.find("its index is damaged"), std::string::npos);
}

TEST(Checks, LetSilenceAloneBeNoMatterOfLosses) {
  CheckFacts facts = good();
  facts.recorded = true;
  facts.stats.counts.frames_complete = 264;
  facts.stats.counts.frames_incomplete = 1;  // 0.4 percent
  facts.stats.silences = 2;
  const Check few = check_of(facts, "link");
  EXPECT_EQ(few.verdict, CheckVerdict::kFix);
  EXPECT_EQ(few.fix.find("parity"), std::string::npos) << few.fix;
  EXPECT_NE(few.fix.find("stood still"), std::string::npos) << few.fix;
  facts.stats.counts.frames_incomplete = 10;
  const Check many = check_of(facts, "link");
  EXPECT_NE(many.fix.find("parity"), std::string::npos) << many.fix;
  EXPECT_NE(many.fix.find("stood still"), std::string::npos) << many.fix;
}

TEST(Checks, SayHowManyFramesOfAFileHaveNoLens) {
  CheckFacts facts = good();
  facts.recorded = true;
  EXPECT_EQ(check_of(facts, "calibration").verdict, CheckVerdict::kOk);
  facts.stats.counts.frames_complete = 273;
  facts.frames_without_lens = 233;
  EXPECT_EQ(check_of(facts, "calibration").verdict, CheckVerdict::kNote);
  EXPECT_NE(check_of(facts, "calibration").found.find("233 of 273 frames have none"),
            std::string::npos);
}

TEST(Checks, OfARecordingAreThoseThatItTells) {
  CheckFacts facts = good();
  facts.recorded = true;
  std::vector<std::string> names;
  for (const Check& check : judge_checks(facts)) {
    names.push_back(check.name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"file", "link", "clock", "calibration", "health"}));
}

TEST(Checks, OfThisMachineItselfWantNoBeacon) {
  CheckFacts facts = good();
  facts.beacon_heard = false;
  facts.network.loopback = true;
  EXPECT_EQ(check_of(facts, "firewall").verdict, CheckVerdict::kOk);
}

}  // namespace
}  // namespace stof::host
