#include "tests/hal/gpio/fake_gpiod.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>

#include <gpiod.h>

#include "hal/linux/system/clock.h"

namespace stof::test {
namespace {

FakeGpioChip* chip = nullptr;

template <typename T>
T* fail_with(int error) {
  errno = error;
  return nullptr;
}

}  // namespace

FakeGpioChip::FakeGpioChip() {
  chip = this;
  std::string pattern = (std::filesystem::temp_directory_path() / "stof-gpio-XXXXXX").string();
  devices_ = mkdtemp(pattern.data());
  std::ofstream(devices_ + "/gpiochip0") << '\n';
  std::ofstream(devices_ + "/null") << '\n';
}

FakeGpioChip::~FakeGpioChip() {
  std::filesystem::remove_all(devices_);
  chip = nullptr;
}

}  // namespace stof::test

using stof::test::chip;
using stof::test::FakeGpioChip;

// NOLINTBEGIN(readability-identifier-naming): libgpiod's names
struct gpiod_chip {};
struct gpiod_chip_info {};
struct gpiod_line_settings {
  gpiod_line_direction direction = GPIOD_LINE_DIRECTION_AS_IS;
  gpiod_line_edge edge = GPIOD_LINE_EDGE_NONE;
  gpiod_line_clock clock = GPIOD_LINE_CLOCK_REALTIME;
  gpiod_line_bias bias = GPIOD_LINE_BIAS_AS_IS;
  bool active_low = false;
};
struct gpiod_line_config {
  struct Line {
    unsigned offset;
    gpiod_line_settings settings;
  };
  std::vector<Line> lines;
};
struct gpiod_request_config {};
struct gpiod_line_request {};
struct gpiod_edge_event {
  FakeGpioChip::Event event;
};
struct gpiod_edge_event_buffer {
  std::vector<gpiod_edge_event> events;
};

