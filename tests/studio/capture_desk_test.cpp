// The socket /capture: devices recorded, followed, replayed and made into scans, and what must not harm it.
#include "studio/capture_desk.hpp"

#include "scratch.hpp"
#include "studio/client.hpp"
#include "studio/frames.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "batten/capture/decode.hpp"
#include "batten/core/text.hpp"
#include "batten/io/scan_io.hpp"

namespace batten::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;
namespace fs = std::filesystem;

// As fast as it goes, and the same every time.
constexpr const char* kQuick = "simulator:bumpycube?speed=max&pace=40&rest=0.5";
// At rest for longer than a test lasts, slowly; of a kind that is not given up where a busy machine is late.
constexpr const char* kLong = "simulator:bumpycube?rest=60&device=line&speed=0.1";

fs::path empty_folder(const std::string& name) {
  const fs::path folder = fs::path(scratch()) / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

/// A value of the live view; null where there is none yet.
Json state(const Json& news, const char* key) {
  return news.is_object() && news["state"].is_object() ? news["state"][key] : Json();
}

/// A window: asks, and follows what it is told.
class Window {
 public:
  explicit Window(Studio& studio) : wire_(studio.open_socket(nullptr, "/capture")) {}

  Json ask(Json message) {
    message["id"] = ++id_;
    EXPECT_TRUE(wire_->send(masked(1, message.dump())));
    for (;;) {
      const Json heard = hear();
      if (heard.is_null() || heard["id"] == id_) {
        if (!heard.contains("event")) return heard;
      }
    }
  }

  /// The next text; what it says of the track is taken over.
  Json hear() {
    Received frame = receive_frame(*wire_);
    // A recording that is decoded on a busy machine is no news for longer than a wire waits.
    for (int k = 0; frame.opcode == 0 && k < 10; ++k) frame = receive_frame(*wire_);
    const Json json = Json::parse(frame.payload, nullptr, false);
    if (frame.opcode != 1 || !json.is_object()) return nullptr;
    for (const Json& array : json["arrays"]) {
      const Received bytes = receive_frame(*wire_);
      EXPECT_TRUE(studio::decode_array(bytes.payload).has_value());
      last_array = bytes.payload.substr(studio::ArrayHead::kSize);
      if (array["name"] != "points") continue;
      const auto first = json["first"].get<std::size_t>();
      EXPECT_LE(first * 5, points.size());
      points.resize(first * 5 + last_array.size() / 4);
      std::copy(last_array.begin(), last_array.end(), reinterpret_cast<char*>(points.data() + first * 5));
    }
    if (json.contains("event")) news.push_back(json);
    return json;
  }

  /// Hears until it is told so. Null where nothing comes any more.
  Json until(const std::function<bool(const Json&)>& is_so) {
    for (;;) {
      const Json heard = hear();
      if (heard.is_null() || (heard.contains("event") && is_so(heard))) return heard;
    }
  }
  Json until_over() {
    return until([](const Json& one) {
      return one["doing"] == "nothing" && (!one["report"].is_null() || !one["problem"].is_null());
    });
  }

  std::vector<Json> news;
  std::vector<float> points;  // of the track, five columns
  std::string last_array;

 private:
  std::unique_ptr<Wire> wire_;
  int id_ = 0;
};

Studio studio_with(const fs::path& folder, std::chrono::milliseconds alone = 60s) {
  studio::ServerOptions options;
  options.place = folder.string();
  options.limits.farewell = 100ms;
  options.limits.alone = alone;
  return Studio(options);
}

TEST(CaptureDesk, ListsSourcesAndRecordings) {
  const fs::path folder = empty_folder("desk_list");
  std::ofstream(folder / "old.blog") << "x";
  std::ofstream(folder / "hull.ply") << "x";
  Studio studio = studio_with(folder);
  Window window(studio);
  const Json list = window.ask({{"op", "sources"}});
  ASSERT_EQ(list["ok"], true) << list;
  EXPECT_EQ(list["sources"][0]["source"].get<std::string>().substr(0, 10), "simulator:");
  ASSERT_EQ(list["recordings"].size(), 1U);
  EXPECT_EQ(list["recordings"][0]["name"], "old.blog");
  EXPECT_EQ(list["folder"], "desk_list");
}

// The recording is that of the command, the track follows it, and its scan is that of `batten convert`.
TEST(CaptureDesk, RecordsADeviceAndMakesAScanOfIt) {
  const fs::path folder = empty_folder("desk_record");
  Studio studio = studio_with(folder);
  Window window(studio);
  ASSERT_EQ(
      window.ask({{"op", "record"}, {"source", kQuick}, {"name", "a b.blog"}, {"wheel_m", 0.0628}})["ok"],
      true);
  const Json over = window.until_over();
  ASSERT_TRUE(over["problem"].is_null()) << over;
  EXPECT_EQ(over["report"]["figures"]["end"], "the simulated motion is over");
  const std::string path = (folder / "a b.blog").string();
  const Recording recording = read_recording(path);
  EXPECT_EQ(recording.header.source, kQuick);
  EXPECT_EQ(recording.header.wheel_m, 0.0628);
  const DecodedRecording decoded = decode_recording(recording);
  EXPECT_EQ(over["report"]["figures"]["curves"], decoded.log.curves.size());
  EXPECT_EQ(over["report"]["figures"]["decoded"]["readings"], decoded.log.n_readings());
  EXPECT_EQ(over["state"]["curves"], decoded.log.curves.size());

  // The track of the preview stays within the object of 0.3 m, and its curves are as long as those of the
  // log.
  ASSERT_GT(window.points.size(), 5U * 200);
  double way = 0, largest = 0;
  for (std::size_t i = 5; i < window.points.size(); i += 5) {
    double squared = 0;
    for (std::size_t k = 1; k < 4; ++k) {
      squared += std::pow(window.points[i + k] - window.points[i + k - 5], 2);
      largest = std::max(largest, std::abs(static_cast<double>(window.points[i + k])));
    }
    if (window.points[i] == window.points[i - 5]) way += std::sqrt(squared);
  }
  double drawn = 0;
  for (std::size_t c = 0; c < decoded.log.curves.size(); ++c) {
    double longest = 0;
    for (long i = 0; i < decoded.log.n_readings(); ++i)
      if (decoded.log.curve[static_cast<std::size_t>(i)] == static_cast<int>(c))
        longest = std::max(longest, decoded.log.distance[i]);
    drawn += longest;
  }
  EXPECT_LT(largest, 0.4);
  EXPECT_NEAR(way, drawn, 0.1 * drawn);

  const Json scan = window.ask({{"op", "convert"}, {"file", over["file"]}, {"name", "a b.blog"}});
  ASSERT_EQ(scan["ok"], true) << scan;
  EXPECT_EQ(window.last_array, format_rawnet(scan_from_recording(decoded).scan));
}

TEST(CaptureDesk, KeysGoIntoTheRecording) {
  const fs::path folder = empty_folder("desk_keys");
  Studio studio = studio_with(folder);
  Window window(studio);
  EXPECT_EQ(window.ask({{"op", "key"}, {"key", "+"}})["ok"], false) << "nothing is being recorded";
  ASSERT_EQ(window.ask({{"op", "record"}, {"source", kLong}, {"name", "keys.blog"}, {"nodes", 30}})["ok"],
            true);
  window.until([](const Json& one) { return state(one, "readings") > 5; });
  for (const char* key : {"-", "1", "2"}) EXPECT_EQ(window.ask({{"op", "key"}, {"key", key}})["ok"], true);
  const Json typed = window.until([](const Json& one) { return state(one, "digits") == "12"; });
  EXPECT_EQ(typed["state"]["drawing"], true);
  for (const char* key : {"enter", "backspace", "/"})
    EXPECT_EQ(window.ask({{"op", "key"}, {"key", key}})["ok"], true);
  for (const char* key : {"q", "", "12", "new", "end", "x\n"})
    EXPECT_EQ(window.ask({{"op", "key"}, {"key", key}})["ok"], false) << key;
  EXPECT_EQ(window.ask({{"op", "key"}, {"key", 1}})["ok"], false);
  window.until([](const Json& one) { return state(one, "drawing") == false; });
  EXPECT_EQ(window.ask({{"op", "stop"}})["ok"], true);
  EXPECT_EQ(window.until_over()["report"]["figures"]["end"], "stopped");
  std::string keys;
  for (const CaptureEvent& event : read_recording((folder / "keys.blog").string()).events)
    if (event.kind == EventKind::Key) keys += event.payload + " ";
  EXPECT_NE(keys.find("- 1 2 enter backspace / "), std::string::npos) << keys;
}

TEST(CaptureDesk, NothingIsWrittenOutsideTheFolderOrOverAFile) {
  const fs::path folder = empty_folder("desk_paths/work");
  fs::create_directories(folder / "deep");
  std::ofstream(folder / "there.blog") << "kept";
  fs::create_symlink("../outside.blog", folder / "link.blog");
  Studio studio = studio_with(folder);
  Window window(studio);
  for (const char* name : {"../outside.blog", "/tmp/outside.blog", "deep/x.blog", "..\\x.blog", ".x.blog", "",
                           "x", "x.sh", "x.ply", "x.blog.gz", "x\n.blog", "there.blog", "link.blog"}) {
    const Json answer = window.ask({{"op", "record"}, {"source", kQuick}, {"name", name}});
    EXPECT_EQ(answer["ok"], false) << name;
    EXPECT_FALSE(answer["message"].get<std::string>().empty());
  }
  for (const char* source :
       {"file:there.blog", "line:/etc/passwd", "simulator:/etc/passwd.csv", "udp:0.0.0.0:9000"})
    EXPECT_EQ(window.ask({{"op", "record"}, {"source", source}, {"name", "new.blog"}})["ok"], false)
        << source;
  for (const Json& option :
       {Json{{"wheel_m", -1}}, Json{{"nodes", 1e9}}, Json{{"calibration", "{}"}}, Json{{"wheel_m", "x"}}}) {
    Json message = {{"op", "record"}, {"source", kQuick}, {"name", "new.blog"}};
    message.update(option);
    EXPECT_EQ(window.ask(message)["ok"], false) << option;
  }
  for (const Json& message :
       {Json{{"op", "replay"}, {"file", 77}, {"name", "x"}}, Json{{"op", "convert"}, {"name", "x"}},
        Json{{"op", "replay"}, {"name", "x"}}, Json{{"op", "nothing"}}, Json{{"op", "record"}}})
    EXPECT_EQ(window.ask(message)["ok"], false) << message;
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder.parent_path()))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"deep", "link.blog", "there.blog", "work"}));
  EXPECT_EQ(fs::file_size(folder / "there.blog"), 4U);
}

