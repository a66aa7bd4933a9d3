#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <linux/videodev2.h>

#include "hal/clock.h"
#include "hal/linux/v4l2/grey_formats.h"
#include "hal/linux/v4l2/v4l2_calls.h"

namespace stof::test {

enum class V4l2Fault {
  kNone,
  kLose,       // never arrives, the driver counts it
  kErrorFlag,  // V4L2_BUF_FLAG_ERROR
  kShort,      // a byte is missing
  kLate,       // arrives, and is stamped, 100 ms late
};

struct FakeControl {
  std::int32_t minimum = 0;
  std::int32_t maximum = 10'000;
  std::int32_t value = 0;
  std::int32_t quantum = 1;  // the driver rounds down to a multiple of it
};

// A camera as its driver shows it.
struct FakeCamera {
  std::string path;
  std::string card = "Fake";
  std::uint32_t caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<hal::linux::FourCc> formats = {hal::linux::kGrey};
  std::uint32_t width = 8;  // the only size
  std::uint32_t height = 4;
  std::uint32_t padding = 0;  // bytes after each row
  std::uint32_t most_buffers = 32;
  hal::Duration stamps_ahead{};  // of the rig's clock
  std::uint32_t stamps = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  std::map<std::uint32_t, FakeControl> controls = {};
  // The brightness of a pixel in exposure `number`, which counts from 1.
  std::function<std::uint32_t(std::uint32_t number, int x, int y)> pixel = {};
  std::map<std::uint32_t, V4l2Fault> faults = {};  // by exposure
  bool chatty = false;                             // always has one more picture
  int errors = 0;                                  // so many DQBUF fail with EIO
};

// A kernel with V4L2 cameras that expose at edges, on a clock that moves when somebody polls. What
// was unmapped is unreadable (with AddressSanitizer), what was opened twice is busy.
class FakeV4l2 final : public hal::linux::V4l2Calls {
 public:
  explicit FakeV4l2(hal::Clock& clock) : clock_(clock) {}

  // Stays where it is.
  FakeCamera& add(FakeCamera camera);
  // The next exposure of every camera is number 1 again; the driver's own count goes on.
  void count_anew();
  void expose(hal::Time edge, hal::Duration exposure, hal::Duration readout);
  void unplug(FakeCamera& camera);
  void plug(FakeCamera& camera, const std::string& path);
  // Every second ioctl and poll is interrupted first.
  void interrupt() { interrupts_ = true; }

  std::size_t mappings() const { return mapped_.size(); }
  int open_files() const { return static_cast<int>(files_.size()); }
  int polls() const { return polls_; }

  int open(const char* path) noexcept override;
  void close(int fd) noexcept override;
  int ioctl(int fd, unsigned long request, void* argument) noexcept override;
  const std::uint8_t* map(int fd, std::size_t bytes, std::uint32_t offset) noexcept override;
  void unmap(const std::uint8_t* data, std::size_t bytes) noexcept override;
  int poll(std::span<pollfd> entries, hal::Duration timeout) noexcept override;

 private:
  using Memory = std::shared_ptr<std::vector<std::uint8_t>>;
  struct Shot {
    std::uint32_t number = 0;
    hal::Time ready;
    V4l2Fault fault = V4l2Fault::kNone;
  };
  struct Node {
    FakeCamera camera;
    bool present = true;
    int plugged = 0;  // how often
    int owner = -1;   // of the queue
    bool streaming = false;
    std::uint32_t format = 0;
    std::uint32_t exposures = 0;
    std::uint32_t sequence = 0;
    std::vector<Memory> buffers;
    std::deque<std::uint32_t> queued;
    std::deque<v4l2_buffer> done;
    std::deque<Shot> coming;
  };
  struct File {
    Node* node = nullptr;
    int plugged = 0;
  };
  struct Mapped {
    Memory memory;
    int fd = -1;
  };

  Node* live(int fd);
  static std::uint32_t stride(const Node& node);
  void settle(Node& node);
  static void fill(Node& node, const Shot& shot);
  static void paint(const Node& node, std::uint32_t number, std::vector<std::uint8_t>& out);
  bool interrupted(bool& last) const;
  static int set_format(Node& node, v4l2_format& format, bool keep);
  static int control(Node& node, unsigned long request, v4l2_control& control);
  static int request_buffers(Node& node, int fd, v4l2_requestbuffers& request);
  int dequeue(Node& node, v4l2_buffer& buffer);
  int answer(Node& node, int fd, unsigned long request, void* argument);
  int stream(Node& node, int fd, unsigned long request, void* argument);

  hal::Clock& clock_;
  std::deque<Node> nodes_;
  std::map<int, File> files_;
  std::map<const std::uint8_t*, Mapped> mapped_;
  int next_fd_ = 100;
  bool interrupts_ = false;
  bool control_interrupted_ = false;
  bool poll_interrupted_ = false;
  int polls_ = 0;
};

}  // namespace stof::test
