#include "tests/hal/v4l2/v4l2_fake.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

namespace stof::test {

using namespace std::chrono_literals;
using hal::linux::row_bytes;

FakeCamera& FakeV4l2::add(FakeCamera camera) {
  nodes_.emplace_back().camera = std::move(camera);
  return nodes_.back().camera;
}

void FakeV4l2::expose(hal::Time edge, hal::Duration exposure, hal::Duration readout) {
  for (Node& node : nodes_) {
    if (!node.present || !node.streaming) {
      continue;
    }
    const std::uint32_t number = ++node.exposures;
    const auto fault = node.camera.faults.find(number);
    Shot shot{.number = number, .ready = edge + exposure + readout};
    if (fault != node.camera.faults.end()) {
      shot.fault = fault->second;
      shot.ready += fault->second == V4l2Fault::kLate ? 100ms : 0ms;
    }
    node.coming.push_back(shot);
    std::ranges::sort(node.coming, {}, &Shot::ready);
  }
}

void FakeV4l2::count_anew() {
  for (Node& node : nodes_) {
    node.exposures = 0;
  }
}

void FakeV4l2::unplug(FakeCamera& camera) {
  for (Node& node : nodes_) {
    if (&node.camera == &camera) {
      node.present = false;
      ++node.plugged;
      node.owner = -1;
      node.streaming = false;
      node.sequence = 0;
      node.buffers.clear();
      node.queued.clear();
      node.done.clear();
      node.coming.clear();
    }
  }
}

void FakeV4l2::plug(FakeCamera& camera, const std::string& path) {
  camera.path = path;
  for (Node& node : nodes_) {
    node.present = node.present || &node.camera == &camera;
  }
}

FakeV4l2::Node* FakeV4l2::live(int fd) {
  const auto file = files_.find(fd);
  if (file == files_.end()) {
    errno = EBADF;
    return nullptr;
  }
  Node* const node = file->second.node;
  if (!node->present || node->plugged != file->second.plugged) {
    errno = ENODEV;
    return nullptr;
  }
  return node;
}

std::uint32_t FakeV4l2::stride(const Node& node) {
  const auto width = static_cast<int>(node.camera.width);
  return static_cast<std::uint32_t>(row_bytes(node.format, width)) + node.camera.padding;
}

void FakeV4l2::settle(Node& node) {
  while (!node.coming.empty() && node.coming.front().ready <= clock_.now()) {
    const Shot shot = node.coming.front();
    node.coming.pop_front();
    fill(node, shot);
  }
  while (node.camera.chatty && node.streaming && !node.queued.empty()) {
    fill(node, {.number = ++node.exposures, .ready = clock_.now()});
  }
}

void FakeV4l2::fill(Node& node, const Shot& shot) {
  const std::uint32_t sequence = node.sequence++;
  if (node.queued.empty() || shot.fault == V4l2Fault::kLose) {
    return;
  }
  v4l2_buffer buffer{};
  buffer.index = node.queued.front();
  node.queued.pop_front();
  std::vector<std::uint8_t>& memory = *node.buffers[buffer.index];
  paint(node, shot.number, memory);
  buffer.sequence = sequence;
  const std::size_t missing = shot.fault == V4l2Fault::kShort ? node.camera.padding + 1 : 0;
  buffer.bytesused = static_cast<std::uint32_t>(memory.size() - missing);
  buffer.flags = shot.fault == V4l2Fault::kErrorFlag ? V4L2_BUF_FLAG_ERROR : 0;
  const auto stamp = std::chrono::duration_cast<std::chrono::microseconds>(
      shot.ready.time_since_epoch() + node.camera.stamps_ahead);
  buffer.timestamp.tv_sec = stamp / 1s;
  buffer.timestamp.tv_usec = (stamp % 1s).count();
  node.done.push_back(buffer);
}

void FakeV4l2::paint(const Node& node, std::uint32_t number, std::vector<std::uint8_t>& out) {
  const auto byte = [](std::uint32_t value) { return static_cast<std::uint8_t>(value & 0xFF); };
  for (std::uint32_t y = 0; y < node.camera.height && node.camera.pixel; ++y) {
    std::uint8_t* const row = out.data() + std::size_t{y} * stride(node);
    for (std::uint32_t x = 0; x < node.camera.width; ++x) {
      const std::uint32_t value =
          node.camera.pixel(number, static_cast<int>(x), static_cast<int>(y));
      if (node.format == hal::linux::kGrey) {
        row[x] = byte(value);
      } else if (node.format == hal::linux::kY12p) {
        std::uint8_t* const three = row + std::size_t{x} / 2 * 3;
        three[x % 2] = byte(value >> 4);
        three[2] = x % 2 == 0 ? byte(value & 0x0F) : byte(three[2] | (value & 0x0F) << 4);
      } else {
        row[2 * x] = byte(value);
        row[2 * x + 1] = node.format == hal::linux::kYuyv ? byte(x + 77) : byte(value >> 8);
      }
    }
  }
}

bool FakeV4l2::interrupted(bool& last) const {
  last = interrupts_ && !last;
  errno = last ? EINTR : errno;
  return last;
}

int FakeV4l2::open(const char* path) noexcept {
  for (Node& node : nodes_) {
    if (node.present && node.camera.path == path) {
      files_[next_fd_] = {.node = &node, .plugged = node.plugged};
      return next_fd_++;
    }
  }
  errno = ENOENT;
  return -1;
}

void FakeV4l2::close(int fd) noexcept {
  const bool held =
      std::ranges::any_of(mapped_, [fd](const auto& entry) { return entry.second.fd == fd; });
  Node* const node = live(fd);
  if (node != nullptr && node->owner == fd && !held) {  // a mapping keeps the file
    node->owner = -1;
  }
  files_.erase(fd);
}

int FakeV4l2::set_format(Node& node, v4l2_format& format, bool keep) {
  v4l2_pix_format& pixels = format.fmt.pix;
  if (keep && !node.buffers.empty()) {
    return EBUSY;
  }
  if (std::ranges::find(node.camera.formats, pixels.pixelformat) == node.camera.formats.end()) {
    pixels.pixelformat = node.camera.formats.front();  // as drivers do
  }
  pixels.width = node.camera.width;
  pixels.height = node.camera.height;
  if (keep) {
    node.format = pixels.pixelformat;
    pixels.bytesperline = stride(node);
  }
  return 0;
}

int FakeV4l2::control(Node& node, unsigned long request, v4l2_control& control) {
  const auto found = node.camera.controls.find(control.id);
  if (found == node.camera.controls.end()) {
    return EINVAL;
  }
  FakeControl& known = found->second;
  if (request == VIDIOC_S_CTRL) {
    if (control.value < known.minimum || control.value > known.maximum) {
      return ERANGE;
    }
    known.value = control.value / known.quantum * known.quantum;
  }
  control.value = known.value;
  return 0;
}

int FakeV4l2::request_buffers(Node& node, int fd, v4l2_requestbuffers& request) {
  if (node.owner >= 0 && node.owner != fd) {
    return EBUSY;
  }
  node.queued.clear();
  node.done.clear();
  node.buffers.clear();
  request.count = std::min(request.count, node.camera.most_buffers);
  const std::size_t bytes = std::size_t{stride(node)} * node.camera.height;
  for (std::uint32_t i = 0; i < request.count; ++i) {
    node.buffers.push_back(std::make_shared<std::vector<std::uint8_t>>(bytes));
  }
  node.owner = request.count == 0 ? -1 : fd;
  return 0;
}

int FakeV4l2::dequeue(Node& node, v4l2_buffer& buffer) {
  if (!node.streaming) {
    return EINVAL;
  }
  if (node.camera.errors > 0) {
    --node.camera.errors;
    return EIO;
  }
  if (node.camera.chatty) {
    clock_.wait_until(clock_.now() + 10us);
    settle(node);
  }
  if (node.done.empty()) {
    return EAGAIN;
  }
  buffer = node.done.front();
  node.done.pop_front();
  return 0;
}

int FakeV4l2::stream(Node& node, int fd, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_REQBUFS:
      return request_buffers(node, fd, *static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      buffer.length = static_cast<std::uint32_t>(node.buffers.at(buffer.index)->size());
      buffer.m.offset = buffer.index << 12;
      buffer.flags = node.camera.stamps;
      return 0;
    }
    case VIDIOC_QBUF:
      node.queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return dequeue(node, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF:
      if (node.owner != fd) {
        return EBUSY;
      }
      node.streaming = request == VIDIOC_STREAMON;
      node.sequence = 0;
      node.coming.clear();
      return 0;
    default:
      return ENOTTY;
  }
}

int FakeV4l2::answer(Node& node, int fd, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& about = *static_cast<v4l2_capability*>(argument);
      std::memcpy(about.card, node.camera.card.data(),
                  std::min(node.camera.card.size(), sizeof about.card - 1));
      about.device_caps = node.camera.caps;
      return 0;
    }
    case VIDIOC_ENUM_FMT: {
      auto& about = *static_cast<v4l2_fmtdesc*>(argument);
      if (about.index >= node.camera.formats.size()) {
        return EINVAL;
      }
      about.pixelformat = node.camera.formats[about.index];
      return 0;
    }
    case VIDIOC_TRY_FMT:
    case VIDIOC_S_FMT:
      return set_format(node, *static_cast<v4l2_format*>(argument), request == VIDIOC_S_FMT);
    case VIDIOC_QUERYCTRL: {
      auto& about = *static_cast<v4l2_queryctrl*>(argument);
      const auto found = node.camera.controls.find(about.id);
      if (found == node.camera.controls.end()) {
        return EINVAL;
      }
      about.minimum = found->second.minimum;
      about.maximum = found->second.maximum;
      about.step = 1;
      return 0;
    }
    case VIDIOC_S_CTRL:
    case VIDIOC_G_CTRL:
      return control(node, request, *static_cast<v4l2_control*>(argument));
    default:
      return stream(node, fd, request, argument);
  }
}

