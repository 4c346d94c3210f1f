#include "batten/capture/keys.hpp"

#include <gtest/gtest.h>

namespace batten::test {
namespace {

constexpr int kNone = Mark::kUnnumbered;

/// All marks of keys pressed 0.1 s apart.
std::vector<Mark> marks_of(const std::vector<std::string>& keys, std::optional<int> n_nodes = std::nullopt) {
  KeyReader reader(n_nodes);
  std::vector<Mark> all;
  std::int64_t time = 0;
  for (const std::string& key : keys)
    for (const Mark& mark : reader.press(time += 100000, key)) all.push_back(mark);
  for (const Mark& mark : reader.wait(time + 5000000)) all.push_back(mark);
  return all;
}

TEST(KeyReader, ReadsNumbersOfSeveralDigitsAtTheTimeOfTheFirst) {
  const std::vector<Mark> expected = {{100000, MarkKind::Inner, kNone},
                                      {200000, MarkKind::Node, 12},
                                      {500000, MarkKind::Node, 3},
                                      {600000, MarkKind::End, kNone}};
  EXPECT_EQ(marks_of({"+", "1", "2", "enter", "3", "."}), expected);
}

TEST(KeyReader, TakesEachDigitForANodeWhereThereAreFewerThanTen) {
  const std::vector<Mark> expected = {{100000, MarkKind::Node, 1}, {200000, MarkKind::Node, 2}};
  EXPECT_EQ(marks_of({"1", "2", "enter"}, 9), expected);
  EXPECT_EQ(marks_of({"1", "2", "enter"}, 10), (std::vector<Mark>{{100000, MarkKind::Node, 12}}));
}

TEST(KeyReader, EndsANumberAfterTwoSeconds) {
  KeyReader reader;
  reader.press(0, "4");
  EXPECT_TRUE(reader.wait(1900000).empty());
  EXPECT_EQ(reader.wait(2100000), (std::vector<Mark>{{0, MarkKind::Node, 4}}));
}

TEST(KeyReader, TakesBackDigitsBeforeNodes) {
  const std::vector<Mark> expected = {{100000, MarkKind::Node, 1}, {500000, MarkKind::Undo, kNone}};
  EXPECT_EQ(marks_of({"1", "2", "backspace", "enter", "backspace"}), expected);
}

TEST(KeyReader, ReadsTheButtonsOfADevice) {
  const std::vector<Mark> expected = {{200000, MarkKind::Boundary, kNone},
                                      {300000, MarkKind::Node, kNone},
                                      {400000, MarkKind::Number, 5},
                                      {600000, MarkKind::Node, 7},
                                      {700000, MarkKind::End, kNone}};
  EXPECT_EQ(marks_of({"mode", "new", "node", "5", "enter", "node=7", "end", "tea"}), expected);
}

TEST(MarkBook, KeepsCurvesNodesAndPauses) {
  MarkBook book;
  for (const Mark& mark :
       {Mark{1, MarkKind::Boundary, kNone}, Mark{2, MarkKind::Node, 4}, Mark{3, MarkKind::Pause, kNone},
        Mark{5, MarkKind::Pause, kNone}, Mark{6, MarkKind::Node, 9}, Mark{7, MarkKind::Undo, kNone},
        Mark{8, MarkKind::Node, 4}, Mark{9, MarkKind::End, kNone}, Mark{10, MarkKind::Inner, kNone},
        Mark{11, MarkKind::Discard, kNone}})
    EXPECT_FALSE(book.apply(mark).has_value());
  ASSERT_EQ(book.curves().size(), 1U);
  const MarkedCurve& curve = book.curves()[0];
  EXPECT_TRUE(curve.boundary);
  EXPECT_TRUE(curve.closed());
  EXPECT_EQ(curve.nodes.size(), 2U);
  ASSERT_EQ(curve.pauses.size(), 1U);
  EXPECT_EQ(curve.pauses[0].second, 5);
  EXPECT_EQ(*curve.end_us, 9);
  EXPECT_EQ(book.current(), nullptr);
}

TEST(MarkBook, SaysWhatIsOdd) {
  MarkBook book;
  EXPECT_TRUE(book.apply({1, MarkKind::Node, 3}).has_value());  // no curve
  EXPECT_FALSE(book.apply({2, MarkKind::Inner, kNone}).has_value());
  EXPECT_TRUE(book.apply({3, MarkKind::Undo, kNone}).has_value());   // no node
  EXPECT_TRUE(book.apply({4, MarkKind::Inner, kNone}).has_value());  // the first was not finished
  EXPECT_EQ(*book.curves()[0].end_us, 4);
}

}  // namespace
}  // namespace batten::test
