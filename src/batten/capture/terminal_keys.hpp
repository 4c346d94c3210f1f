#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace batten {

/// Keys as they are pressed, from standard input. A terminal gives them one by one while this object lives,
/// without showing them, and is as it was before afterwards; Ctrl-C still interrupts. Files and pipes are
/// read as they come.
class TerminalKeys {
 public:
  TerminalKeys();
  ~TerminalKeys();
  TerminalKeys(const TerminalKeys&) = delete;
  TerminalKeys& operator=(const TerminalKeys&) = delete;

  /// Keys pressed since the last call, as KeyReader takes them, and "q". Does not wait.
  std::vector<std::string> read();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// The keys in what a terminal sends: characters of KeyReader and q, "enter" for ends of lines, "backspace"
/// for both codes that stand for it; escape sequences of other keys are left out.
std::vector<std::string> keys_of(std::string_view bytes);

}  // namespace batten
