#include "batten/io/zip_archive.hpp"

#include <map>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

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
