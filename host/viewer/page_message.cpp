#include "host/viewer/page_message.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace stof::viewer {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostName = 64;   // of a setting, a device, a fault
constexpr std::size_t kMostText = 256;  // of a setting's value
constexpr std::size_t kMostChanges = 64;

// Exactly these members.
bool has_only(const Json& said, std::initializer_list<const char*> names) {
  return said.size() == names.size() &&
         std::ranges::all_of(names, [&](const char* name) { return said.contains(name); });
}

std::optional<std::uint64_t> number_in(const Json& said, const char* name, std::uint64_t most) {
  const Json& value = said[name];
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > most) {
    return std::nullopt;
  }
  return value.get<std::uint64_t>();
}

bool is_name(std::string_view text, std::string_view more) {
  return !text.empty() && text.size() <= kMostName && std::ranges::all_of(text, [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           more.find(c) != std::string_view::npos;
  });
}

std::optional<Look> look_of(const Json& said) {
  if (!has_only(said, {"show", "frames", "quiet"}) || !said["show"].is_array() ||
      !said["quiet"].is_boolean()) {
    return std::nullopt;
  }
  const auto frames = number_in(said, "frames", Look::kMostFrames);
  if (!frames) {
    return std::nullopt;
  }
  Look look{.frames = static_cast<int>(*frames), .quiet = said["quiet"].get<bool>()};
  for (const Json& one : said["show"]) {
    const auto* const name = one.get_ptr<const std::string*>();
    const std::optional<Plane> plane = name == nullptr ? std::nullopt : plane_named(*name);
    if (!plane) {
      return std::nullopt;
    }
    look.planes |= *plane;
  }
  return look;
}

std::optional<Wish> change_of(const Json& said) {
  const Json& settings = said["settings"];
  if (!settings.is_object() || settings.empty() || settings.size() > kMostChanges) {
    return std::nullopt;
  }
  ChangeSettings change;
  for (const auto& [path, value] : settings.items()) {
    const auto* const text = value.get_ptr<const std::string*>();
    const bool fits = value.is_number_integer() || value.is_boolean() ||
                      (text != nullptr && text->size() <= kMostText);
    if (!is_name(path, ".-") || !fits) {
      return std::nullopt;
    }
    change.assignments.push_back(path + "=" + value.dump());
  }
  return change;
}

std::optional<Wish> fault_of(const Json& said) {
  const auto* const device = said["device"].get_ptr<const std::string*>();
  const auto* const kind = said["kind"].get_ptr<const std::string*>();
  const auto edges = number_in(said, "edges", 1'000'000);
  if (device == nullptr || kind == nullptr || !edges || !is_name(*device, "") ||
      !is_name(*kind, "")) {
    return std::nullopt;
  }
  return GiveFault{*device + ":" + *kind + (*edges == 0 ? "" : ":" + std::to_string(*edges))};
}

// A text of at most so many bytes, all of them of `alphabet`.
const std::string* text_in(const Json& said, const char* name, std::size_t most,
                           std::string_view alphabet) {
  const auto* const text = said[name].get_ptr<const std::string*>();
  return text != nullptr && text->size() <= most &&
                 text->find_first_not_of(alphabet) == std::string::npos
             ? text
             : nullptr;
}

std::optional<Wish> pairing_of(const Json& said) {
  const auto* const code = text_in(said, "code", kMostName, "0123456789abcdefABCDEF- ");
  const auto* const role = said["role"].get_ptr<const std::string*>();
  if (code == nullptr || role == nullptr ||
      (*role != "view" && *role != "tune" && *role != "admin")) {
    return std::nullopt;
  }
  return BeginPairing{.code = *code, .role = *role};
}

std::optional<Wish> digits_of(const Json& said) {
  const auto* const digits = text_in(said, "digits", 16, "0123456789 ");
  return digits != nullptr ? std::optional<Wish>(GiveDigits{*digits}) : std::nullopt;
}

// The name of a file, never a path.
std::optional<Wish> release_of(const Json& said) {
  const auto* const file = said["file"].get_ptr<const std::string*>();
  constexpr std::size_t kMostFile = 255;
  if (file == nullptr || file->empty() || file->size() > kMostFile || file->front() == '.' ||
      file->find_first_of(std::string_view("/\0", 2)) != std::string::npos) {
    return std::nullopt;
  }
  return PutRelease{*file};
}

// "charuco:12x9:0.04": no word of a command line is made of it that begins with "-".
std::optional<Wish> calibration_of(const Json& said) {
  const auto* const board =
      text_in(said, "board", kMostName, "abcdefghijklmnopqrstuvwxyz0123456789:.");
  if (board == nullptr || board->empty() || !said["goes_on"].is_boolean()) {
    return std::nullopt;
  }
  return BeginCalibration{.board = *board, .goes_on = said["goes_on"].get<bool>()};
}

