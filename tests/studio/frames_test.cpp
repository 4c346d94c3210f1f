#include "studio/frames.hpp"

#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::studio {
namespace {

using Json = nlohmann::json;

template <typename T>
const T& only(const std::vector<Incoming>& complete) {
  EXPECT_EQ(complete.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<T>(complete.at(0)));
  return std::get<T>(complete.at(0));
}

TEST(Frames, ATextIsARequest) {
  FrameReader reader;
  const std::string text = R"({"id":4294967295,"op":"document"})";
  const auto complete = reader.text(text);
  EXPECT_EQ(only<Request>(complete).id, 4294967295U);
  EXPECT_EQ(only<Request>(complete).text, text);
  EXPECT_FALSE(only<Request>(complete).file.has_value());
  EXPECT_EQ(only<Request>(reader.text(R"({"id":1,"op":"open","file":7})")).file, 7U);
  EXPECT_EQ(only<Cancel>(reader.text(R"({"op":"cancel","target":7})")).target, 7U);
}

TEST(Frames, BytesFollowTheirAnnouncement) {
  FrameReader reader;
  EXPECT_TRUE(reader.text(R"({"id":1,"op":"open","name":"a.off","bytes":3})").empty());
  const auto complete = reader.binary(std::string("a\0b", 3));
  EXPECT_EQ(only<Request>(complete).bytes, std::string("a\0b", 3));
  EXPECT_TRUE(reader.text(R"({"id":2,"op":"open","bytes":0})").empty());
  EXPECT_EQ(only<Request>(reader.binary("")).id, 2U);
  // One announcement, one frame.
  EXPECT_FALSE(only<Problem>(reader.binary("abc")).id.has_value());
}

TEST(Frames, WrongOnesAreRefusedAndForgotten) {
  FrameReader reader;
  EXPECT_TRUE(reader.text(R"({"id":1,"op":"open","bytes":3})").empty());
  EXPECT_EQ(only<Problem>(reader.binary("abcd")).id, 1U);
  EXPECT_TRUE(reader.text(R"({"id":2,"op":"open","bytes":3})").empty());
  const auto complete = reader.text(R"({"id":3,"op":"document"})");
  ASSERT_EQ(complete.size(), 2U);
  EXPECT_EQ(std::get<Problem>(complete[0]).id, 2U);
  EXPECT_EQ(std::get<Request>(complete[1]).id, 3U);
  for (const char* text : {"",
                           "{",
                           "[]",
                           "null",
                           "{}",
                           R"({"id":1})",
                           R"({"op":"show"})",
                           R"({"id":-1,"op":"show"})",
                           R"({"id":1.5,"op":"show"})",
                           R"({"id":"1","op":"show"})",
                           R"({"id":4294967296,"op":"show"})",
                           R"({"id":1,"op":3})",
                           R"({"op":"cancel"})",
                           R"({"op":"cancel","target":-1})",
                           R"({"id":1,"op":"open","bytes":-1})",
                           R"({"id":1,"op":"open","bytes":"3"})",
                           R"({"id":1,"op":"open","file":-1})",
                           R"({"id":1,"op":"open","file":"a"})",
                           R"({"id":1,"op":"open","file":1,"bytes":3})",
                           R"({"id":1,"op":"open","bytes":67108865})",
                           R"({"id":1,"op":"open","bytes":1e3})"}) {
    EXPECT_FALSE(only<Problem>(reader.text(text)).sentence.empty()) << text;
  }
  EXPECT_FALSE(only<Problem>(reader.text(std::string(kMostText + 1, ' '))).sentence.empty());
  EXPECT_TRUE(std::holds_alternative<Request>(reader.text(R"({"id":1,"op":"show"})").at(0))) << "goes on";
}

// The bytes are written out by hand: they are what a page reads with a DataView.
TEST(Frames, AnArrayHasSixteenBytesBeforeItsElements) {
  const std::string head = encode({1, 258, 2, 1});
  EXPECT_EQ(head, std::string("\1\0\0\0\2\1\0\0\2\0\0\0\1\0\0\0", 16));
  const auto read = decode_array(head + std::string(8, 'x'));
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->id, 258U);
  EXPECT_EQ(read->count, 2U);
  EXPECT_FALSE(decode_array(head + std::string(7, 'x')));
  EXPECT_FALSE(decode_array(head + std::string(9, 'x')));
  EXPECT_FALSE(decode_array(head + std::string(12, 'x')));
  EXPECT_FALSE(decode_array(head.substr(0, 15)));
  EXPECT_FALSE(decode_array(encode({1, 0, 0, 4})));
  EXPECT_FALSE(decode_array(encode({2, 0, 0, 1})));
  EXPECT_TRUE(decode_array(encode({1, 0, 3, 3}) + "abc"));
}

TEST(Frames, AReplyNamesItsArraysInTheirOrder) {
  Reply reply;
  reply.text = R"({"ok":true,"kind":"mesh"})";
  const float positions[] = {0, 1, 2, 3, 4, 5};
  const std::uint32_t triangles[] = {0, 1, 1};
  const auto array = [](const char* name, ElementType type, int columns, const void* data, std::size_t n) {
    ReplyArray made{name, type, columns, std::vector<std::byte>(n)};
    std::memcpy(made.bytes.data(), data, n);
    return made;
  };
  reply.arrays = {array("positions", ElementType::Float32, 3, positions, sizeof positions),
                  array("triangles", ElementType::Uint32, 3, triangles, sizeof triangles),
                  array("file", ElementType::Uint8, 1, "abc", 3)};
  const std::vector<Frame> frames = frames_of(9, reply);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_TRUE(frames[0].is_text);
  EXPECT_EQ(Json::parse(frames[0].head), Json::parse(R"({"id":9,"ok":true,"kind":"mesh","arrays":[
      {"name":"positions","type":"float32","columns":3,"count":6},
      {"name":"triangles","type":"uint32","columns":3,"count":3},
      {"name":"file","type":"uint8","columns":1,"count":3}]})"));
  const std::uint32_t codes[] = {1, 2, 3}, counts[] = {6, 3, 3};
  for (std::size_t k = 0; k < 3; ++k) {
    const Frame& frame = frames[k + 1];
    EXPECT_FALSE(frame.is_text);
    std::string bytes = frame.head;
    for (const std::byte byte : frame.body) bytes += static_cast<char>(byte);
    const auto head = decode_array(bytes);
    ASSERT_TRUE(head.has_value()) << k;
    EXPECT_EQ(head->id, 9U);
    EXPECT_EQ(head->type, codes[k]);
    EXPECT_EQ(head->count, counts[k]);
  }
}

TEST(Frames, EventsAndFailuresAreJsonWhateverTheyQuote) {
  const Json event = Json::parse(progress_frame(3, "a \"stage\"\n\xff", 0.25).head);
  EXPECT_EQ(event["event"], "progress");
  EXPECT_EQ(event["fraction"], 0.25);
  const Json failure = Json::parse(failure_frame({}, "protocol", "\"").head);
  EXPECT_EQ(failure["id"], nullptr);
  EXPECT_EQ(failure["ok"], false);
  EXPECT_EQ(failure["arrays"].size(), 0U);
}

}  // namespace
}  // namespace batten::studio
