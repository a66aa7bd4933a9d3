#pragma once

#include "dsp/pmd/converter.h"
#include "host/evaluate/workspace.h"

namespace stof::host {

// A PmdConverter with its memory.
class OwningConverter {
 public:
  explicit OwningConverter(const dsp::PmdSensor& sensor)
      : space_(dsp::bytes_taken(
            [&](dsp::Arena& arena) noexcept { dsp::PmdConverter(sensor, arena); })),
        arena_(space_.arena()),
        converter_(sensor, arena_) {}
  dsp::PmdConverter& operator*() { return converter_; }
  dsp::PmdConverter* operator->() { return &converter_; }

 private:
  Workspace space_;
  dsp::Arena arena_;
  dsp::PmdConverter converter_;
};

}  // namespace stof::host
