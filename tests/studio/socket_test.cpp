// The socket /engine: messages in, replies and arrays out, cancel, and what must not harm it.
#include "scratch.hpp"
#include "studio/client.hpp"
#include "studio/engine_thread.hpp"
#include "studio/frames.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

/// Engines in tests: "work" goes on until it is cancelled, "much" answers with an array of as many bytes as
/// it is told, all else with the message and its bytes.
studio::MakeHandle scripted(
    std::shared_ptr<std::atomic<int>> n_alive = std::make_shared<std::atomic<int>>(0)) {
  return [n_alive]() -> studio::Handle {
    struct Life {
      std::shared_ptr<std::atomic<int>> n;
      explicit Life(std::shared_ptr<std::atomic<int>> count) : n(std::move(count)) { ++*n; }
      ~Life() { --*n; }
    };
    return [life = std::make_shared<Life>(n_alive)](std::string_view text, std::string_view bytes,
                                                    const Progress& progress) {
      const Json message = Json::parse(text);
      Reply reply;
      if (message["op"] == "work") {
        for (int k = 0;; ++k) {
          progress.report("work", 0.001 * (k % 1000));
          std::this_thread::sleep_for(1ms);
        }
      } else if (message["op"] == "throw") {
        throw std::runtime_error("thrown");
      } else if (message["op"] == "much") {
        reply.text = R"({"ok":true})";
        reply.arrays.push_back(
            {"much", ElementType::Uint8, 1, std::vector<std::byte>(message["size"].get<std::size_t>())});
      } else {
        reply.text = Json{{"ok", true}, {"n_bytes", bytes.size()}, {"echo", message}}.dump();
      }
      return reply;
    };
  };
}

studio::ServerOptions with_script() {
  studio::ServerOptions options;
  options.engine = scripted();
  options.limits.farewell = 200ms;
  return options;
}

void send_json(Wire& wire, const Json& json) {
  ASSERT_TRUE(wire.send(masked(1, json.dump())));
}

TEST(Socket, TakesBytesAndAnswersInOrder) {
  Studio studio(with_script());
  const auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  send_json(*wire, {{"id", 1}, {"op", "a"}});
  send_json(*wire, {{"id", 2}, {"op", "b"}, {"bytes", 70000}});
  wire->send(masked(2, std::string(70000, 'x')));
  send_json(*wire, {{"id", 3}, {"op", "throw"}});
  for (int id = 1; id <= 3; ++id) {
    const Json reply = Json::parse(receive_reply(*wire).text);
    EXPECT_EQ(reply["id"], id);
    EXPECT_EQ(reply["ok"], id != 3);
    if (id == 2) {
      EXPECT_EQ(reply["n_bytes"], 70000);
    }
  }
}

// A file of the folder goes to the engine by its number, whatever its length; the page never sees its bytes.
TEST(Socket, OpensFilesOfTheFolderByNumber) {
  studio::ServerOptions options = with_script();
  const std::filesystem::path folder = std::filesystem::path(scratch()) / "socket";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "hull.ply") << std::string(100000, 'x');
  std::ofstream(folder / "gone.ply") << "x";
  options.place = folder.string();
  Studio studio(options);
  const auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  send_json(*wire, {{"id", 1}, {"op", "open"}, {"file", 1}});
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["ok"], false) << "the list gives the numbers";
  EXPECT_EQ(studio.ask_as_page("GET", "/files").status, 200);
  std::filesystem::remove(folder / "gone.ply");
  send_json(*wire, {{"id", 2}, {"op", "open"}, {"file", 1}});
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["n_bytes"], 100000);
  for (const int number : {0, 2, 1000000}) {
    send_json(*wire, {{"id", 3}, {"op", "open"}, {"file", number}});
    const Json reply = Json::parse(receive_reply(*wire).text);
    EXPECT_EQ(reply["kind"], "error") << reply;
  }
}

// The real engine: a tetrahedron goes in as a file and comes out as arrays.
TEST(Socket, CarriesTheEngine) {
  studio::ServerOptions options;
  options.limits.farewell = 200ms;
  Studio studio(options);
  const auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  const std::string off = "OFF\n4 4 0\n0 0 0\n2 0 0\n0 2 0\n0 0 2\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  send_json(*wire, {{"id", 1}, {"op", "open"}, {"name", "tetra.off"}, {"bytes", off.size()}});
  wire->send(masked(2, off));
  const Json opened = Json::parse(receive_reply(*wire).text);
  ASSERT_EQ(opened["ok"], true) << opened;
  send_json(*wire, {{"id", 2}, {"op", "show"}, {"object", opened["object"]}});
  const SocketReply shown = receive_reply(*wire);
  const Json json = Json::parse(shown.text);
  ASSERT_EQ(json["ok"], true) << json;
  EXPECT_EQ(json["kind"], "mesh");
  const Json origin = json["origin"];
  bool has_positions = false, has_triangles = false;
  for (std::size_t k = 0; k < shown.arrays.size(); ++k) {
    const Json& array = json["arrays"][k];
    const auto head = studio::decode_array(shown.arrays[k]);
    ASSERT_TRUE(head.has_value()) << array;
    EXPECT_EQ(head->id, 2U);
    EXPECT_EQ(head->count, array["count"].get<std::uint32_t>());
    if (array["name"] == "positions") {
      has_positions = true;
      std::vector<float> values(head->count);
      std::memcpy(values.data(), shown.arrays[k].data() + studio::ArrayHead::kSize, 4 * values.size());
      float largest = 0;  // of x; corners at sharp edges come once for every side
      for (std::size_t i = 0; i < values.size(); i += 3) largest = std::max(largest, values[i]);
      EXPECT_EQ(values.size() % 3, 0U);
      EXPECT_NEAR(largest + origin[0].get<double>(), 2.0, 1e-6);
    }
    if (array["name"] == "triangles") {
      has_triangles = true;
      EXPECT_EQ(head->count, 12U);
      EXPECT_EQ(array["type"], "uint32");
      EXPECT_EQ(array["columns"], 3);
    }
  }
  EXPECT_TRUE(has_positions && has_triangles) << json;
  send_json(*wire, {{"id", 3}, {"op", "no such"}});
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["ok"], false);
}