extern "C" {
gpiod_chip* gpiod_chip_open(const char* path) {
  if (chip->open_error != 0) {
    return stof::test::fail_with<gpiod_chip>(chip->open_error);
  }
  if (!std::filesystem::exists(path)) {
    return stof::test::fail_with<gpiod_chip>(ENOENT);
  }
  ++chip->open_chips;
  return new gpiod_chip;
}
void gpiod_chip_close(gpiod_chip* one) {
  --chip->open_chips;
  delete one;
}
gpiod_chip_info* gpiod_chip_get_info(gpiod_chip*) { return new gpiod_chip_info; }
void gpiod_chip_info_free(gpiod_chip_info* info) { delete info; }
const char* gpiod_chip_info_get_name(gpiod_chip_info*) { return "gpiochip0"; }
const char* gpiod_chip_info_get_label(gpiod_chip_info*) { return "9030000.pl061"; }
size_t gpiod_chip_info_get_num_lines(gpiod_chip_info*) { return FakeGpioChip::kLines; }
int gpiod_chip_get_line_offset_from_name(gpiod_chip*, const char* name) {
  for (int i = 0; i < 4; ++i) {
    if (name == "GPIO" + std::to_string(i)) {
      return i;
    }
  }
  errno = ENOENT;
  return -1;
}
gpiod_line_settings* gpiod_line_settings_new() { return new gpiod_line_settings; }
void gpiod_line_settings_free(gpiod_line_settings* settings) { delete settings; }
int gpiod_line_settings_set_direction(gpiod_line_settings* settings, gpiod_line_direction to) {
  settings->direction = to;
  return 0;
}
int gpiod_line_settings_set_edge_detection(gpiod_line_settings* settings, gpiod_line_edge edge) {
  settings->edge = edge;
  return 0;
}
int gpiod_line_settings_set_bias(gpiod_line_settings* settings, gpiod_line_bias bias) {
  settings->bias = bias;
  return 0;
}
int gpiod_line_settings_set_event_clock(gpiod_line_settings* settings, gpiod_line_clock clock) {
  settings->clock = clock;
  return 0;
}
int gpiod_line_settings_set_output_value(gpiod_line_settings*, gpiod_line_value value) {
  return value == GPIOD_LINE_VALUE_INACTIVE ? 0 : -1;
}
void gpiod_line_settings_set_active_low(gpiod_line_settings* settings, bool active_low) {
  settings->active_low = active_low;
}
gpiod_line_config* gpiod_line_config_new() { return new gpiod_line_config; }
void gpiod_line_config_free(gpiod_line_config* config) { delete config; }
int gpiod_line_config_add_line_settings(gpiod_line_config* config, const unsigned* offsets,
                                        size_t count, gpiod_line_settings* settings) {
  for (const unsigned offset : std::span(offsets, count)) {
    config->lines.push_back({offset, *settings});
  }
  return 0;
}
gpiod_request_config* gpiod_request_config_new() { return new gpiod_request_config; }
void gpiod_request_config_free(gpiod_request_config* config) { delete config; }
void gpiod_request_config_set_consumer(gpiod_request_config*, const char*) {}
void gpiod_request_config_set_event_buffer_size(gpiod_request_config*, size_t) {}
gpiod_line_request* gpiod_chip_request_lines(gpiod_chip*, gpiod_request_config*,
                                             gpiod_line_config* config) {
  if (chip->request_error != 0) {
    return stof::test::fail_with<gpiod_line_request>(chip->request_error);
  }
  for (const gpiod_line_config::Line& line : config->lines) {
    chip->output.at(line.offset) = line.settings.direction == GPIOD_LINE_DIRECTION_OUTPUT;
    chip->active_low.at(line.offset) = line.settings.active_low;
    chip->high.at(line.offset) = line.settings.active_low;
    chip->pulled_up.at(line.offset) = line.settings.bias == GPIOD_LINE_BIAS_PULL_UP;
    chip->tells_edges.at(line.offset) = line.settings.edge == GPIOD_LINE_EDGE_BOTH &&
                                        line.settings.clock == GPIOD_LINE_CLOCK_MONOTONIC;
  }
  ++chip->requests;
  return new gpiod_line_request;
}
gpiod_line_value gpiod_line_request_get_value(gpiod_line_request*, unsigned offset) {
  if (chip->value_error != 0) {
    errno = chip->value_error;
    return GPIOD_LINE_VALUE_ERROR;
  }
  return chip->high.at(offset) != chip->active_low.at(offset) ? GPIOD_LINE_VALUE_ACTIVE
                                                              : GPIOD_LINE_VALUE_INACTIVE;
}
void gpiod_line_request_release(gpiod_line_request* request) {
  --chip->requests;
  delete request;
}
int gpiod_line_request_set_values_subset(gpiod_line_request*, size_t count, const unsigned* offsets,
                                         const gpiod_line_value* values) {
  if (chip->set_error != 0) {
    errno = chip->set_error;
    return -1;
  }
  stof::hal::linux::Clock clock;
  clock.wait_until(clock.now() + chip->set_takes);
  for (size_t i = 0; i < count; ++i) {
    chip->high.at(offsets[i]) =
        (values[i] == GPIOD_LINE_VALUE_ACTIVE) != chip->active_low.at(offsets[i]);
  }
  chip->levels.push_back({clock.now(), chip->high});
  return 0;
}
gpiod_edge_event_buffer* gpiod_edge_event_buffer_new(size_t capacity) {
  auto* const buffer = new gpiod_edge_event_buffer;
  buffer->events.reserve(capacity);
  return buffer;
}
void gpiod_edge_event_buffer_free(gpiod_edge_event_buffer* buffer) { delete buffer; }
int gpiod_line_request_wait_edge_events(gpiod_line_request*, int64_t timeout_ns) {
  return timeout_ns == 0 && !chip->events.empty() ? 1 : 0;
}
int gpiod_line_request_read_edge_events(gpiod_line_request*, gpiod_edge_event_buffer* buffer,
                                        size_t most) {
  const size_t count = std::min({most, buffer->events.capacity(), chip->events.size()});
  buffer->events.clear();
  for (size_t i = 0; i < count; ++i) {
    buffer->events.push_back({chip->events[i]});
  }
  chip->events.erase(chip->events.begin(),
                     chip->events.begin() + static_cast<long>(count));  // NOLINT
  return static_cast<int>(count);
}
gpiod_edge_event* gpiod_edge_event_buffer_get_event(gpiod_edge_event_buffer* buffer,
                                                    unsigned long index) {  // NOLINT: its own type
  return &buffer->events.at(index);
}
unsigned gpiod_edge_event_get_line_offset(gpiod_edge_event* event) { return event->event.line; }
uint64_t gpiod_edge_event_get_timestamp_ns(gpiod_edge_event* event) {
  return static_cast<uint64_t>(event->event.at.time_since_epoch().count());
}
unsigned long gpiod_edge_event_get_line_seqno(gpiod_edge_event* event) {  // NOLINT: its own type
  return event->event.number;
}
gpiod_edge_event_type gpiod_edge_event_get_event_type(gpiod_edge_event* event) {
  return event->event.rising ? GPIOD_EDGE_EVENT_RISING_EDGE : GPIOD_EDGE_EVENT_FALLING_EDGE;
}
}
// NOLINTEND(readability-identifier-naming)
