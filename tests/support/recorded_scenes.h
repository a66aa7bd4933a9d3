#pragma once

#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

namespace stof::test {

// The folder of recorded scenes (dataset/README.md) that STOF_DATA names; empty: none.
inline std::filesystem::path recorded_scenes() {
  const char* const folder = std::getenv("STOF_DATA");  // NOLINT(concurrency-mt-unsafe): no threads
  return folder == nullptr ? "" : folder;
}

// Tests that read it.
class RecordedScenes : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(recorded_scenes())) {
      GTEST_SKIP() << "STOF_DATA does not name the folder of the recorded scenes";
    }
  }
};

}  // namespace stof::test