TEST(CaptureDesk, WithoutAFolderItSaysSo) {
  Studio studio;
  Window window(studio);
  EXPECT_TRUE(window.ask({{"op", "sources"}})["folder"].is_null());
  const Json answer = window.ask({{"op", "record"}, {"source", kQuick}, {"name", "x.blog"}});
  EXPECT_NE(answer["message"].get<std::string>().find("without a folder"), std::string::npos);
}

TEST(CaptureDesk, TheSocketIsForWindowsOfThisServer) {
  Studio studio;
  const HttpAnswer answer = studio.ask(
      "GET", "/capture", "Origin: " + studio.origin() + "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n");
  EXPECT_EQ(answer.status, 401);
  EXPECT_EQ(studio.ask("GET", "/capture").status, 426);
}

// A source that cannot be opened says why, and its name is free for the next attempt.
TEST(CaptureDesk, ASourceThatIsTakenIsTold) {
  const fs::path folder = empty_folder("desk_taken");
  Studio studio = studio_with(folder);
  Window window(studio);
  const std::string source = concat("ws://127.0.0.1:", studio.server().port());
  ASSERT_EQ(window.ask({{"op", "record"}, {"source", source}, {"name", "x.blog"}})["ok"], true);
  const Json over = window.until_over();
  EXPECT_FALSE(over["problem"].get<std::string>().empty());
  EXPECT_FALSE(fs::exists(folder / "x.blog"));
}

