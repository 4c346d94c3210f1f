#include "command.hpp"
#include "studio/page.hpp"
#include "studio/server.hpp"

#include <csignal>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

#include <fcntl.h>
#include <spawn.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

extern char** environ;

namespace batten::cli {

namespace {

struct StudioArguments {
  std::string place, page;
  std::string port;
  bool no_browser = false;
};

unsigned short parse_port(const std::string& text) {
  long port = 0;
  if (!parse_integer(text, port) || port < 0 || port > 65535)
    throw InvalidInput(concat("the port must be a whole number from 0 to 65535, got '", text, "'"));
  return static_cast<unsigned short>(port);
}

/// Opens the address where there is a desktop; nobody waits for it, and whether it worked is seen on the
/// screen.
void open_browser(const std::string& url) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  // Browsers talk on their standard streams; those of this program are its caller's.
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);  // Ctrl-C here is none there
  std::string name = "xdg-open", address = url;
  char* const words[] = {name.data(), address.data(), nullptr};
  pid_t pid = 0;
  std::signal(SIGCHLD, SIG_IGN);  // the system forgets it when it has ended
  posix_spawnp(&pid, "xdg-open", &actions, &attributes, words, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
}

Outcome run_studio(const StudioArguments& arguments, const Context& context) {
  studio::ServerOptions options;
  if (!arguments.port.empty()) options.port = parse_port(arguments.port);
  options.place = arguments.place;
  options.page_folder = arguments.page;
  options.version = BATTEN_VERSION;
  options.stop_on_signals = true;
  if (!context.quiet)
    options.refused = [](const std::string& sentence) { std::cerr << "refused: " + sentence + "\n"; };
  studio::Server server(std::move(options));
  server.start();
  if (context.json) {
    std::cout << Json{{"url", server.url()}, {"port", server.port()}}.dump() << std::endl;
  } else if (!context.quiet) {
    std::cout << "studio: " << server.url() << "\nCtrl-C ends it" << std::endl;
  }
  if (!server.has_page() && !context.quiet) std::cerr << "warning: " << studio::no_page_sentence() << '\n';
  if (!arguments.no_browser) open_browser(server.url());
  server.wait();
  Outcome outcome;
  outcome.is_printed = true;
  return outcome;
}

}  // namespace

void add_studio(CLI::App& app) {
  auto arguments = std::make_shared<StudioArguments>();
  CLI::App* command =
      add_command(app, "studio", "Open Batten in the browser: a server for this machine alone, until Ctrl-C.",
                  "batten studio scans/ --port 8617",
                  [arguments](Context& context) { return run_studio(*arguments, context); });
  command->remove_option(command->get_option("--report"));  // there is no result to report on
  command->add_option(
      "PLACE", arguments->place,
      "Folder whose files may be opened and that files are written to, or one file; without it "
      "the page opens what is dropped on it");
  command
      ->add_option("--port", arguments->port,
                   "Port on 127.0.0.1; 0 takes a free one. Without it 8617 where that is free, so that the "
                   "browser finds again what it keeps for the page, else a free one")
      ->check(parses("N", [](const std::string& text) { parse_port(text); }));
  command->add_flag("--no-browser", arguments->no_browser, "Print the address and open nothing");
  command
      ->add_option("--page", arguments->page, "Files of the page, in place of those that the program holds")
      ->group("");  // for whoever works on the page
}

}  // namespace batten::cli
