#pragma once

#include <array>
#include <cstddef>
#include <expected>
#include <memory>
#include <string>
#include <vector>

#include "hal/linux/camera/exposures.h"
#include "hal/linux/gpio/strobe_log.h"
#include "hal/linux/open_error.h"
#include "hal/trigger.h"

// libgpiod's own (version 2, C).
struct gpiod_line_request;
struct gpiod_edge_event_buffer;

namespace stof::hal::linux {

struct GpioTriggerOptions {
  std::string chip;              // such as /dev/gpiochip0; empty: the first that has all lines
  std::string devices = "/dev";  // where chips are looked for

  // Lines of one chip, by the kernel's name ("GPIO17"), or "LABEL:OFFSET" with the chip's label or
  // name ("9030000.pl061:0", "gpiochip0:4").
  std::vector<std::string> outputs;  // 1 to 3: what the cameras' trigger inputs hang on
  std::vector<std::string> strobes;  // 0 to 2: inputs that are high while a sensor exposes
  bool active_low = false;           // outputs
  bool strobe_active_low = false;

  Duration width = std::chrono::microseconds(100);  // of a pulse, 1 us to 10 ms
  bool width_is_exposure = false;  // the sensors expose as long as the pulse is (IMX296's XTR)
  // An edge whose time is known to no better than this is a kDeviceError.
  Duration max_uncertainty = std::chrono::milliseconds(1);
};

// A pulse on all outputs through the kernel's GPIO lines, which one call raises, in their order,
// within microseconds of each other. pulse() returns the time right before that call: the edge
// comes at or after it, by at most uncertainty(), usually microseconds. The pulse is as long as
// `width` or, where the scheduler is late, longer. For one thread. pulse() and read_strobes()
// allocate nothing.
class GpioTrigger final : public hal::Trigger {
 public:
  static constexpr std::size_t kMostOutputs = 3;
  static constexpr std::size_t kMostStrobes = 2;

  // An error is one line: which line or chip, why, what to do.
  static std::expected<std::unique_ptr<GpioTrigger>, OpenError> open(
      const GpioTriggerOptions& options);
  // Leaves the outputs low.
  ~GpioTrigger() override;
  GpioTrigger(const GpioTrigger&) = delete;
  GpioTrigger& operator=(const GpioTrigger&) = delete;

  // kDeviceError: an edge went out, but when is not known to `max_uncertainty`, or the exposure
  // that it began was longer than that. kDeviceLost: reopen().
  Result<Time> pulse() noexcept override;
  // In place; nothing where it was not lost. kDeviceLost: not back yet; trouble() says why.
  Status reopen() noexcept;
  // One line, why reopen() failed last; empty: it did not.
  const std::string& trouble() const noexcept { return trouble_; }

  // The uncertainty of the last pulse.
  Duration uncertainty() const noexcept { return uncertainty_; }
  // Edges that went out at a known time.
  const EdgeLog& edges() const noexcept { return edges_; }
  // Takes in what the strobe lines have told. Does not block.
  void read_strobes() noexcept;
  // strobe < options.strobes.size().
  const StrobeLog& strobe(std::size_t strobe) const noexcept;

 private:
  explicit GpioTrigger(GpioTriggerOptions options);
  std::expected<void, OpenError> request();
  bool set_outputs(bool high) noexcept;
  void shut() noexcept;

  GpioTriggerOptions options_;
  gpiod_line_request* request_ = nullptr;
  gpiod_edge_event_buffer* events_ = nullptr;
  std::array<unsigned, kMostOutputs> output_offsets_{};
  std::array<unsigned, kMostStrobes> strobe_offsets_{};
  std::array<StrobeLog, kMostStrobes> strobes_;
  EdgeLog edges_;
  Duration uncertainty_{};
  bool lost_ = false;
  std::string trouble_;
};

// Exposures of the sensor on a strobe line, which must outlive it.
class StrobeExposures final : public Exposures {
 public:
  // strobe < the trigger's options.strobes.size().
  StrobeExposures(GpioTrigger& trigger, std::size_t strobe) noexcept
      : trigger_(trigger), strobe_(strobe) {}
  std::optional<Exposure> ended_at(Time stamp) noexcept override {
    trigger_.read_strobes();
    return trigger_.strobe(strobe_).ended_at(stamp);
  }

 private:
  GpioTrigger& trigger_;
  std::size_t strobe_;
};

}  // namespace stof::hal::linux
