#include "hal/linux/libcamera/libcamera_find.h"

#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include <regex.h>

#include "dsp/base/parse_number.h"

namespace stof::hal::linux {
namespace {

constexpr std::string_view kModel = "model:";

std::string list(std::span<const LibcameraName> cameras) {
  std::string text;
  for (const LibcameraName& camera : cameras) {
    text += (text.empty() ? "" : ", ") + camera.id + " (" + camera.model + ")";
  }
  return text.empty() ? "no camera at all" : text;
}

std::vector<std::size_t> with_part(std::span<const LibcameraName> cameras,
                                   const std::string& part) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].id == part) {
      return {i};
    }
    if (cameras[i].id.find(part) != std::string::npos) {
      found.push_back(i);
    }
  }
  return found;
}

std::vector<std::size_t> with_expression(std::span<const LibcameraName> cameras,
                                         const std::string& expression) {
  std::vector<std::size_t> found;
  regex_t compiled{};
  if (regcomp(&compiled, expression.c_str(), REG_EXTENDED | REG_NOSUB) != 0) {
    return found;
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (regexec(&compiled, cameras[i].id.c_str(), 0, nullptr, 0) == 0) {
      found.push_back(i);
    }
  }
  regfree(&compiled);
  return found;
}

// "model:imx296:0": at most one.
std::vector<std::size_t> with_model(std::span<const LibcameraName> cameras,
                                    std::string_view wanted) {
  wanted.remove_prefix(kModel.size());
  const std::size_t colon = wanted.rfind(':');
  if (colon == std::string_view::npos) {
    return {};
  }
  std::optional<std::size_t> number = dsp::parse_number<std::size_t>(wanted.substr(colon + 1));
  if (!number) {
    return {};
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].model == wanted.substr(0, colon) && (*number)-- == 0) {
      return {i};
    }
  }
  return {};
}

}  // namespace

std::expected<std::size_t, OpenError> find_libcamera(std::span<const LibcameraName> cameras,
                                                     const std::string& wanted) {
  std::vector<std::size_t> found;
  if (wanted.starts_with(kModel)) {
    found = with_model(cameras, wanted);
  } else if (!wanted.empty()) {
    found = with_part(cameras, wanted);
    if (found.empty()) {
      found = with_expression(cameras, wanted);
    }
  }
  if (found.size() == 1) {
    return found.front();
  }
  return std::unexpected(OpenError{(found.empty() ? "no camera" : "more than one camera") +
                                   std::string(" of libcamera is '") + wanted +
                                   "': name one of: " + list(cameras)});
}

}  // namespace stof::hal::linux
