#include "firmware/settings/saved_settings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <span>

#include "dsp/depth/max_range.h"
#include "firmware/settings/depth_settings.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/field_value.h"
#include "firmware/settings/text/as_text.h"

namespace stof::settings {
namespace {

// Room for a file that somebody wrote by hand.
constexpr std::size_t kMostFile = 4 * kMostDocumentBytes;
// "1a2b3c4d 2": the fingerprint of the settings on trial, and their failed starts.
constexpr std::size_t kTrialBytes = 10;
constexpr std::size_t kFingerprintDigits = 8;
// Room for what an installer fixed, which has some 350 bytes.
constexpr std::size_t kFixedBytes = 512;

// One document of a store.
struct Loaded {
  std::optional<Settings> settings;  // none: `why` says why not, or there is none
  Dropped dropped = Dropped::kNot;
};

// why: also of settings that were loaded: which fields fell back.
Loaded load(hal::Store& store, Limits* limits, PagedWriter& why) noexcept {
  std::array<std::byte, kMostFile> bytes;
  const Result<std::optional<std::size_t>> loaded = store.load(bytes);
  if (!loaded && loaded.error() == Status::kTooLarge) {
    why << "longer than " << kMostFile << " bytes";
    return {.settings = {}, .dropped = Dropped::kUnusable};
  }
  if (!loaded && loaded.error() == Status::kUnsupported) {
    why << "no regular file, it is left alone";
    return {.settings = {}, .dropped = Dropped::kNoFile};
  }
  if (!loaded) {
    why << "cannot be read, it is left alone";
    return {.settings = {}, .dropped = Dropped::kUnreadable};
  }
  if (!*loaded) {
    return {};
  }
  if (**loaded == 0) {
    why << "empty";
    return {.settings = {}, .dropped = Dropped::kEmpty};
  }
  Settings settings;
  if (!parse(as_text(std::span(bytes).first(**loaded)), settings, why)) {
    return {.settings = {}, .dropped = Dropped::kUnusable};
  }
  fit_blocks(settings, why);
  std::array<char, kWhyBytes> space;
  PagedWriter refusal(space);
  if (!usable(settings, limits, refusal)) {
    why << (why.text().empty() ? "" : "; ") << refusal.text();
    return {.settings = {}, .dropped = Dropped::kUnusable};
  }
  return {.settings = settings, .dropped = Dropped::kNot};
}

std::optional<Settings> load_good(hal::Store& store, Limits* limits) noexcept {
  std::array<char, kWhyBytes> space;
  PagedWriter unused(space);
  return load(store, limits, unused).settings;
}

// Something was saved there, also where it cannot be used any more.
bool was_saved(hal::Store& store) noexcept {
  std::array<std::byte, kMostFile> bytes;
  const Result<std::optional<std::size_t>> loaded = store.load(bytes);
  return !loaded || loaded->has_value();
}

// In place of the current settings, of which `why` says what is wrong.
StartSettings replace(const SettingsStores& stores, std::string_view place, Limits* limits,
                      Dropped dropped, std::string_view why, PagedWriter& line) noexcept {
  const bool damaged = dropped == Dropped::kEmpty || dropped == Dropped::kUnusable;
  const bool aside = damaged && stores.current.set_aside() == Status::kOk;
  const std::optional<Settings> good = load_good(stores.good, limits);
  StartSettings start{
      .settings = good.value_or(Settings{}), .dropped = dropped, .good = good.has_value()};
  start.strictest = !keep_fixed(stores, start.settings);
  line << place << ": " << why << (good ? ": the last good settings hold" : ": the defaults hold")
       << (start.strictest ? ", with the strictest limits and serial.remote" : "")
       << (aside ? ", the file is kept as .bad" : "");
  return start;
}

bool is_empty(hal::Store& store) noexcept {
  std::array<std::byte, 1> space;
  const Result<std::optional<std::size_t>> loaded = store.load(space);
  return loaded && !*loaded;
}

bool is_fixed(const Field& field) noexcept {
  return field.group == "limits" || field.group == "network" ||
         (field.group == "serial" && field.name == "remote");
}

void copy_fixed(const Settings& from, Settings& to) noexcept {
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    if (const Field known = field(place); is_fixed(known)) {
      copy_field(known, from, to);
    }
  }
}

// None: the record is missing, damaged or does not name every one of these fields. One of before
// there were settings of the network names none of these.
std::optional<Settings> load_fixed(hal::Store& store) noexcept {
  std::array<std::byte, kFixedBytes> bytes;
  const Result<std::optional<std::size_t>> loaded = store.load(bytes);
  if (!loaded || !*loaded) {
    return std::nullopt;
  }
  Settings settings;
  FieldSet named;
  std::array<char, kWhyBytes> space;
  PagedWriter unused(space);
  if (!parse(as_text(std::span(bytes).first(**loaded)), settings, unused, &named)) {
    return std::nullopt;
  }
  const std::size_t count = field_count();
  for (std::size_t place = 0; place < count; ++place) {
    const Field known = field(place);
    const bool may_be_missing = known.group == "network";
    if (is_fixed(known) ? !named.test(place) && !may_be_missing : named.test(place)) {
      return std::nullopt;
    }
  }
  return settings;
}

}  // namespace

