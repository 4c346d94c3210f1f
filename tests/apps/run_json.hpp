#pragma once
#include "apps/run_batten.hpp"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {

/// Runs a line with --json, which must end with the exit code and print exactly one object, and returns that:
/// an empty one where it does not.
inline nlohmann::json run_json(const std::string& arguments, int exit_code = 0) {
  SCOPED_TRACE("batten " + arguments);
  const Run run = run_batten(arguments + " --json");
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  const nlohmann::json json = nlohmann::json::parse(run.out, nullptr, false);
  EXPECT_TRUE(json.is_object()) << run.out;
  return json.is_object() ? json : nlohmann::json::object();
}

}  // namespace batten::test
