#include <gtest/gtest.h>

#include "tests/hal/v4l2/v4l2_pmd_rig.h"
#include "tests/hal/v4l2/v4l2_rigs.h"
#include "tests/support/heap_guard.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;

// What is allocated while it lives does not count.
class Uncounted {
 public:
  Uncounted() = default;
  ~Uncounted() { allocations = before_; }
  Uncounted(const Uncounted&) = delete;
  Uncounted& operator=(const Uncounted&) = delete;

 private:
  int before_ = allocations;
};

class UncountedKernel final : public hal::linux::V4l2Calls {
 public:
  explicit UncountedKernel(FakeV4l2& kernel) : kernel_(kernel) {}

  int open(const char* path) noexcept override {
    const Uncounted own;
    return kernel_.open(path);
  }
  void close(int fd) noexcept override {
    const Uncounted own;
    kernel_.close(fd);
  }
  int ioctl(int fd, unsigned long request, void* argument) noexcept override {
    const Uncounted own;
    return kernel_.ioctl(fd, request, argument);
  }
  const std::uint8_t* map(int fd, std::size_t bytes, std::uint32_t offset) noexcept override {
    const Uncounted own;
    return kernel_.map(fd, bytes, offset);
  }
  void unmap(const std::uint8_t* data, std::size_t bytes) noexcept override {
    const Uncounted own;
    kernel_.unmap(data, bytes);
  }
  int poll(std::span<pollfd> entries, hal::Duration timeout) noexcept override {
    const Uncounted own;
    return kernel_.poll(entries, timeout);
  }

 private:
  FakeV4l2& kernel_;
};

template <typename Rig>
void expect_no_heap(Rig& rig, int least_frames) {
  rig.close();
  UncountedKernel kernel(rig.kernel());
  const auto camera = Rig::Camera::open(kernel, rig.clock(), rig.options());
  ASSERT_TRUE(camera);
  int frames = 0;
  int allocated = 0;
  for (int i = 0; i < 200; ++i) {
    const hal::Time edge = rig.pulse();
    const int before = allocations;
    frames += (*camera)->wait_frame(edge + 33ms) ? 1 : 0;
    allocated += allocations - before;
  }
  EXPECT_EQ(allocated, 0);
  EXPECT_GE(frames, least_frames);
}

TEST(V4l2NoHeap, StereoAllocatesNothingAfterItWasOpened) {
  V4l2StereoRig<hal::linux::kGrey, false> grey;
  V4l2StereoRig<hal::linux::kYuyv, true> converted;
  for (std::uint32_t number = 1; number < 200; number += 7) {
    grey.fake(0).faults[number] = V4l2Fault::kLose;
    grey.fake(1).faults[number + 1] = V4l2Fault::kErrorFlag;
    grey.fake(1).faults[number + 2] = V4l2Fault::kLate;
  }
  // Of each seven pairs three are broken, and after the late picture one more is not believed.
  expect_no_heap(grey, 200 * 3 / 7 - 2);
  expect_no_heap(converted, 200);
}

TEST(V4l2NoHeap, PmdAllocatesNothingAfterItWasOpened) {
  V4l2PmdRig<hal::linux::kY12p> rig;
  expect_no_heap(rig, 200);
}

}  // namespace
}  // namespace stof::test
