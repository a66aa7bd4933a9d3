#pragma once

#include "dsp/pmd/converter.h"
#include "host/evaluate/workspace.h"

namespace stof::host {

// A Converter with its memory.
class OwningConverter {
 public:
  explicit OwningConverter(const dsp::PmdSensor& sensor)
      : space_(
            dsp::bytes_taken([&](dsp::Arena& arena) noexcept { dsp::Converter(sensor, arena); })),
        arena_(space_.arena()),
        converter_(sensor, arena_) {}
  dsp::Converter& operator*() { return converter_; }
  dsp::Converter* operator->() { return &converter_; }

 private:
  Workspace space_;
  dsp::Arena arena_;
  dsp::Converter converter_;
};

}  // namespace stof::host
