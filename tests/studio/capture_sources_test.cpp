// Which sources a page may open.
#include "studio/capture_sources.hpp"

#include <gtest/gtest.h>

#include "batten/capture/source.hpp"
#include "batten/core/error.hpp"

namespace batten::test {
namespace {

TEST(CaptureSources, SimulatorsComeFirst) {
  const auto sources = studio::offered_sources();
  ASSERT_EQ(sources.size(), list_sources().size());
  bool was_other = false;
  for (const auto& [source, what] : sources) {
    const bool is_simulator = source.rfind("simulator:", 0) == 0;
    EXPECT_FALSE(is_simulator && was_other) << source;
    was_other = was_other || !is_simulator;
    EXPECT_FALSE(what.empty());
  }
  EXPECT_TRUE(was_other);
}

TEST(CaptureSources, WhatIsOfferedMayBeOpened) {
  for (const auto& [source, what] : studio::offered_sources()) EXPECT_NO_THROW(studio::check_offered(source));
  EXPECT_NO_THROW(studio::check_offered("simulator:torus?flip=1%&speed=max"));
  EXPECT_NO_THROW(studio::check_offered("udp:127.0.0.1:9000"));
}

// A page must not make the program open, create or listen to what its user did not offer.
TEST(CaptureSources, FilesAndNetworksAreRefused) {
  for (const char* source :
       {"file:/etc/passwd", "file:recording.blog", "line:/etc/passwd", "line:/dev/null",
        "morphorider:/dev/tty", "line:/dev/../etc/passwd", "simulator:/etc/passwd.csv",
        "simulator:../log.csv", "simulator:log.csv?speed=max", "ws://0.0.0.0:9000", "ws://192.168.0.2",
        "udp:0.0.0.0:9000", "udp:[::]:9000", "rubbish", "", "simulator:"})
    EXPECT_THROW(studio::check_offered(source), InvalidInput) << source;
}

}  // namespace
}  // namespace batten::test