TEST(CaptureDesk, AnUnpluggedDeviceIsToldAndComesBack) {
  const fs::path folder = empty_folder("desk_unplug");
  Studio studio = studio_with(folder);
  Window window(studio);
  ASSERT_EQ(window.ask({{"op", "record"},
                        {"source", "simulator:bumpycube?rest=60&device=line&speed=0.5&unplug=0.3:0.6"},
                        {"name", "u.blog"}})["ok"],
            true);
  const auto device_is = [](const char* word) {
    return [word](const Json& one) {
      return one["state"].is_object() && state(one, "device").get<std::string>().rfind(word, 0) == 0;
    };
  };
  const Json lost = window.until(device_is("lost "));
  ASSERT_FALSE(lost.is_null());
  EXPECT_GT(lost["state"]["device"].get<std::string>().size(), 10U) << "with a reason";
  EXPECT_EQ(window.ask({{"op", "record"}, {"source", kQuick}, {"name", "second.blog"}})["ok"], false)
      << "one at a time";
  const long before = lost["state"]["readings"];
  const Json back = window.until([&](const Json& one) { return state(one, "readings") > before + 20; });
  ASSERT_FALSE(back.is_null());
  EXPECT_EQ(back["state"]["device"], "back");
  EXPECT_GE(back["state"]["gaps"], 1);
  window.ask({{"op", "stop"}});
  EXPECT_EQ(window.until_over()["report"]["figures"]["losses"], 1);
  EXPECT_FALSE(fs::exists(folder / "second.blog"));
}

