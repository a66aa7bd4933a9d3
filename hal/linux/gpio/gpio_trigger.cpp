#include "hal/linux/gpio/gpio_trigger.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <gpiod.h>

#include "dsp/base/check.h"
#include "hal/linux/gpio/gpio_lines.h"
#include "hal/linux/system/clock.h"

namespace stof::hal::linux {
namespace {

constexpr Duration kLeastWidth = std::chrono::microseconds(1);
constexpr Duration kMostWidth = std::chrono::milliseconds(10);
constexpr std::size_t kEventsAtOnce = 64;
constexpr int kMostReads = 16;  // a line that chatters must not keep us here

struct FreeSettings {
  void operator()(gpiod_line_settings* settings) const noexcept {
    gpiod_line_settings_free(settings);
  }
};
struct FreeConfig {
  void operator()(gpiod_line_config* config) const noexcept { gpiod_line_config_free(config); }
};
struct FreeRequestConfig {
  void operator()(gpiod_request_config* config) const noexcept {
    gpiod_request_config_free(config);
  }
};
using Settings = std::unique_ptr<gpiod_line_settings, FreeSettings>;

std::string advice(int error) {
  switch (error) {
    case EBUSY:
      return "another program or driver has one of them: gpioinfo tells which";
    case EACCES:
    case EPERM:
      return "add the user to the group of that device, often gpio";
    case EINVAL:
    case ENOTSUP:
      return "the chip cannot do that with one of them: choose others";
    default:
      return "check the names of the lines and the chip";
  }
}

std::string names_of(const GpioTriggerOptions& options) {
  std::string names;
  for (const std::vector<std::string>* lines : {&options.outputs, &options.strobes}) {
    for (const std::string& line : *lines) {
      names += (names.empty() ? "'" : ", '") + line + "'";
    }
  }
  return names;
}

std::expected<void, OpenError> check(const GpioTriggerOptions& options) {
  if (options.outputs.empty() || options.outputs.size() > GpioTrigger::kMostOutputs ||
      options.strobes.size() > GpioTrigger::kMostStrobes) {
    return std::unexpected(OpenError{"GPIO trigger: give 1 to 3 outputs and up to 2 strobes"});
  }
  if (options.width < kLeastWidth || options.width > kMostWidth ||
      options.max_uncertainty <= Duration::zero()) {
    return std::unexpected(
        OpenError{"GPIO trigger: give a pulse of 1 us to 10 ms and some uncertainty"});
  }
  return {};
}

// Adds `offsets` as outputs that are low, or as inputs that tell their edges.
bool add_lines(gpiod_line_config* config, std::span<const unsigned> offsets, bool output,
               bool active_low) {
  if (offsets.empty()) {
    return true;
  }
  const Settings settings(gpiod_line_settings_new());
  if (!settings) {
    return false;
  }
  gpiod_line_settings_set_active_low(settings.get(), active_low);
  const bool set =
      output
          ? gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT) == 0 &&
                gpiod_line_settings_set_output_value(settings.get(), GPIOD_LINE_VALUE_INACTIVE) == 0
          : gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT) == 0 &&
                gpiod_line_settings_set_edge_detection(settings.get(), GPIOD_LINE_EDGE_BOTH) == 0 &&
                gpiod_line_settings_set_event_clock(settings.get(), GPIOD_LINE_CLOCK_MONOTONIC) ==
                    0;
  return set && gpiod_line_config_add_line_settings(config, offsets.data(), offsets.size(),
                                                    settings.get()) == 0;
}

}  // namespace

GpioTrigger::GpioTrigger(GpioTriggerOptions options) : options_(std::move(options)) {}

std::expected<std::unique_ptr<GpioTrigger>, OpenError> GpioTrigger::open(
    const GpioTriggerOptions& options) {
  if (const auto good = check(options); !good) {
    return std::unexpected(good.error());
  }
  std::unique_ptr<GpioTrigger> trigger(new GpioTrigger(options));
  if (const auto requested = trigger->request(); !requested) {
    return std::unexpected(requested.error());
  }
  return trigger;
}

GpioTrigger::~GpioTrigger() { shut(); }

void GpioTrigger::shut() noexcept {
  if (request_ != nullptr) {
    static_cast<void>(set_outputs(false));
    gpiod_line_request_release(std::exchange(request_, nullptr));
  }
  if (events_ != nullptr) {
    gpiod_edge_event_buffer_free(std::exchange(events_, nullptr));
  }
}

