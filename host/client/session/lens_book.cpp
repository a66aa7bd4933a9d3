#include "host/client/session/lens_book.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace stof::client {
namespace {

ImageSize size_of(const wire::CalibrationPacket& lens) noexcept {
  return {.width = lens.image_width, .height = lens.image_height};
}

// What messages are compared by: others are of two rigs, or of two pictures.
bool same_key(const wire::CalibrationPacket& one, const wire::CalibrationPacket& other) noexcept {
  return one.fingerprint == other.fingerprint && size_of(one) == size_of(other);
}

// Whoever tells a message may be somebody else; a frame's info has its other packets beside it.
std::optional<wire::CalibrationPacket> with_settings(const wire::CalibrationPacket* lens,
                                                     const std::optional<MadeWith>& made) noexcept {
  if (lens == nullptr) {
    return std::nullopt;
  }
  wire::CalibrationPacket told = *lens;
  if (made && made->max_range_um > 0) {
    told.max_range = made->max_range_um / std::max(lens->depth_unit_um, 1U);
  }
  if (made && made->period > Duration(0)) {
    told.period_ns = std::chrono::nanoseconds(made->period).count();
  }
  return told;
}

}  // namespace

// Settings change the range and the period.
bool LensBook::same(const wire::CalibrationPacket& one,
                    const wire::CalibrationPacket& other) const noexcept {
  wire::CalibrationPacket compared = one;
  compared.max_range = other.max_range;
  compared.period_ns = other.period_ns;
  if (units_change_) {
    compared.depth_unit_um = other.depth_unit_um;
  }
  return compared == other || one.fingerprint == 0;
}

void LensBook::restart(bool outlasts) noexcept {
  made_.reset();
  for (std::optional<Entry>& entry : entries_) {
    if (!outlasts) {
      entry.reset();
    } else if (entry) {
      entry->told = 0;
    }
  }
}

bool LensBook::take(const wire::CalibrationPacket& told, Time arrived, bool late) noexcept {
  ++told_;
  std::optional<Entry>& entry = place(told);
  if (!entry) {
    entry = Entry{.lens = told, .alone = {.since = arrived}, .told = told_};
    return true;
  }
  return same(told, entry->lens) ? take_again(*entry, told, arrived, late)
                                 : take_other(*entry, told, arrived);
}

bool LensBook::take_again(Entry& entry, const wire::CalibrationPacket& told, Time arrived,
                          bool late) noexcept {
  entry.lens = late ? entry.lens : told;
  entry.told = late && entry.told != 0 ? entry.told : told_;
  entry.rival.reset();
  const Duration alone = arrived - entry.alone.since;
  const std::uint64_t frames = entry.frames - entry.alone.frames;
  const bool short_alone = alone < kBelievedAfter || frames < kBelievedFrames;
  const bool long_alone = alone >= kStandsAfter && frames >= kStandsFrames;
  entry.doubted = entry.doubted && short_alone;
  entry.stands = entry.stands || long_alone || !(entry.ever_doubted || short_alone);
  return !entry.doubted;
}

bool LensBook::take_other(Entry& entry, const wire::CalibrationPacket& told,
                          Time arrived) noexcept {
  const Alone now{.since = arrived, .frames = entry.frames};
  if (!entry.stands) {
    entry.doubted = true;
    entry.ever_doubted = true;
    entry.lens = told;
    entry.alone = now;
    return false;
  }
  if (!entry.rival || !same(told, entry.rival->lens)) {
    entry.rival = Rival{.lens = told, .alone = now};
  }
  const Alone& alone = entry.rival->alone;
  if (arrived - alone.since < kStandsAfter || entry.frames - alone.frames < kStandsFrames) {
    return false;
  }
  entry.lens = told;
  entry.alone = now;
  entry.told = told_;
  entry.stands = false;
  entry.ever_doubted = true;
  entry.rival.reset();
  return true;
}

// The entry of this fingerprint and size, or else an empty one: of those that do not stand the one
// which frames named least recently, and of these the one told least recently.
std::optional<LensBook::Entry>& LensBook::place(const wire::CalibrationPacket& told) noexcept {
  std::optional<Entry>* oldest = entries_.data();
  const auto age = [](const std::optional<Entry>& entry) {
    return entry ? std::tuple(entry->stands, entry->named, entry->told)
                 : std::tuple(false, std::uint64_t{0}, std::uint64_t{0});
  };
  for (std::optional<Entry>& entry : entries_) {
    if (entry && same_key(entry->lens, told)) {
      return entry;
    }
    if (oldest->has_value() && (!entry || age(entry) < age(*oldest))) {
      oldest = &entry;
    }
  }
  oldest->reset();
  return *oldest;
}

void LensBook::note_frame(const MadeWith& made, ImageSize depth, Time arrived) noexcept {
  const std::uint32_t fingerprint = made.calibration;
  const bool anew = !made_ || made_->calibration != fingerprint;
  made_ = made;
  ++frames_;
  const bool known = std::ranges::any_of(entries_, [&](const std::optional<Entry>& entry) {
    return entry && entry->lens.fingerprint == fingerprint && entry->named != 0;
  });
  for (std::optional<Entry>& entry : entries_) {
    if (!entry || entry->lens.fingerprint != fingerprint) {
      continue;
    }
    // Frames without depth go with the lens that they went with before.
    if (depth == ImageSize{} ? known && entry->named == 0 : size_of(entry->lens) != depth) {
      continue;
    }
    // What was told while no frame named it proves nothing.
    if (anew) {
      entry->alone = {.since = arrived, .frames = entry->frames};
    }
    ++entry->frames;
    entry->named = frames_;
  }
}

template <typename Accepts>
const wire::CalibrationPacket* LensBook::newest(Accepts accepts) const noexcept {
  const Entry* found = nullptr;
  const auto rank = [](const Entry& entry) {
    return std::tuple(entry.stands, entry.named != 0, entry.told);
  };
  for (const std::optional<Entry>& entry : entries_) {
    if (entry && entry->told != 0 && accepts(entry->lens) &&
        (found == nullptr || rank(*entry) > rank(*found))) {
      found = &*entry;
    }
  }
  return found == nullptr || found->doubted ? nullptr : &found->lens;
}

std::uint32_t LensBook::last_told() const noexcept {
  const auto last = std::ranges::max_element(
      entries_, {}, [](const std::optional<Entry>& entry) { return entry ? entry->told : 0; });
  return *last ? (*last)->lens.fingerprint : 0;
}

std::optional<wire::CalibrationPacket> LensBook::current() const noexcept {
  const std::uint32_t named = made_ ? made_->calibration : 0;
  return with_settings(newest([named](const wire::CalibrationPacket& lens) {
                         return named == 0 || lens.fingerprint == named;
                       }),
                       made_);
}

std::optional<wire::CalibrationPacket> LensBook::of(const std::optional<MadeWith>& made,
                                                    ImageSize depth) const noexcept {
  const std::optional<MadeWith>& with = made ? made : made_;
  const std::uint32_t named = with ? with->calibration : 0;
  if (!made && named != 0 && last_told() != named) {
    return std::nullopt;
  }
  return with_settings(newest([&](const wire::CalibrationPacket& lens) {
                         return (named == 0 || lens.fingerprint == named) &&
                                (depth == ImageSize{} || size_of(lens) == depth);
                       }),
                       with);
}

}  // namespace stof::client
