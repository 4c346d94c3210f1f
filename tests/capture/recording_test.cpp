#include "batten/capture/recording.hpp"

#include "scratch.hpp"

#include <algorithm>
#include <csignal>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/io/file.hpp"

namespace batten::test {
namespace {

std::vector<CaptureEvent> sample_events(int n) {
  std::vector<CaptureEvent> events;
  for (int i = 0; i < n; ++i) {
    const auto time = std::int64_t{10000} * i + 7;
    if (i % 5 == 4)
      events.push_back({time, "keys", EventKind::Key, "+"});
    else if (i % 2 == 0)
      events.push_back({time, "device", EventKind::Packet, std::string("\x00\xff,\n\\", 5)});
    else
      events.push_back({time, "device", EventKind::Line, "S,1,2\\x,\xc3\xa4\t" + std::to_string(i)});
  }
  return events;
}

std::string file_of(const std::vector<CaptureEvent>& events) {
  const std::string path = scratch_file("events.blog");
  std::remove(path.c_str());
  RecordingHeader header;
  header.source = "simulator:sphere?a=b";
  RecordingWriter(path, header).append(events);
  return read_file(path);
}

TEST(Recording, BringsBackEveryByteOfEveryEvent) {
  const std::vector<CaptureEvent> events = sample_events(200);
  const Recording recording = parse_recording(file_of(events), "events.blog");
  EXPECT_EQ(recording.events, events);
  EXPECT_EQ(recording.header.source, "simulator:sphere?a=b");
  EXPECT_TRUE(recording.warnings.empty());
}

TEST(Recording, BringsBackItsHeader) {
  const std::string path = scratch_file("header.blog");
  RecordingHeader header;
  header.source = "udp:9000";
  header.wheel_m = 0.0628;
  header.axes = DeviceAxes{{0, -1, 0}, {1, 0, 0}};
  header.n_nodes = 8;
  header.form = "le-tc";
  header.calibration = "{\"a\": [1, 2]}";
  RecordingWriter(path, header, true).sync();
  const RecordingHeader read = read_recording(path).header;
  EXPECT_EQ(read.wheel_m, header.wheel_m);
  EXPECT_EQ(read.axes->forward, header.axes->forward);
  EXPECT_EQ(read.axes->normal, header.axes->normal);
  EXPECT_EQ(read.n_nodes, header.n_nodes);
  EXPECT_EQ(read.form, header.form);
  EXPECT_EQ(read.calibration, header.calibration);
}

// Wherever the file is cut, all whole lines are there, and a torn one is told.
TEST(Recording, LosesNothingButATornLastLineWhereverItIsCut) {
  const std::vector<CaptureEvent> events = sample_events(60);
  const std::string text = file_of(events);
  const std::size_t body = text.find("#events");
  const std::size_t first = text.find('\n', body) + 1;
  Random random(5);
  for (int trial = 0; trial < 1000; ++trial) {
    const std::size_t length = first + random.below(text.size() - first + 1);
    const std::string cut = text.substr(0, length);
    const Recording recording = parse_recording(cut, "cut.blog");
    const auto whole =
        static_cast<std::size_t>(std::count(cut.begin() + static_cast<long>(first), cut.end(), '\n'));
    ASSERT_EQ(recording.events.size(), whole);
    for (std::size_t i = 0; i < whole; ++i) ASSERT_EQ(recording.events[i], events[i]);
    ASSERT_EQ(recording.warnings.size(), cut.back() == '\n' ? 0U : 1U);
  }
}

// A killed process: all that append() came back from is there. What a child reports over a pipe was appended.
TEST(Recording, SurvivesTheDeathOfItsProcess) {
  for (int trial = 0; trial < 20; ++trial) {
    const std::string path = scratch_file("killed.blog");
    std::remove(path.c_str());
    int channel[2];
    ASSERT_EQ(pipe(channel), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      RecordingWriter writer(path, {});
      for (std::int64_t i = 0;; ++i) {
        writer.append({{i * 1000, "device", EventKind::Line, std::to_string(i)}});
        if (write(channel[1], "x", 1) != 1) _exit(1);
      }
    }
    close(channel[1]);
    long appended = 0;
    char byte = 0;
    for (; appended < 20 + 37 * trial; ++appended) ASSERT_EQ(read(channel[0], &byte, 1), 1);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    while (read(channel[0], &byte, 1) == 1) ++appended;
    close(channel[0]);
    const Recording recording = read_recording(path);
    ASSERT_GE(static_cast<long>(recording.events.size()), appended);
    for (std::size_t i = 0; i < recording.events.size(); ++i)
      ASSERT_EQ(recording.events[i].payload, std::to_string(i));
  }
}

TEST(Recording, LinesThatCannotBeReadAreLeftOutAndTold) {
  const Recording recording = parse_recording(
      "#batten-recording 1\n#events x\n0.000001,device,line,a\nnonsense\n0.000002,device,line,b\n", "x.blog");
  EXPECT_EQ(recording.events.size(), 2U);
  ASSERT_EQ(recording.warnings.size(), 1U);
  EXPECT_NE(recording.warnings[0].find("line 4"), std::string::npos);
}

void expect_refused(const std::string& text, const std::string& word) {
  try {
    parse_recording(text, "x.blog");
    ADD_FAILURE() << text;
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST(Recording, RefusesWhatItCannotReadInWords) {
  expect_refused("#batten-recording 2\n", "newer");
  expect_refused("time_s,curve\n", "no recording");
  expect_refused("", "empty");
  expect_refused("#batten-rec", "header");
  expect_refused("#batten-recording 1\n#wheel_m -1\n", "wheel");
}

TEST(ParseEvent, RefusesLinesOfAnotherForm) {
  for (const char* line :
       {"", "1.0,device,line,x", "1.000000,device,line", "1.000000,Device,line,x", "1.000000,device,word,x",
        "1.000000,device,packet,0", "1.000000,device,packet,0g", "1.000000,device,line,\\x0",
        "-1.000000,device,line,x", "99999999999.000000,d,line,x"})
    EXPECT_THROW(parse_event(line), InvalidInput) << line;
}

TEST(RecordingWriter, DoesNotReplaceARecordingUnlessTold) {
  const std::string path = scratch_file("there.blog");
  RecordingWriter(path, {}, true).append(sample_events(3));
  EXPECT_THROW(RecordingWriter(path, {}), FileError);
  EXPECT_EQ(read_recording(path).events.size(), 3U);
  RecordingWriter(path, {}, true).sync();
  EXPECT_EQ(read_recording(path).events.size(), 0U);
}

TEST(RecordingWriter, SaysThatTheDiskIsFull) {
  try {
    RecordingWriter("/dev/full", {});
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("full"), std::string::npos);
  }
}

}  // namespace
}  // namespace batten::test
