#include "host/calibrate/rig/exchange/ros_ini.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/files/file.h"
#include "dsp/base/parse_number.h"
#include "host/calibrate/rig/exchange/lens_checks.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::string_view kBlank = " \t\r\v\f";
constexpr std::size_t kMostCameras = 8;
constexpr const char* kAgain = "export it again";

struct Kind {
  std::string_view name;
  IniNumbers IniCamera::* list;
  std::size_t least;
  std::size_t most;
};
constexpr std::array<Kind, 4> kKinds{{{"camera matrix", &IniCamera::matrix, 9, 9},
                                      {"distortion", &IniCamera::distortion, 1, kMostCoefficients},
                                      {"rectification", &IniCamera::rectification, 9, 9},
                                      {"projection", &IniCamera::projection, 12, 12}}};

std::string_view trimmed(std::string_view line) {
  const std::size_t first = line.find_first_not_of(kBlank);
  if (first == std::string_view::npos) {
    return {};
  }
  return line.substr(first, line.find_last_not_of(kBlank) - first + 1);
}

// Lines without comments and blanks around them; empty ones stay, for their numbers.
std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = trimmed(text.substr(begin, end - begin));
    lines.push_back(line.starts_with('#') || line.starts_with(';') ? std::string_view{} : line);
    begin = end + 1;
  }
  return lines;
}

bool begins_number(std::string_view line) {
  return line.find_first_of("0123456789") == 0 ||
         ((line[0] == '-' || line[0] == '.') && line.size() > 1);
}

class IniParser {
 public:
  // What is wrong with the line; empty: nothing.
  std::string take(std::string_view line, int number) {
    if (line.starts_with('[')) {
      return begin_section(line, number);
    }
    if (section_ == Section::kOther) {
      return {};
    }
    if (section_ == Section::kNone) {
      return "has something before its first section";
    }
    return begins_number(line) ? take_numbers(line) : begin_name(line, number);
  }
  // What is missing in the end.
  std::string missing(int& line) const {
    for (const IniCamera& camera : cameras_) {
      for (const Kind& kind : kKinds) {
        const IniNumbers& list = camera.*kind.list;
        const bool there = list.line != 0;
        line = there ? list.line : camera.line;
        if (!there) {
          return "has no " + std::string(kind.name) + " in this section";
        }
        if (list.numbers.size() < kind.least) {
          return printed("has %zu numbers of %s, not %zu", list.numbers.size(), kind.name.data(),
                         kind.least);
        }
      }
      line = camera.line;
      if (camera.width == 0 || camera.height == 0) {
        return "has no width and height in a section [image] before this camera";
      }
    }
    return {};
  }
  std::vector<IniCamera> take_cameras() { return std::move(cameras_); }

 private:
  enum class Section : std::uint8_t { kNone, kImage, kCamera, kOther };

  std::string begin_section(std::string_view line, int number) {
    list_ = nullptr;
    side_ = nullptr;
    if (!line.ends_with(']') || line.size() < 3) {
      return "has a section without a name or its closing bracket";
    }
    const std::string_view name = trimmed(line.substr(1, line.size() - 2));
    section_ = Section::kCamera;
    if (name == "image") {
      section_ = Section::kImage;
    } else if (name == "externals") {
      section_ = Section::kOther;
    } else if (cameras_.size() == kMostCameras) {
      return "has too many cameras";
    } else {
      cameras_.push_back({.line = number, .width = width_, .height = height_});
    }
    return {};
  }

  std::string begin_name(std::string_view line, int number) {
    list_ = nullptr;
    side_ = nullptr;
    if (section_ == Section::kImage) {
      if (line != "width" && line != "height") {
        return "has in [image] what is neither width nor height";
      }
      side_ = line == "width" ? &width_ : &height_;
      return {};
    }
    const auto* const kind = std::ranges::find(kKinds, line, &Kind::name);
    if (kind == kKinds.end()) {
      return "has what is no name of a camera's numbers";
    }
    list_ = &(cameras_.back().*kind->list);
    most_ = kind->most;
    if (list_->line != 0) {
      return "has " + std::string(kind->name) + " more than once";
    }
    list_->line = number;
    return {};
  }

  std::string take_numbers(std::string_view line) {
    for (std::size_t begin = 0; begin < line.size();) {
      const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
      if (end > begin) {
        const auto value = dsp::parse_number<double>(line.substr(begin, end - begin));
        if (!value || !std::isfinite(*value)) {
          return "has what is no number";
        }
        if (const std::string wrong = take(*value); !wrong.empty()) {
          return wrong;
        }
      }
      begin = end + 1;
    }
    return {};
  }

  std::string take(double value) {
    if (side_ != nullptr) {
      constexpr double kLargest = 65536;
      if (!(value >= 1) || value > kLargest || value != std::floor(value)) {
        return "has a width or height that is no whole number of 1 to 65536";
      }
      *side_ = static_cast<int>(value);
      side_ = nullptr;
      return {};
    }
    if (list_ == nullptr) {
      return "has numbers without a name before them";
    }
    if (list_->numbers.size() == most_) {
      return "has too many numbers";
    }
    list_->numbers.push_back(value);
    return {};
  }

  Section section_ = Section::kNone;
  int width_ = 0;
  int height_ = 0;
  int* side_ = nullptr;         // which of both the next number is
  IniNumbers* list_ = nullptr;  // what numbers belong to
  std::size_t most_ = 0;        // of them
  std::vector<IniCamera> cameras_;
};

}  // namespace

bool is_ini(std::string_view text) {
  const std::vector<std::string_view> lines = lines_of(text);
  const auto first =
      std::ranges::find_if(lines, [](std::string_view line) { return !line.empty(); });
  return first != lines.end() && first->starts_with('[') && first->ends_with(']') &&
         first->find_first_of(",:\"") == std::string_view::npos;
}

dataset::Loaded<std::vector<IniCamera>> parse_ini(const NamedText& text) {
  IniParser parser;
  int number = 0;
  for (const std::string_view line : lines_of(text.text)) {
    ++number;
    const std::string wrong = line.empty() ? "" : parser.take(line, number);
    if (!wrong.empty()) {
      return dataset::refuse(text.file, printed("line %d: ", number) + wrong, kAgain);
    }
  }
  const std::string missing = parser.missing(number);
  if (!missing.empty()) {
    return dataset::refuse(text.file, printed("line %d: ", number) + missing, kAgain);
  }
  return parser.take_cameras();
}

}  // namespace stof::host
