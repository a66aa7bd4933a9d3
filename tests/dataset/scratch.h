#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <unistd.h>

namespace stof::test {

// A folder of its own for each test, gone afterwards.
class Scratch : public testing::Test {
 protected:
  Scratch() {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("stof_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~Scratch() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path put(const std::string& name, std::string_view bytes) const {
    const std::filesystem::path file = folder_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  std::filesystem::path folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

// The promise of every message: one line "FILE: what: what to do" that names the file and the fact.
inline void expect_one_line_about(const std::string& message, const std::filesystem::path& file,
                                  std::string_view fact) {
  EXPECT_TRUE(message.starts_with(file.string() + ": ")) << message;
  EXPECT_NE(message.find(fact), std::string::npos) << message;
  EXPECT_EQ(std::ranges::count(message, '\n'), 0) << message;
  const std::string rest = message.substr(std::min(message.size(), file.string().size() + 2));
  EXPECT_NE(rest.find(": "), std::string::npos) << "says nothing to do: " << message;
}

}  // namespace stof::test