std::expected<void, OpenError> GpioTrigger::request() {
  std::vector<std::string> names = options_.outputs;
  names.insert(names.end(), options_.strobes.begin(), options_.strobes.end());
  std::expected<GpioLines, OpenError> found =
      find_gpio_lines(options_.chip, options_.devices, names);
  if (!found) {
    return std::unexpected(found.error());
  }
  const std::span<const unsigned> outputs =
      std::span(found->offsets).first(options_.outputs.size());
  const std::span<const unsigned> strobes =
      std::span(found->offsets).subspan(options_.outputs.size());
  std::ranges::copy(outputs, output_offsets_.begin());
  std::ranges::copy(strobes, strobe_offsets_.begin());
  const std::unique_ptr<gpiod_line_config, FreeConfig> lines(gpiod_line_config_new());
  const std::unique_ptr<gpiod_request_config, FreeRequestConfig> how(gpiod_request_config_new());
  if (lines && how && add_lines(lines.get(), outputs, true, options_.active_low) &&
      add_lines(lines.get(), strobes, false, options_.strobe_active_low)) {
    gpiod_request_config_set_consumer(how.get(), "stof");
    gpiod_request_config_set_event_buffer_size(how.get(), kEventsAtOnce * 2);
    request_ = gpiod_chip_request_lines(found->chip.get(), how.get(), lines.get());
  }
  const int error = errno;
  if (request_ != nullptr && !strobes.empty()) {
    events_ = gpiod_edge_event_buffer_new(kEventsAtOnce);
  }
  if (request_ == nullptr || (events_ == nullptr && !strobes.empty())) {
    shut();
    return std::unexpected(OpenError{"GPIO lines " + names_of(options_) + ": " +
                                     std::strerror(error) + "; " + advice(error)});
  }
  for (StrobeLog& strobe : strobes_) {
    strobe.restart();
  }
  return {};
}

Status GpioTrigger::reopen() noexcept {
  if (request_ != nullptr && !lost_) {
    return Status::kOk;
  }
  shut();
  const auto requested = request();
  lost_ = !requested;
  trouble_ = requested ? std::string() : requested.error().message;
  return requested ? Status::kOk : Status::kDeviceLost;
}

bool GpioTrigger::set_outputs(bool high) noexcept {
  std::array<gpiod_line_value, kMostOutputs> values{};
  values.fill(high ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE);
  return gpiod_line_request_set_values_subset(request_, options_.outputs.size(),
                                              output_offsets_.data(), values.data()) == 0;
}

Result<Time> GpioTrigger::pulse() noexcept {
  if (request_ == nullptr) {
    return fail(Status::kDeviceLost);
  }
  Clock clock;
  const Time before = clock.now();
  const bool raised = set_outputs(true);
  const Time after = clock.now();
  if (raised) {
    clock.wait_until(after + options_.width);
  }
  // Also where raising failed: one of the lines may be high.
  const bool lowered = set_outputs(false);
  uncertainty_ = after - before;
  const Duration longer = clock.now() - after - options_.width;
  if (!raised || !lowered) {
    lost_ = true;
    return fail(Status::kDeviceLost);
  }
  if (uncertainty_ > options_.max_uncertainty ||
      (options_.width_is_exposure && longer > options_.max_uncertainty)) {
    return fail(Status::kDeviceError);
  }
  edges_.note(before);
  return before;
}

void GpioTrigger::read_strobes() noexcept {
  // A wait of 0 only looks; a read would block without it.
  for (int i = 0; i < kMostReads && events_ != nullptr &&
                  gpiod_line_request_wait_edge_events(request_, 0) == 1;
       ++i) {
    const int count = gpiod_line_request_read_edge_events(request_, events_, kEventsAtOnce);
    for (int k = 0; k < count; ++k) {
      gpiod_edge_event* const event =
          gpiod_edge_event_buffer_get_event(events_, static_cast<unsigned>(k));  // not a copy
      const unsigned offset = gpiod_edge_event_get_line_offset(event);
      const Time at(Duration(static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event))));
      for (std::size_t s = 0; s < options_.strobes.size(); ++s) {
        if (strobe_offsets_[s] != offset) {
          continue;
        }
        const std::uint64_t number = gpiod_edge_event_get_line_seqno(event);
        if (gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE) {
          strobes_[s].note_rise(at, number);
        } else {
          strobes_[s].note_fall(at, number);
        }
      }
    }
    if (count <= 0) {
      return;
    }
  }
}

const StrobeLog& GpioTrigger::strobe(std::size_t strobe) const noexcept {
  STOF_CHECK(strobe < options_.strobes.size());
  return strobes_[strobe];
}

}  // namespace stof::hal::linux
