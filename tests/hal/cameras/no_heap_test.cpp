#include <gtest/gtest.h>

#include "hal/emu/cameras/pmd_camera.h"
#include "hal/emu/cameras/stereo_camera.h"
#include "hal/emu/cameras/trigger.h"
#include "hal/emu/devices/clock.h"
#include "hal/emu/devices/datagram_port.h"
#include "hal/emu/imagery/moving_scene.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "tests/support/heap_guard.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::emu::Fault;
using hal::emu::FaultKind;
using hal::emu::FaultPlan;

TEST(EmuDevices, AllocateNothingAfterConstruction) {
  hal::emu::Rig rig = hal::emu::corridor_rig();
  rig.stereo.left.width = 64;
  rig.stereo.left.height = 48;
  rig.pmd_lens.width = 32;
  rig.pmd_lens.height = 24;
  hal::emu::RenderedScene scene(hal::emu::corridor(), rig);
  const FaultPlan faults{{.kind = FaultKind::kRepeat, .call = 3, .every = 7},
                         {.kind = FaultKind::kTear, .call = 4, .every = 7},
                         {.kind = FaultKind::kDelay, .call = 5, .every = 7, .duration = 20ms}};
  hal::emu::Clock clock;
  hal::emu::StereoCamera stereo(clock, scene, {}, faults);
  hal::emu::PmdCamera pmd(clock, scene, {}, faults);
  hal::emu::Trigger trigger(clock, 100us, {&stereo, &pmd});
  hal::emu::DatagramPort port(8, faults);
  const std::array<std::byte, 100> datagram{};
  std::array<std::byte, hal::kMaxDatagram> space;
  int frames = 0;
  const int before = allocations;
  ASSERT_GT(before, 0);
  for (int i = 0; i < 200; ++i) {
    const hal::Time next = clock.now() + 33ms;
    const auto edge = trigger.pulse();
    const auto frame = stereo.wait_frame(next);
    const auto set = pmd.wait_frame(next);
    frames += frame && set ? 1 : 0;
    const std::span<const std::byte> bytes = datagram;
    std::size_t sent = 0;
    (void)port.send({}, std::span(&bytes, 1), sent);
    (void)port.take_sent();
    port.inject(bytes, {});
    (void)port.receive(space, {});
    clock.wait_until(next);
    ASSERT_TRUE(edge);
  }
  EXPECT_EQ(allocations, before);
  EXPECT_GT(frames, 100);
}

TEST(MovingScene, AllocatesNothingInItsExposures) {
  hal::emu::Rig rig = hal::emu::corridor_rig();
  hal::emu::resize_stereo(rig, 64, 48);
  hal::emu::resize_pmd(rig, 32, 24);
  hal::emu::MovingScene scene(hal::emu::walking(), rig);
  dataset::Image<std::uint8_t> view(64, 48);
  dataset::Image<std::uint16_t> sample(32, 24);
  const int before = allocations;
  for (std::uint32_t number = 1; number < 400; number += 7) {
    scene.left(number, view.view());
    scene.right(number + 1, view.view());
    for (int k = 0; k < 4; ++k) {
      scene.pmd(number, k, sample.view());
    }
  }
  EXPECT_EQ(allocations, before);
}

}  // namespace
}  // namespace stof::test