template <typename Switch>
std::optional<Wish> switch_of(const Json& said) {
  return said["on"].is_boolean() ? std::optional<Wish>(Switch{said["on"].get<bool>()})
                                 : std::nullopt;
}

std::optional<Wish> seek_of(const Json& said) {
  const auto ms = number_in(said, "to_ms", std::uint64_t{1} << 40);
  return ms ? std::optional<Wish>(SeekTo{*ms}) : std::nullopt;
}

template <typename Plain>
std::optional<Wish> plain(const Json& /*said*/) {
  return Plain{};
}

// What a page may ask for.
struct Asked {
  std::string_view what;
  std::array<const char*, 3> members;  // beside do, id and ticket; nullptr: no more
  std::optional<Wish> (*read)(const Json&);
};
constexpr std::array kAsked{
    Asked{"settings", {}, plain<ReadSettings>},
    Asked{"set", {"settings"}, change_of},
    Asked{"save", {}, plain<SaveSettings>},
    Asked{
        "faults", {}, [](const Json& /*said*/) { return std::optional<Wish>(GiveFault{"list"}); }},
    Asked{"fault", {"device", "kind", "edges"}, fault_of},
    Asked{"record", {"on"}, switch_of<SetRecording>},
    Asked{"play", {"on"}, switch_of<SetPlaying>},
    Asked{"seek", {"to_ms"}, seek_of},
    Asked{"pair", {"code", "role"}, pairing_of},
    Asked{"digits", {"digits"}, digits_of},
    Asked{"end_pairing", {}, plain<EndPairing>},
    Asked{"release", {}, plain<ReadRelease>},
    Asked{"update", {"file"}, release_of},
    Asked{"revert", {}, plain<RevertRelease>},
    Asked{"calibration", {}, plain<ReadCalibration>},
    Asked{"calibrate", {"board", "goes_on"}, calibration_of},
    Asked{"end_calibration", {}, plain<EndCalibration>},
    Asked{"install", {}, plain<InstallCalibration>},
};

// do, id and ticket are there.
std::optional<Wish> wish_of(const std::string& what, const Json& said) {
  const auto* const asked = std::ranges::find(kAsked, what, &Asked::what);
  if (asked == kAsked.end()) {
    return std::nullopt;
  }
  const auto last = std::ranges::find(asked->members, nullptr);
  const auto count = static_cast<std::size_t>(last - asked->members.begin());
  const bool has_all = std::all_of(asked->members.begin(), last,
                                   [&](const char* name) { return said.contains(name); });
  return has_all && said.size() == 3 + count ? asked->read(said) : std::nullopt;
}

std::optional<Request> request_of(const Json& said) {
  const auto* const what = said["do"].get_ptr<const std::string*>();
  if (what == nullptr || !said.contains("id") || !said.contains("ticket")) {
    return std::nullopt;
  }
  const auto id = number_in(said, "id", std::numeric_limits<std::uint32_t>::max());
  const auto* const ticket = said["ticket"].get_ptr<const std::string*>();
  std::optional<Wish> wish = id && ticket != nullptr ? wish_of(*what, said) : std::nullopt;
  if (!wish) {
    return std::nullopt;
  }
  return Request{
      .id = static_cast<std::uint32_t>(*id), .ticket = *ticket, .wish = *std::move(wish)};
}

// An object that names a member twice means two things at once: whoever reads the first one, and
// whoever reads the last one, would do something else.
std::optional<Json> parse_once(std::string_view text) {
  std::vector<std::set<std::string>> open;  // the names so far of the objects around
  bool twice = false;
  const auto watch = [&](int, Json::parse_event_t event, const Json& part) {
    if (event == Json::parse_event_t::object_start) {
      open.emplace_back();
    } else if (event == Json::parse_event_t::object_end) {
      open.pop_back();
    } else if (event == Json::parse_event_t::key) {
      twice = !open.back().insert(part.get<std::string>()).second || twice;
    }
    return true;
  };
  Json said = Json::parse(text, watch, false);
  return twice ? std::nullopt : std::optional(std::move(said));
}

}  // namespace

std::optional<PageMessage> parse_page_message(std::string_view text) {
  const std::optional<Json> parsed = parse_once(text);
  if (!parsed || !parsed->is_object()) {
    return std::nullopt;
  }
  const Json& said = *parsed;
  if (!said.contains("do")) {
    const std::optional<Look> look = look_of(said);
    return look ? std::optional<PageMessage>(*look) : std::nullopt;
  }
  std::optional<Request> request = request_of(said);
  return request ? std::optional<PageMessage>(*std::move(request)) : std::nullopt;
}

}  // namespace stof::viewer
