#pragma once
#include "scratch.hpp"

#include <string>

namespace batten::test {

/// What a run of the program left behind.
struct Run {
  int exit_code = -1;
  std::string out, err;
};

/// Runs the program under test with a line of arguments, as a shell would split them, in the folder
/// `scratch()`. Standard input is empty where the line does not redirect it.
Run run_batten(const std::string& arguments);
/// Writes a file into scratch() and returns its path.
std::string write_file(const std::string& name, const std::string& content);
bool file_exists(const std::string& name);
std::string read_file(const std::string& name);

}  // namespace batten::test
