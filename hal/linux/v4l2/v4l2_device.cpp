#include "hal/linux/v4l2/v4l2_device.h"

#include <cerrno>
#include <chrono>
#include <utility>

#include <linux/videodev2.h>

#include "dsp/base/check.h"
#include "hal/linux/v4l2/v4l2_controls.h"
#include "hal/linux/v4l2/v4l2_find.h"

namespace stof::hal::linux {
namespace {

constexpr int kMostErrors = 8;  // EIO in a row: a queue that was given up answers nothing else

v4l2_buffer empty_buffer(std::uint32_t index) noexcept {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

bool stamps_monotonic(std::uint32_t flags) noexcept {
  return (flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
}

}  // namespace

V4l2Device::V4l2Device(V4l2Calls& calls, V4l2Options options)
    : calls_(calls), options_(std::move(options)) {
  STOF_CHECK(options_.width > 0 && options_.height > 0 && !options_.formats.empty());
}

V4l2Device::~V4l2Device() { shut(); }

std::string V4l2Device::name() const {
  return "camera '" + options_.node + (path_.empty() ? "'" : "' (" + path_ + ")");
}

std::unexpected<OpenError> V4l2Device::refuse(const std::string& reason) const {
  return std::unexpected(OpenError{name() + ": " + reason});
}

V4l2Device::Done V4l2Device::open() {
  shut();
  Done done = open_node();
  if (done) {
    done = set_format();
  }
  if (done) {
    done = set_controls();
  }
  if (done) {
    done = start();
  }
  if (!done) {
    shut();
  }
  return done;
}

V4l2Device::Done V4l2Device::open_node() {
  path_.clear();
  std::expected<std::string, OpenError> path =
      find_v4l2_node(calls_, options_.node, options_.sysfs);
  if (!path) {
    return std::unexpected(std::move(path.error()));
  }
  path_ = std::move(*path);
  fd_ = calls_.open(path_.c_str());
  if (fd_ < 0) {
    return refuse(with_advice("cannot be opened", errno));
  }
  lost_ = false;
  errors_in_a_row_ = 0;
  v4l2_capability answer{};
  if (const int error = ask_driver(calls_, fd_, VIDIOC_QUERYCAP, &answer); error != 0) {
    return refuse(with_advice("is no video device", error));
  }
  constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if ((answer.device_caps & kNeeded) != kNeeded) {
    return refuse(with_advice("does not capture", EINVAL));
  }
  return {};
}

V4l2Device::Done V4l2Device::set_format() {
  std::expected<V4l2Format, std::string> set =
      set_v4l2_format(calls_, fd_, options_.width, options_.height, options_.formats);
  if (!set) {
    return refuse(set.error());
  }
  format_ = *set;
  needed_bytes_ = format_.stride * static_cast<std::size_t>(options_.height - 1) +
                  row_bytes(format_.pixels, options_.width);
  return {};
}

V4l2Device::Done V4l2Device::set_controls() {
  exposure_.reset();
  if (options_.exposure) {
    auto made = set_v4l2_exposure(calls_, fd_, *options_.exposure);
    if (!made) {
      return refuse(made.error());
    }
    exposure_ = *made;
  }
  if (options_.gain) {
    if (auto set = set_v4l2_gain(calls_, fd_, *options_.gain); !set) {
      return refuse(set.error());
    }
  }
  return {};
}

V4l2Device::Done V4l2Device::start() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = ask_driver(calls_, fd_, VIDIOC_REQBUFS, &request); error != 0) {
    return refuse(with_advice("gives no buffers", error));
  }
  if (request.count < kLeastBuffers) {
    return refuse("gives " + std::to_string(request.count) + " buffers, " +
                  std::to_string(kLeastBuffers) + " are needed; free memory of the system");
  }
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = empty_buffer(i);
    if (const int error = ask_driver(calls_, fd_, VIDIOC_QUERYBUF, &buffer); error != 0) {
      return refuse(with_advice("does not tell its buffers", error));
    }
    if (!stamps_monotonic(buffer.flags)) {
      return refuse("does not stamp with CLOCK_MONOTONIC; use another camera or driver");
    }
    if (buffer.length < needed_bytes_) {
      return refuse("has buffers that are too short for a picture; use another format or driver");
    }
    const std::uint8_t* const data = calls_.map(fd_, buffer.length, buffer.m.offset);
    if (data == nullptr) {
      return refuse(with_advice("does not show its buffers", errno));
    }
    mappings_.push_back({.data = data, .bytes = buffer.length});
    if (!enqueue(i)) {
      return refuse(with_advice("does not take its buffers", errno));
    }
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = ask_driver(calls_, fd_, VIDIOC_STREAMON, &type); error != 0) {
    return refuse(with_advice("does not stream", error));
  }
  return {};
}

