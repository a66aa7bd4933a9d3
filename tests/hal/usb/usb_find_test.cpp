#include "hal/linux/usb/usb_find.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using hal::linux::find_usb;

class FindUsb : public testing::Test {
 protected:
  FindUsb() {
    std::string pattern = (std::filesystem::temp_directory_path() / "stof-find-XXXXXX").string();
    root_ = mkdtemp(pattern.data());
  }
  ~FindUsb() override { std::filesystem::remove_all(root_); }

  void plug_in(const std::string& name, const std::string& vendor, const std::string& serial,
               const std::string& number) const {
    const std::string device = root_ + "/" + name;
    std::filesystem::create_directories(device);
    std::ofstream(device + "/idVendor") << vendor << '\n';
    std::ofstream(device + "/idProduct") << "0050\n";
    std::ofstream(device + "/serial") << serial << '\n';
    std::ofstream(device + "/busnum") << "2\n";
    std::ofstream(device + "/devnum") << number << '\n';
  }
  // The node, or the error.
  std::string find(const std::string& serial = {}) const {
    const auto node = find_usb({.vendor = 0x1209, .product = 0x0050, .serial = serial},
                               {.devices = root_, .nodes = "/nodes"});
    return node ? *node : node.error().message;
  }
  bool finds_none() const { return find().find("not plugged in") != std::string::npos; }

 private:
  std::string root_;
};

TEST_F(FindUsb, NamesTheNodeOfTheOneDevice) {
  plug_in("1-1", "1d6b", "a", "1");
  plug_in("1-2", "1209", "b", "17");
  EXPECT_EQ(find(), "/nodes/002/017");
}

TEST_F(FindUsb, SerialNumberTellsTwoApart) {
  plug_in("1-1", "1209", "a", "3");
  plug_in("1-2", "1209", "b", "4");
  EXPECT_NE(find().find("2 are plugged in"), std::string::npos);
  EXPECT_EQ(find("b"), "/nodes/002/004");
  EXPECT_NE(find("c").find("serial 'c'"), std::string::npos);
}

TEST_F(FindUsb, WhatIsNoNumberIsNoDevice) {
  EXPECT_TRUE(finds_none());
  plug_in("1-1", "12o9", "a", "3");
  plug_in("1-2", "1209", "a", "-3");
  plug_in("1-3", "1209", "a", "1000");
  plug_in("1-4", "1209", "a", "");
  plug_in("1-5", "12091209120912091209", "a", "1");
  EXPECT_TRUE(finds_none());
}

TEST(FindUsbRoots, MachineWithoutUsbSaysSo) {
  const auto node = find_usb({.vendor = 1, .product = 2, .serial = {}},
                             {.devices = "/nowhere/at/all", .nodes = "/nodes"});
  ASSERT_FALSE(node);
  EXPECT_NE(node.error().message.find("does this kernel have USB?"), std::string::npos);
}

}  // namespace
}  // namespace stof::test