TEST(CaptureDesk, ReplaysARecordingByItsNumber) {
  const fs::path folder = empty_folder("desk_replay");
  Studio studio = studio_with(folder);
  Window window(studio);
  ASSERT_EQ(window.ask({{"op", "record"}, {"source", kQuick}, {"name", "x.blog"}, {"wheel_m", 0.0628}})["ok"],
            true);
  const Json recorded = window.until_over();
  ASSERT_EQ(
      window.ask({{"op", "replay"}, {"file", recorded["file"]}, {"name", "x.blog"}, {"speed", 0}})["ok"],
      true);
  const Json replayed =
      window.until([&](const Json& one) { return one["id"] != recorded["id"] && one["doing"] == "nothing"; });
  EXPECT_EQ(replayed["report"]["figures"]["decoded"], recorded["report"]["figures"]["decoded"]);
  EXPECT_EQ(replayed["state"]["readings"], recorded["state"]["readings"]);
  for (const Json& speed : {Json(-1), Json(1e9), Json("fast")})
    EXPECT_EQ(window.ask(
                  {{"op", "replay"}, {"file", recorded["file"]}, {"name", "x.blog"}, {"speed", speed}})["ok"],
              false);
  // Something else under the name of a recording.
  std::ofstream(folder / "rubbish.blog") << "rubbish\n";
  const Json list = window.ask({{"op", "sources"}});
  for (const char* op : {"replay", "convert"}) {
    Json message = {{"op", op}, {"file", list["recordings"][0]["number"]}, {"name", "rubbish.blog"}};
    ASSERT_EQ(list["recordings"][0]["name"], "rubbish.blog");
    const Json answer = window.ask(message);
    if (op == std::string("convert")) {
      EXPECT_EQ(answer["ok"], false);
    } else {
      EXPECT_FALSE(window.until_over()["problem"].is_null());
    }
  }
}

TEST(CaptureDesk, AWindowThatComesBackFindsTheCapture) {
  const fs::path folder = empty_folder("desk_back");
  Studio studio = studio_with(folder);
  int run = 0;
  {
    Window window(studio);
    ASSERT_EQ(window.ask({{"op", "record"}, {"source", kLong}, {"name", "x.blog"}})["ok"], true);
    run = window.until([](const Json& one) { return state(one, "readings") > 5; })["id"];
  }
  Window again(studio), other(studio);
  for (Window* window : {&again, &other}) {
    const Json news = window->until([](const Json& one) { return one["doing"] == "record"; });
    EXPECT_EQ(news["id"], run);
    EXPECT_EQ(news["name"], "x.blog");
  }
  other.ask({{"op", "stop"}});
  EXPECT_FALSE(again.until_over().is_null());
}

TEST(CaptureDesk, ACaptureThatNobodyFollowsEnds) {
  const fs::path folder = empty_folder("desk_alone");
  Studio studio = studio_with(folder, 300ms);
  {
    Window window(studio);
    ASSERT_EQ(window.ask({{"op", "record"}, {"source", kLong}, {"name", "x.blog"}})["ok"], true);
    window.until([](const Json& one) { return state(one, "readings") > 5; });
    // Longer than the time for which it may be alone: it is not.
    const auto begin = std::chrono::steady_clock::now();
    window.until([&](const Json&) { return std::chrono::steady_clock::now() - begin > 1500ms; });
    EXPECT_EQ(window.news.back()["doing"], "record");
  }
  std::this_thread::sleep_for(2500ms);
  Window window(studio);
  const Json over = window.until_over();
  ASSERT_FALSE(over.is_null());
  EXPECT_EQ(over["report"]["figures"]["end"], "stopped");
}

