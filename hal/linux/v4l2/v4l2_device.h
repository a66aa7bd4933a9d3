#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "dsp/base/status.h"
#include "hal/linux/open_error.h"
#include "hal/linux/v4l2/grey_formats.h"
#include "hal/linux/v4l2/v4l2_calls.h"
#include "hal/linux/v4l2/v4l2_format.h"
#include "hal/time.h"

namespace stof::hal::linux {

struct V4l2Options {
  std::string node;  // as find_v4l2_node() takes it
  int width = 0;     // of the node's pictures
  int height = 0;
  std::vector<FourCc> formats;       // the best one first
  std::optional<Duration> exposure;  // none: controls are left alone
  std::optional<std::int32_t> gain;  // in the driver's units
  std::string sysfs = "/sys";
};

// A picture as the driver wrote it. Readable until it is released, also when its device is lost,
// shut or opened anew meanwhile.
struct V4l2Buffer {
  const std::uint8_t* data = nullptr;
  std::size_t bytes = 0;
  std::uint32_t index = 0;
  std::uint32_t session = 0;   // which opening of the device it is of
  std::uint32_t sequence = 0;  // the driver's; counts lost pictures, starts anew at each opening
  Time stamp;
};

struct V4l2Counters {
  std::uint64_t pictures = 0;
  std::uint64_t damaged = 0;    // with the driver's error flag, or too short
  std::uint64_t io_errors = 0;  // EIO
};

// One capture node that streams by mmap, single-planar. Allocates in open() alone; does not block
// but there. For one thread.
class V4l2Device {
 public:
  static constexpr std::uint32_t kBuffers = 8;  // asked for; the driver may give more or less
  static constexpr std::uint32_t kLeastBuffers = 5;

  V4l2Device(V4l2Calls& calls, V4l2Options options);
  ~V4l2Device();
  V4l2Device(const V4l2Device&) = delete;
  V4l2Device& operator=(const V4l2Device&) = delete;

  // Finds the node, sets format, size, exposure and gain, and starts the stream; when it was open,
  // anew. Refuses another size than asked, less than kLeastBuffers buffers, and drivers that do
  // not stamp with CLOCK_MONOTONIC.
  std::expected<void, OpenError> open();
  void shut() noexcept;

  // kOk; kWouldBlock: nothing has come; kCorrupt: a damaged picture came and was given back,
  // `out` has its sequence and stamp; kDeviceLost: from now on, until open().
  Status dequeue(V4l2Buffer& out) noexcept;
  // Each dequeued buffer once.
  void release(const V4l2Buffer& buffer) noexcept;

  // For poll(); negative: shut.
  int fd() const noexcept { return fd_; }
  bool lost() const noexcept { return lost_; }
  void lose() noexcept { lost_ = true; }

  const V4l2Format& format() const noexcept { return format_; }
  // The exposure that the driver set; none where it does not report it.
  std::optional<Duration> exposure() const noexcept { return exposure_; }
  const V4l2Counters& counters() const noexcept { return counters_; }
  // For messages: "camera 'card:X' (/dev/video0)".
  std::string name() const;

 private:
  struct Mapping {
    const std::uint8_t* data = nullptr;
    std::size_t bytes = 0;
    bool out = false;  // with the reader
  };
  using Done = std::expected<void, OpenError>;

  std::unexpected<OpenError> refuse(const std::string& reason) const;
  Done open_node();
  Done set_format();
  Done set_controls();
  Done start();
  bool enqueue(std::uint32_t index) noexcept;

  V4l2Calls& calls_;
  V4l2Options options_;
  std::string path_;
  int fd_ = -1;
  bool lost_ = false;
  V4l2Format format_;
  std::size_t needed_bytes_ = 0;  // of a whole picture
  std::optional<Duration> exposure_;
  std::vector<Mapping> mappings_;
  std::uint32_t session_ = 0;
  int errors_in_a_row_ = 0;
  V4l2Counters counters_;
};

}  // namespace stof::hal::linux
