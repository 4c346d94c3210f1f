#include "errors.hpp"
#include "functions.hpp"
#include "objects.hpp"
#include "options.hpp"
#include "running.hpp"

#include "batten/core/parallel.hpp"

// What the package calls. Nothing here is for users: python/batten has the names, signatures and docstrings.
PYBIND11_MODULE(_batten, module) {
  using namespace batten::python;
  module.doc() = "The compiled part of batten; use the package.";
  module.attr("__version__") = BATTEN_VERSION;
  add_errors(module);
  add_running(module);
  add_objects(module);
  add_options(module);
  add_mesh_functions(module);
  add_network_functions(module);
  add_solvers(module);
  add_files(module);
  module.def("set_threads", [](int n) { batten::set_thread_count(n); });
  module.def("threads", [] { return batten::thread_count(); });
}