TEST(CaptureDesk, TheEndOfTheServerLeavesAWholeRecording) {
  const fs::path folder = empty_folder("desk_end");
  {
    Studio studio = studio_with(folder);
    Window window(studio);
    ASSERT_EQ(window.ask({{"op", "record"}, {"source", kLong}, {"name", "x.blog"}})["ok"], true);
    window.until([](const Json& one) { return state(one, "readings") > 20; });
    studio.server().stop();
  }
  const Recording recording = read_recording((folder / "x.blog").string());
  EXPECT_TRUE(recording.warnings.empty());
  EXPECT_GT(recording.events.size(), 20U);
  EXPECT_EQ(recording.events.back().payload, "end");
}

/// A desk without sockets: what it sends to a window is counted, and taken when the test says so.
struct Desk {
  explicit Desk(const fs::path& place) : folder(place.string()), desk(&folder, 60s) {
    studio::Service::Hooks hooks;
    hooks.send = [this](std::vector<studio::Frame> frames) {
      const std::lock_guard lock(mutex);
      ++n_messages;
      last_text = frames[0].head;
      std::size_t size = 0;
      for (const studio::Frame& frame : frames) size += frame.size();
      unsent += size;
      largest = std::max(largest, size);
    };
    hooks.ended = [] {};
    window = desk.window(std::move(hooks));
  }

  void ask(const Json& message) { window->ask({1, message.dump(), {}, {}}, {}); }
  void take() {
    std::size_t n = 0;
    {
      const std::lock_guard lock(mutex);
      n = std::exchange(unsent, 0);
    }
    window->sent(n);
  }
  int count() {
    const std::lock_guard lock(mutex);
    return n_messages;
  }
  Json last() {
    const std::lock_guard lock(mutex);
    return Json::parse(last_text);
  }

  std::mutex mutex;
  int n_messages = 0;
  std::string last_text = "{}";
  std::size_t unsent = 0, largest = 0;
  studio::Folder folder;
  studio::CaptureDesk desk;
  std::unique_ptr<studio::Service> window;  // last: it sends into the above
};

// A window that takes nothing is sent one message and no more; the recording does not wait for it.
TEST(CaptureDesk, ASlowWindowMissesStatesAndTheRecordingNothing) {
  const fs::path folder = empty_folder("desk_slow");
  Desk desk(folder);
  for (int k = 0; k < 100 && desk.count() < 1; ++k) std::this_thread::sleep_for(10ms);
  desk.take();
  desk.ask({{"op", "record"}, {"source", kQuick}, {"name", "x.blog"}});
  std::this_thread::sleep_for(100ms);
  const int n = desk.count();
  for (int k = 0; k < 300 && !fs::exists(folder / "x.blog"); ++k) std::this_thread::sleep_for(10ms);
  std::uintmax_t size = 0;
  for (int k = 0; k < 100; ++k) {  // until it does not grow any more
    std::this_thread::sleep_for(200ms);
    const std::uintmax_t now = fs::file_size(folder / "x.blog");
    if (now == size && now > 10000) break;
    size = now;
  }
  EXPECT_EQ(read_recording((folder / "x.blog").string()).events.back().payload, "end");
  EXPECT_LE(desk.count(), n + 1);
  Json last;
  for (int k = 0; k < 200; ++k) {
    desk.take();
    std::this_thread::sleep_for(30ms);
    last = desk.last();
    if (last["doing"] == "nothing" && !last["report"].is_null()) break;
  }
  EXPECT_EQ(last["state"]["curves"], last["report"]["figures"]["curves"])
      << "what it is told at last is all of it";
}

// Ten minutes at 100 Hz, in virtual time: no message and no track grows with them.
TEST(CaptureDesk, TenMinutesDoNotGrow) {
  const fs::path folder = empty_folder("desk_growth");
  Desk desk(folder);
  desk.ask(
      {{"op", "record"}, {"source", "simulator:bumpycube?speed=max&pace=1.7&flip=1%"}, {"name", "x.blog"}});
  Json last;
  for (int k = 0; k < 3000; ++k) {
    desk.take();
    std::this_thread::sleep_for(10ms);
    last = desk.last();
    if (last.contains("report") && last["doing"] == "nothing" && !last["report"].is_null()) break;
  }
  ASSERT_TRUE(last.contains("report")) << last;
  EXPECT_GT(last["state"]["seconds"], 600);
  EXPECT_GT(last["report"]["figures"]["decoded"]["readings"], 48000) << "four of five packets are whole";
  EXPECT_LT(desk.largest, studio::LiveTrack::kMostPoints * studio::LiveTrack::kColumns * 4 + 4096);
}

}  // namespace
}  // namespace batten::test
