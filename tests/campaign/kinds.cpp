#include <array>

#include "tests/campaign/trial.h"

namespace stof::campaign {
namespace {

using namespace std::chrono_literals;
using emu::FaultKind;

constexpr int kSteadyEdge = 60;

// How long: some runs of a kind have one frame struck, others up to two seconds.
int calls(test::Random& random) {
  return random.between(0, 2) == 0 ? random.between(1, 3) : random.between(4, 60);
}

hal::Duration delay(test::Random& random) {
  constexpr std::array<hal::Duration, 4> kDelays{5ms, 25ms, 40ms, 70ms};
  return kDelays[static_cast<std::size_t>(random.between(0, 3))];
}

// From the start, from an edge, or from within a frame.
Span span_of(hal::Time base, Place place, hal::Duration length, test::Random& random) {
  hal::Time begin = base;
  if (place != Place::kStart) {
    begin += kPeriod * (kSteadyEdge + random.between(0, 30));
  }
  if (place == Place::kMidFrame) {
    begin += std::chrono::microseconds(random.between(500, 32'500));
  }
  return {begin, begin + length};
}
Span some_span(hal::Time base, Place place, test::Random& random) {
  return span_of(base, place, kPeriod * calls(random), random);
}

// A fault of a device: by FaultPlan at the start and in steady run, timed in mid-frame.
template <emu::FaultPlan CallFaults::* kCalls, TimedFault Plan::* kTimed, Plan::By kBy,
          FaultKind kKind>
void device(Plan& plan, Place place, test::Random& random) {
  const auto count = static_cast<std::uint32_t>(calls(random));
  const hal::Duration duration = kKind == FaultKind::kDelay    ? delay(random)
                                 : kKind == FaultKind::kRepeat ? hal::Duration(12ms)
                                                               : hal::Duration(0);
  if (place == Place::kMidFrame) {
    plan.span = span_of(plan.base, place, kPeriod * static_cast<int>(count), random);
    (plan.*kTimed) = {.kind = kKind, .span = plan.span, .duration = duration};
    return;
  }
  const bool link = kBy == Plan::By::kLinkCalls;  // a frame is several datagrams
  const int first = place == Place::kStart ? random.between(0, 3) : kSteadyEdge;
  plan.by = kBy;
  plan.fault = {.kind = kKind,
                .call = static_cast<std::uint32_t>(link ? 8 * first + random.between(0, 7) : first),
                .calls = link ? 4 * count : count,
                .duration = duration};
  plan.calls.*kCalls = {plan.fault};
}

template <FaultKind kKind>
constexpr auto kTrigger =
    device<&CallFaults::trigger, &Plan::trigger, Plan::By::kTriggerCalls, kKind>;
template <FaultKind kKind>
constexpr auto kStereo = device<&CallFaults::stereo, &Plan::stereo, Plan::By::kStereoCalls, kKind>;
template <FaultKind kKind>
constexpr auto kPmd = device<&CallFaults::pmd, &Plan::pmd, Plan::By::kPmdCalls, kKind>;

// The port's datagrams are its calls: in mid-frame the first that is struck is not a frame's first.
template <FaultKind kKind>
void link(Plan& plan, Place place, test::Random& random) {
  device<&CallFaults::link, &Plan::link, Plan::By::kLinkCalls, kKind>(
      plan, place == Place::kMidFrame ? Place::kSteady : place, random);
  if (place == Place::kMidFrame) {
    plan.fault.call += static_cast<std::uint32_t>(random.between(1, 30));
    plan.calls.link = {plan.fault};
  }
}

void trigger_lies(Plan& plan, Place place, test::Random& random) {
  constexpr std::array<hal::Duration, 5> kOff{-5ms, -33ms, 1ms, 3600s, -1000s};
  plan.span = some_span(plan.base, place, random);
  plan.trigger = {.lie = Lie::kLaterStamps,
                  .span = plan.span,
                  .duration = kOff[static_cast<std::size_t>(random.between(0, 4))]};
}

void stereo_lies(Plan& plan, Place place, test::Random& random) {
  constexpr std::array kLies{Lie::kOldPixels,     Lie::kOldPixelsOfBoth, Lie::kLaterStamps,
                             Lie::kEarlierStamps, Lie::kNoStamps,        Lie::kEndsBeforeItBegins,
                             Lie::kSequenceStands};
  plan.span = some_span(plan.base, place, random);
  plan.stereo = {.lie = kLies[static_cast<std::size_t>(random.between(0, 6))], .span = plan.span};
}

void pmd_lies(Plan& plan, Place place, test::Random& random) {
  constexpr std::array kLies{Lie::kOldPixels,     Lie::kDark,     Lie::kLaterStamps,
                             Lie::kEarlierStamps, Lie::kNoStamps, Lie::kEndsBeforeItBegins,
                             Lie::kSequenceStands};
  plan.span = some_span(plan.base, place, random);
  plan.pmd = {.lie = kLies[static_cast<std::size_t>(random.between(0, 6))], .span = plan.span};
}

void network(Plan& plan, Place place, test::Random& random,
             const netem::ImpairmentOptions& options) {
  plan.span = some_span(plan.base, place, random);
  plan.network = options;
  plan.network->seed = random.next();
}
void loss(Plan& plan, Place place, test::Random& random) {
  network(plan, place, random, {.loss = random.between(1, 30) / 100.0});
}
void bursts(Plan& plan, Place place, test::Random& random) {
  network(plan, place, random, {.loss = 0.3, .burst = 20});
}
void cut(Plan& plan, Place place, test::Random& random) {
  network(plan, place, random, {.loss = 1});
}
void reorder(Plan& plan, Place place, test::Random& random) {
  network(plan, place, random, {.reorder = random.between(2, 64)});
}
void duplicate(Plan& plan, Place place, test::Random& random) {
  network(plan, place, random, {.duplicate = random.between(1, 100) / 100.0});
}
void damage(Plan& plan, Place place, test::Random& random) {
  network(plan, place, random, {.corrupt = random.between(1, 50) / 100.0});
}
void jitter(Plan& plan, Place place, test::Random& random) {
  network(plan, place, random,
          {.delay = 5ms, .jitter = std::chrono::milliseconds(random.between(1, 80))});
}

template <Attack kAttack>
void attack(Plan& plan, Place place, test::Random& random) {
  plan.span =
      span_of(plan.base, place, std::chrono::milliseconds(random.between(100, 2000)), random);
  plan.attack = kAttack;
}

void link_full(Plan& plan, Place place, test::Random& random) {
  plan.span = some_span(plan.base, place, random);
  plan.link = {.kind = FaultKind::kDrop, .span = plan.span};
}
void unreachable(Plan& plan, Place place, test::Random& random) {
  plan.span = some_span(plan.base, place, random);
  plan.link = {.kind = FaultKind::kVanish, .span = plan.span};
}
void stopped_sensor(Plan& plan, Place place, test::Random& random) {
  plan.span =
      span_of(plan.base, place, std::chrono::milliseconds(random.between(20, 4000)), random);
  plan.stops_sensor = true;
}
void stopped_robot(Plan& plan, Place place, test::Random& random) {
  plan.span =
      span_of(plan.base, place, std::chrono::milliseconds(random.between(20, 4000)), random);
  plan.stops_robot = true;
}
void busy(Plan& plan, Place place, test::Random& random) {
  plan.span = some_span(plan.base, place, random);
  plan.busy = std::chrono::microseconds(random.between(200, 5000));
}
void killed(Plan& plan, Place place, test::Random& random) {
  plan.span =
      span_of(plan.base, place, std::chrono::milliseconds(random.between(50, 3000)), random);
  plan.power_off = true;
}
void wall_clock(Plan& plan, Place place, test::Random& random) {
  constexpr std::array<hal::Duration, 6> kJumps{-3600s, -1s, -50ms, 50ms, 1s, 3600s};
  plan.span = span_of(plan.base, place, 1ms, random);
  plan.wall_jump = kJumps[static_cast<std::size_t>(random.between(0, 5))];
}
// Two sensors at a time, one of them for good.
void both_cameras(Plan& plan, Place place, test::Random& random) {
  plan.span = some_span(plan.base, place, random);
  plan.stereo = {.kind = FaultKind::kVanish, .span = plan.span};
  plan.pmd = plan.stereo;
}

constexpr std::array kKinds{
    Kind{"trigger", "drop", kTrigger<FaultKind::kDrop>},
    Kind{"trigger", "delay", kTrigger<FaultKind::kDelay>},
    Kind{"trigger", "tear", kTrigger<FaultKind::kTear>},
    Kind{"trigger", "repeat", kTrigger<FaultKind::kRepeat>},
    Kind{"trigger", "vanish", kTrigger<FaultKind::kVanish>},
    Kind{"trigger", "lie", trigger_lies},
    Kind{"stereo", "drop", kStereo<FaultKind::kDrop>},
    Kind{"stereo", "delay", kStereo<FaultKind::kDelay>},
    Kind{"stereo", "tear", kStereo<FaultKind::kTear>},
    Kind{"stereo", "corrupt", kStereo<FaultKind::kCorrupt>},
    Kind{"stereo", "repeat", kStereo<FaultKind::kRepeat>},
    Kind{"stereo", "vanish", kStereo<FaultKind::kVanish>},
    Kind{"stereo", "lie", stereo_lies},
    Kind{"pmd", "drop", kPmd<FaultKind::kDrop>},
    Kind{"pmd", "delay", kPmd<FaultKind::kDelay>},
    Kind{"pmd", "tear", kPmd<FaultKind::kTear>},
    Kind{"pmd", "corrupt", kPmd<FaultKind::kCorrupt>},
    Kind{"pmd", "repeat", kPmd<FaultKind::kRepeat>},
    Kind{"pmd", "vanish", kPmd<FaultKind::kVanish>},
    Kind{"pmd", "lie", pmd_lies},
    Kind{"both", "vanish", both_cameras},
    Kind{"port", "drop", link<FaultKind::kDrop>},
    Kind{"port", "delay", link<FaultKind::kDelay>},
    Kind{"port", "tear", link<FaultKind::kTear>},
    Kind{"port", "repeat", link<FaultKind::kRepeat>},
    Kind{"port", "vanish", link<FaultKind::kVanish>},
    Kind{"port", "lie", link<FaultKind::kCorrupt>},
    Kind{"port", "full", link_full},
    Kind{"port", "unreachable", unreachable},
    Kind{"network", "loss", loss},
    Kind{"network", "bursts", bursts},
    Kind{"network", "cut", cut},
    Kind{"network", "reorder", reorder},
    Kind{"network", "duplicate", duplicate},
    Kind{"network", "damage", damage},
    Kind{"network", "jitter", jitter},
    Kind{"attack", "flood", attack<Attack::kJunk>},
    Kind{"attack", "stale flood", attack<Attack::kStale>},
    Kind{"attack", "lies", attack<Attack::kLies>},
    Kind{"attack", "other session", attack<Attack::kOtherSession>},
    Kind{"attack", "forged requests", attack<Attack::kForgedRequests>},
    Kind{"attack", "request flood", attack<Attack::kRequestFlood>},
    Kind{"attack", "ICMP", attack<Attack::kUnreachable>},
    Kind{"time", "sensor stopped", stopped_sensor},
    Kind{"time", "robot stopped", stopped_robot},
    Kind{"time", "busy", busy},
    Kind{"time", "killed", killed},
    Kind{"time", "wall clock", wall_clock},
};

}  // namespace

std::span<const Kind> kinds() noexcept { return kKinds; }

}  // namespace stof::campaign