void V4l2Device::shut() noexcept {
  if (fd_ < 0) {
    return;
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  static_cast<void>(ask_driver(calls_, fd_, VIDIOC_STREAMOFF, &type));
  for (const Mapping& mapping : mappings_) {
    if (!mapping.out) {  // what is out stays readable until release()
      calls_.unmap(mapping.data, mapping.bytes);
    }
  }
  mappings_.clear();
  // A mapping that is out keeps the file open, and the driver's queue with it: without this the
  // device would be busy at the next open() (V4L2_BUF_CAP_SUPPORTS_ORPHANED_BUFS).
  v4l2_requestbuffers none{};
  none.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  none.memory = V4L2_MEMORY_MMAP;
  static_cast<void>(ask_driver(calls_, fd_, VIDIOC_REQBUFS, &none));
  calls_.close(fd_);
  fd_ = -1;
  lost_ = true;
  ++session_;
}

Status V4l2Device::dequeue(V4l2Buffer& out) noexcept {
  if (lost_ || fd_ < 0) {
    return Status::kDeviceLost;
  }
  v4l2_buffer buffer = empty_buffer(0);
  const int error = ask_driver(calls_, fd_, VIDIOC_DQBUF, &buffer);
  if (error == EAGAIN) {
    return Status::kWouldBlock;
  }
  if (error == EIO) {  // the driver's own trouble, which may pass
    ++counters_.io_errors;
    lost_ = ++errors_in_a_row_ >= kMostErrors;
    return lost_ ? Status::kDeviceLost : Status::kWouldBlock;
  }
  if (error != 0 || buffer.index >= mappings_.size() || mappings_[buffer.index].out) {
    lost_ = true;
    return Status::kDeviceLost;
  }
  errors_in_a_row_ = 0;
  Mapping& mapping = mappings_[buffer.index];
  mapping.out = true;
  out = {.data = mapping.data,
         .bytes = mapping.bytes,
         .index = buffer.index,
         .session = session_,
         .sequence = buffer.sequence,
         .stamp = Time(std::chrono::seconds(buffer.timestamp.tv_sec) +
                       std::chrono::microseconds(buffer.timestamp.tv_usec))};
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 || buffer.bytesused < needed_bytes_) {
    ++counters_.damaged;
    release(out);
    return Status::kCorrupt;
  }
  ++counters_.pictures;
  return Status::kOk;
}

void V4l2Device::release(const V4l2Buffer& buffer) noexcept {
  if (buffer.session != session_) {
    calls_.unmap(buffer.data, buffer.bytes);
    return;
  }
  STOF_CHECK(buffer.index < mappings_.size() && mappings_[buffer.index].out);
  mappings_[buffer.index].out = false;
  if (!lost_ && !enqueue(buffer.index)) {
    lost_ = true;
  }
}

bool V4l2Device::enqueue(std::uint32_t index) noexcept {
  v4l2_buffer buffer = empty_buffer(index);
  errno = ask_driver(calls_, fd_, VIDIOC_QBUF, &buffer);
  return errno == 0;
}

}  // namespace stof::hal::linux
