#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dsp/base/arena.h"

namespace stof::host {

// Memory for a dsp::Arena of `bytes`.
class Workspace {
 public:
  explicit Workspace(std::size_t bytes) : lines_((bytes + sizeof(Line) - 1) / sizeof(Line)) {}
  dsp::Arena arena() noexcept { return dsp::Arena(std::as_writable_bytes(std::span(lines_))); }

 private:
  struct alignas(dsp::Arena::kAlign) Line {
    std::byte bytes[dsp::Arena::kAlign];
  };
  std::vector<Line> lines_;
};

}  // namespace stof::host
