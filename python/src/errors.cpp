#include "errors.hpp"

#include <cctype>
#include <exception>

#include "batten/core/error.hpp"

namespace batten::python {

namespace py = pybind11;

namespace {

void raise(const char* type, const std::string& sentence) {
  const py::object kind = py::module_::import("batten._errors").attr(type);
  PyErr_SetObject(kind.ptr(), kind(sentence).ptr());
}

void raise_file_error(const FileError& error) {
  const py::object kind = py::module_::import("batten._errors").attr("FileError");
  const py::object raised = kind(error.what());
  raised.attr("path") = error.path();
  raised.attr("line") = error.line() > 0 ? py::object(py::int_(error.line())) : py::object(py::none());
  PyErr_SetObject(kind.ptr(), raised.ptr());
}

}  // namespace

std::string spoken(const std::string& sentence) {
  const auto is_letter = [&](std::size_t i) {
    return i < sentence.size() && std::islower(static_cast<unsigned char>(sentence[i])) != 0;
  };
  std::string result;
  for (std::size_t i = 0; i < sentence.size();) {
    if (sentence[i] == '`') {
      ++i;
    } else if (sentence.compare(i, 2, "--") == 0 && is_letter(i + 2) && (i == 0 || sentence[i - 1] != '-')) {
      for (i += 2; is_letter(i) || (i < sentence.size() && sentence[i] == '-' && is_letter(i + 1)); ++i)
        result += sentence[i] == '-' ? '_' : sentence[i];
    } else {
      result += sentence[i++];
    }
  }
  return result;
}

std::vector<std::string> spoken(std::vector<std::string> sentences) {
  for (std::string& sentence : sentences) sentence = spoken(sentence);
  return sentences;
}

void add_errors(py::module_&) {
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const FileError& error) {
      raise_file_error(error);
    } catch (const InvalidInput& error) {
      raise("InvalidInput", spoken(error.what()));
    } catch (const SolverFailure& error) {
      raise("SolverFailure", spoken(error.what()));
    } catch (const Cancelled& error) {
      raise("Cancelled", spoken(error.what()));
    } catch (const Error& error) {
      raise("Error", spoken(error.what()));
    }
  });
}

}  // namespace batten::python
