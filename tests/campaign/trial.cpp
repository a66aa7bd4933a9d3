#include "tests/campaign/trial.h"

#include <algorithm>

namespace stof::campaign {
namespace {

using namespace std::chrono_literals;

// At the robot's next look.
constexpr client::Duration kDetected = 3 * kPeriod + 20ms + Robot::kLook;
constexpr client::Duration kUnknown = 500ms;  // as long as libstof does not know the period
constexpr client::Duration kTold = 1s;
constexpr client::Duration kHealed = 2s;
constexpr hal::Duration kAfter = 3500ms;  // watched behind the fault

double ms(client::Duration time) { return std::chrono::duration<double, std::milli>(time).count(); }

// When the fault begins and ends, as the devices saw it; nothing before it strikes.
std::optional<Span> struck(const World& world, const Plan& plan) {
  const auto at = [&](std::uint32_t call) -> std::optional<hal::Time> {
    switch (plan.by) {
      case Plan::By::kTriggerCalls:
        return world.trigger.time_of_call(call);
      case Plan::By::kLinkCalls:
        return world.network.time_of_call(call);
      default:
        return call < world.log.count() ? std::optional(world.log.at(call)) : std::nullopt;
    }
  };
  if (plan.by == Plan::By::kTime) {
    return plan.span;
  }
  const std::optional<hal::Time> begin = at(plan.fault.call);
  const std::optional<hal::Time> end = at(plan.fault.call + plan.fault.calls);
  if (!begin) {
    return std::nullopt;
  }
  // A delay strikes until what was held back has come.
  return Span{*begin, end ? *end + plan.fault.duration : hal::Time::max()};
}

Verdict judge(const World& world, const Plan& plan, const Span& fault) {
  const Robot& robot = world.robot;
  const client::Time on = client_time(fault.begin);
  const client::Time off = client_time(fault.end);
  Verdict verdict;
  verdict.delivered = robot.counts().delivered;
  verdict.falsehoods = robot.counts().falsehoods;
  verdict.oldest_ms = ms(robot.counts().oldest);
  verdict.healed_ms = std::max(ms(robot.unwell_until() - off), 0.0);

  // The first gap in the whole frames that the fault can have to do with, and the longest.
  std::optional<client::Time> before;  // none: the robot had nothing yet that it could believe
  std::optional<client::Time> gap;     // where it begins
  std::optional<client::Time> last;
  for (const client::Time at : robot.whole()) {
    // A robot that is stopped does nothing with what it believes: its time counts from there.
    const bool slept = plan.stops_robot && last && *last <= off && off <= at;
    const client::Time from = slept ? off : last.value_or(on);
    if (last && at - from > kDetected && at > on) {
      gap = gap ? gap : from;
      verdict.outage_ms = std::max(verdict.outage_ms, ms(at - from));
    }
    before = at <= on ? std::optional(at) : before;
    last = at;
  }
  const bool never = robot.whole().empty();
  const bool at_start = !before && !never && robot.whole().front() - on > 2 * kPeriod + kUnknown;
  if (at_start) {
    verdict.outage_ms = std::max(verdict.outage_ms, ms(robot.whole().front() - on));
  }
  verdict.effect = never || gap || at_start;
  // At the start the robot has nothing that it could believe: it knows.
  const client::Time since = std::max(gap.value_or(on), plan.stops_robot ? off : on);
  const auto first = [&](Sign least) -> std::optional<client::Time> {
    for (const SignAt& sign : robot.signs()) {
      if (sign.sign >= least && sign.at >= since) {
        return sign.at;
      }
    }
    return std::nullopt;
  };
  if (const auto sign = first(Sign::kCounted)) {
    verdict.detected_ms = at_start && !gap ? 0 : ms(*sign - since);
  }
  // What lasts has a condition, but for a bad network, of which a sensor knows nothing: libstof
  // says with each frame what is missing.
  const bool lasts = verdict.outage_ms > ms(kTold) && !plan.network;
  const Sign word = lasts ? Sign::kCondition : Sign::kIncomplete;
  if (const auto sign = first(word)) {
    verdict.told_ms = ms(*sign - since);
  }
  return verdict;
}

}  // namespace

void arm(World& world, const Plan& plan) {
  world.trigger.fault = plan.trigger;
  world.stereo.fault = plan.stereo;
  world.pmd.fault = plan.pmd;
  world.network.fault = plan.link;
  if (plan.network) {
    world.network.impair(plan.span, *plan.network);
  }
  world.attacker.arm(plan.attack, plan.span);
  if (plan.stops_sensor) {
    world.clock.stop(plan.span);
  }
  if (plan.stops_robot) {
    world.robot.sleep(plan.span);
  }
  if (plan.power_off) {
    world.power_off(plan.span);
  }
  if (plan.busy > 0ns) {
    world.clock.busy(plan.span, plan.busy);
  }
  if (plan.wall_jump != 0ns) {
    world.robot.set_wall_clock(plan.span.begin, plan.wall_jump);
  }
}

bool Verdict::in_time() const noexcept {
  return !effect || (detected_ms && *detected_ms <= ms(kDetected));
}

bool Verdict::was_told() const noexcept { return !effect || (told_ms && *told_ms <= ms(kTold)); }

bool Verdict::healed() const noexcept { return healed_ms <= ms(kHealed); }

std::uint64_t Verdict::false_frames() const noexcept {
  std::uint64_t sum = 0;
  for (std::size_t i = 1; i < kFalsehoods; ++i) {
    sum += falsehoods[i];
  }
  return sum;
}

Verdict run(const Kind& kind, Place place, std::uint64_t seed) {
  test::Random random(seed * 977 + static_cast<std::uint64_t>(place) * 31 + 1);
  Plan plan;
  kind.make(plan, place, random);
  World world(kSmallRig, plan.calls, 4096, seed);
  arm(world, plan);
  std::optional<Span> fault = struck(world, plan);
  const hal::Time latest = world.clock.peek() + 30s;
  while (world.clock.peek() < latest && (!fault || world.clock.peek() < fault->end + kAfter)) {
    world.step();
    fault = struck(world, plan);
    if (fault && fault->end == hal::Time::max()) {
      fault->end = latest;
    }
  }
  return judge(world, plan, fault.value_or(Span{latest, latest}));
}

bool check_the_judge() {
  // A robot that takes each wall for the one after it.
  RigSize other = kSmallRig;
  other.shown_later = 1;
  World wrong(kSmallRig, {}, 200, 1, {.truth = other});
  wrong.run(hal::Time(1000s) + 40 * kPeriod);
  const RobotCounts& counts = wrong.robot.counts();
  const bool pixels = counts.delivered > 30 && counts.false_frames() == counts.delivered;

  // A robot that takes frames of any age.
  World late(kSmallRig, {}, 400, 1, {.truth = kSmallRig, .max_age = 10s});
  const hal::Time begin = hal::Time(1000s) + 60 * kPeriod;
  late.robot.sleep({begin, begin + 2s});
  late.run(begin + 3s);
  const bool stale =
      late.robot.counts().falsehoods[static_cast<std::size_t>(Falsehood::kStale)] > 20;

  // Nothing is wrong.
  World well(kSmallRig, {}, 400, 1);
  well.run(begin);
  const bool quiet = well.robot.counts().false_frames() == 0 && well.robot.counts().whole > 50;
  return pixels && stale && quiet;
}

}  // namespace stof::campaign
