#include "apps/run_batten.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <sys/wait.h>

namespace batten::test {

std::string read_file(const std::string& name) {
  std::ifstream in(scratch_file(name), std::ios::binary);
  std::ostringstream content;
  content << in.rdbuf();
  return content.str();
}

bool file_exists(const std::string& name) {
  return std::filesystem::exists(scratch_file(name));
}

std::string write_file(const std::string& name, const std::string& content) {
  const std::string path = scratch_file(name);
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

Run run_batten(const std::string& arguments) {
  const std::string command =
      "cd '" + scratch() + "' && </dev/null >.stdout 2>.stderr '" BATTEN_PROGRAM "' " + arguments;
  const int status = std::system(command.c_str());
  Run run;
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.out = read_file(".stdout");
  run.err = read_file(".stderr");
  return run;
}

}  // namespace batten::test
