#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "host/cli/upload_way.h"

// Another release on a sensor, step by step: `stof update`, and the page of `stof view`.
namespace stof::host {

enum class ReleaseStep : std::uint8_t { kRestarting, kOnTrial };

// Who follows it. Each may be empty.
struct ReleaseFollower {
  std::function<void(std::size_t bytes, std::size_t total)> sent{};
  std::function<void(ReleaseStep step, const std::string& line)> told{};
  // False: nobody follows it any more; what the sensor does it goes on doing.
  std::function<bool()> goes_on{};
};

// kOnTrial: nobody waited. kReverted: the former one runs again. kUnknown: the sensor did not tell.
enum class ReleaseState : std::uint8_t { kOnTrial, kConfirmed, kReverted, kUnknown };
// "on_trial", "confirmed", "reverted", "unknown".
const char* name_of(ReleaseState state) noexcept;

struct ReleaseEnd {
  ReleaseState state = ReleaseState::kOnTrial;
  std::uint32_t release = 0;  // that was put there
  std::uint32_t former = 0;
  std::string line{};  // of an end; empty: on trial
};

// What no sensor takes is told before anything is sent. Throws Failure.
std::string read_release(const std::filesystem::path& file);

// Puts the release there, or has the other slot's tried where `bytes` is empty; the sensor restarts
// with it on trial. wait_s: for what comes of that; 0: nobody waits.
// Throws Failure.
ReleaseEnd put_release(UploadWay& way, const std::string& bytes, double wait_s,
                       const ReleaseFollower& follower);

}  // namespace stof::host
