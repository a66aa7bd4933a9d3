#include "board/emu/fault_orders.h"

#include <algorithm>

#include "dsp/base/parse_number.h"

namespace stof::board {
namespace {

using hal::emu::Fault;
using hal::emu::FaultKind;

template <typename Names>
std::optional<std::size_t> place_in(const Names& names, std::string_view name) noexcept {
  const auto found = std::ranges::find(names, name);
  return found == names.end() ? std::nullopt
                              : std::optional(static_cast<std::size_t>(found - names.begin()));
}

// faults.h: the trigger has no pixels, and the pair no lamp.
bool has_fault(Device device, FaultKind kind) noexcept {
  const bool of_pixels = kind == FaultKind::kFreeze || kind == FaultKind::kHang;
  return (device == Device::kPmd || kind != FaultKind::kDark) &&
         (device != Device::kTrigger || !of_pixels);
}

std::string kinds_of(Device device) {
  std::string all;
  for (const FaultKind kind : hal::emu::kAllFaultKinds) {
    if (has_fault(device, kind)) {
      all += all.empty() ? "" : ",";
      all += kFaultNames[static_cast<std::size_t>(kind)];
    }
  }
  return all;
}

}  // namespace

std::optional<Device> device_named(std::string_view name) noexcept {
  const auto place = place_in(kDeviceNames, name);
  return place ? std::optional(static_cast<Device>(*place)) : std::nullopt;
}

std::optional<FaultKind> fault_named(std::string_view name) noexcept {
  const auto place = place_in(kFaultNames, name);
  return place ? std::optional(static_cast<FaultKind>(*place)) : std::nullopt;
}

std::string FaultOrders::refusal_or_empty(std::string_view order) {
  if (order == "list") {
    return {};
  }
  const std::size_t first = order.find(':');
  const std::optional<Device> device = device_named(order.substr(0, first));
  if (!device || (*device == Device::kPmd && !pmd_)) {
    return std::string("no such device: give ") +
           (pmd_ ? "trigger, stereo or pmd" : "trigger or stereo");
  }
  const std::string_view rest =
      first == std::string_view::npos ? std::string_view{} : order.substr(first + 1);
  const std::size_t second = rest.find(':');
  const std::optional<FaultKind> kind = fault_named(rest.substr(0, second));
  if (!kind || !has_fault(*device, *kind)) {
    return "no such fault of " + std::string(kDeviceNames[static_cast<std::size_t>(*device)]) +
           ": give none, " + kinds_of(*device);
  }
  std::uint32_t calls = Fault::kForever;
  if (second != std::string_view::npos) {
    const auto number = dsp::parse_number<std::uint32_t>(rest.substr(second + 1));
    if (!number || *number == 0) {
      return "EDGES is no number from 1 to 4294967295: leave it out, and it lasts until it is "
             "ended";
    }
    calls = *number;
  }
  of(*device).give({.kind = *kind, .calls = calls});
  return {};
}

std::string FaultOrders::obey(std::string_view order) {
  const std::string refusal = refusal_or_empty(order);
  std::string answer = refusal.empty() ? "ok\n" : "refused: " + refusal + "\n";
  for (std::size_t i = 0; i < kDeviceCount; ++i) {
    const auto device = static_cast<Device>(i);
    if (device == Device::kPmd && !pmd_) {
      continue;
    }
    const hal::emu::LiveFault::State left = of(device).left();
    const bool counts = left.calls != 0 && left.calls != Fault::kForever;
    answer += std::string(kDeviceNames[i]) + " " +
              std::string(kFaultNames[static_cast<std::size_t>(left.kind)]) + " " +
              (counts ? std::to_string(left.calls) : "-") + " " + kinds_of(device) + "\n";
  }
  return answer;
}

}  // namespace stof::board