int failed_starts(hal::Store& trial, const Settings& settings) noexcept {
  std::array<std::byte, kTrialBytes> bytes;
  const Result<std::optional<std::size_t>> loaded = trial.load(bytes);
  if (!loaded || *loaded != kTrialBytes) {
    return 0;
  }
  const std::string_view text = as_text(bytes);
  std::uint32_t of = 0;
  const auto read = std::from_chars(text.data(), text.data() + kFingerprintDigits, of, 16);
  const int count = text.back() - '0';
  const bool whole = read.ec == std::errc() && read.ptr == text.data() + kFingerprintDigits;
  return whole && of == fingerprint(settings) && count >= 0 && count <= kMaxFailedStarts ? count
                                                                                         : 0;
}

Status count_failed_starts(hal::Store& trial, const Settings& settings, int count) noexcept {
  std::array<char, kTrialBytes> text;
  text.fill('0');
  std::array<char, kFingerprintDigits> digits;
  const auto written =
      std::to_chars(digits.data(), digits.data() + digits.size(), fingerprint(settings), 16);
  std::copy_backward(digits.data(), written.ptr, text.data() + kFingerprintDigits);
  text[kFingerprintDigits] = ' ';
  text.back() = static_cast<char>('0' + count);
  return trial.save(std::as_bytes(std::span(text)));
}

bool keep_fixed(const SettingsStores& stores, Settings& settings) noexcept {
  if (stores.fixed == nullptr) {
    return true;
  }
  if (const std::optional<Settings> last = load_fixed(*stores.fixed)) {
    copy_fixed(*last, settings);
    return true;
  }
  settings.serial.remote = true;
  // No period lies within these, and no range is less than the largest.
  settings.limits = {.least_range_mm = dsp::kMostMaxRangeMm,
                     .least_period_ms = kMostPeriodMs,
                     .most_period_ms = 0,
                     .streams = StreamLimit::kFixed};
  return false;
}

Status save_fixed(hal::Store& fixed, const Settings& settings) noexcept {
  Settings now;
  copy_fixed(settings, now);
  if (load_fixed(fixed) == now) {
    return Status::kOk;
  }
  std::array<char, kFixedBytes> space;
  PagedWriter out(space);
  out << R"({"serial": {"remote": )" << (now.serial.remote ? "true" : "false") << "}";
  for (const char* const group : {"limits", "network"}) {
    out << ", \"" << group << "\": {";
    const char* between = "";
    const std::size_t count = field_count();
    for (std::size_t place = 0; place < count; ++place) {
      if (const Field known = field(place); known.group == group) {
        out << between << '"' << known.name << "\": ";
        write_value(known, now, out);
        between = ", ";
      }
    }
    out << "}";
  }
  out << "}\n";
  return out.complete() ? fixed.save(std::as_bytes(std::span(out.text()))) : Status::kTooLarge;
}

void save_first(const SettingsStores& stores, std::string_view text, std::string_view place,
                PagedWriter& line) noexcept {
  if (!is_empty(stores.current) || !is_empty(stores.good) ||
      (stores.fixed != nullptr && !is_empty(*stores.fixed))) {
    return;
  }
  Settings settings;
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  line << place << ": ";
  if (!parse(text, settings, why) || !usable(settings, nullptr, why)) {
    line << why.text() << ": none of it is taken";
  } else if (save_document(stores.current, settings) != Status::kOk) {
    line << "cannot be saved: none of it is taken";
  } else {
    line << "taken as the first settings";
  }
}

Status save_document(hal::Store& store, const Settings& settings) noexcept {
  std::array<char, kMostDocumentBytes> space;
  PagedWriter document(space);
  write_document(settings, document);
  return document.complete() ? store.save(std::as_bytes(std::span(document.text())))
                             : Status::kTooLarge;
}

StartSettings load_settings(const SettingsStores& stores, std::string_view place, Limits* limits,
                            PagedWriter& line) noexcept {
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  const Loaded current = load(stores.current, limits, why);
  if (!current.settings) {
    if (current.dropped != Dropped::kNot) {
      return replace(stores, place, limits, current.dropped, why.text(), line);
    }
    const bool missing =
        was_saved(stores.good) || (stores.fixed != nullptr && was_saved(*stores.fixed));
    return missing ? replace(stores, place, limits, Dropped::kMissing, "missing", line)
                   : StartSettings{};
  }
  StartSettings start{.settings = *current.settings, .fell_back = !why.text().empty()};
  bool counted = true;
  if (start.settings != load_good(stores.good, nullptr)) {
    const int failed = failed_starts(stores.trial, start.settings);
    if (failed >= kMaxFailedStarts) {
      return replace(stores, place, limits, Dropped::kFailedStarts,
                     "two starts with these settings have failed", line);
    }
    start.on_trial = true;
    counted = count_failed_starts(stores.trial, start.settings, failed + 1) == Status::kOk;
  }
  if (stores.fixed != nullptr) {  // of settings that somebody else wrote, too
    static_cast<void>(save_fixed(*stores.fixed, start.settings));
  }
  if (start.fell_back) {
    line << place << ": " << why.text() << (counted ? "" : "; ");
  }
  if (!counted) {
    line << place
         << ".trial: cannot be written: starts that fail with these settings are not counted, so "
            "the last good ones will not come back: make it a file, or remove it";
  }
  return start;
}

StartSettings reload_settings(const SettingsStores& stores, std::string_view place, Limits& limits,
                              PagedWriter& line) noexcept {
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  const Loaded current = load(stores.current, &limits, why);
  return replace(stores, place, &limits,
                 current.dropped == Dropped::kNot ? Dropped::kUnusable : current.dropped,
                 why.text(), line);
}

}  // namespace stof::settings
