#include "hal/linux/gpio/gpio_trigger.h"

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <memory>

#include <gtest/gtest.h>

#include "hal/linux/system/clock.h"
#include "hal/linux/system/heap_watch.h"
#include "tests/hal/gpio/fake_gpiod.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::linux::GpioTrigger;
using hal::linux::GpioTriggerOptions;
using hal::linux::StrobeExposures;

GpioTriggerOptions options_of(const FakeGpioChip& chip) {
  GpioTriggerOptions options;
  options.devices = chip.devices();
  options.outputs = {"GPIO1", "9030000.pl061:5", "gpiochip0:6"};
  options.strobes = {"GPIO2", "GPIO3"};
  options.max_uncertainty = 1s;  // of a busy machine
  return options;
}

std::unique_ptr<GpioTrigger> open_trigger(const GpioTriggerOptions& options) {
  auto trigger = GpioTrigger::open(options);
  if (!trigger) {
    ADD_FAILURE() << trigger.error().message;
    std::abort();
  }
  return std::move(*trigger);
}

std::string refusal(const GpioTriggerOptions& options) {
  const auto trigger = GpioTrigger::open(options);
  EXPECT_FALSE(trigger);
  return trigger ? std::string() : trigger.error().message;
}

bool says(const std::string& message, const char* what) {
  EXPECT_EQ(message.find('\n'), std::string::npos);
  const bool found = message.find(what) != std::string::npos;
  EXPECT_TRUE(found) << message;
  return found;
}

TEST(GpioTrigger, RaisesAllOutputsAtOnceAndLowersThemAfterTheWidth) {
  FakeGpioChip chip;
  const auto trigger = open_trigger(options_of(chip));
  const auto edge = trigger->pulse();
  ASSERT_TRUE(edge);
  ASSERT_EQ(chip.levels.size(), 2U) << "one call to raise, one to lower";
  for (const unsigned line : {1U, 5U, 6U}) {
    EXPECT_TRUE(chip.output.at(line));
    EXPECT_TRUE(chip.levels[0].high.at(line));
    EXPECT_FALSE(chip.levels[1].high.at(line));
  }
  EXPECT_FALSE(chip.levels[0].high.at(0));
  EXPECT_LE(*edge, chip.levels[0].at);
  EXPECT_LE(chip.levels[0].at, *edge + trigger->uncertainty());
  EXPECT_GE(chip.levels[1].at - chip.levels[0].at, 100us);
  EXPECT_EQ(trigger->edges().at_or_before(*edge), *edge);
  EXPECT_TRUE(chip.tells_edges.at(2) && chip.tells_edges.at(3));
}

TEST(GpioTrigger, ActiveLowPullsThePinsDown) {
  FakeGpioChip chip;
  GpioTriggerOptions options = options_of(chip);
  options.active_low = true;
  const auto trigger = open_trigger(options);
  EXPECT_TRUE(chip.high.at(5));
  ASSERT_TRUE(trigger->pulse());
  EXPECT_FALSE(chip.levels[0].high.at(5));
  EXPECT_TRUE(chip.levels[1].high.at(5));
}

TEST(GpioTrigger, EdgeAtAnUnknownTimeIsAnErrorAndNotInTheLog) {
  FakeGpioChip chip;
  GpioTriggerOptions options = options_of(chip);
  options.max_uncertainty = 1ms;
  const auto trigger = open_trigger(options);
  chip.set_takes = 2ms;
  const auto edge = trigger->pulse();
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error(), Status::kDeviceError);
  EXPECT_FALSE(chip.high.at(1));
  EXPECT_FALSE(trigger->edges().at_or_before(hal::Time::max()));
}