TEST(Socket, CancelStopsWhatRunsAndWhatWaits) {
  Studio studio(with_script());
  const auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  send_json(*wire, {{"id", 1}, {"op", "work"}});
  send_json(*wire, {{"id", 2}, {"op", "work"}});
  send_json(*wire, {{"id", 3}, {"op", "a"}});
  const Json event = Json::parse(receive_frame(*wire).payload);  // it runs
  EXPECT_EQ(event["event"], "progress");
  EXPECT_EQ(event["id"], 1);
  EXPECT_EQ(event["stage"], "work");
  send_json(*wire, {{"op", "cancel"}, {"target", 99}});  // nobody: nothing happens
  send_json(*wire, {{"op", "cancel"}, {"target", 2}});
  const Json waiting = Json::parse(receive_reply(*wire).text);
  EXPECT_EQ(waiting["id"], 2);
  EXPECT_EQ(waiting["kind"], "cancelled");
  send_json(*wire, {{"op", "cancel"}, {"target", 1}});
  const Json running = Json::parse(receive_reply(*wire).text);
  EXPECT_EQ(running["id"], 1);
  EXPECT_EQ(running["kind"], "cancelled");
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["id"], 3) << "the next one is carried out";
}

TEST(Socket, ProgressComesAtMostEvery50Milliseconds) {
  Studio studio(with_script());
  const auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  const auto begin = std::chrono::steady_clock::now();
  send_json(*wire, {{"id", 1}, {"op", "work"}});
  std::this_thread::sleep_for(300ms);
  send_json(*wire, {{"op", "cancel"}, {"target", 1}});
  const SocketReply reply = receive_reply(*wire);
  const auto took =
      std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - begin);
  EXPECT_GE(reply.events.size(), 2U);
  EXPECT_LE(static_cast<long>(reply.events.size()), took.count() / 50 + 1);
}

TEST(Socket, BrokenMessagesAreAnsweredAndTheSocketGoesOn) {
  Studio studio(with_script());
  const auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  for (const char* text : {"", "{", "[]", "{\"id\":1}", "{\"id\":-1,\"op\":\"a\"}"}) {
    wire->send(masked(1, text));
    const Json reply = Json::parse(receive_reply(*wire).text);
    EXPECT_EQ(reply["kind"], "protocol") << text;
  }
  wire->send(masked(2, "abc"));
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["kind"], "protocol");
  send_json(*wire, {{"id", 7}, {"op", "a"}, {"bytes", 4}});
  wire->send(masked(2, "abc"));
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["id"], 7);
  send_json(*wire, {{"id", 8}, {"op", "a"}});
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["ok"], true);
}

TEST(Socket, FramesThatBreakTheProtocolCloseIt) {
  Studio studio(with_script());
  const std::string unmasked("\x81\x02{}", 4);
  const std::string frames[] = {
      unmasked,
      masked(3, "x"),                         // an opcode that there is not
      masked(1, "\xff\xfe"),                  // no UTF-8
      masked(9, std::string(126, 'x')),       // a ping that is too long
      masked(2, "", std::uint64_t{1} << 30),  // announces 1 GB
      masked(2, "", ~std::uint64_t{0}),
      masked(1, "", (std::uint64_t{64} << 20) + 1),
  };
  for (const std::string& frame : frames) {
    const auto wire = studio.open_socket();
    ASSERT_TRUE(wire);
    wire->send(frame);
    EXPECT_TRUE(wire->closes_within(2s));
  }
  EXPECT_NE(studio.told().find("a frame above 67108864 bytes"), std::string::npos) << studio.told();
  EXPECT_TRUE(studio.open_socket());
}

