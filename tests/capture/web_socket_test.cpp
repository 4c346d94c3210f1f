#include "batten/capture/web_socket.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

std::string request(const std::string& more) {
  return "GET /chat HTTP/1.1\r\nHost: 127.0.0.1:8765\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n" +
         more + "\r\n";
}

/// A frame as a client sends it.
std::string masked(unsigned first, const std::string& payload) {
  std::string frame(1, static_cast<char>(first));
  frame += static_cast<char>(0x80U | payload.size());
  const std::string mask = "\x37\xfa\x21\x3d";
  frame += mask;
  for (std::size_t i = 0; i < payload.size(); ++i) frame += static_cast<char>(payload[i] ^ mask[i % 4]);
  return frame;
}

// Key and answer are the example of RFC 6455, 1.3.
TEST(AnswerHandshake, IsThatOfTheStandard) {
  const WebSocketHandshake handshake = answer_handshake(request(""));
  EXPECT_TRUE(handshake.accepted);
  EXPECT_NE(handshake.answer.find("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"),
            std::string::npos);
}

TEST(AnswerHandshake, RefusesPagesOfOtherSites) {
  EXPECT_FALSE(answer_handshake(request("Origin: https://example.org\r\n")).accepted);
  EXPECT_FALSE(answer_handshake(request("Origin: null\r\n")).accepted);
  EXPECT_TRUE(answer_handshake(request("Origin: http://127.0.0.1:8080\r\n")).accepted);
  EXPECT_TRUE(answer_handshake(request("origin: http://localhost\r\n")).accepted);
  EXPECT_FALSE(answer_handshake("POST / HTTP/1.1\r\n\r\n").accepted);
  EXPECT_FALSE(answer_handshake("GET / HTTP/1.1\r\n\r\n").accepted);
}

// "Hello" masked is the example of RFC 6455, 5.7; the mask is the same.
TEST(WebSocketFrames, UnmasksTheExampleOfTheStandard) {
  WebSocketFrames frames;
  EXPECT_EQ(frames.push("\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58"), "Hello\n");
}

TEST(WebSocketFrames, JoinsPartsAndAnswersPings) {
  WebSocketFrames frames;
  const std::string stream =
      masked(0x01, "one ") + masked(0x89, "hi") + masked(0x80, "line") + masked(0x88, "");
  std::string text;
  for (const char byte : stream) text += frames.push(std::string(1, byte));
  EXPECT_EQ(text, "one line\n");
  EXPECT_EQ(frames.take_answers(), std::string("\x8a\x02hi\x88\x00", 6));
  EXPECT_TRUE(frames.closed());
}

TEST(WebSocketFrames, RefusesWhatIsNotMaskedOrTooLargeOrNoText) {
  EXPECT_THROW(WebSocketFrames().push(std::string("\x81\x01x", 3)), InvalidInput);
  EXPECT_THROW(WebSocketFrames().push("\x81\xff"), InvalidInput);
  EXPECT_THROW(WebSocketFrames().push(masked(0x82, "binary")), InvalidInput);
}

TEST(TextFrame, HasTheLengthOfItsText) {
  EXPECT_EQ(text_frame("ab"),
            "\x81\x02"
            "ab");
  EXPECT_EQ(text_frame(std::string(300, 'x')).substr(0, 4), std::string("\x81\x7e\x01\x2c", 4));
}

}  // namespace
}  // namespace batten::test
