#include "batten/camera/grey_image.hpp"

#include <gtest/gtest.h>

namespace batten::test {
namespace {

TEST(GreyImage, StoresItsRowsFromTopToBottom) {
  const GreyImage image{3, 2, {1, 2, 3, 4, 5, 6}};
  EXPECT_EQ(image.at(0, 0), 1);
  EXPECT_EQ(image.at(2, 0), 3);
  EXPECT_EQ(image.at(0, 1), 4);
  EXPECT_EQ(image.at(2, 1), 6);
}

}  // namespace
}  // namespace batten::test