TEST(Socket, ThereAreEightAtMost) {
  Studio studio(with_script());
  std::vector<std::unique_ptr<Wire>> wires;
  for (int k = 0; k < 8; ++k) {
    wires.push_back(studio.open_socket());
    ASSERT_TRUE(wires.back());
  }
  int status = 0;
  EXPECT_FALSE(studio.open_socket(&status));
  EXPECT_EQ(status, 503);
  send_json(*wires[3], {{"id", 1}, {"op", "a"}});
  EXPECT_EQ(Json::parse(receive_reply(*wires[3]).text)["ok"], true);
  wires.pop_back();  // closed without a word
  std::unique_ptr<Wire> next;
  for (int k = 0; k < 100 && !next; ++k) {
    std::this_thread::sleep_for(10ms);
    next = studio.open_socket(&status);
  }
  EXPECT_TRUE(next) << "its place becomes free";
}

// Whatever state the answer is in that makes a connection a socket: one write at a time, and no socket holds
// the end up.
TEST(Socket, TheServerStopsWhileSocketsAreBeingOpened) {
  for (int k = 0; k < 50; ++k) {
    Studio studio(with_script());
    studio.cookie();
    std::vector<std::unique_ptr<Wire>> wires;
    for (int i = 0; i < 1 + k % 8; ++i) wires.push_back(studio.begin_socket());
    if (k % 2 == 1) {
      EXPECT_EQ(wires[0]->answer().status, 101);
    }
  }
}

TEST(Socket, AClientThatDoesNotReadIsDropped) {
  studio::ServerOptions options = with_script();
  options.limits.write = 150ms;
  Studio studio(options);
  const auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  // More than the system holds for a client; the time for it is 150 ms, and no second for each whole MiB.
  for (int k = 0; k < 20; ++k) send_json(*wire, {{"id", k}, {"op", "much"}, {"size", 1000000}});
  std::this_thread::sleep_for(400ms);
  for (int k = 0; k < 100 && studio.told().empty(); ++k) std::this_thread::sleep_for(20ms);
  EXPECT_NE(studio.told().find("too slowly"), std::string::npos) << studio.told();
  EXPECT_TRUE(studio.open_socket());
}

TEST(Socket, TooManyRequestsAreAnsweredAsBusy) {
  Studio studio(with_script());
  const auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  send_json(*wire, {{"id", 0}, {"op", "work"}});
  EXPECT_EQ(Json::parse(receive_frame(*wire).payload)["event"], "progress");
  const int most = static_cast<int>(studio::EngineThread::kMostWaiting);
  for (int k = 1; k <= most + 1; ++k) send_json(*wire, {{"id", k}, {"op", "a"}});
  const Json busy = Json::parse(receive_reply(*wire).text);
  EXPECT_EQ(busy["kind"], "busy");
  EXPECT_EQ(busy["id"], most + 1);
  send_json(*wire, {{"op", "cancel"}, {"target", 0}});
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["kind"], "cancelled");
  EXPECT_EQ(Json::parse(receive_reply(*wire).text)["id"], 1);
}

TEST(Socket, ClosingStopsItsWork) {
  studio::ServerOptions options = with_script();
  const auto n_alive = std::make_shared<std::atomic<int>>(0);
  options.engine = scripted(n_alive);
  Studio studio(options);
  {
    const auto wire = studio.open_socket();
    ASSERT_TRUE(wire);
    send_json(*wire, {{"id", 1}, {"op", "work"}});
    EXPECT_EQ(Json::parse(receive_frame(*wire).payload)["event"], "progress");
    EXPECT_EQ(n_alive->load(), 1);
  }
  for (int k = 0; k < 200 && n_alive->load() > 0; ++k) std::this_thread::sleep_for(5ms);
  EXPECT_EQ(n_alive->load(), 0);
}

TEST(Socket, TheEndOfTheServerIsSaidAndStopsTheWork) {
  studio::ServerOptions options = with_script();
  const auto n_alive = std::make_shared<std::atomic<int>>(0);
  options.engine = scripted(n_alive);
  Studio studio(options);
  const auto working = studio.open_socket(), idle = studio.open_socket();
  ASSERT_TRUE(working && idle);
  send_json(*working, {{"id", 1}, {"op", "work"}});
  EXPECT_EQ(Json::parse(receive_frame(*working).payload)["event"], "progress");
  studio.server().stop();
  EXPECT_EQ(n_alive->load(), 0);
  const Received last = receive_frame(*idle);
  EXPECT_EQ(last.opcode, 8);
  EXPECT_EQ(last.payload.substr(0, 2), "\x03\xe9") << "1001, going away";
  studio.server().stop();  // again: nothing happens
}

// A browser answers the farewell when the engine of its socket is long gone.
TEST(Socket, ClientsMayAnswerTheFarewell) {
  studio::ServerOptions options = with_script();
  options.limits.farewell = 3000ms;
  Studio studio(options);
  auto wire = studio.open_socket();
  ASSERT_TRUE(wire);
  std::thread browser([&wire] {
    EXPECT_EQ(receive_frame(*wire).opcode, 8);
    std::this_thread::sleep_for(100ms);
    wire->send(masked(8, "\x03\xe9"));
    wire.reset();
  });
  const auto begin = std::chrono::steady_clock::now();
  studio.server().stop();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2500ms) << "it need not wait for the whole farewell";
  browser.join();
}

}  // namespace
}  // namespace batten::test