int FakeV4l2::ioctl(int fd, unsigned long request, void* argument) noexcept {
  if (interrupted(control_interrupted_)) {
    return -1;
  }
  Node* const node = live(fd);
  if (node == nullptr) {
    return -1;
  }
  settle(*node);
  const int error = answer(*node, fd, request, argument);
  errno = error == 0 ? errno : error;
  return error == 0 ? 0 : -1;
}

const std::uint8_t* FakeV4l2::map(int fd, std::size_t /*bytes*/, std::uint32_t offset) noexcept {
  const Node* const node = live(fd);
  if (node == nullptr) {
    return nullptr;
  }
  const Memory& memory = node->buffers.at(offset >> 12);
  mapped_[memory->data()] = {.memory = memory, .fd = fd};
  return memory->data();
}

void FakeV4l2::unmap(const std::uint8_t* data, std::size_t /*bytes*/) noexcept {
  mapped_.erase(data);
}

int FakeV4l2::poll(std::span<pollfd> entries, hal::Duration timeout) noexcept {
  ++polls_;
  if (interrupted(poll_interrupted_)) {
    return -1;
  }
  const hal::Time end = clock_.now() + timeout;
  for (;;) {
    hal::Time next = end;
    int ready = 0;
    for (pollfd& entry : entries) {
      Node* const node = live(entry.fd);
      entry.revents = POLLERR | POLLHUP;
      if (node != nullptr) {
        settle(*node);
        const bool readable = !node->done.empty() || node->camera.errors > 0;
        entry.revents = readable ? POLLIN : 0;
        next = node->coming.empty() ? next : std::min(next, node->coming.front().ready);
      }
      ready += entry.revents != 0 ? 1 : 0;
    }
    if (ready > 0 || clock_.now() >= end) {
      return ready;
    }
    clock_.wait_until(next);
  }
}

}  // namespace stof::test
