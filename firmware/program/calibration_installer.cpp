#include "firmware/program/calibration_installer.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "firmware/wire/calibration/calibration_file.h"

namespace stof::firmware {

using settings::PagedWriter;
using wire::SettingsResult;

CalibrationInstaller::CalibrationInstaller(const Parts& parts) : parts_(parts) {
  if (parts.store != nullptr) {
    file_.resize(most_calibration_bytes(*parts.rig.needs.board));
    installed_.resize(file_.size());
    next_pattern_.resize(pattern_pixels(*parts.rig.needs.board));
    parts.rig.fixed_pattern.resize(next_pattern_.size());  // moves nothing: it has it, or is empty
  }
  if (parts.store != nullptr && parts.rig.installed) {
    const Result<std::optional<std::size_t>> bytes = parts.store->load(installed_);
    installed_bytes_ = bytes ? bytes->value_or(0) : 0;
  }
}

SettingsResult CalibrationInstaller::begin(std::uint32_t total, PagedWriter& why) noexcept {
  bytes_ = 0;
  if (parts_.store == nullptr) {
    why << "calibration: this sensor keeps none: start stofd with --settings FILE";
    return SettingsResult::kNotSaved;
  }
  if (total > file_.size()) {
    why << "calibration: longer than the " << file_.size()
        << " bytes of any calibration of this board: check the file";
    return SettingsResult::kInvalid;
  }
  return SettingsResult::kOk;
}

SettingsResult CalibrationInstaller::write(std::span<const std::byte> bytes,
                                           PagedWriter& /*why*/) noexcept {
  std::ranges::copy(bytes, std::span(file_).subspan(bytes_).begin());
  bytes_ += bytes.size();
  return SettingsResult::kOk;
}

SettingsResult CalibrationInstaller::commit(const Requester& by, PagedWriter& why) noexcept {
  return change(std::span(file_).first(bytes_), true, by, why);
}

SettingsResult CalibrationInstaller::revert(const Requester& by, PagedWriter& why) noexcept {
  if (parts_.store == nullptr) {
    why << "calibration: this sensor keeps none, so there is none to go back from: start stofd "
           "with --settings FILE";
    return SettingsResult::kNotSaved;
  }
  if (parts_.rig.factory.empty()) {
    why << "calibration: this sensor has no factory calibration: start stofd with --calibration "
           "FILE and --settings FILE";
    return SettingsResult::kNotSaved;
  }
  if (!parts_.rig.installed && parts_.rig.dropped == CalibrationDropped::kNot) {
    former_ = parts_.rig.fingerprint;
    return SettingsResult::kOk;  // a repeated request does not wear the medium
  }
  return change(parts_.rig.factory, false, by, why);
}

SettingsResult CalibrationInstaller::change(std::span<const std::byte> file, bool keep,
                                            const Requester& by, PagedWriter& why) noexcept {
  RigInfo& rig = parts_.rig;
  if (!parts_.sink.rig_in_force()) {
    why << "calibration: the one before is not in force yet: try again";
    return SettingsResult::kBusy;
  }
  why << "calibration: ";
  const std::optional<dsp::Calibration> next =
      read_rig_calibration(file, rig.needs, next_pattern_, why);
  if (!next) {
    return SettingsResult::kInvalid;
  }
  const dsp::Calibration before = std::exchange(rig.calibration, *next);
  const std::uint32_t former = std::exchange(rig.fingerprint, wire::calibration_fingerprint(file));
  std::swap(rig.fixed_pattern, next_pattern_);
  ++rig.installs;
  SettingsResult result = parts_.sink.takes_rig(why);
  if (result == SettingsResult::kOk && !changes_.take(by.now)) {
    why << "not changed: " << kMostChanges << " changes at once, then one a minute: try later";
    result = SettingsResult::kNotSaved;
  }
  if (result == SettingsResult::kOk && store(file, keep) != Status::kOk) {
    why << "not changed: its file, SETTINGS.calibration, cannot be written: check "
           "its folder: room, permissions, and that nothing but files has this name, with .new and "
           ".bad, too";
    result = SettingsResult::kNotSaved;
  }
  if (result != SettingsResult::kOk) {
    --rig.installs;
    std::swap(rig.fixed_pattern, next_pattern_);
    rig.fingerprint = former;
    rig.calibration = before;
    return result;
  }
  rig.installed = keep;
  rig.dropped = CalibrationDropped::kNot;
  if (keep) {  // `file` is what was uploaded
    installed_bytes_ = file.size();
    std::swap(file_, installed_);
    bytes_ = 0;
  }
  former_ = former;
  parts_.sink.use_rig();
  tell(by);
  return result;
}

std::span<const std::byte> CalibrationInstaller::file_in_force() const noexcept {
  const RigInfo& rig = parts_.rig;
  return rig.installed ? std::span(installed_).first(installed_bytes_) : std::span(rig.factory);
}

Status CalibrationInstaller::store(std::span<const std::byte> file, bool keep) noexcept {
  if (keep) {
    return parts_.store->save(file);
  }
  const Result<std::optional<std::size_t>> there = parts_.store->load(file_);
  return there && !*there ? Status::kOk : parts_.store->set_aside();
}

void CalibrationInstaller::tell(const Requester& by) noexcept {
  if (parts_.changes != nullptr) {
    static_cast<void>(
        parts_.changes->push({.kind = EventKind::kCalibrationChanged,
                              .value = parts_.rig.fingerprint,
                              .former = former_,
                              .address = by.peer ? by.peer->address : hal::Peer{}.address}));
  }
}

}  // namespace stof::firmware
