#include "batten/io/zip_archive.hpp"

#include <map>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

std::string from_hex(const std::string& hex) {
  std::string bytes;
  for (size_t k = 0; k < hex.size(); k += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(k, 2), nullptr, 16));
  return bytes;
}

TEST(ZipArchive, ReadsBackWhatItWrote) {
  const std::map<std::string, std::string> entries{
      {"a.txt", "hello"}, {"b/empty", ""}, {"c", std::string(1000, '\0')}};
  EXPECT_EQ(parse_archive(format_archive(entries)), entries);
  EXPECT_EQ(format_archive(entries), format_archive(entries));
}

// CRC-32 of the nine digits, the value that every table of checksums gives for it.
TEST(ZipArchive, HasTheCheckSumOfZipFiles) {
  const std::string bytes = format_archive({{"n", "123456789"}});
  EXPECT_EQ(bytes.substr(14, 4), "\x26\x39\xf4\xcb");
}

// "batten " forty times as a.txt, deflated by another program.
TEST(ZipArchive, UnpacksDeflatedEntries) {
  std::string bytes = from_hex(
      "504b03041400000008000000210057f904ec0d0000001801000005000000612e7478744b4a2c2949cd53481aa550290050"
      "4b010214031400000008000000210057f904ec0d000000180100000500000000000000000000008001000000006"
      "12e747874504b0506000000000100010033000000300000000000");
  std::string expected;
  for (int k = 0; k < 40; ++k) expected += "batten ";
  EXPECT_EQ(parse_archive(bytes), (std::map<std::string, std::string>{{"a.txt", expected}}));
  for (const size_t place : {35, 40, 47, 72, 73}) {  // packed bytes, and the size that is announced
    std::string damaged = bytes;
    damaged[place] ^= 0x11;
    EXPECT_THROW(parse_archive(damaged), InvalidInput) << place;
  }
  // A size that no honest file has is refused before memory is taken for it.
  bytes[48 + 27] = 0x70;
  EXPECT_THROW(parse_archive(bytes), InvalidInput);
}

// Another program's file: 50,000 zeros deflated, a thousandth of their size, and a stored entry; both with an
// extra field in either header, and a comment behind everything. A comment has 65,535 bytes at most.
TEST(ZipArchive, PassesOverExtraFieldsAndComments) {
  const std::string bytes = from_hex(
      "504b03041400000008000000210025b3b7164100000050c30000010007006142420300616263edc1010d000000c2a0f7"
      "4f6d0f071400000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
      "00000000004f06504b03041400000000000000210069111fb60600000006000000010007006242420300616263736563"
      "6f6e64504b010214031400000008000000210025b3b7164100000050c300000100070000000000000000008001000000"
      "006142420300616263504b010214031400000000000000210069111fb606000000060000000100070000000000000000"
      "008001670000006242420300616263504b050600000000020002006c000000930000000c006d6164652062792068616e"
      "64");
  const std::map<std::string, std::string> expected{{"a", std::string(50000, '\0')}, {"b", "second"}};
  EXPECT_EQ(parse_archive(bytes), expected);
  const std::string bare = bytes.substr(0, bytes.size() - 12);
  EXPECT_EQ(parse_archive(bare + std::string(65535, ' ')), expected);
  EXPECT_THROW(parse_archive(bare + std::string(70000, ' ')), InvalidInput);
}

TEST(ZipArchive, DamageIsSeen) {
  const std::string bytes = format_archive({{"name", "some content"}});
  std::string damaged = bytes;
  damaged[36] ^= 1;
  EXPECT_THROW(parse_archive(damaged), InvalidInput);
  for (size_t n = 0; n < bytes.size(); ++n)
    EXPECT_THROW(parse_archive(bytes.substr(0, n)), InvalidInput) << n;
}

}  // namespace
}  // namespace batten