TEST(GpioTrigger, ChipThatGoesIsLostAndReopensInPlace) {
  FakeGpioChip chip;
  const auto trigger = open_trigger(options_of(chip));
  ASSERT_TRUE(trigger->pulse());
  chip.set_error = ENODEV;
  EXPECT_EQ(trigger->pulse().error(), Status::kDeviceLost);
  chip.request_error = EBUSY;
  EXPECT_EQ(trigger->reopen(), Status::kDeviceLost);
  EXPECT_TRUE(says(trigger->trouble(), "another program"));
  EXPECT_EQ(trigger->pulse().error(), Status::kDeviceLost);
  trigger->read_strobes();
  chip.set_error = 0;
  chip.request_error = 0;
  EXPECT_EQ(trigger->reopen(), Status::kOk);
  EXPECT_TRUE(trigger->trouble().empty());
  EXPECT_TRUE(trigger->pulse());
}

TEST(GpioTrigger, LeavesNothingBehind) {
  FakeGpioChip chip;
  open_trigger(options_of(chip)).reset();
  EXPECT_EQ(chip.requests, 0);
  EXPECT_EQ(chip.open_chips, 0);
}

TEST(GpioTrigger, StrobesTellExposures) {
  FakeGpioChip chip;
  const auto trigger = open_trigger(options_of(chip));
  StrobeExposures left(*trigger, 0);
  StrobeExposures right(*trigger, 1);
  constexpr hal::Time kAt{1000s};
  EXPECT_FALSE(left.ended_at(kAt + 1h));
  for (int i = 0; i < 200; ++i) {
    chip.tell(2, true, kAt + i * 10ms);
    chip.tell(3, true, kAt + i * 10ms + 1us);
    chip.tell(2, false, kAt + i * 10ms + 4ms);
    chip.tell(3, false, kAt + i * 10ms + 5ms);
  }
  const auto one = left.ended_at(kAt + 1h);
  const auto two = right.ended_at(kAt + 1h);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->begin, kAt + 1990ms);
  EXPECT_EQ(one->end, kAt + 1994ms);
  EXPECT_EQ(two->begin, kAt + 1990ms + 1us);
  EXPECT_EQ(two->end, kAt + 1995ms);
}

TEST(GpioTrigger, AllocatesNothingWhileItRuns) {
  FakeGpioChip chip;
  const auto trigger = open_trigger(options_of(chip));
  chip.levels.reserve(100);
  StrobeExposures left(*trigger, 0);
  for (int i = 0; i < 100; ++i) {
    chip.tell(2, i % 2 == 0, hal::Time(1000s) + i * 1ms);
  }
  hal::linux::watch_heap_of_this_thread();
  for (int i = 0; i < 10; ++i) {
    static_cast<void>(trigger->pulse());
  }
  static_cast<void>(left.ended_at(hal::Time(2000s)));
  const hal::linux::HeapCounts counts = hal::linux::heap_counts();
  EXPECT_TRUE(counts.counted);
  EXPECT_EQ(counts.calls, 0U);
}

TEST(GpioTrigger, SaysInOneLineWhyItDoesNotOpen) {
  FakeGpioChip chip;
  GpioTriggerOptions options = options_of(chip);
  options.outputs = {"GPIO1", "GPIO9"};
  EXPECT_TRUE(says(refusal(options), "'GPIO9'"));
  for (const char* const line :
       {"9030000.pl061:8", "9030000.pl061:", "other:1", ":1", "", "a:-1"}) {
    options.outputs = {line};
    EXPECT_TRUE(says(refusal(options), "gpioinfo lists"));
  }
  options = options_of(chip);
  options.outputs.clear();
  EXPECT_TRUE(says(refusal(options), "1 to 3 outputs"));
  options = options_of(chip);
  options.width = 11ms;
  EXPECT_TRUE(says(refusal(options), "1 us to 10 ms"));
  options = options_of(chip);
  options.chip = chip.devices() + "/gpiochip7";
  EXPECT_TRUE(says(refusal(options), "gpiochip7"));
  options = options_of(chip);
  options.devices = chip.devices() + "/none";
  EXPECT_TRUE(says(refusal(options), "no GPIO chip"));
  options = options_of(chip);
  chip.open_error = EACCES;
  EXPECT_TRUE(says(refusal(options), "group of that device"));
  chip.open_error = 0;
  chip.request_error = EBUSY;
  EXPECT_TRUE(says(refusal(options), "another program"));
  EXPECT_EQ(chip.open_chips, 0);
}

}  // namespace
}  // namespace stof::test
