#include "host/cli/release_upload.h"

#include <chrono>
#include <optional>
#include <span>
#include <string_view>
#include <thread>

#include "dataset/files/file.h"
#include "host/cli/failure.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kMostUpdateBytes = std::size_t{1} << 28;
constexpr std::size_t kUpdateHeadBytes = 192;
constexpr std::string_view kUpdateMagic{"STOFUPD\0", 8};
constexpr auto kBetweenAsking = std::chrono::milliseconds(500);
using wire::UploadKind;
using wire::UploadState;

void need_follower(const ReleaseFollower& follower, const UploadWay& way) {
  if (follower.goes_on && !follower.goes_on()) {
    throw Failure(Exit::kFailure, way.who() +
                                      ": was given up: put it there again, it goes on "
                                      "where it stopped");
  }
}

// What comes of the trial: the sensor restarts, perhaps twice, and tells.
ReleaseEnd await_verdict(UploadWay& way, std::uint32_t former, std::uint32_t tried, double wait_s,
                         const ReleaseFollower& follower) {
  const auto ended = [&](ReleaseState state, const std::string& what) {
    return ReleaseEnd{
        .state = state, .release = tried, .former = former, .line = way.who() + ": " + what};
  };
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(wait_s);
  bool told = false;
  bool seen = tried != former;  // the same release again is known by its trial alone
  while (std::chrono::steady_clock::now() < end) {
    need_follower(follower, way);
    std::this_thread::sleep_for(kBetweenAsking);
    const auto state = way.uploads.state_of(UploadKind::kUpdate);
    if (!state || state->result != wire::SettingsResult::kOk) {
      continue;  // it restarts
    }
    if (state->state == UploadState::kOnTrial && state->fingerprint == tried) {
      seen = true;
      if (!told && follower.told) {
        follower.told(ReleaseStep::kOnTrial,
                      printed("%s: release %08x runs on trial", way.who().c_str(), tried));
      }
      told = true;
    } else if (state->state == UploadState::kSettled && seen && state->fingerprint == tried) {
      return ended(ReleaseState::kConfirmed,
                   printed("release %08x is confirmed; it was %08x", tried, former));
    } else if (state->fingerprint == former && tried != former &&
               (state->state == UploadState::kSettled || state->state == UploadState::kLeft)) {
      return ended(ReleaseState::kReverted,
                   "went back to the former release: the new one did not publish for 30 s what was "
                   "published before");
    }
  }
  return ended(ReleaseState::kUnknown,
               "did not tell what came of it: look with stof view, and try again later");
}

}  // namespace

const char* name_of(ReleaseState state) noexcept {
  switch (state) {
    case ReleaseState::kOnTrial:
      return "on_trial";
    case ReleaseState::kConfirmed:
      return "confirmed";
    case ReleaseState::kReverted:
      return "reverted";
    case ReleaseState::kUnknown:
      break;
  }
  return "unknown";
}

std::string read_release(const std::filesystem::path& file) {
  std::string bytes = value_or_fail(dataset::read_whole(file, kMostUpdateBytes));
  if (bytes.size() <= kUpdateHeadBytes || !bytes.starts_with(kUpdateMagic)) {
    throw Failure(Exit::kBadInput,
                  file.string() + ": is no update file: name one that scripts/image wrote");
  }
  return bytes;
}

ReleaseEnd put_release(UploadWay& way, const std::string& bytes, double wait_s,
                       const ReleaseFollower& follower) {
  const auto before = way.uploads.state_of(UploadKind::kUpdate);
  if (!before) {
    throw Failure(Exit::kFailure, before.error().message);
  }
  if (before->result != wire::SettingsResult::kOk) {
    refuse_upload(*before, way.place);
  }
  const auto answer = bytes.empty()
                          ? way.uploads.revert(UploadKind::kUpdate)
                          : way.uploads.upload(UploadKind::kUpdate, std::as_bytes(std::span(bytes)),
                                               [&](std::size_t now, std::size_t all) {
                                                 need_follower(follower, way);
                                                 if (follower.sent) {
                                                   follower.sent(now, all);
                                                 }
                                               });
  if (!answer) {
    throw Failure(Exit::kFailure, answer.error().message);
  }
  if (answer->result != wire::SettingsResult::kOk) {
    refuse_upload(*answer, way.place);
  }
  way.remember();
  if (follower.told) {
    follower.told(ReleaseStep::kRestarting,
                  printed("%s: release %08x is in the other slot; the sensor restarts with it on "
                          "trial",
                          way.who().c_str(), answer->former));
  }
  return wait_s > 0 ? await_verdict(way, before->fingerprint, answer->former, wait_s, follower)
                    : ReleaseEnd{.release = answer->former, .former = before->fingerprint};
}

}  // namespace stof::host
